//! A curve of the reference, and the twin's along the same strokes.

use std::path::Path;

use anyhow::Result;
use hysteron_base::MaterialLaw;
use hysteron_fem::Mesh;
use hysteron_twin::{Stepper, Target, Twin, TwinState};

use crate::tendon::columns::read_columns;
use crate::tendon::numbers::distance;
use crate::tendon::scenes::{N_PRIMARY, Setting, one_sided, sofa_folder, sofa_scene};

/// A curve of the reference, one entry per stroke; SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Stroke of p0 [m].
    pub strokes: Vec<f64>,
    /// Mean of the tip nodes [m].
    pub tips: Vec<[f64; 3]>,
    /// Tension of the primaries [N].
    pub tensions: Vec<[f64; N_PRIMARY]>,
}

impl Curve {
    /// Reads a curve of the reference.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn read(repository: &Path, name: &str) -> Result<Self> {
        let names = [
            "stroke_mm",
            "tipface_x",
            "tipface_y",
            "tipface_z",
            "force_p0",
            "force_p1",
            "force_p2",
            "force_p3",
        ];
        let columns = read_columns(&sofa_folder(repository).join(name), &names)?;
        let rows = 0..columns[0].len();
        Ok(Self {
            strokes: columns[0].iter().map(|mm| 1e-3 * mm).collect(),
            tips: rows.clone().map(|k| [1, 2, 3].map(|c| 1e-3 * columns[c][k])).collect(),
            tensions: rows.map(|k| [4, 5, 6, 7].map(|c: usize| columns[c][k])).collect(),
        })
    }

    /// How far `tip` [m] and the tension of p0 [N] are from row `k`.
    pub fn difference(&self, k: usize, tip: [f64; 3], tension: f64) -> Difference {
        let (reference, rest) = (self.tips[k], self.tips[0]);
        let deflection = distance(reference, rest);
        Difference {
            tip: distance(tip, reference) / deflection,
            deflection: (distance(tip, rest) / deflection - 1.0).abs(),
            tension: (tension / self.tensions[k][0] - 1.0).abs(),
        }
    }
}

/// Relative differences from a row of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Distance of the tips over the deflection.
    pub tip: f64,
    /// Difference of the distances from rest over the deflection: leaves out a sideways drift.
    pub deflection: f64,
    /// Tension of p0.
    pub tension: f64,
}

/// Equilibria at `strokes` [m], of which the first is rest and not solved for, with targets from `command`.
///
/// # Errors
/// A step fails.
pub fn solve(
    twin: &Twin,
    strokes: &[f64],
    command: impl Fn(f64) -> Vec<Target>,
) -> hysteron_twin::Result<Vec<TwinState>> {
    let mut stepper = Stepper::new(twin);
    let mut states = vec![stepper.state().clone()];
    for &stroke in &strokes[1..] {
        stepper.step(twin, &command(stroke))?;
        states.push(stepper.state().clone());
    }
    Ok(states)
}

/// One-sided drive with `law` compared with `curve`, rows 1 to `last`.
///
/// # Errors
/// The scene or a step fails.
pub fn compare(
    repository: &Path,
    mesh: &Mesh,
    (law, curve, last): (MaterialLaw, &Curve, usize),
) -> Result<Vec<Difference>> {
    let twin = sofa_scene(repository, Setting::exact(law), mesh, N_PRIMARY)?;
    let states = solve(&twin, &curve.strokes[..=last], |stroke| one_sided(N_PRIMARY, stroke))?;
    let difference = |k: usize| curve.difference(k, twin.tip_of(&states[k]), states[k].tensions[0]);
    Ok((1..=last).map(difference).collect())
}
