//! The report of an evaluation: targets dashed, what became of them coloured by error (CoReAct paper, Figs. 4 to 6).

use std::path::Path;

use hysteron_control::TargetPath;
use hysteron_control::tracking::{Timed, errors};
use plotters::prelude::*;

use crate::shared::health;
use crate::tendon::evaluate::{Commanded, Outcome, Row, ScoredRecordings, cells, headings};
use hysteron_report::figure::{Drawn, Figure, register_embedded_font, save};
use hysteron_report::folder::ReportFolder;
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::page::{Page, write_metrics, write_page};
use hysteron_report::plane::{dashes, square_around};
use hysteron_report::series::millimetres;
use hysteron_report::sheet::{BELOW, COLORS, LEFT, Sheet, number, ramp};
use hysteron_report::simplify::{between_sharp_turns, simplified};

/// Colour of the target.
pub const TARGET: RGBColor = COLORS[0];
/// Side of the square inside a pair of axes, height of the line above it, room between columns [px].
const SIDE: f64 = 240.0;
const ABOVE: f64 = 26.0;
const COLUMN: f64 = LEFT + SIDE + 18.0;
const ROW: f64 = ABOVE + SIDE + BELOW + 10.0;
const BAR: f64 = 90.0;
/// Recordings that are drawn at most.
const MAX_PANELS: usize = 12;
/// Recordings in a chart over time at most.
const MAX_CURVES: usize = 5;
/// Colours that can be distinguished along a path.
const SHADES: f64 = 24.0;

/// Writes the figure, `report.html` and `metrics.json` to `folder`.
pub(crate) fn write(
    folder: &Path,
    shown: &ScoredRecordings,
    outcome: &Outcome,
    with_png: bool,
) -> anyhow::Result<()> {
    register_embedded_font()?;
    let ScoredRecordings { target, rows, commanded, findings } = *shown;
    write_metrics(folder, outcome)?;
    let figure = save(folder, &Overlay::new(target, rows), with_png)?;
    let about = "How closely the tip followed the target, in the plane (x, y). RMSE and NRMSE by nearest points, averaged \
                 over x and y, and polygon IoU as in the CoReAct paper, section V-B; definitions in docs/control.md.";
    let mut page =
        Page::judged(&format!("Target {}", target.name), &outcome.verdict, about, &outcome.command);
    page.heading("Results");
    if let Some(Commanded { extrapolating, limited, .. }) = commanded {
        let percent = |part: f64| format!("{:.1} % of the samples", 100.0 * part);
        if *extrapolating > 0.0 {
            page.paragraph(&format!(
                "Warning: the network was asked for what it had not seen in training in {}.",
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
        health::section(&mut page, &ReportFolder { path: folder, png: with_png }, health)?;
    }
    page.heading("Figures");
    page.figure(&figure);
    if let Some(chart) = over_time(target, rows) {
        page.figure(&save(folder, &chart, with_png)?);
    }
    page.heading("Recordings");
    let source = |row: &Row| vec![row.name.clone(), row.source.clone(), row.sha256.clone()];
    page.table(&["Recording", "Source", "SHA-256"], rows.iter().map(source));
    findings.show(&mut page);
    page.small(&format!("Target {}.", target.hash));
    write_page(folder, page.finish(&outcome.commit))?;
    Ok(())
}

/// Target and tips at the same times, and their distance; `None` where the times do not compare.
pub fn over_time(target: &TargetPath, rows: &[Row]) -> Option<TimeChart> {
    let shown: Vec<&Row> =
        rows.iter().filter(|row| row.score.aligned_rmse_m.is_some()).take(MAX_CURVES).collect();
    if shown.is_empty() {
        return None;
    }
    let samples: Vec<usize> = target.curve().collect();
    let time: Vec<f64> = samples.iter().map(|i| target.time(*i)).collect();
    let goal: Vec<[f64; 3]> = samples.iter().map(|i| target.points()[*i]).collect();
    let tip = |row: &Row| -> Vec<[f64; 2]> {
        let path = Timed { time: &row.tracked.time, points: &row.tracked.points };
        time.iter().map(|t| path.at(*t).unwrap_or([f64::NAN; 2])).collect()
    };
    let tips: Vec<Vec<[f64; 2]>> = shown.iter().map(|row| tip(row)).collect();
    // The first colour is the target's.
    let curves = |of: &dyn Fn(usize, &[f64; 2]) -> f64| -> Vec<Curve> {
        let values = |tip: &Vec<[f64; 2]>| tip.iter().enumerate().map(|(i, p)| 1e3 * of(i, p)).collect();
        shown
            .iter()
            .zip(&tips)
            .enumerate()
            .map(|(k, (row, tip))| Curve::new(&row.name, k + 1, values(tip)))
            .collect()
    };
    let axis = |c: usize| {
        let wanted = Curve::new("target", 0, goal.iter().map(|p| 1e3 * p[c]).collect());
        let panel = [wanted].into_iter().chain(curves(&|_, p| p[c])).collect();
        TimePanel::new(["x [mm]", "y [mm]"][c], panel)
    };
    let distance = |i: usize, p: &[f64; 2]| (p[0] - goal[i][0]).hypot(p[1] - goal[i][1]);
    let panels = vec![axis(0), axis(1), TimePanel::new("error [mm]", curves(&distance))];
    let more = match rows.len() - shown.len() {
        0 => String::new(),
        n => format!(" {n} more recordings are in the table."),
    };
    let caption = format!(
        "Target and measured tip at equal times, and the distance between them [mm] over time [s]. A tip that follows late \
         shows a large error here even where its path lies on the target.{more}"
    );
    Some(TimeChart::over_time("tracking-time", "Target and tip over time", caption, &time, panels))
}

/// Writes the figure alone, as `tracking.svg`, to `folder`.
pub fn overlay(folder: &Path, target: &TargetPath, rows: &[Row]) -> anyhow::Result<Drawn> {
    save(folder, &Overlay::new(target, rows), false)
}

/// Target and paths over each other, one pair of axes per recording.
struct Overlay {
    /// The target's curve [mm].
    target: Vec<(f64, f64)>,
    panels: Vec<Panel>,
    /// Number of recordings that are not drawn.
    n_left_out: usize,
}

struct Panel {
    name: String,
    /// Path [mm], and distance of each point from the target [mm].
    path: Vec<(f64, f64)>,
    errors: Vec<f64>,
}

impl Overlay {
    fn new(target: &TargetPath, rows: &[Row]) -> Self {
        let panel = |row: &Row| Panel {
            name: row.name.clone(),
            path: row.tracked.curve().iter().map(|[x, y]| (1e3 * x, 1e3 * y)).collect(),
            errors: millimetres(&errors(target, &row.tracked)),
        };
        Self {
            target: target.outline.points().iter().map(|p| (1e3 * p[0], 1e3 * p[1])).collect(),
            panels: rows.iter().take(MAX_PANELS).map(panel).collect(),
            n_left_out: rows.len().saturating_sub(MAX_PANELS),
        }
    }

    /// Largest distance from the target in all panels [mm].
    fn largest(&self) -> f64 {
        self.panels.iter().flat_map(|panel| &panel.errors).fold(1e-6, |most: f64, error| most.max(*error))
    }

    fn draw_panel<DB: DrawingBackend>(&self, panel: &Panel, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let paths = self.panels.iter().flat_map(|panel| &panel.path);
        let ([x, y], half) = square_around(self.target.iter().chain(paths));
        let mm_per_px = 2.0 * half / SIDE;
        let most = panel.errors.iter().copied().fold(0.0, f64::max);
        sheet.text(&format!("{}: at most {} mm off", panel.name, number(most)), LEFT, 12.0)?;
        let part = sheet.part(0.0, ABOVE, LEFT + SIDE, SIDE + BELOW);
        let mut chart = part.chart(x - half..x + half, y - half..y + half, "x [mm]", "y [mm]")?;
        for (shade, line) in shades(panel, self.largest()) {
            let fewer = simplified(&line, 0.15 * mm_per_px);
            for run in between_sharp_turns(&fewer) {
                chart.draw_series(LineSeries::new(run.iter().copied(), part.line(ramp(shade), 2.2)))?;
            }
        }
        for dash in dashes(&self.target, 5.0 * mm_per_px) {
            chart.draw_series(LineSeries::new(dash, part.line(TARGET, 1.2)))?;
        }
        Ok(())
    }
}

impl Figure for Overlay {
    fn name(&self) -> String {
        "tracking".into()
    }

    fn title(&self) -> String {
        "Target and tip".into()
    }

    fn caption(&self) -> String {
        let more = match self.n_left_out {
            0 => String::new(),
            n => format!(" {n} more are in the table."),
        };
        format!(
            "Target, dashed, and path of the tip on it, coloured by its distance from the target [mm]; all axes have one \
             scale.{more}"
        )
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        let panels = self.panels.iter().map(|_| [COLUMN, ROW]);
        panels.chain([[BAR, ABOVE + SIDE + 8.0]]).collect()
    }

    fn draw<DB: DrawingBackend>(&self, tile: usize, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        match self.panels.get(tile) {
            Some(panel) => self.draw_panel(panel, sheet),
            None => sheet.part(12.0, ABOVE, BAR - 12.0, SIDE).color_bar("error [mm]", 0.0, self.largest()),
        }
    }
}

/// Parts of a path of one shade each, 0 to 1 for errors from 0 to `largest`.
fn shades(panel: &Panel, largest: f64) -> Vec<(f64, Vec<(f64, f64)>)> {
    let level = |i: usize| (0.5 * (panel.errors[i] + panel.errors[i + 1]) / largest * SHADES).floor();
    let mut pieces: Vec<(f64, Vec<(f64, f64)>)> = Vec::new();
    let mut last = f64::NAN;
    for i in 0..panel.path.len() - 1 {
        if level(i) != last {
            last = level(i);
            pieces.push(((last + 0.5) / SHADES, vec![panel.path[i]]));
        }
        if let Some((_, line)) = pieces.last_mut() {
            line.push(panel.path[i + 1]);
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_of_a_path_is_drawn_in_its_shade() {
        let path: Vec<(f64, f64)> = (0..10).map(|i| (f64::from(i), 0.0)).collect();
        let errors = path.iter().map(|(x, _)| if *x < 5.0 { 0.0 } else { 1.0 }).collect();
        let pieces = shades(&Panel { name: String::new(), path, errors }, 1.0);
        // Low, the step between, high.
        let ends: Vec<(f64, f64)> =
            pieces.iter().map(|(_, line)| (line[0].0, line[line.len() - 1].0)).collect();
        assert_eq!(ends, [(0.0, 4.0), (4.0, 5.0), (5.0, 9.0)]);
        assert!(pieces[0].0 < pieces[1].0 && pieces[1].0 < pieces[2].0);
    }
}
