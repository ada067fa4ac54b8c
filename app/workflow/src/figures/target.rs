//! The figure and report of a target: its curve, the way to it, and where a robot does not reach it.

use std::path::Path;

use hysteron_control::TargetPath;
use plotters::prelude::*;

use super::tracking::TARGET;
use crate::tendon::target::Outcome;
use crate::tendon::target::reach::Reach;
use hysteron_report::figure::{Figure, LegendEntry, register_embedded_font, save};
use hysteron_report::page::{Page, write_metrics, write_page};
use hysteron_report::plane::{dashes, square_around};
use hysteron_report::sheet::{BELOW, COLORS, LEFT, Sheet};
use hysteron_report::simplify::{between_sharp_turns, simplified};

const WAY: RGBColor = RGBColor(190, 194, 200);
const MISSED: RGBColor = COLORS[1];
const REACHED: RGBColor = COLORS[2];
const SIDE: f64 = 440.0;

/// Writes the figure, `report.html` and `outcome.json` to `folder`.
pub fn write(
    folder: &Path,
    target: &TargetPath,
    reach: Option<&Reach>,
    outcome: &Outcome,
    with_png: bool,
) -> anyhow::Result<()> {
    register_embedded_font()?;
    write_metrics(folder, outcome)?;
    let figure = save(folder, &Picture { target, reach }, with_png)?;
    let conclusion = match reach {
        Some(reach) => format!(
            "The robot reaches {} of {} points of the target within {} mm.",
            reach.goals - reach.out_of_reach,
            reach.goals,
            1e3 * reach.tolerance_m
        ),
        None => "A path for the tip; no robot was asked whether it reaches it.".to_owned(),
    };
    let about = "Where the tip should go, from where it rests.";
    let mut page = Page::concluded(&format!("Target {}", target.name), &conclusion, about, &outcome.command);
    page.list([
        ("Family", target.family.clone()),
        ("Length of a lap [mm]", format!("{:.2}", 1e3 * outcome.length_m)),
        ("Laps", outcome.laps.to_string()),
        ("Curve [s]", format!("{:.2} to {:.2}", outcome.curve_s[0], outcome.curve_s[1])),
        ("Duration [s]", format!("{:.2}", outcome.duration_s)),
        ("Samples", format!("{}, {} a second", outcome.samples, target.rate_hz)),
    ]);
    if let Some(reach) = reach {
        page.list([
            ("Robot", reach.scene.clone()),
            ("Points out of reach", format!("{} of {}", reach.out_of_reach, reach.goals)),
            ("Tolerance [mm]", (1e3 * reach.tolerance_m).to_string()),
            ("Largest distance [mm]", format!("{:.3}", 1e3 * reach.largest_distance_m)),
            ("Largest tension [N]", format!("{:.2}", reach.tension_max_n)),
        ]);
        page.small(&format!("Scene {}.", reach.scene_sha256));
    }
    page.figure(&figure);
    page.small(&format!("Target {}.", target.hash));
    write_page(folder, page.finish(&outcome.commit))?;
    Ok(())
}

/// The target from above.
struct Picture<'a> {
    target: &'a TargetPath,
    reach: Option<&'a Reach>,
}

impl Figure for Picture<'_> {
    fn name(&self) -> String {
        "target".into()
    }

    fn title(&self) -> String {
        "Target".into()
    }

    fn caption(&self) -> String {
        let reach = match self.reach {
            None => "",
            Some(_) => {
                " Dots: points that the twin reaches, and those that it does not, with a line to its tip."
            }
        };
        format!("The target's curve, dashed, and the way to it from rest, at (0, 0).{reach}")
    }

    fn legend(&self) -> Vec<LegendEntry> {
        let mut names = vec![("target".to_owned(), TARGET), ("way to it".to_owned(), WAY)];
        if self.reach.is_some() {
            names.extend([("reached".to_owned(), REACHED), ("out of reach".to_owned(), MISSED)]);
        }
        names
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        vec![[LEFT + SIDE + 16.0, SIDE + BELOW + 8.0]]
    }

    fn draw<DB: DrawingBackend>(&self, _: usize, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let mm = |p: &[f64; 3]| (1e3 * p[0], 1e3 * p[1]);
        let all: Vec<(f64, f64)> = self.target.points().iter().map(mm).collect();
        let curve: Vec<(f64, f64)> = self.target.outline.points().iter().map(mm).collect();
        let ([x, y], half) = square_around(all.iter().chain(&curve));
        let mm_per_px = 2.0 * half / SIDE;
        let part = sheet.part(0.0, 0.0, LEFT + SIDE, SIDE + BELOW);
        let mut chart = part.chart(x - half..x + half, y - half..y + half, "x [mm]", "y [mm]")?;
        for way in [&all[..=*self.target.curve().start()], &all[*self.target.curve().end()..]] {
            for run in between_sharp_turns(&simplified(way, 0.15 * mm_per_px)) {
                chart.draw_series(LineSeries::new(run.iter().copied(), part.line(WAY, 1.6)))?;
            }
        }
        for dash in dashes(&curve, 6.0 * mm_per_px) {
            chart.draw_series(LineSeries::new(dash, part.line(TARGET, 1.6)))?;
        }
        for (goal, distance, tip) in self.reach.iter().flat_map(|reach| &reach.places) {
            let is_missed = self.reach.is_some_and(|reach| *distance > reach.tolerance_m);
            if is_missed {
                chart.draw_series(LineSeries::new([mm(goal), mm(tip)], part.line(MISSED, 1.0)))?;
            }
            let color = if is_missed { MISSED } else { REACHED };
            chart.draw_series([Circle::new(mm(goal), part.px(2.0), color.filled())])?;
        }
        Ok(())
    }
}
