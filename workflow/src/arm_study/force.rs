//! Force at the tip of the virtual arm.

use hysteron_arm::study::Listener;
use hysteron_arm::study::force::{ForceData, TASKS, Telemetry, force_study};
use hysteron_base::Metadata;
use hysteron_learn::Error;
use hysteron_rig::virtual_arm::{N_JOINTS, Planned, VirtualArm, data_set};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::Options;
use crate::{Caller, arm, arm_estimation_figures};

/// Virtual arm of the study.
const ARM: &str = "open-manipulator-x";
/// Contact-free training trajectories of each task.
const TRAINING: usize = 3;

/// Carries out the study on as many individual arms as there are seeds; `None` where it was interrupted.
pub(super) fn run(
    options: &Options,
    listener: Listener<'_>,
    caller: &Caller,
) -> anyhow::Result<Option<Value>> {
    let general = VirtualArm::preset(ARM)?;
    let seeds: Vec<u64> = (1..=options.seeds as u64).collect();
    let identity = json!({ "arm": general.hash, "training": TRAINING });
    let mut data = |seed: u64| {
        if caller.is_cancelled() { Ok(None) } else { recorded(&general, seed).map(Some) }
    };
    match force_study(&options.out.join("cells"), &seeds, &identity, &mut data, listener)? {
        Some(study) if !caller.is_cancelled() => {
            let meta = arm::meta(caller, "study of forces without a sensor");
            arm_estimation_figures::write_force(&options.out, &study, &meta).map(Some)
        }
        _ => Ok(None),
    }
}

/// What an individual arm records: contact-free training, contact-free tests, tests with objects.
fn recorded(general: &VirtualArm, seed: u64) -> Result<ForceData, Error> {
    let arm = general.individual(seed);
    let is_training =
        |one: &Planned| one.subset == "force_unlabeled" && one.split == "train" && one.number <= TRAINING;
    let is_free = |one: &Planned| one.subset == "force_unlabeled" && one.split == "test";
    let is_loaded =
        |one: &Planned| one.subset == "weight" && one.split == "test" && TASKS.contains(&one.task.as_str());
    let telemetry = |wanted: &(dyn Fn(&Planned) -> bool + Sync)| {
        let planned: Vec<Planned> = data_set().into_iter().filter(wanted).collect();
        let one = |one: &Planned| -> Result<(String, Telemetry), Error> {
            let recording = arm.record(&one.trial, seed, &one.name(), Metadata::default()).map_err(|e| {
                Error::from(hysteron_base::BadInput::new(one.name(), "a recording", e.to_string()))
            })?;
            Ok((one.task.clone(), Telemetry::of(&recording, N_JOINTS)?))
        };
        planned.par_iter().map(one).collect::<Result<Vec<_>, Error>>()
    };
    Ok(ForceData {
        training: telemetry(&is_training)?.into_iter().map(|(_, one)| one).collect(),
        free: telemetry(&is_free)?,
        loaded: telemetry(&is_loaded)?,
    })
}
