//! Parameters of the tentacle fitted to the eight holds of session B, each set with one hold as test in turn,
//! those searches from the values found on all.

use std::sync::{Arc, Mutex};

use anyhow::{Context as _, Result};
use hysteron_fem::{FemModel, Mesh};
use hysteron_twin::TwinState;
use hysteron_twin::fit::{Fit, Identifiability, Options, TOLERANCE, least_squares};
use hysteron_workflow::Context;
use rayon::prelude::*;

use super::holds::{Hold, Markers, N_MARKERS};
use super::outcome::{FittedValue, ParameterFit};
use super::setup::{Key, Set, Setup, coarse_body};
use crate::tendon::numbers::rms;

/// Root mean square by which a parameter must move the markers to count as observable [m].
const SEEN: f64 = 1e-4;

/// Shapes that are kept: those of a Jacobian and more.
const KEPT: usize = 12;

/// Shapes in the holds of a fit, and what they depend on.
type Known = (Key, Arc<Vec<TwinState>>);

/// Errors of the markers in a hold [m].
pub type Errors = [f64; N_MARKERS];

/// The body and what is read off it.
pub struct Bench {
    /// Its mesh.
    pub mesh: Mesh,
    /// The markers on it.
    pub markers: Markers,
    /// Holds of session B.
    pub holds: Vec<Hold>,
}

impl Bench {
    /// The coarse body with the holds to fit.
    pub fn new(holds: &[Hold]) -> Result<Self> {
        let mesh = coarse_body()?;
        let twin = Setup::NOMINAL.twin(&mesh, &[])?;
        let holds = holds.iter().filter(|hold| hold.is_session_b()).cloned().collect();
        Ok(Self { markers: Markers::new(&twin.body as &FemModel), mesh, holds })
    }

    /// Shapes in `holds`, from shapes `near` if there are any.
    fn states(
        &self,
        setup: &Setup,
        holds: &[Hold],
        near: Option<&[TwinState]>,
    ) -> hysteron_twin::Result<Vec<TwinState>> {
        let twin = setup.twin(&self.mesh, &[]).map_err(as_twin_error)?;
        setup.states(&twin, holds, near, &|_| Vec::new())
    }

    /// Errors of the markers in these shapes.
    pub fn errors_in(
        &self,
        setup: &Setup,
        states: &[TwinState],
        holds: &[Hold],
    ) -> Vec<[f64; 3 * N_MARKERS]> {
        let error = |(state, hold): (&TwinState, &Hold)| {
            let found = setup.markers(&self.markers, state, hold.base);
            std::array::from_fn(|i| found[i / 3][i % 3] - hold.markers[i / 3][i % 3])
        };
        states.iter().zip(holds).map(error).collect()
    }

    /// Fits a set, from nominal values or from others with the shapes of a setup near them.
    fn fit(&self, set: Set, start: Option<(&[f64], Known)>, holds: &[Hold]) -> Result<Fit> {
        let mut parameters = set.parameters();
        let mut begin = Vec::new();
        if let Some((start, known)) = start {
            parameters.iter_mut().zip(start).for_each(|(parameter, value)| parameter.start = *value);
            begin.push(known);
        }
        let options = Options {
            huber: None,
            smallest_effect: SEEN,
            n_nuisance: 0,
            tolerance: TOLERANCE,
            watch: &|_, _| true,
        };
        // Most parameters move only the markers, and differences come back to the same middle: the shapes last computed
        // serve them all.
        let known: Mutex<Vec<Known>> = Mutex::new(begin);
        let residuals = |values: &[f64]| {
            let setup = set.setup(values);
            let last = |matches: &dyn Fn(&Known) -> bool| {
                known.lock().ok().and_then(|known| known.iter().rev().find(|known| matches(known)).cloned())
            };
            let states = match last(&|(key, _)| *key == setup.key()) {
                Some((_, states)) => states,
                None => {
                    let near = last(&|_| true);
                    let near = near.as_ref().map(|(_, states)| states.as_slice());
                    let states = Arc::new(self.states(&setup, holds, near)?);
                    if let Ok(mut known) = known.lock() {
                        known.push((setup.key(), states.clone()));
                        if known.len() > KEPT {
                            known.remove(0);
                        }
                    }
                    states
                }
            };
            Ok::<_, hysteron_twin::Error>(
                self.errors_in(&setup, &states, holds).iter().map(|e| e.to_vec()).collect(),
            )
        };
        Ok(least_squares(&parameters, &options, residuals)?)
    }
}

fn as_twin_error(error: anyhow::Error) -> hysteron_twin::Error {
    hysteron_base::BadInput::new("tentacle", "a twin", error.to_string()).into()
}

/// Distances of the markers [m].
pub fn distances(error: &[f64; 3 * N_MARKERS]) -> Errors {
    std::array::from_fn(|m| (0..3).map(|c| error[3 * m + c].powi(2)).sum::<f64>().sqrt())
}

/// Mean over the markers of their RMSE over the holds, as published [m].
pub fn mean_of_markers(errors: &[Errors]) -> f64 {
    (0..N_MARKERS).map(|m| rms(errors.iter().map(|e| e[m]))).sum::<f64>() / N_MARKERS as f64
}

/// Fits every set, prints what is found of each; the fitted setups and the metrics.
pub fn run(bench: &Bench, context: &Context) -> Result<(Vec<Setup>, Vec<ParameterFit>)> {
    let (mut setups, mut found) = (Vec::new(), Vec::new());
    for set in Set::ALL {
        let fit = bench.fit(set, None, &bench.holds)?;
        let setup = set.setup(&fit.values());
        let states = bench.states(&setup, &bench.holds, None)?;
        let all: Vec<Errors> = bench.errors_in(&setup, &states, &bench.holds).iter().map(distances).collect();
        for estimate in &fit.estimates {
            let error = estimate.standard_error.map_or("-".into(), |error| format!("{error:.3e}"));
            context.print(format_args!(
                "{:<34}{:>12.4e} ± {error:<10} {:?}",
                estimate.name, estimate.value, estimate.identifiability
            ));
        }
        let of_marker = |m: usize| format!("{:.2}", 1e3 * rms(all.iter().map(|e| e[m])));
        context.print(format_args!(
            "{}: {} ({} evaluations), markers {} mm, mean {:.2} mm\n",
            set.name(),
            fit.ended,
            fit.evaluations,
            (0..N_MARKERS).map(of_marker).collect::<Vec<_>>().join(", "),
            1e3 * mean_of_markers(&all)
        ));
        // A search does not begin on a bound, where it would stay.
        let inside: Vec<f64> = fit
            .estimates
            .iter()
            .map(|e| if e.identifiability == Identifiability::AtBound { e.start } else { e.value })
            .collect();
        let left_out: Vec<Errors> = (0..bench.holds.len())
            .into_par_iter()
            .map(|out| -> Result<Errors> {
                let mut rest = bench.holds.clone();
                let hold = rest.remove(out);
                let mut near = states.clone();
                let of_hold = near.remove(out);
                let values = bench.fit(set, Some((&inside, (setup.key(), Arc::new(near)))), &rest)?.values();
                let (setup, hold) = (set.setup(&values), [hold]);
                let state = bench.states(&setup, &hold, Some(&[of_hold]))?;
                Ok(distances(bench.errors_in(&setup, &state, &hold).first().context("one hold")?))
            })
            .collect::<Result<_>>()?;
        found.push(ParameterFit {
            set: set.name().to_owned(),
            mean_of_markers_rmse_mm: 1e3 * mean_of_markers(&all),
            left_out_mean_of_markers_rmse_mm: 1e3 * mean_of_markers(&left_out),
            converged: fit.is_converged,
            parameters: fit.estimates.iter().map(FittedValue::of).collect(),
        });
        setups.push(setup);
    }
    Ok((setups, found))
}

impl FittedValue {
    fn of(estimate: &hysteron_twin::fit::IdentifiedParameter) -> Self {
        Self {
            name: estimate.name.clone(),
            start: estimate.start,
            value: estimate.value,
            standard_error: estimate.standard_error,
            is_fitted: estimate.identifiability == Identifiability::Fitted,
        }
    }
}
