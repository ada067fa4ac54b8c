//! `hysteron arm evaluate` of a neural actuator: rollouts by horizon beside simple rivals, forces, contact, condition.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use hysteron_arm::Model;
use hysteron_arm::neural::{
    DetectorScores, NeuralActuator, PoseScores, Positions, Rollout, Segment, Simulation, Telemetry,
    Trajectory, condition_scores, copied_goal, detectors, force_scores, pose_scores, roll_out,
};
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
}

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
    let mut summary = summary(actuator, &tasks);
    if !known.is_empty() {
        let known = read(&known)?;
        let wanted = (&actuator.features, actuator.simulation.period, places.free);
        let training = trajectories(&known, Role::Training, wanted)?;
        summary["detectors"] = json!(detected(actuator, &simulation, &training, &tasks)?);
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
        Ok(Task { name, trajectories, positions, rollouts, pure })
    }
}

/// Every number of the evaluation.
fn summary(actuator: &NeuralActuator, tasks: &[Task]) -> Value {
    let features = &actuator.features;
    let poses = |task: &Task, method: usize| -> BTreeMap<String, PoseScores> {
        let of =
            |h: usize| (h.to_string(), pose_scores(features, &task.trajectories, &task.positions[method], h));
        HORIZONS.map(of).into_iter().collect()
    };
    let forces = |trajectories: &[Trajectory], rollouts: &[&Rollout]| {
        let said: Vec<_> = rollouts.iter().map(|one| (one.force.clone(), one.gate.clone())).collect();
        force_scores(trajectories, &said, (usize::MAX, actuator.contact))
    };
    let of_task = |task: &Task| {
        let methods: BTreeMap<&str, _> =
            METHODS.iter().enumerate().map(|(k, name)| (*name, poses(task, k))).collect();
        json!({
            "task": task.name, "trajectories": task.trajectories.len(), "poses": methods,
            "force": forces(&task.trajectories, &task.rollouts.iter().collect::<Vec<_>>()),
            "force_pure": forces(&task.trajectories, &task.pure.iter().collect::<Vec<_>>()),
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
    let rollouts: Vec<&Rollout> = tasks.iter().flat_map(|task| &task.rollouts).collect();
    let pure: Vec<&Rollout> = tasks.iter().flat_map(|task| &task.pure).collect();
    let conditions: Vec<Vec<f64>> = rollouts.iter().map(|one| one.condition.clone()).collect();
    json!({
        "format": "hysteron-neural-evaluation", "version": 1, "mean_deg": means, "force": forces(&all, &rollouts),
        "force_pure": forces(&all, &pure), "condition_accuracy_auc": condition_scores(&all, &conditions),
        "tasks": tasks.iter().map(of_task).collect::<Vec<_>>(), "left_out": actuator.details["left_out"],
        "trained_on": actuator.details["recordings"].as_array().map_or(0, Vec::len),
    })
}

/// Detectors of a degraded motor, fitted to `training`, and the network.
fn detected(
    actuator: &NeuralActuator,
    simulation: &Simulation,
    training: &[Trajectory],
    tasks: &[Task],
) -> Result<Vec<DetectorScores>, BadInput> {
    let with_label = |one: &&Trajectory| one.is_healthy.is_some();
    let training: Vec<Trajectory> = training.iter().filter(with_label).cloned().collect();
    let roll = |one: &Trajectory| roll_out(actuator, simulation, one, Telemetry::Recorded).condition;
    let known: Vec<Vec<f64>> = training.par_iter().map(roll).collect();
    let test: Vec<Trajectory> = tasks.iter().flat_map(|task| task.trajectories.clone()).collect();
    let asked: Vec<Vec<f64>> =
        tasks.iter().flat_map(|task| &task.rollouts).map(|one| one.condition.clone()).collect();
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
    for (name, key) in [("recorded currents", "force"), ("pure simulation", "force_pure")] {
        let force = &summary[key];
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
    let head =
        ["Task", "Mean of axes", "under force", "Loaded axis", "Norm", "False contact", "Missed contact"];
    page.table(
        &head,
        tasks.iter().filter(|task| !task["force"].is_null()).map(|task| {
            let name = task["task"].as_str().unwrap_or_default().to_owned();
            std::iter::once(name).chain(keys.map(|key| number(&task["force"][key], 3))).collect()
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
