//! `hysteron arm evaluate` of a neural actuator: rollouts by horizon beside simple rivals, forces, contact, condition.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use hysteron_arm::neural::{Comparison, FORCES, HORIZONS, METHODS, NeuralActuator, Trajectory};
use hysteron_base::checks::Purpose;
use hysteron_base::{BadInput, file, json};
use hysteron_report::page::{Page, write_metrics, write_page};
use serde_json::Value;

use super::neural::trajectories;
use super::recordings::{Role, checked, files, read};
use crate::figures::arm_neural::mean_of;
use crate::shared::error::Cancelled;
use crate::{COMMIT, Context, arm};

/// Where it is read and written.
pub(super) struct Places<'a> {
    pub recordings: &'a [PathBuf],
    pub leave_out: &'a [String],
    pub free: &'a [String],
    pub detectors: &'a [PathBuf],
    pub model: &'a str,
    pub robot_options: &'a arm::RobotOptions,
    pub out: Option<&'a Path>,
    pub figures: Option<&'a Path>,
}

/// Compares an actuator and its rivals with recordings.
pub(super) fn run(
    actuator: &NeuralActuator,
    places: &Places<'_>,
    context: &Context,
) -> anyhow::Result<Value> {
    let files = files(places.recordings, places.leave_out)?;
    let known = match places.detectors {
        [] => Vec::new(),
        named => super::recordings::files(named, places.leave_out)?,
    };
    let outputs = arm::reads(places.model).and(&files).and(&known);
    let outputs = places.out.iter().fold(outputs, |all, out| all.file("--out", *out));
    let _claim = outputs.report("--figures", places.figures).check(context)?;
    let model = places.robot_options.model(places.model, context)?;
    context.listen();
    let mut by_task: BTreeMap<String, Vec<Trajectory>> = BTreeMap::new();
    let named = read(&files)?;
    let findings = checked(&named, &model, Purpose::Score)?;
    for one in named {
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
    let bar = context.progress("tasks", by_task.len(), 0);
    let mut comparison = Comparison::new(actuator, &model)?;
    for (name, trajectories) in by_task {
        if context.is_cancelled() {
            return Err(Cancelled::new("; nothing is written").into());
        }
        comparison.add(name, trajectories)?;
        bar.inc(1);
    }
    bar.finish();
    let mut summary = json::to_value(comparison.summary())?;
    if !known.is_empty() {
        let known = read(&known)?;
        let wanted = (&actuator.features, actuator.simulation.period, places.free);
        let training = trajectories(&known, Role::Training, wanted)?;
        summary["detectors"] = json!(comparison.detectors("", &training)?);
    }
    summary["recording_warnings"] = json!(findings);
    summary["command"] = json!(context.command);
    summary["commit"] = json!(COMMIT);
    print(&summary, context);
    if let Some(out) = places.out {
        file::write_bytes(out, json::to_text(&summary)?)?;
    }
    if let Some(folder) = places.figures {
        write_metrics(folder, &summary)?;
        let mut page = page(&summary, &context.command);
        findings.show(&mut page);
        write_page(folder, page.finish(COMMIT))?;
        context.reported(folder);
    }
    Ok(summary)
}

fn number(value: &Value, digits: usize) -> String {
    value.as_f64().map_or_else(|| "-".to_owned(), |x| format!("{x:.digits$}"))
}

/// Errors by method and horizon.
fn say_poses(summary: &Value, (key, what, unit): (&str, &str, &str), context: &Context) {
    context.print(format_args!(
        "mean absolute error {what} over the first steps of rollouts [{unit}], mean of tasks:"
    ));
    let head = HORIZONS.map(|h| format!("{h:>8}")).concat();
    context.print(format_args!("{:56}{head}", ""));
    for name in METHODS {
        let cells = HORIZONS.map(|h| format!("{:>8}", number(&summary[key][name][h.to_string()], 3)));
        context.print(format_args!("{name:56}{}", cells.concat()));
    }
}

fn print(summary: &Value, context: &Context) {
    say_poses(summary, ("mean_deg", "of the joints", "deg"), context);
    if !summary["mean_gripper_mm"][METHODS[0]]["100"].is_null() {
        say_poses(summary, ("mean_gripper_mm", "of the aperture", "mm"), context);
    }
    for (key, name) in FORCES {
        let force = &summary["forces"][key];
        if !force.is_null() {
            let of = |key: &str| number(&force[key], 3);
            context.print(format_args!(
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
        context.print(format_args!(
            "condition: accuracy {}, area under the curve {}",
            number(accuracy, 3),
            number(auc, 3)
        ));
    }

    for detector in summary["detectors"].as_array().map_or(&[][..], Vec::as_slice) {
        let name = detector["name"].as_str().unwrap_or_default();
        let of = |key: &str| number(&detector[key], 3);
        context.print(format_args!(
            "condition over windows, {name}: accuracy {}, area {}",
            of("accuracy"),
            of("area")
        ));
    }
}

/// Errors of the joints [deg], and of the aperture [mm] where there is one.
fn numbers(scores: &Value) -> Vec<Option<f64>> {
    let joints = scores["joints_deg"].as_array().map_or(&[][..], Vec::as_slice);
    joints.iter().chain([&scores["gripper_mm"]]).map(Value::as_f64).collect()
}

/// The same, column by column the mean of all rows.
fn means(rows: &[Vec<Option<f64>>]) -> Vec<Option<f64>> {
    let column = |k: usize| mean_of(rows.iter().map(|row| row.get(k).copied().flatten()));
    (0..rows.first().map_or(0, Vec::len)).map(column).collect()
}

/// As the paper prints them: `J1 / J2 / J3 / J4 | gripper`.
fn shown(errors: &[Option<f64>]) -> String {
    let all: Vec<String> =
        errors.iter().map(|x| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.2}"))).collect();
    all.split_last()
        .map_or_else(String::new, |(gripper, joints)| format!("{} | {gripper}", joints.join(" / ")))
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
        let scores = |task: &Value, name: &str| numbers(&task["poses"][name][horizon.to_string()]);
        let row = |name: &str, of: &dyn Fn(&str) -> Vec<Option<f64>>| {
            std::iter::once(name.to_owned()).chain(METHODS.map(|method| shown(&of(method)))).collect()
        };
        let rows = tasks
            .iter()
            .map(|task| row(task["task"].as_str().unwrap_or_default(), &|method| scores(task, method)));
        let mean = |method: &str| means(&tasks.iter().map(|task| scores(task, method)).collect::<Vec<_>>());
        page.table(&head, rows.chain([row("mean", &mean)]));
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
