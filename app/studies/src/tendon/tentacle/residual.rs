//! Residual tendons: virtual cables whose tensions take up what the fitted twin leaves of the markers.
//!
//! Linearised at the present shapes, the markers move by S Δ; the tensions of all virtual cables follow from a QP,
//! min |m + S Δ - m*|² + ρ |t + Δ|², within their bounds, and the shapes from a step of the twin; repeated, with a
//! smaller step where the error grows. One reading lets every hold have tensions of its own; the others share them.

use anyhow::{Context as _, Result};
use hysteron_base::{Scene, Tendon};
use hysteron_fit::qp::{QpStatus, RowQp, solve_rows};
use hysteron_twin::{Stepper, Target, Twin, TwinState, auxiliary_tendons};
use rayon::prelude::*;

use super::fits::{Bench, Errors, distances, mean_of_markers};
use super::holds::{Hold, N_MARKERS};
use super::outcome::{ResidualTensions, SharedTensions};
use super::setup::Setup;

const N: usize = 3 * N_MARKERS;
/// Weight of (1 N)² against (1 cm)² of a coordinate.
const REGULARISATION: f64 = 1e-3;
const CENTIMETRE: f64 = 1e-2;
const ROUNDS: usize = 5;
/// Change of the body along a column for the difference of the markers [N].
const DIFFERENCE: f64 = 1e-3;

/// How the tensions of the virtual cables depend on the hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sharing {
    /// One number: a hold has tensions of its own.
    Constant,
    /// A constant and a part for each newton of the real tendons.
    Linear,
}

impl Sharing {
    /// Factors of the unknown blocks under these tensions.
    fn factors(self, tensions: [f64; 2]) -> Vec<f64> {
        match self {
            Self::Constant => vec![1.0],
            Self::Linear => vec![1.0, tensions[0], tensions[1]],
        }
    }
}

/// The twin with virtual cables.
struct Residual<'a> {
    bench: &'a Bench,
    setup: &'a Setup,
    twin: Twin,
    cables: Vec<Tendon>,
    sharing: Sharing,
    /// Shapes in the bench's holds while the cables do nothing.
    uncorrected: Vec<TwinState>,
}

impl<'a> Residual<'a> {
    fn new(bench: &'a Bench, setup: &'a Setup, cables: &[Tendon], sharing: Sharing) -> Result<Self> {
        let twin = setup.twin(&bench.mesh, cables)?;
        let idle = |_| vec![Target::Tension(0.0); cables.len()];
        let bare = setup.states(&twin, &bench.holds, None, &idle)?;
        Ok(Self { bench, setup, twin, cables: cables.to_vec(), sharing, uncorrected: bare })
    }

    /// Tensions of the cables for the unknowns, within their bounds.
    fn tensions(&self, unknowns: &[f64], applied: [f64; 2]) -> Vec<f64> {
        let n = self.cables.len();
        let factors = self.sharing.factors(applied);
        let tension =
            |j: usize| factors.iter().enumerate().map(|(b, f)| f * unknowns[b * n + j]).sum::<f64>();
        (0..n).map(|j| self.cables[j].tension.clamp(tension(j))).collect()
    }

    fn states(
        &self,
        unknowns: &[f64],
        holds: &[Hold],
        near: &[TwinState],
    ) -> hysteron_twin::Result<Vec<TwinState>> {
        let further = |applied| self.tensions(unknowns, applied).into_iter().map(Target::Tension).collect();
        self.setup.states(&self.twin, holds, Some(near), &further)
    }

    fn errors(&self, states: &[TwinState], holds: &[Hold]) -> Vec<[f64; N]> {
        self.bench.errors_in(self.setup, states, holds)
    }

    /// Markers per tension of each cable, by differences along the body's exact response [m/N].
    fn rows(&self, state: &TwinState, hold: &Hold) -> hysteron_twin::Result<Vec<[f64; N]>> {
        let mut stepper = Stepper::new(&self.twin);
        stepper.restore(&self.twin, state)?;
        let columns = stepper.displacements_per_tension(&self.twin)?;
        let here = self.setup.markers(&self.bench.markers, state, hold.base);
        let first = self.twin.tendons.len() - self.cables.len();
        let along = |column: &Vec<f64>| {
            let mut moved = state.clone();
            for (node, change) in moved.positions.iter_mut().zip(column.as_chunks::<3>().0) {
                (0..3).for_each(|c| node[c] += DIFFERENCE * change[c]);
            }
            let there = self.setup.markers(&self.bench.markers, &moved, hold.base);
            std::array::from_fn(|i| (there[i / 3][i % 3] - here[i / 3][i % 3]) / DIFFERENCE)
        };
        Ok(columns[first..].iter().map(along).collect())
    }

    /// Unknowns that bring the markers of `holds` to where they were measured, and the shapes there; `near` are the
    /// shapes while the cables do nothing.
    fn identify(&self, holds: &[Hold], near: &[TwinState]) -> Result<(Vec<f64>, Vec<TwinState>)> {
        let n_blocks = self.sharing.factors([0.0; 2]).len();
        let mut unknowns = vec![0.0; n_blocks * self.cables.len()];
        let mut states = near.to_vec();
        let mut longest = 1.0;
        for _ in 0..ROUNDS {
            let before = self.cost(&unknowns, &self.errors(&states, holds));
            let step = self.correction(&unknowns, &states, holds, longest)?;
            let next: Vec<f64> = unknowns.iter().zip(&step).map(|(a, b)| a + b).collect();
            match self.states(&next, holds, &states) {
                Ok(found) if self.cost(&next, &self.errors(&found, holds)) < before => {
                    (unknowns, states) = (next, found);
                }
                _ => longest *= 0.3,
            }
        }
        Ok((unknowns, states))
    }

    fn cost(&self, unknowns: &[f64], errors: &[[f64; N]]) -> f64 {
        let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
        squares(&mut errors.iter().flatten().map(|e| e / CENTIMETRE))
            + REGULARISATION * squares(&mut unknowns.iter().copied())
    }

    /// The QP of a round: no unknown moves by more than `longest` times what moves a cable by 1 N.
    fn correction(
        &self,
        unknowns: &[f64],
        states: &[TwinState],
        holds: &[Hold],
        longest: f64,
    ) -> Result<Vec<f64>> {
        let (n, n_cables) = (unknowns.len(), self.cables.len());
        let errors = self.errors(states, holds);
        let rows: Vec<Vec<[f64; N]>> = states
            .par_iter()
            .zip(holds)
            .map(|(state, hold)| self.rows(state, hold))
            .collect::<hysteron_twin::Result<_>>()?;
        let mut qp = RowQp {
            hessian: vec![0.0; n * n],
            linear: unknowns.iter().map(|t| REGULARISATION * t).collect(),
            bounds: Vec::new(),
            rows: Vec::new(),
            row_bounds: Vec::new(),
        };
        for ((error, rows), hold) in errors.iter().zip(&rows).zip(holds) {
            let factors = self.sharing.factors(hold.tensions);
            for i in 0..N {
                let row: Vec<f64> =
                    (0..n).map(|k| factors[k / n_cables] * rows[k % n_cables][i] / CENTIMETRE).collect();
                for a in 0..n {
                    qp.linear[a] += row[a] * error[i] / CENTIMETRE;
                    (0..n).for_each(|b| qp.hessian[a * n + b] += row[a] * row[b]);
                }
            }
        }
        let strongest = holds.iter().flat_map(|hold| hold.tensions).fold(1.0, f64::max);
        for k in 0..n {
            qp.hessian[k * n + k] += REGULARISATION;
            // A block that is multiplied by the tensions has bounds in proportion.
            let part = if k < n_cables { 1.0 } else { 1.0 / strongest };
            let bounds = self.cables[k % n_cables].tension;
            let free = |bound: f64| (part * bound - unknowns[k]).clamp(-longest * part, longest * part);
            qp.bounds.push([free(bounds.min), free(bounds.max)]);
        }
        let (step, status) = solve_rows(&qp);
        anyhow::ensure!(status == QpStatus::Solved, "the QP of the residual tensions: {status}");
        Ok(step)
    }
}

/// Residual tensions identified on top of `setup`.
pub fn run(bench: &Bench, setup: &Setup, scene: &Scene) -> Result<ResidualTensions> {
    let layout = scene.auxiliary.as_ref().context("a layout of virtual cables")?;
    let cables = auxiliary_tendons(layout);
    let of = |errors: &[[f64; N]]| -> Vec<Errors> { errors.iter().map(distances).collect() };
    let mut rows: Vec<(&str, f64, Option<f64>)> = Vec::new();

    let own = Residual::new(bench, setup, &cables, Sharing::Constant)?;
    let errors: Vec<[f64; N]> = bench
        .holds
        .par_iter()
        .zip(&own.uncorrected)
        .map(|(hold, uncorrected)| {
            let holds = std::slice::from_ref(hold);
            let (_, states) = own.identify(holds, std::slice::from_ref(uncorrected))?;
            Ok(own.errors(&states, holds)[0])
        })
        .collect::<Result<_>>()?;
    rows.push(("each hold its own", mean_of_markers(&of(&errors)), None));
    let shared = Residual::new(bench, setup, &cables, Sharing::Linear)?;
    let (_, states) = shared.identify(&bench.holds, &shared.uncorrected)?;
    let all = shared.errors(&states, &bench.holds);
    let left_out: Vec<[f64; N]> = (0..bench.holds.len())
        .into_par_iter()
        .map(|out| {
            let (mut rest, mut near) = (bench.holds.clone(), shared.uncorrected.clone());
            let (hold, uncorrected) = ([rest.remove(out)], [near.remove(out)]);
            let (unknowns, _) = shared.identify(&rest, &near)?;
            Ok(shared.errors(&shared.states(&unknowns, &hold, &uncorrected)?, &hold)[0])
        })
        .collect::<Result<_>>()?;
    rows.push(("linear in the tensions", mean_of_markers(&of(&all)), Some(mean_of_markers(&of(&left_out)))));
    let row = |(name, error, left_out): &(&str, f64, Option<f64>)| SharedTensions {
        sharing: (*name).to_owned(),
        rmse_mm: 1e3 * error,
        left_out_rmse_mm: left_out.map(|e| 1e3 * e),
    };
    Ok(ResidualTensions { cables: cables.len(), readings: rows.iter().map(row).collect() })
}
