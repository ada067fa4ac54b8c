//! The same tube and cables as SOFA: tip and tension, stroke by stroke.
#![allow(clippy::print_stdout)] // this program prints tables

use std::path::Path;

use anyhow::Result;
use hysteron_base::{MaterialLaw, json};
use hysteron_fem::Mesh;
use hysteron_twin::{Stepper, Target, Twin, TwinState};

use super::{distance, write_metrics};
use crate::columns::read_columns;
use crate::drive::one_sided;
use crate::scenes::{N_PRIMARY, Setting, sofa_folder, sofa_mesh, sofa_scene};
use crate::table::print_cells;

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
    pub fn read(name: &str) -> Result<Self> {
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
        let columns = read_columns(&sofa_folder().join(name), &names)?;
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
pub fn compare(mesh: &Mesh, law: MaterialLaw, curve: &Curve, last: usize) -> Result<Vec<Difference>> {
    let twin = sofa_scene(Setting::exact(law), mesh, N_PRIMARY)?;
    let states = solve(&twin, &curve.strokes[..=last], |stroke| one_sided(N_PRIMARY, stroke))?;
    let difference = |k: usize| curve.difference(k, twin.tip_of(&states[k]), states[k].tensions[0]);
    Ok((1..=last).map(difference).collect())
}

/// Runs the study.
///
/// # Errors
/// The reference cannot be read, or a step fails.
pub fn run(folder: &Path) -> Result<()> {
    let mesh = sofa_mesh()?;
    let cases = [
        ("edges against SOFA polar", MaterialLaw::CorotationalEdges, "ref_A_qs_aux0_polar_one.csv", 38),
        ("polar factor against SOFA polar", MaterialLaw::Corotational, "ref_A_qs_aux0_polar_one.csv", 38),
        ("polar factor against SOFA large", MaterialLaw::Corotational, "ref_A_qs_aux0_one.csv", 50),
        ("edges against SOFA large", MaterialLaw::CorotationalEdges, "ref_A_qs_aux0_one.csv", 50),
    ];
    let heading = ["comparison", "to [mm]", "tip", "deflection", "tension"];
    println!("worst relative differences");
    let mut cells = vec![heading.map(str::to_owned).to_vec()];
    let mut metrics = Vec::new();
    for (name, law, file, last) in cases {
        let curve = Curve::read(file)?;
        let differences = compare(&mesh, law, &curve, last)?;
        for end in [5, 10, 35, last] {
            let worst = |of: fn(&Difference) -> f64| differences[..end].iter().map(of).fold(0.0, f64::max);
            let [tip, deflection, tension] =
                [worst(|d| d.tip), worst(|d| d.deflection), worst(|d| d.tension)];
            let to = 1e3 * curve.strokes[end];
            let figures = [tip, deflection, tension].map(|v| format!("{v:.2e}"));
            cells.push([vec![name.into(), format!("{to:.1}")], figures.to_vec()].concat());
            metrics.push(json!({
                "comparison": name,
                "to_stroke_mm": to,
                "worst_tip": tip,
                "worst_deflection": deflection,
                "worst_tension": tension,
            }));
        }
    }
    print_cells(&cells);
    write_metrics(folder, "sofa", json!(metrics))
}
