//! The study, arm by arm.

use std::path::Path;

use hysteron_base::json;
use hysteron_learn::Result;
use serde::{Deserialize, Serialize};

use super::ForceData;
use super::methods::TASKS;
use super::score::{Errors, FreeRow, LoadedRow, Trace, free_row, learned_threshold};
use crate::runner::cells::{Listener, StudyProgress, cell, make_folder};
use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::servo_force::{estimators, observed_arm};

/// One arm: the estimates of every method of [`METHODS`] for its trajectories.
#[derive(Debug, Clone, Serialize, Deserialize, PartialEq)]
pub struct ForceCell {
    /// Draws the arm and its trajectories.
    pub seed: u64,
    /// Method by method, task by task of [`TASKS`]; `None` where there is no trajectory of that task.
    pub loaded: Vec<Vec<Option<LoadedRow>>>,
    /// Method by method, on contact-free trajectories.
    pub free: Vec<FreeRow>,
    /// Trajectories for figures.
    pub traces: Vec<Trace>,
    /// Rows that were identified on, tested on with objects, and without.
    pub samples: [usize; 3],
}

/// The study.
#[derive(Debug, Clone)]
pub struct ForceStudy {
    /// One for each arm.
    pub cells: Vec<ForceCell>,
}

/// Joints of the arm.
const N_JOINTS: usize = 4;
/// Tasks that figures show.
const SHOWN: [&str; 2] = ["go_up_and_stay_still_400g", "pick_place_object_500g"];

/// Estimates forces on the arms of `seeds`; `data` gives their recordings, which `identity` describes. `None`
/// where the listener ended it; what is done is found again below `folder`.
///
/// # Errors
/// Cells of another study; files that cannot be written; recordings without what is needed.
pub fn force_study(
    folder: &Path,
    seeds: &[u64],
    identity: &impl Serialize,
    data: &mut dyn FnMut(u64) -> Result<Option<ForceData>>,
    listener: Listener<'_>,
) -> Result<Option<ForceStudy>> {
    make_folder(folder)?;
    let mut cells = Vec::new();
    for (k, seed) in seeds.iter().enumerate() {
        let name = format!("arm-{seed}");
        if !listener(&StudyProgress { cell: &name, done: [k, seeds.len()], training: None }) {
            return Ok(None);
        }
        let identity = json!({ "study": "force", "version": 1, "data": identity, "seed": seed });
        let row =
            cell(folder, &name, &identity, || data(*seed)?.map(|data| force_cell(*seed, &data)).transpose())?;
        let Some(row) = row else { return Ok(None) };
        cells.push(row);
    }
    Ok(Some(ForceStudy { cells }))
}

fn force_cell(seed: u64, data: &ForceData) -> Result<ForceCell> {
    let model = observed_arm(&Model::builtin("open-manipulator-x")?, N_JOINTS)?;
    let [linear, friction, momentum, drive] = estimators(&model, &data.training)?;
    // The first is the estimate of no force.
    let methods = [None, Some(linear), Some(friction), Some(momentum), Some(drive)];
    let mut found = ForceCell {
        seed,
        loaded: Vec::new(),
        free: Vec::new(),
        traces: traces(data),
        samples: [
            data.training.iter().map(super::ServoForceTelemetry::n_samples).sum(),
            data.loaded.iter().map(|(_, one)| one.n_samples()).sum(),
            data.free.iter().map(|(_, one)| one.n_samples()).sum(),
        ],
    };
    for (kind, method) in methods.iter().enumerate() {
        let forces = |one: &super::ServoForceTelemetry| match method {
            Some(method) => method.forces(one),
            None => Ok(vec![[0.0; 3]; one.n_samples()]),
        };
        let mut training = Vec::new();
        for trajectory in &data.training {
            training.extend(forces(trajectory)?);
        }
        let mut free = Vec::new();
        for (_, trajectory) in &data.free {
            free.extend(forces(trajectory)?);
        }
        found.free.push(free_row(&free, learned_threshold(&training)));
        let mut errors: [Option<Errors>; TASKS.len()] = [None; TASKS.len()];
        for (task, trajectory) in &data.loaded {
            let estimated = forces(trajectory)?;
            if let Some(k) = TASKS.iter().position(|known| known == task) {
                errors[k].get_or_insert_default().add(trajectory, &estimated);
            }
            if let Some(trace) = found.traces.iter_mut().find(|trace| trace.task == *task)
                && trace.estimates_n.len() == kind
            {
                trace.estimates_n.push(estimated.iter().map(|force| force[2]).collect());
            }
        }
        found.loaded.push(errors.iter().map(|errors| errors.as_ref().map(Errors::row)).collect());
    }
    Ok(found)
}

/// The first trajectory of each task that is shown, without estimates.
fn traces(data: &ForceData) -> Vec<Trace> {
    let of = |task: &&str| {
        let (_, one) = data.loaded.iter().find(|(name, _)| name == task)?;
        Some(Trace {
            task: (*task).to_owned(),
            time_s: one.time.clone(),
            label_n: one.force.iter().map(|force| force[2]).collect(),
            estimates_n: Vec::new(),
        })
    };
    SHOWN.iter().filter_map(of).collect()
}
