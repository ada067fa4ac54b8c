//! Actuators learned from telemetry: the virtual arm, or the arm of NAD.

use std::path::{Path, PathBuf};

use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::{ColumnMap, ImportOptions, import};
use hysteron_arm_learning::neural::{
    FeatureLayout, SimulationOptions, Unlabelled, gripper_of, trajectory_of,
};
use hysteron_base::{BadInput, Metadata, Recording, file, json, parallel};
use hysteron_studies::Listener;
use hysteron_studies::neural::{NeuralData, NeuralScope, NeuralSize, Sample, Split, neural_study};
use hysteron_virtual_rig::virtual_arm::{N_JOINTS, Planned, VirtualArm, data_set, fault_set};
use serde_json::Value;

use super::Options;
use crate::arm::recordings::{Role, files, role_and_task};
use crate::{Context, arm, arm_neural_figures};

/// Virtual arm of the study, and its model.
const ARM: &str = "open-manipulator-x";
/// Seed of the individual arm that is recorded.
const INDIVIDUAL: u64 = 1;

/// Recordings with what they are for.
type Recorded = Vec<(String, Split, Recording)>;

/// Carries out the study with these seeds of networks; `None` where it was interrupted.
pub(super) fn run(
    options: &Options,
    scope: NeuralScope,
    listener: Listener<'_>,
    context: &Context,
) -> anyhow::Result<Option<Value>> {
    let size = if options.quick { NeuralSize::Quick } else { NeuralSize::Full };
    let first = u64::from(options.first_seed);
    let seeds = first..first + if options.quick { 1 } else { options.seeds as u64 };
    let (recordings, identity) = match &options.data {
        Some(folder) => read(folder)?,
        None => {
            let general = VirtualArm::preset(ARM)?;
            let identity = json!({ "arm": general.hash, "seed": INDIVIDUAL });
            (recorded(&general)?, identity)
        }
    };
    if context.is_cancelled() {
        return Ok(None);
    }
    let data = data(&recordings)?;
    let model = Model::builtin(ARM)?;
    let about = (&model, &data, &identity);
    let found = neural_study(&options.out.join("cells"), about, (size, scope, seeds), listener)?;
    match found {
        Some(study) if !context.is_cancelled() => {
            let meta = arm::meta(context, "study of learned actuators");
            let source = match &options.data {
                Some(folder) => format!("Recordings below {}.", folder.display()),
                None => "Virtual arm, stand-in for NAD, whose physics share neither code nor parameters with what is learned and identified \
                         (docs/virtual-arm.md). Published figures are of the real arm."
                    .to_owned(),
            };
            let amount = match size {
                NeuralSize::Quick => {
                    " Quick: networks of a few minutes, which show that the study works and not what it finds."
                }
                NeuralSize::Full => "",
            };
            let about = format!("{source}{amount}");
            arm_neural_figures::write(&options.out, &study, &about, &meta).map(Some)
        }
        _ => Ok(None),
    }
}

/// All 350 trajectories of the virtual arm, and faults that NAD does not have.
fn recorded(general: &VirtualArm) -> anyhow::Result<Recorded> {
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

/// Recordings of NAD (CSV), or of `hysteron arm generate`, and what tells one set of them from another.
fn read(folder: &Path) -> anyhow::Result<(Recorded, Value)> {
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
    Ok((found, json!({ "files": file::sha256_hex(&digests) })))
}

/// The recordings as networks learn from them; free motion is that of the folder `force_unlabeled`.
fn data(recordings: &Recorded) -> anyhow::Result<NeuralData> {
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
