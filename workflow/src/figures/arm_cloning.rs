//! The report of behaviour cloning with and without a force.

use std::path::Path;

use hysteron_base::{Metadata, json};
use hysteron_report::page::{Page, write_metrics, write_page};
use serde_json::Value;

use crate::arm_study::cloning::score::{Row, Task};

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
    let value = write_metrics(
        folder,
        &json!({
            "format": "hysteron-metrics", "version": 1, "study": about, "rows": rows, "published": published,
            "command": meta.command, "commit": meta.commit,
        }),
    )?;
    let text = "Success rates of policies that put an object of unknown mass in place, or hold it there, on the virtual arm. All rows are \
                tried on the same trials. Printed for a real arm, of 40 trials: place 32 without force and 37 with it, stay 34 and 38.";
    let mut page = Page::new("Behaviour cloning with and without a force", text, &meta.command);
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
