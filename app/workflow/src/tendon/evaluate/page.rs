//! The page of an evaluation: verdict, table of scores, target and tips.

use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;

use super::figures::{over_time, overlay};
use super::outcome::Outcome;
use super::table::{Commanded, Row, ScoredRecordings, cells, headings};
use crate::shared::health;

/// Writes the figures, `report.html` and `metrics.json` to `folder`.
pub(super) fn write(
    folder: &ReportFolder,
    shown: &ScoredRecordings,
    outcome: &Outcome,
) -> anyhow::Result<()> {
    folder.write_metrics(outcome)?;
    let ScoredRecordings { target, rows, commanded, findings } = *shown;
    let about = "How closely the tip followed the target, in the plane (x, y). RMSE and NRMSE by nearest points, averaged \
                 over x and y, and polygon IoU as in the CoReAct paper, section V-B; definitions in docs/control.md.";
    let mut page =
        Page::with_verdict(&format!("Target {}", target.name), &outcome.verdict, about, &outcome.command);
    page.heading("Results");
    if let Some(Commanded { extrapolating, limited, .. }) = commanded {
        let percent = |part: f64| format!("{:.1} % of the samples", 100.0 * part);
        if *extrapolating > 0.0 {
            page.paragraph(&format!(
                "Warning: the network left its training range in {}.",
                percent(*extrapolating)
            ));
        }
        page.list([
            ("Network outside its training", percent(*extrapolating)),
            ("Strokes limited", percent(*limited)),
        ]);
    }
    page.table(&headings(), cells(rows));
    if let Some(health) = commanded.and_then(|commanded| commanded.health.as_ref()) {
        health::section(&mut page, folder, health)?;
    }
    page.heading("Figures");
    folder.add(&mut page, &overlay(target, rows))?;
    if let Some(chart) = over_time(target, rows) {
        folder.add(&mut page, &chart)?;
    }
    page.heading("Recordings");
    let source = |row: &Row| vec![row.name.clone(), row.source.clone(), row.sha256.clone()];
    page.table(&["Recording", "Source", "SHA-256"], rows.iter().map(source));
    findings.show(&mut page);
    page.small(&format!("Target {}.", target.hash));
    folder.write_page(page, &outcome.commit)
}
