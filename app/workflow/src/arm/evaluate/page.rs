//! The page of `arm evaluate` for a neural actuator: the tables III to V of the paper, with every baseline.

use hysteron_arm_learning::neural::{
    DetectorScores, FORCES, ForceScores, HORIZONS, METHODS, PoseScores, TaskScores,
};
use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;

use super::outcome::ActuatorEvaluation;
use crate::shared::recording_checks;

/// Three digits behind the point, or a dash where there is no finite number.
pub(super) fn number(value: Option<f64>) -> String {
    value.filter(|x| x.is_finite()).map_or_else(|| "-".to_owned(), |x| format!("{x:.3}"))
}

/// Errors of a force as cells of a table.
pub(super) fn force_cells(scores: &ForceScores) -> [String; 6] {
    [
        scores.mean_of_axes_n,
        scores.loaded_mean_of_axes_n,
        scores.loaded_axis_n,
        scores.loaded_norm_n,
        scores.false_contact,
        scores.missed_contact,
    ]
    .map(|value| number(Some(value)))
}

/// Errors of the joints [deg], and of the aperture [mm] where there is one.
fn numbers(scores: &PoseScores) -> Vec<Option<f64>> {
    let joints = scores.joints_deg.iter().map(|error| Some(*error));
    joints.chain([scores.gripper_mm]).map(|error| error.filter(|x| x.is_finite())).collect()
}

/// The same, column by column the mean of all rows.
fn means(rows: &[Vec<Option<f64>>]) -> Vec<Option<f64>> {
    let column = |k: usize| -> Option<f64> {
        let values = rows.iter().map(|row| row.get(k).copied().flatten());
        Some(values.sum::<Option<f64>>()? / rows.len() as f64)
    };
    (0..rows.first().map_or(0, Vec::len)).map(column).collect()
}

/// As the paper prints them: `J1 / J2 / J3 / J4 | gripper`.
fn shown(errors: &[Option<f64>]) -> String {
    let all: Vec<String> =
        errors.iter().map(|x| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.2}"))).collect();
    all.split_last()
        .map_or_else(String::new, |(gripper, joints)| format!("{} | {gripper}", joints.join(" / ")))
}

/// Writes `report.html` and `metrics.json` to `folder`.
pub(super) fn write(folder: &ReportFolder, outcome: &ActuatorEvaluation) -> anyhow::Result<()> {
    folder.write_metrics(outcome)?;
    let about = "Rollouts from the true initial state, as tables III to V of NeuralActuator: mean absolute error over the first steps, by \
                 joint, aperture and force. Baselines were fitted to the training recordings.";
    let conclusion = format!(
        "The actuator, trained on {} recordings, is compared with its baselines on {} tasks.",
        outcome.trained_on,
        outcome.tasks.len()
    );
    let mut page = Page::concluded("Neural actuator", &conclusion, about, &outcome.command);
    for (at, horizon) in HORIZONS.iter().enumerate() {
        page.heading(&format!("First {horizon} steps: joints [deg] | aperture [mm]"));
        poses(&mut page, &outcome.tasks, at);
    }
    page.heading("Force on the tip [N], whole trajectories");
    forces(&mut page, &outcome.tasks);
    if let Some(detectors) = &outcome.detectors {
        page.heading("Condition of the watched motor, windows of 64 samples");
        let row =
            |one: &DetectorScores| vec![one.name.clone(), number(Some(one.accuracy)), number(Some(one.area))];
        page.table(&["Detector", "Accuracy", "Area under the curve"], detectors.iter().map(row));
    }
    recording_checks::show(&outcome.recording_warnings, &mut page);
    folder.write_page(page, &outcome.commit)
}

/// Errors of the poses of every task by every method, at the horizon with this index; and their means.
fn poses(page: &mut Page, tasks: &[TaskScores], at: usize) {
    let scores = |task: &TaskScores, method: usize| numbers(task.poses.values()[method].values()[at]);
    let row = |name: &str, of: &dyn Fn(usize) -> Vec<Option<f64>>| -> Vec<String> {
        std::iter::once(name.to_owned()).chain((0..METHODS.len()).map(|method| shown(&of(method)))).collect()
    };
    let rows = tasks.iter().map(|task| row(&task.task, &|method| scores(task, method)));
    let mean = |method: usize| means(&tasks.iter().map(|task| scores(task, method)).collect::<Vec<_>>());
    let head: Vec<&str> = std::iter::once("Task").chain(METHODS).collect();
    page.table(&head, rows.chain([row("mean", &mean)]));
}

fn forces(page: &mut Page, tasks: &[TaskScores]) {
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
    let rows = tasks.iter().flat_map(|task| {
        let of = |((_, name), scores): (&(&str, &str), Option<&ForceScores>)| {
            let names = [task.task.clone(), (*name).to_owned()];
            Some(names.into_iter().chain(force_cells(scores?)).collect())
        };
        FORCES.iter().zip(task.forces.values()).filter_map(of).collect::<Vec<Vec<String>>>()
    });
    page.table(&head, rows);
}
