//! Recordings that `study neural` learns from: of the virtual arm, or of the arm of NAD.

use std::path::{Path, PathBuf};

use hysteron_arm_estimation::{ColumnMap, ImportOptions, import};
use hysteron_arm_learning::neural::{
    FeatureLayout, SimulationOptions, Unlabelled, gripper_of, trajectory_of,
};
use hysteron_base::{BadInput, Metadata, Recording, file, parallel};
use hysteron_virtual_rig::virtual_arm::{N_JOINTS, Planned, VirtualArm, data_set, fault_set};
use hysteron_workflow::arm::recordings::{Role, files, role_and_task};

use super::{NeuralData, Sample, Split};

/// Seed of the individual arm that is recorded.
pub(super) const INDIVIDUAL: u64 = 1;

/// Recordings with what they are for.
pub(super) type Recorded = Vec<(String, Split, Recording)>;

/// All 350 trajectories of the virtual arm, and faults that NAD does not have.
pub(super) fn recorded(general: &VirtualArm) -> anyhow::Result<Recorded> {
    let arm = general.individual(INDIVIDUAL);
    let one = |one: &Planned| -> anyhow::Result<(String, Split, Recording)> {
        let split = match one.split {
            "train" => Split::Training,
            "validation" => Split::Validation,
            _ => Split::Test,
        };
        let recording = arm.record(&one.trial, INDIVIDUAL, &one.name(), Metadata::default())?;
        Ok((format!("{}/{}", one.subset, one.task), split, recording))
    };
    parallel::try_map(&[data_set(), fault_set()].concat(), one)
}

/// Recordings of NAD (CSV), or of `hysteron arm generate`, and the identity of a set of them.
pub(super) fn read(folder: &Path) -> anyhow::Result<(Recorded, String)> {
    let paths = files(&[folder.to_owned()], &[])?;
    let mut digests = Vec::new();
    for path in &paths {
        digests.extend_from_slice(file::sha256_of(path)?.as_bytes());
    }
    let one = |path: &PathBuf| -> anyhow::Result<Option<(String, Split, Recording)>> {
        let recording = if path.extension().is_some_and(|ending| ending == "csv") {
            let columns = Some(ColumnMap::named("nad-omx")?);
            let options = ImportOptions { columns, ..Default::default() };
            import(path, &options, Metadata::default())?.recording
        } else {
            Recording::read(path)?
        };
        let Some((role, task)) = role_and_task(path) else { return Ok(None) };
        let split = match role {
            Role::Training => Split::Training,
            Role::Validation => Split::Validation,
            Role::Test => Split::Test,
        };
        Ok(Some((task, split, recording)))
    };
    let found = parallel::try_map(&paths, one)?;
    let found: Recorded = found.into_iter().flatten().collect();
    if found.is_empty() {
        let expected = "recordings in folders train, validation and test";
        return Err(BadInput::new(folder.display().to_string(), expected, "none").into());
    }
    Ok((found, file::sha256_hex(&digests)))
}

/// The recordings as networks learn from them; free motion is that of the folder `force_unlabeled`.
pub(super) fn data(recordings: &Recorded) -> anyhow::Result<NeuralData> {
    let all: Vec<Recording> = recordings.iter().map(|(_, _, recording)| recording.clone()).collect();
    let features = FeatureLayout { joints: N_JOINTS, gripper: gripper_of(&all)? };
    let period = SimulationOptions::PUBLISHED.period;
    let one = |(task, split, recording): &(String, Split, Recording)| -> anyhow::Result<Sample> {
        let is_free = task.starts_with("force_unlabeled");
        let unlabelled = if is_free { Unlabelled::Free } else { Unlabelled::Unknown };
        let trajectory =
            trajectory_of(recording, &features, period, unlabelled).map_err(|bad| bad.within(task))?;
        Ok(Sample { task: task.clone(), split: *split, trajectory })
    };
    let samples = parallel::try_map(recordings, one)?;
    Ok(NeuralData { features, period, samples })
}
