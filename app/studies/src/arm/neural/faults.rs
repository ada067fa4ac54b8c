//! Faults that NAD does not have: detectors of a degraded motor by fault, with every payload.

use hysteron_learn::{Error, Result, TrainingProgress};

use super::cells::Protocol;
use super::comparison::{FaultCell, FaultDetectors};
use super::{NeuralData, Sample, Split};
use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::servo_force::observed_arm;
use hysteron_arm_learning::neural::{
    ActuatorOptions, ActuatorSession, ConditionEstimate, DetectorScores, TrainingStage, Trajectory,
    detectors, fit_sensing, identified_observers,
};

/// Kinds, as names of tasks end.
pub const KINDS: [&str; 3] = ["band", "friction", "lost_tooth"];
/// Cells: name, and the part of a task's name that makes it a test task.
pub const FAULT_SPLITS: [(&str, Option<&str>); 2] = [("faults", None), ("faults-without-200g", Some("200g"))];

/// Trains the network of force, contact and condition, and compares it and its baselines on every kind of
/// fault, and on all together.
pub(super) fn fault_cell(
    (model, data): (&Model, &NeuralData),
    protocol: Protocol,
    options: &ActuatorOptions,
    file: &std::path::Path,
    listener: &mut dyn FnMut(&TrainingProgress) -> bool,
) -> Result<Option<FaultCell>> {
    let of = |split: Split| -> Vec<Trajectory> {
        let own = data.samples.iter().filter(|one| protocol.uses(one, split));
        own.map(|one| one.trajectory.clone()).collect()
    };
    let [training, validation] = [Split::Training, Split::Validation].map(of);
    let Some(sensing) = &options.sensing else { return Ok(None) };
    let arm = observed_arm(model, data.features.joints)?;
    let about = (&data.features, data.period);
    let observers = identified_observers(&arm, about, &training)?;
    let names: Vec<String> =
        training.iter().chain(&validation).map(|one| format!("{} ({})", one.name, one.len())).collect();
    let mut session = ActuatorSession {
        recordings: &names,
        files: [file, file],
        progress: &mut |stage, p| stage != TrainingStage::Sensing || listener(p),
    };
    let about_arm = (&arm, &data.features, data.period);
    let found = fit_sensing(about_arm, &observers, [&training, &validation], sensing, &mut session);
    let sensing = match found {
        Ok((sensing, found)) if found.is_finished => sensing,
        Ok(_) | Err(Error::NothingTrained) => return Ok(None),
        Err(error) => return Err(error),
    };
    let along = |trajectories: &[Trajectory]| -> Result<Vec<ConditionEstimate>> {
        trajectories.iter().map(|one| Ok(ConditionEstimate::of(&sensing.along(&arm, about, one)?))).collect()
    };
    let known: Vec<Trajectory> = training.iter().filter(|one| one.is_healthy.is_some()).cloned().collect();
    let tests: Vec<&Sample> = data.samples.iter().filter(|one| protocol.uses(one, Split::Test)).collect();
    let test_trajectories: Vec<Trajectory> = tests.iter().map(|one| one.trajectory.clone()).collect();
    let estimates = [along(&known)?, along(&test_trajectories)?];
    let among = |kinds: &[&str]| -> Result<Vec<DetectorScores>> {
        let is = |one: &Sample| {
            one.trajectory.is_healthy == Some(true) || kinds.iter().any(|kind| one.task.ends_with(kind))
        };
        let chosen: Vec<usize> = (0..tests.len()).filter(|k| is(tests[*k])).collect();
        let test: Vec<Trajectory> = chosen.iter().map(|k| test_trajectories[*k].clone()).collect();
        let own: Vec<ConditionEstimate> = chosen.iter().map(|k| estimates[1][*k].clone()).collect();
        Ok(detectors((&arm, &data.features), [&known, &test], [&estimates[0], &own])?)
    };
    let [band, friction, lost_tooth] = KINDS.map(|kind| among(&[kind]));
    let detectors =
        FaultDetectors { band: band?, friction: friction?, lost_tooth: lost_tooth?, all: among(&KINDS)? };
    if file.exists() {
        std::fs::remove_file(file).map_err(|e| hysteron_base::Error::io(file, e))?;
    }
    Ok(Some(FaultCell { trained_on: training.len(), tests: test_trajectories.len(), detectors }))
}
