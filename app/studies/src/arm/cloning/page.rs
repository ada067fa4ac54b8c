//! The page of `study cloning`.

use std::path::Path;

use hysteron_base::json;
use hysteron_report::page::{Page, write_metrics, write_page};

use super::outcome::Outcome;
use super::score::Row;

/// Writes `report.html` and `metrics.json`.
pub(super) fn write(folder: &Path, outcome: &Outcome) -> anyhow::Result<()> {
    write_metrics(folder, outcome)?;
    let text = "Success rates of policies that put an object of unknown mass in place, or hold it there, on the virtual arm. All rows are \
                tried on the same trials. Printed for a real arm, of 40 trials: place 32 without force and 37 with it, stay 34 and 38.";
    let title = "Behaviour cloning with and without a force";
    let mut page = Page::with_verdict(title, &outcome.verdict, text, &outcome.command);
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
    page.table(&headings, outcome.rows.iter().map(cells));
    page.heading("Setting");
    page.details("Numbers of the study", &json::to_text(&outcome.study)?);
    write_page(folder, page.finish(&outcome.commit))
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
