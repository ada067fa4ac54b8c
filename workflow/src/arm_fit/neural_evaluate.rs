//! `hysteron arm evaluate` of a neural actuator: rollouts by horizon beside simple rivals, forces, contact, condition.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use hysteron_arm::Model;
use hysteron_arm::neural::{
    DetectorScores, ForceScores, NeuralActuator, PoseScores, Positions, Rollout, Segment, Sensed, Sensing,
    Simulation, Telemetry, Trajectory, condition_scores, copied_goal, detectors, force_scores, length,
    pose_scores, roll_out, telemetry,
};
use hysteron_arm::servo_force::Observers;
use hysteron_base::{BadInput, file};
use hysteron_report::page::{Page, write_metrics, write_page};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::neural::{Rivals, trajectories};
use super::recordings::{Role, files, read};
use crate::{COMMIT, Caller, arm};

/// Horizons of the paper's tables [steps].
const HORIZONS: [usize; 3] = [100, 300, 600];

/// What is compared, in the order of the table.
const METHODS: [&str; 5] = [
    "network, recorded currents (as published)",
    "network, pure simulation (currents of the drive model)",
    "copy the goal",
    "copy the goal, lag and droop fitted",
    "servo identified by rollout",
];

/// Where it is read and written.
pub(super) struct Places<'a> {
    pub recordings: &'a [PathBuf],
    pub leave_out: &'a [String],
    pub free: &'a [String],
    pub detectors: &'a [PathBuf],
    pub model: &'a str,
    pub out: Option<&'a Path>,
    pub figures: Option<&'a Path>,
}

/// One task: its trajectories, the positions of every method, and what the network says besides.
struct Task {
    name: String,
    trajectories: Vec<Trajectory>,
    positions: Vec<Vec<Positions>>,
    rollouts: Vec<Rollout>,
    pure: Vec<Rollout>,
    /// Of the network of labels, where there is one.
    sensed: Option<Vec<Sensed>>,
    /// Forces of either momentum observer, trajectory by trajectory; none where none was identified.
    observed: Option<Vec<[Vec<[f64; 3]>; 2]>>,
}

impl Task {
    /// Forces and gates of the network, of either observer, and of the network in pure simulation where that says any.
    fn forces(&self, contact: [f64; 2]) -> [Option<Vec<Said>>; 4] {
        let of =
            |rollouts: &[Rollout]| rollouts.iter().map(|one| (one.force.clone(), one.gate.clone())).collect();
        let network = self
            .sensed
            .as_ref()
            .map(|all| all.iter().map(|one| (one.force.clone(), one.gate.clone())).collect::<Vec<Said>>());
        let observer = |k: usize| -> Option<Vec<Said>> {
            let gate = |f: &[f64; 3]| f64::from(u8::from(length(f) > contact[k]));
            let one = |own: &[Vec<[f64; 3]>; 2]| (own[k].clone(), own[k].iter().map(gate).collect());
            Some(self.observed.as_ref()?.iter().map(one).collect())
        };
        let pure = self.sensed.is_none().then(|| of(&self.pure));
        [Some(network.unwrap_or_else(|| of(&self.rollouts))), observer(0), observer(1), pure]
    }

    /// How healthy the watched motor is found, sample by sample.
    fn conditions(&self) -> Vec<Vec<f64>> {
        match &self.sensed {
            Some(all) => all.iter().map(|one| one.condition.clone()).collect(),
            None => self.rollouts.iter().map(|one| one.condition.clone()).collect(),
        }
    }
}

/// Forces and probabilities of contact, row by row.
type Said = (Vec<[f64; 3]>, Vec<f64>);

/// Who says forces, in the order of [`Task::forces`]: key and name.
const FORCES: [(&str, &str); 4] = [
    ("force", "network, recorded telemetry"),
    ("force_gmo_linear", "GMO-linear"),
    ("force_gmo_drive", "GMO-drive"),
    ("force_pure", "network, pure simulation"),
];

/// Compares an actuator and its rivals with recordings.
pub(super) fn run(actuator: &NeuralActuator, places: &Places<'_>, caller: &Caller) -> anyhow::Result<Value> {
    let files = files(places.recordings, places.leave_out)?;
    let known = match places.detectors {
        [] => Vec::new(),
        named => super::recordings::files(named, places.leave_out)?,
    };
    let outputs = arm::reads(places.model).and(&files).and(&known);
    let outputs = places.out.iter().fold(outputs, |all, out| all.file("--out", *out));
    let _claim = outputs.report("--figures", places.figures).check(caller)?;
    let model = arm::model(places.model)?;
    let simulation = actuator.simulation(&model)?;
    let rivals = Rivals::of(actuator)?;
    caller.listen()?;
    let mut by_task: BTreeMap<String, Vec<Trajectory>> = BTreeMap::new();
    for one in read(&files)? {
        // What a data set calls training or validation is no test.
        if one.role == Role::Test || !one.is_split {
            let wanted = (&actuator.features, actuator.simulation.period, places.free);
            let found = trajectories(std::slice::from_ref(&one), one.role, wanted)?;
            by_task.entry(one.task).or_default().extend(found);
        }
    }
    if by_task.is_empty() {
        let bad = BadInput::new(
            "recordings",
            "at least one for a test",
            "only recordings in folders train and validation",
        );
        return Err(bad.hint("name files, or a folder called test").into());
    }
    let bar = caller.progress("tasks", by_task.len(), 0);
    let mut tasks = Vec::new();
    for (name, trajectories) in by_task {
        if caller.is_cancelled() {
            anyhow::bail!("interrupted; nothing is written");
        }
        tasks.push(rivals.compare(actuator, (&model, &simulation), name, trajectories)?);
        bar.inc(1);
    }
    bar.finish();
    let mut summary = summary(actuator, &rivals, &tasks);
    if !known.is_empty() {
        let known = read(&known)?;
        let wanted = (&actuator.features, actuator.simulation.period, places.free);
        let training = trajectories(&known, Role::Training, wanted)?;
        summary["detectors"] = json!(detected(actuator, (&model, &simulation), &training, &tasks)?);
    }
    summary["command"] = json!(caller.command);
    summary["commit"] = json!(COMMIT);
    say(&summary, caller);
    if let Some(out) = places.out {
        file::write_bytes(out, serde_json::to_vec_pretty(&summary)?)?;
    }
    if let Some(folder) = places.figures {
        write_metrics(folder, &summary)?;
        write_page(folder, page(&summary, &caller.command).finish(COMMIT))?;
        caller.reported(folder);
    }
    Ok(summary)
}

impl Rivals {
    /// As they were fitted with the actuator, on its training data.
    fn of(actuator: &NeuralActuator) -> Result<Self, BadInput> {
        let bad = |e: serde_json::Error| BadInput::new("rivals", "those of arm fit neural", e.to_string());
        serde_json::from_value(actuator.details["rivals"].clone()).map_err(bad)
    }

    fn compare(
        &self,
        actuator: &NeuralActuator,
        (model, simulation): (&Model, &Simulation),
        name: String,
        trajectories: Vec<Trajectory>,
    ) -> anyhow::Result<Task> {
        let features = &actuator.features;
        let m = features.motors();
        let roll = |telemetry: Telemetry<'_>| -> Vec<Rollout> {
            trajectories.par_iter().map(|one| roll_out(actuator, simulation, one, telemetry)).collect()
        };
        let rollouts = roll(Telemetry::Recorded);
        let pure = roll(Telemetry::Modelled(&actuator.currents));
        let servo = |trajectory: &Trajectory| -> Result<Positions, BadInput> {
            let segment = Segment::recorded(trajectory, 0);
            let about = (features, actuator.simulation.period);
            let states = self.servo.run(model, about, &[segment], trajectory.len() - 1)?;
            Ok(states.chunks_exact(2 * m).flat_map(|state| &state[..m]).copied().collect())
        };
        let positions = vec![
            rollouts.iter().map(|one| one.positions.clone()).collect(),
            pure.iter().map(|one| one.positions.clone()).collect(),
            trajectories.iter().map(|one| copied_goal(features, one)).collect(),
            trajectories.iter().map(|one| self.lag.positions(simulation.model(), features, one)).collect(),
            trajectories.par_iter().map(servo).collect::<Result<_, _>>()?,
        ];
        let about = (features, actuator.simulation.period);
        let arm = actuator.observed_arm(model);
        let along = |sensing: &Sensing| -> Result<Vec<Sensed>, BadInput> {
            let arm = arm.clone()?;
            trajectories.par_iter().map(|one| sensing.along(&arm, about, one)).collect()
        };
        let observe = |observers: &Observers| -> Result<Vec<[Vec<[f64; 3]>; 2]>, BadInput> {
            let arm = arm.clone()?;
            let one = |one: &Trajectory| observers.forces(&arm, &telemetry(features, about.1, one)?);
            trajectories.par_iter().map(one).collect()
        };
        let sensed = actuator.sensing.as_ref().map(along).transpose()?;
        let observed = self.observers.as_ref().map(observe).transpose()?;
        Ok(Task { name, trajectories, positions, rollouts, pure, sensed, observed })
    }
}

/// Every number of the evaluation.
fn summary(actuator: &NeuralActuator, rivals: &Rivals, tasks: &[Task]) -> Value {
    let features = &actuator.features;
    let poses = |task: &Task, method: usize| -> BTreeMap<String, PoseScores> {
        let of =
            |h: usize| (h.to_string(), pose_scores(features, &task.trajectories, &task.positions[method], h));
        HORIZONS.map(of).into_iter().collect()
    };
    let contact = rivals.observers.as_ref().map_or([f64::INFINITY; 2], |own| own.contact);
    let forces = |tasks: &[&Task]| -> BTreeMap<&str, Option<ForceScores>> {
        let trajectories: Vec<Trajectory> = tasks.iter().flat_map(|task| task.trajectories.clone()).collect();
        let all: Vec<_> = tasks.iter().map(|task| task.forces(contact)).collect();
        let one = |(k, (key, _)): (usize, &(&'static str, &str))| {
            let said: Option<Vec<Vec<Said>>> = all.iter().map(|task| task[k].clone()).collect();
            let scores = |said: Vec<Vec<Said>>| {
                force_scores(&trajectories, &said.concat(), (usize::MAX, actuator.contact))
            };
            (*key, said.and_then(scores))
        };
        FORCES.iter().enumerate().map(one).collect()
    };
    let of_task = |task: &Task| {
        let methods: BTreeMap<&str, _> =
            METHODS.iter().enumerate().map(|(k, name)| (*name, poses(task, k))).collect();
        json!({
            "task": task.name, "trajectories": task.trajectories.len(), "poses": methods,
            "forces": forces(&[task]),
        })
    };
    let all: Vec<Trajectory> = tasks.iter().flat_map(|task| task.trajectories.clone()).collect();
    let mean = |method: usize, horizon: usize| {
        let n = tasks.len() as f64;
        let one = |task: &Task| {
            pose_scores(features, &task.trajectories, &task.positions[method], horizon).mean_deg()
        };
        tasks.iter().map(one).sum::<f64>() / n
    };
    let means: BTreeMap<&str, BTreeMap<String, f64>> = METHODS
        .iter()
        .enumerate()
        .map(|(k, name)| (*name, HORIZONS.iter().map(|h| (h.to_string(), mean(k, *h))).collect()))
        .collect();
    let conditions: Vec<Vec<f64>> = tasks.iter().flat_map(Task::conditions).collect();
    json!({
        "format": "hysteron-neural-evaluation", "version": 2, "mean_deg": means, "forces": forces(&tasks.iter().collect::<Vec<_>>()),
        "force_from": if actuator.sensing.is_some() { "observer" } else { "loop" },
        "condition_accuracy_auc": condition_scores(&all, &conditions),
        "tasks": tasks.iter().map(of_task).collect::<Vec<_>>(), "left_out": actuator.details["left_out"],
        "trained_on": actuator.details["recordings"].as_array().map_or(0, Vec::len),
    })
}

/// Detectors of a degraded motor, fitted to `training`, and the network.
fn detected(
    actuator: &NeuralActuator,
    (model, simulation): (&Model, &Simulation),
    training: &[Trajectory],
    tasks: &[Task],
) -> Result<Vec<DetectorScores>, BadInput> {
    let with_label = |one: &&Trajectory| one.is_healthy.is_some();
    let training: Vec<Trajectory> = training.iter().filter(with_label).cloned().collect();
    let about = (&actuator.features, actuator.simulation.period);
    let arm = actuator.observed_arm(model);
    let said = |one: &Trajectory| match &actuator.sensing {
        Some(sensing) => Ok(sensing.along(arm.as_ref().map_err(Clone::clone)?, about, one)?.condition),
        None => Ok(roll_out(actuator, simulation, one, Telemetry::Recorded).condition),
    };
    let known = training.par_iter().map(said).collect::<Result<Vec<_>, BadInput>>()?;
    let test: Vec<Trajectory> = tasks.iter().flat_map(|task| task.trajectories.clone()).collect();
    let asked: Vec<Vec<f64>> = tasks.iter().flat_map(Task::conditions).collect();
    detectors((simulation.model(), &actuator.features), [&training, &test], [&known, &asked])
}

fn number(value: &Value, digits: usize) -> String {
    value.as_f64().map_or_else(|| "-".to_owned(), |x| format!("{x:.digits$}"))
}

fn say(summary: &Value, caller: &Caller) {
    caller.say("mean absolute error of the joints over the first steps of rollouts [deg], mean of tasks:");
    let head = HORIZONS.map(|h| format!("{h:>8}")).concat();
    caller.say(format_args!("{:56}{head}", ""));
    for name in METHODS {
        let cells = HORIZONS.map(|h| format!("{:>8}", number(&summary["mean_deg"][name][h.to_string()], 3)));
        caller.say(format_args!("{name:56}{}", cells.concat()));
    }
    for (key, name) in FORCES {
        let force = &summary["forces"][key];
        if !force.is_null() {
            let of = |key: &str| number(&force[key], 3);
            caller.say(format_args!(
                "force, {name}: mean of three axes {} N (under force {} N), loaded axis {} N, norm {} N; false contact {}, missed {}",
                of("mean_of_axes_n"),
                of("loaded_mean_of_axes_n"),
                of("loaded_axis_n"),
                of("loaded_norm_n"),
                of("false_contact"),
                of("missed_contact")
            ));
        }
    }
    if let Some([accuracy, auc]) = summary["condition_accuracy_auc"].as_array().map(Vec::as_slice) {
        caller.say(format_args!(
            "condition: accuracy {}, area under the curve {}",
            number(accuracy, 3),
            number(auc, 3)
        ));
    }

    for detector in summary["detectors"].as_array().map_or(&[][..], Vec::as_slice) {
        let name = detector["name"].as_str().unwrap_or_default();
        let of = |key: &str| number(&detector[key], 3);
        caller.say(format_args!(
            "condition over windows, {name}: accuracy {}, area {}",
            of("accuracy"),
            of("area")
        ));
    }
}

/// The tables III to V of the paper, with every rival.
fn page(summary: &Value, command: &str) -> Page {
    let about = "Rollouts from the true initial state, as tables III to V of NeuralActuator: mean absolute error over the first steps, by \
                 joint, aperture and force. Rivals were fitted to the training recordings.";
    let mut page = Page::new("Neural actuator", about, command);
    let tasks = summary["tasks"].as_array().map_or(&[][..], Vec::as_slice);
    for horizon in HORIZONS {
        page.heading(&format!("First {horizon} steps: joints [deg] | aperture [mm]"));
        let head: Vec<&str> = std::iter::once("Task").chain(METHODS).collect();
        let cell = |task: &Value, name: &str| {
            let scores = &task["poses"][name][horizon.to_string()];
            let joints = scores["joints_deg"].as_array().map_or(&[][..], Vec::as_slice);
            let joints: Vec<String> = joints.iter().map(|x| number(x, 2)).collect();
            format!("{} | {}", joints.join(" / "), number(&scores["gripper_mm"], 2))
        };
        page.table(
            &head,
            tasks.iter().map(|task| {
                let name = task["task"].as_str().unwrap_or_default().to_owned();
                std::iter::once(name).chain(METHODS.map(|method| cell(task, method))).collect()
            }),
        );
    }
    page.heading("Force on the tip [N], whole trajectories");
    let keys = [
        "mean_of_axes_n",
        "loaded_mean_of_axes_n",
        "loaded_axis_n",
        "loaded_norm_n",
        "false_contact",
        "missed_contact",
    ];
    let head = [
        "Task",
        "By",
        "Mean of axes",
        "under force",
        "Loaded axis",
        "Norm",
        "False contact",
        "Missed contact",
    ];
    page.table(
        &head,
        tasks.iter().flat_map(|task| {
            let of = move |(key, name): (&str, &str)| {
                let force = &task["forces"][key];
                let cells = keys.map(|key| number(&force[key], 3)).to_vec();
                let names = [task["task"].as_str().unwrap_or_default(), name].map(str::to_owned);
                (!force.is_null()).then(|| [names.to_vec(), cells].concat())
            };
            FORCES.into_iter().filter_map(of)
        }),
    );
    if let Some(detectors) = summary["detectors"].as_array() {
        page.heading("Condition of the watched motor, windows of 64 samples");
        page.table(
            &["Detector", "Accuracy", "Area under the curve"],
            detectors.iter().map(|one| {
                let name = one["name"].as_str().unwrap_or_default().to_owned();
                vec![name, number(&one["accuracy"], 3), number(&one["area"], 3)]
            }),
        );
    }
    page
}
