//! The report of behaviour cloning with and without a force.

use std::path::Path;

use hysteron_base::{Metadata, json};
use hysteron_report::page::{Page, write_metrics, write_page};
use hysteron_report::verdict::Verdict;
use serde_json::Value;

use crate::shared::verdict::{compared, repeated};
use crate::study::arm::cloning::score::{Row, Task};

/// Printed rates of NeuralActuator, table IX, 40 trials each: without and with force.
const PUBLISHED: [(Task, [usize; 2]); 2] = [(Task::Place, [32, 37]), (Task::Stay, [34, 38])];

/// Writes `report.html` and `metrics.json`.
pub fn write(folder: &Path, rows: &[Row], about: &Value, meta: &Metadata) -> anyhow::Result<Value> {
    let published: Vec<Value> = PUBLISHED
        .iter()
        .map(|(task, [without, with])| {
            json!({ "task": task, "trials": 40, "without_force": without, "with_force": with })
        })
        .collect();
    let verdict = judged(rows, about["policies"].as_u64().unwrap_or(1) as usize);
    let value = write_metrics(
        folder,
        &json!({
            "format": "hysteron-metrics", "version": 1, "study": about, "rows": rows, "published": published, "verdict": verdict,
            "command": meta.command, "commit": meta.commit,
        }),
    )?;
    let text = "Success rates of policies that put an object of unknown mass in place, or hold it there, on the virtual arm. All rows are \
                tried on the same trials. Printed for a real arm, of 40 trials: place 32 without force and 37 with it, stay 34 and 38.";
    let mut page = Page::judged("Behaviour cloning with and without a force", &verdict, text, &meta.command);
    page.heading("Results");
    let headings = [
        "Task",
        "Policy observes",
        "Successes",
        "Rate [%]",
        "95 % interval [%]",
        "Median distance [mm]",
        "Only this : only plan and positions",
        "p",
    ];
    page.table(&headings, rows.iter().map(cells));
    page.heading("Setting");
    page.details("Numbers of the study", &json::to_text(about)?);
    write_page(folder, page.finish(&meta.commit))?;
    Ok(value)
}

/// Policy that observes least.
const BASELINE: &str = "plan and positions";

/// Whether observing more than plan and positions fails less often; experts and goals as planned are no policies.
fn judged(rows: &[Row], policies: usize) -> Verdict {
    let failures = |row: &Row| (row.method.clone(), 1.0 - row.rate);
    let of = |task: Task| -> Vec<(String, f64)> {
        let is_policy = |row: &&Row| row.method == BASELINE || row.method.contains("with the");
        let policies = rows.iter().filter(|row| row.task == task).filter(is_policy);
        policies.map(failures).collect()
    };
    let claim = "policies that observe a force handle objects of unknown mass better than those that see plan and positions alone";
    let judged = compared(Verdict::on(claim), ("share of failures, place", ""), &of(Task::Place), BASELINE);
    let judged = compared(judged, ("share of failures, stay", ""), &of(Task::Stay), BASELINE);
    repeated(judged, policies, "seed").verdict()
}

fn cells(row: &Row) -> Vec<String> {
    let [low, high] = row.interval.map(|part| 100.0 * part);
    let against = row.against_nothing.map_or_else(
        || ["-".to_owned(), "-".to_owned()],
        |([this, other], p)| [format!("{this} : {other}"), format!("{p:.1e}")],
    );
    let mut cells = vec![
        format!("{:?}", row.task).to_lowercase(),
        row.method.clone(),
        format!("{} of {}", row.successes, row.trials),
        format!("{:.1}", 100.0 * row.rate),
        format!("{low:.1} to {high:.1}"),
        format!("{:.2}", row.distance_mm),
    ];
    cells.extend(against);
    cells
}
