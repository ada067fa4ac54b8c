//! The page of `arm generate`: what the data set holds, task by task.

use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use std::collections::BTreeMap;

use super::outcome::{ArmTrajectory, Outcome};

/// Writes `report.html` and `metrics.json` to `folder`.
pub(super) fn write(folder: &ReportFolder, outcome: &Outcome) -> anyhow::Result<()> {
    folder.write_metrics(outcome)?;
    let conclusion = format!(
        "{} trajectories of {:.1} min together, {} samples.",
        outcome.trajectories, outcome.duration_min, outcome.samples
    );
    let mut page =
        Page::concluded("Data set of the virtual arm", &conclusion, &outcome.about, &outcome.command);
    page.heading("What it holds");
    page.list(vec![
        ("Virtual arm", outcome.arm.clone()),
        ("Seed", outcome.seed.to_string()),
        ("Trajectories", outcome.trajectories.to_string()),
        ("Samples", outcome.samples.to_string()),
        ("Duration [min]", format!("{:.1}", outcome.duration_min)),
    ]);
    page.heading("Tasks");
    let mut tasks: BTreeMap<&str, Vec<&ArmTrajectory>> = BTreeMap::new();
    for row in &outcome.rows {
        let task = row.name.rsplitn(3, '/').last().unwrap_or(&row.name);
        tasks.entry(task).or_default().push(row);
    }
    let head = [
        "Task",
        "Payload [g]",
        "Condition",
        "Trajectories",
        "Samples",
        "Mean duration [s]",
        "Force labelled [% of rows]",
    ];
    page.table(&head, tasks.iter().map(|(task, rows)| cells(task, rows)));
    page.small(&format!("Arm {}.", outcome.arm_sha256));
    folder.write_page(page, &outcome.commit)
}

/// The trajectories of a task as cells of a table.
fn cells(task: &str, rows: &[&ArmTrajectory]) -> Vec<String> {
    let samples: usize = rows.iter().map(|row| row.samples).sum();
    let seconds: f64 = rows.iter().map(|row| row.duration_s).sum();
    let labelled: f64 = rows.iter().map(|row| row.labelled * row.samples as f64).sum();
    vec![
        task.to_owned(),
        format!("{:.0}", 1e3 * rows[0].payload_kg),
        rows[0].condition.clone(),
        rows.len().to_string(),
        samples.to_string(),
        format!("{:.1}", seconds / rows.len() as f64),
        format!("{:.0}", 100.0 * labelled / samples as f64),
    ]
}
