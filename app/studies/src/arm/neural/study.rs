//! The study, cell by cell.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use hysteron_base::json;
use hysteron_learn::{Error, Result, TrainingProgress};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::cells::{FAULTS, LEFT_OUT, NETWORKS, NetworkKind, NeuralScope, NeuralSize, Protocol};
use super::comparison::{FaultCell, NeuralCell};
use super::faults::{FAULT_SPLITS, fault_cell};
use super::gradients::by_horizon;
use super::{NeuralData, Split};
use crate::runner::cells::{Listener, cell, make_folder};
use crate::runner::side_by_side::{at_once, side_by_side};
use hysteron_arm_dynamics::Model;
use hysteron_arm_learning::neural::{
    ActuatorOptions, ActuatorSession, BaselineComparison, Trajectory, fit_actuator,
};

/// The study, split by split and network by network.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct NeuralStudy {
    /// The first network of [`NETWORKS`] on the published split, seed by seed.
    pub published: Vec<NeuralCell>,
    /// Splits of [`LEFT_OUT`], seed by seed; empty where networks alone are compared, as are faults.
    pub left_out: Vec<Vec<NeuralCell>>,
    /// Networks of [`NETWORKS`] but the first, seed by seed.
    pub networks: Vec<Vec<NeuralCell>>,
    /// Splits of [`FAULT_SPLITS`], seed by seed; empty without such data.
    pub faults: Vec<Vec<FaultCell>>,
}

/// Tasks that figures show.
const SHOWN: [&str; 3] = ["force_unlabeled/sweep_2", "force_sensor/z_minus", "weight/pick_place_object_300g"];

/// A cell that is done.
enum Done {
    Compared(Box<NeuralCell>),
    Faults(FaultCell),
}

/// One cell that is to be done.
struct Plan {
    name: String,
    network: &'static NetworkKind,
    protocol: Protocol,
    seed: u64,
    has_sensing: bool,
}

fn plans(seeds: &Range<u64>, scope: NeuralScope, has_faults: bool) -> Vec<Plan> {
    let mut all = Vec::new();
    let first = &NETWORKS[0];
    let is_whole = scope == NeuralScope::Whole;
    for seed in seeds.clone() {
        let plan = |name: &str, protocol| Plan {
            name: format!("{name}-{seed}"),
            network: first,
            protocol,
            seed,
            has_sensing: is_whole,
        };
        all.push(plan(published(scope), Protocol::Published));
        if is_whole {
            if has_faults {
                all.extend(FAULT_SPLITS.map(|(name, left_out)| plan(name, Protocol::Faults(left_out))));
            }
            all.extend(LEFT_OUT.map(|(name, text)| plan(name, Protocol::LeaveOut(text))));
        }
        all.extend(NETWORKS[1..].iter().map(|network| Plan {
            name: format!("{}-{seed}", network.file),
            network,
            protocol: Protocol::Published,
            seed,
            has_sensing: false,
        }));
    }
    all
}

/// Cells of the first network on the published split.
fn published(scope: NeuralScope) -> &'static str {
    match scope {
        NeuralScope::Whole => "published",
        NeuralScope::Networks => NETWORKS[0].file,
    }
}

/// Trains and compares actuators of `model` with these seeds; `identity` describes the data. `None` where the
/// listener ended it; what is done is found again below `folder`, and a training resumes from its file there.
///
/// # Errors
/// Cells of another study; files that cannot be written; data without what is needed.
pub fn neural_study<I: Serialize + Sync>(
    folder: &Path,
    about: (&Model, &NeuralData, &I),
    (size, scope, seeds): (NeuralSize, NeuralScope, Range<u64>),
    listener: Listener<'_>,
) -> Result<Option<NeuralStudy>> {
    let period = about.1.period;
    let actuator_of = |network: &NetworkKind, seed: u64| size.actuator(network, seed, period);
    study_with(folder, about, (&actuator_of, scope, seeds), listener)
}

/// Actuators of the cells, by network and seed.
pub(super) type ActuatorOf<'a> = &'a (dyn Fn(&NetworkKind, u64) -> ActuatorOptions + Sync);

/// The study with these actuators.
pub(super) fn study_with<I: Serialize + Sync>(
    folder: &Path,
    (model, data, identity): (&Model, &NeuralData, &I),
    (actuator_of, scope, seeds): (ActuatorOf<'_>, NeuralScope, Range<u64>),
    listener: Listener<'_>,
) -> Result<Option<NeuralStudy>> {
    make_folder(folder)?;
    let plans = plans(&seeds, scope, data.samples.iter().any(|one| one.task.starts_with(FAULTS)));
    let options = |plan: &Plan| {
        let mut options = actuator_of(plan.network, plan.seed);
        if !plan.has_sensing {
            options.sensing = None;
        }
        options
    };
    let compute = |k: usize, progress: &mut dyn FnMut(&TrainingProgress) -> bool| {
        let (plan, options) = (&plans[k], options(&plans[k]));
        let identity = json!({ "study": "neural", "version": 4, "data": identity, "options": options });
        if let Protocol::Faults(_) = plan.protocol {
            let file = folder.join(format!("{}.training", plan.name));
            let fit = || fault_cell((model, data), plan.protocol, &options, &file, progress);
            return Ok(cell(folder, &plan.name, &identity, fit)?.map(Done::Faults));
        }
        let compare = || compared(folder, (model, data), plan, &options, progress);
        Ok(cell(folder, &plan.name, &identity, compare)?.map(|row| Done::Compared(Box::new(row))))
    };
    let names: Vec<&str> = plans.iter().map(|plan| plan.name.as_str()).collect();
    let Some(found) = side_by_side(at_once(), &names, listener, &compute)? else { return Ok(None) };
    let (mut comparisons, mut faults) = (BTreeMap::new(), BTreeMap::new());
    for (name, done) in names.iter().copied().zip(found) {
        match done {
            Done::Compared(row) => drop(comparisons.insert(name, *row)),
            Done::Faults(row) => drop(faults.insert(name, row)),
        }
    }
    let rows = |name: &str| by_seed(&comparisons, name, &seeds);
    Ok(Some(NeuralStudy {
        published: rows(published(scope)),
        left_out: LEFT_OUT.iter().map(|(name, _)| rows(name)).collect(),
        networks: NETWORKS[1..].iter().map(|network| rows(network.file)).collect(),
        faults: FAULT_SPLITS.iter().map(|(name, _)| by_seed(&faults, name, &seeds)).collect(),
    }))
}

/// The cells of this name, seed by seed.
fn by_seed<C: Clone>(done: &BTreeMap<&str, C>, name: &str, seeds: &Range<u64>) -> Vec<C> {
    seeds.clone().filter_map(|seed| done.get(format!("{name}-{seed}").as_str()).cloned()).collect()
}

/// A cell: trains an actuator and compares it.
fn compared(
    folder: &Path,
    (model, data): (&Model, &NeuralData),
    plan: &Plan,
    options: &ActuatorOptions,
    listener: &mut dyn FnMut(&TrainingProgress) -> bool,
) -> Result<Option<NeuralCell>> {
    let of = |split: Split| -> Vec<Trajectory> {
        let own = data.samples.iter().filter(|one| plan.protocol.uses(one, split));
        own.map(|one| one.trajectory.clone()).collect()
    };
    let [training, validation] = [Split::Training, Split::Validation].map(of);
    let names: Vec<String> =
        training.iter().chain(&validation).map(|one| format!("{} ({})", one.name, one.len())).collect();
    let files = ["training", "sensing-training"].map(|ending| folder.join(format!("{}.{ending}", plan.name)));
    let mut session = ActuatorSession {
        recordings: &names,
        files: [&files[0], &files[1]],
        progress: &mut |_, p| listener(p),
    };
    let found = match fit_actuator(model, &data.features, [&training, &validation], options, &mut session) {
        Ok(found) if found.is_finished => found,
        Ok(_) | Err(Error::NothingTrained) => return Ok(None),
        Err(error) => return Err(error),
    };
    let actuator = found.actuator;
    let mut tasks: BTreeMap<&str, Vec<Trajectory>> = BTreeMap::new();
    for one in data.samples.iter().filter(|one| plan.protocol.uses(one, Split::Test)) {
        tasks.entry(&one.task).or_default().push(one.trajectory.clone());
    }
    let mut comparison = BaselineComparison::new(&actuator, model)?;
    let n_tasks = tasks.len();
    for (k, (task, trajectories)) in tasks.into_iter().enumerate() {
        // A comparison is long: cancelling the study does not wait for it. The networks are in their files.
        if !listener(&TrainingProgress::Step { epoch: found.epochs, done: k, of: n_tasks }) {
            return Ok(None);
        }
        comparison.add(task.to_owned(), trajectories)?;
    }
    let counts = [options.shape(&data.features).n_parameters(), training.len()];
    let mut row = NeuralCell::new(comparison.summary(), found.validation, counts);
    if plan.has_sensing {
        let conditions: Vec<Trajectory> = data
            .samples
            .iter()
            .filter(|one| one.task.starts_with("motor_condition") && plan.protocol.uses(one, Split::Training))
            .map(|one| one.trajectory.clone())
            .collect();
        // Where one condition is missing, no detector can be evaluated.
        row.detectors = comparison.detectors("motor_condition", &conditions).ok();
    }
    if plan.protocol == Protocol::Published && plan.seed == 0 && plan.has_sensing {
        row.traces = Some(SHOWN.map(|task| comparison.trace(task, data.period)).to_vec());
        let tests: Vec<&Trajectory> =
            data.samples.iter().filter(|one| one.split == Split::Test).map(|one| &one.trajectory).collect();
        row.gradients = by_horizon(&actuator, model, &tests)?;
        actuator.write(&folder.join(format!("{}.safetensors", plan.name)))?;
    }
    for file in files.iter().filter(|file| file.exists()) {
        std::fs::remove_file(file).map_err(|e| hysteron_base::Error::io(file, e))?;
    }
    Ok(Some(row))
}
