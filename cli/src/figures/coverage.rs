//! The card of a synthetic data set: where its tips go, beside those of the robot.

use std::path::Path;

use hysteron_base::file;
use plotters::prelude::*;
use serde::Serialize;

use super::figure::{Entry, Figure, register_embedded_font, save};
use super::report::{Page, write_metrics};
use super::sheet::{BELOW, COLORS, LEFT, Sheet};
use super::simplify::simplified;
use super::tip::between_sharp_turns;
use super::tracking::square_around;
use crate::generate::{Card, Row, tip_of};
use crate::inputs::Input;
use crate::terminal;

const SYNTHETIC: RGBColor = COLORS[1];
const REAL: RGBColor = COLORS[0];
const SIDE: f64 = 440.0;
/// Points of a recording that are drawn at most: a shape, not every sample.
const MOST_POINTS: usize = 1500;

#[derive(Serialize)]
struct Metrics<'a> {
    format: &'static str,
    version: u32,
    #[serde(flatten)]
    card: &'a Card,
    command: &'a str,
    commit: &'a str,
}

/// Writes the figure, `report.html` and `metrics.json` to `folder`; an empty set has no figure.
pub fn write(folder: &Path, card: &Card, real: &[Input], with_png: bool) -> anyhow::Result<()> {
    register_embedded_font()?;
    let (command, commit) = (terminal::command_line(), env!("HYSTERON_COMMIT"));
    write_metrics(
        folder,
        &Metrics { format: "hysteron-metrics", version: 1, card, command: &command, commit },
    )?;
    let about =
        "Synthetic data: what the twin did on the strokes of a plan. To learn from, not measured on a robot.";
    let mut page = Page::new(&format!("Synthetic data, plan {}", card.plan), about, &command);
    let area = |k: usize| format!("{:.1}", 1e4 * card.areas_m2[k]);
    let percent = |part: f64| format!("{:.1}", 100.0 * part);
    let mut rows = vec![
        ("Trajectories", card.made.to_string()),
        ("Left out", card.dropped.to_string()),
        ("Samples", card.samples.to_string()),
        ("Network outside its training range [% of samples]", percent(card.extrapolating)),
        ("Area under the tip [cm²]", area(0)),
    ];
    if card.samples_real > 0 {
        rows.extend([
            ("Samples of the robot", card.samples_real.to_string()),
            ("Area under the robot's tip [cm²]", area(1)),
            ("Outside the robot's [% of samples]", percent(card.outside)),
        ]);
    }
    page.list(rows);
    match card.why_empty() {
        Some(why) => page.paragraph(&format!("No figure: {why}.")),
        None => page.figure(&save(folder, &Coverage::new(card, real), with_png)?),
    }
    page.table(&Row::HEADINGS, card.rows.iter().map(Row::cells));
    page.small(&format!("Scene {}.", card.scene_sha256));
    file::write_bytes(&folder.join("report.html"), page.finish(commit))?;
    Ok(())
}

/// Paths of the tip from above.
struct Coverage {
    /// Synthetic ones, then those of the robot [mm].
    paths: [Vec<Vec<(f64, f64)>>; 2],
}

impl Coverage {
    fn new(card: &Card, real: &[Input]) -> Self {
        let path = |tip: &[[f64; 2]]| -> Vec<(f64, f64)> {
            let every = tip.len().div_ceil(MOST_POINTS).max(1);
            tip.iter().step_by(every).map(|[x, y]| (1e3 * x, 1e3 * y)).collect()
        };
        let synthetic = card.rows.iter().map(|row| path(&row.tip)).collect();
        let real = real.iter().filter_map(|input| tip_of(&input.recording).ok());
        Self { paths: [synthetic, real.map(|tip| path(&tip)).collect()] }
    }
}

impl Figure for Coverage {
    fn name(&self) -> String {
        "coverage".into()
    }

    fn title(&self) -> String {
        "Coverage".into()
    }

    fn caption(&self) -> String {
        let robot = if self.paths[1].is_empty() { "" } else { ", over them that of the robot" };
        format!("Paths of the twin's tip{robot}.")
    }

    fn legend(&self) -> Vec<Entry> {
        let names = [("synthetic", SYNTHETIC), ("robot", REAL)];
        let shown = names.into_iter().zip(&self.paths).filter(|(_, paths)| !paths.is_empty());
        shown.map(|((name, color), _)| (name.to_owned(), color)).collect()
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        vec![[LEFT + SIDE + 16.0, SIDE + BELOW + 8.0]]
    }

    fn draw<DB: DrawingBackend>(&self, _: usize, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let ([x, y], half) = square_around(self.paths.iter().flatten().flatten());
        let mm_per_px = 2.0 * half / SIDE;
        let part = sheet.part(0.0, 0.0, LEFT + SIDE, SIDE + BELOW);
        let mut chart = part.chart(x - half..x + half, y - half..y + half, "x [mm]", "y [mm]")?;
        for (color, paths) in [SYNTHETIC, REAL].into_iter().zip(&self.paths) {
            for path in paths {
                for run in between_sharp_turns(&simplified(path, 0.6 * mm_per_px)) {
                    chart.draw_series(LineSeries::new(run.iter().copied(), part.line(color, 0.6)))?;
                }
            }
        }
        Ok(())
    }
}
