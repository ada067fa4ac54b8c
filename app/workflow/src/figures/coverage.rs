//! The card of a synthetic data set: its tip positions compared with those of the robot.

use std::collections::BTreeMap;
use std::path::Path;

use hysteron_control::inverse::{Axes, TipWorkspace};
use plotters::prelude::*;

use crate::shared::inputs::Input;
use crate::tendon::generate::{Outcome, SyntheticTrajectory, tip_of};
use hysteron_report::figure::{Figure, LegendEntry, register_embedded_font, save};
use hysteron_report::page::{Page, write_metrics, write_page};
use hysteron_report::plane::square_around;
use hysteron_report::sheet::{BELOW, COLORS, LEFT, Sheet, number, ramp};

const HULL: RGBColor = COLORS[6];
/// Side of the square inside a pair of axes, height of the line above it, width of the colour bar [px].
const SIDE: f64 = 240.0;
const ABOVE: f64 = 26.0;
const BAR: f64 = 90.0;
/// Cells along the side of the square.
const CELLS: usize = 60;
const SHADES: usize = 16;

/// Writes the figure, `report.html` and `metrics.json` to `folder`; an empty set has no figure.
pub fn write(folder: &Path, card: &Outcome, real: &[Input], with_png: bool) -> anyhow::Result<()> {
    register_embedded_font()?;
    write_metrics(folder, card)?;
    let about = "Synthetic data: trajectories of a plan, simulated by the twin. They are training data and were not measured \
                 on a robot.";
    let area = |k: usize| format!("{:.1}", 1e4 * card.areas_m2[k]);
    let title = format!("Synthetic data, plan {}", card.plan);
    let conclusion = format!("{} trajectories, {} samples, over {} cm².", card.made, card.samples, area(0));
    let mut page = Page::concluded(&title, &conclusion, about, &card.command);
    let percent = |part: f64| format!("{:.1}", 100.0 * part);
    page.heading("Results");
    let mut rows = vec![
        ("Trajectories", card.made.to_string()),
        ("Left out", card.dropped.to_string()),
        ("Samples", card.samples.to_string()),
        ("Network outside its training range [% of samples]", percent(card.extrapolating)),
        ("Area covered by the tip (convex hull) [cm²]", area(0)),
    ];
    if card.samples_real > 0 {
        rows.extend([
            ("Samples of the robot", card.samples_real.to_string()),
            ("Area covered by the robot's tip (convex hull) [cm²]", area(1)),
            ("Outside the robot's area [% of samples]", percent(card.outside)),
        ]);
    }
    page.list(rows);
    match card.why_empty() {
        Some(why) => page.paragraph(&format!("No figure: {why}.")),
        None => page.figure(&save(folder, &Coverage::new(card, real), with_png)?),
    }
    page.heading("Trajectories");
    page.table(&SyntheticTrajectory::HEADINGS, card.rows.iter().map(SyntheticTrajectory::cells));
    page.small(&format!("Scene {}.", card.scene_sha256));
    write_page(folder, page.finish(&card.commit))?;
    Ok(())
}

/// Positions from above [mm].
type Points = Vec<(f64, f64)>;

/// Where samples of the tip are, from above: a tile for every family, and one for the robot.
struct Coverage {
    /// Middle of the square that all tiles show, and half its side [mm].
    middle: [f64; 2],
    half: f64,
    groups: Vec<Group>,
    /// Corners of the convex hull of the robot's tips [mm].
    hull: Points,
    /// Most samples in a cell.
    most: f64,
}

/// Samples of a tile by cell.
struct Group {
    title: String,
    /// By row from below, then by column (CELLS × CELLS).
    counts: Vec<usize>,
}

impl Coverage {
    fn new(card: &Outcome, real: &[Input]) -> Self {
        let mm =
            |tip: &[[f64; 2]]| -> Vec<(f64, f64)> { tip.iter().map(|[x, y]| (1e3 * x, 1e3 * y)).collect() };
        let mut tips: BTreeMap<&str, (usize, Points)> = BTreeMap::new();
        for row in card.rows.iter().filter(|row| !row.tip.is_empty()) {
            let (n, points) = tips.entry(&row.family).or_default();
            *n += 1;
            points.extend(mm(&row.tip));
        }
        let of_robot: Vec<Vec<[f64; 2]>> =
            real.iter().filter_map(|input| tip_of(&input.recording).ok()).collect();
        let robot = of_robot.concat();
        let hull = TipWorkspace::new(Axes::Planar, robot.iter().map(|[x, y]| [*x, *y, 0.0]).collect());
        let mut all: Vec<(String, Points)> = tips
            .into_iter()
            .map(|(family, (n, points))| (format!("{family}: {n} trajectories"), points))
            .collect();
        if !robot.is_empty() {
            all.push((format!("robot: {} recordings", of_robot.len()), mm(&robot)));
        }
        let (middle, half) = square_around(all.iter().flat_map(|(_, points)| points));
        let groups: Vec<Group> = all
            .into_iter()
            .map(|(title, points)| Group { title, counts: counted(&points, middle, half) })
            .collect();
        let most = groups.iter().flat_map(|group| &group.counts).max().map_or(1.0, |most| *most as f64);
        Self { middle, half, groups, hull: mm(hull.corners()), most }
    }

    /// Shade of a cell, 1 to SHADES; 0 where there is no sample. Equal steps are equal factors.
    fn shade(&self, count: usize) -> usize {
        if count == 0 {
            return 0;
        }
        let part = (count as f64).ln() / self.most.ln().max(f64::MIN_POSITIVE);
        1 + ((part * SHADES as f64) as usize).min(SHADES - 1)
    }

    fn draw_group<DB: DrawingBackend>(&self, group: &Group, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let ([x, y], half) = (self.middle, self.half);
        sheet.text(&group.title, LEFT, 12.0)?;
        let part = sheet.part(0.0, ABOVE, LEFT + SIDE, SIDE + BELOW);
        let mut chart = part.chart(x - half..x + half, y - half..y + half, "x [mm]", "y [mm]")?;
        let cell = 2.0 * half / CELLS as f64;
        for (row, counts) in group.counts.chunks(CELLS).enumerate() {
            let shades: Vec<usize> = counts.iter().map(|count| self.shade(*count)).collect();
            let bottom = y - half + cell * row as f64;
            let mut column = 0;
            // Neighbours of one shade are one rectangle.
            for run in shades.chunk_by(|a, b| a == b) {
                let left = x - half + cell * column as f64;
                column += run.len();
                if run[0] > 0 {
                    let corners = [(left, bottom), (left + cell * run.len() as f64, bottom + cell)];
                    let color = ramp((run[0] as f64 - 0.5) / SHADES as f64);
                    chart.draw_series([Rectangle::new(corners, color.filled())])?;
                }
            }
        }
        let outline = self.hull.iter().chain(self.hull.first()).copied();
        chart.draw_series(LineSeries::new(outline, part.line(HULL, 1.2)))?;
        Ok(())
    }
}

/// Samples in every cell of a square.
fn counted(points: &[(f64, f64)], [x, y]: [f64; 2], half: f64) -> Vec<usize> {
    let mut counts = vec![0; CELLS * CELLS];
    let cell = |value: f64, middle: f64| {
        let at = (value - middle + half) / (2.0 * half) * CELLS as f64;
        (at as usize).min(CELLS - 1)
    };
    points.iter().for_each(|point| counts[cell(point.1, y) * CELLS + cell(point.0, x)] += 1);
    counts
}

impl Figure for Coverage {
    fn name(&self) -> String {
        "coverage".into()
    }

    fn title(&self) -> String {
        "Coverage".into()
    }

    fn caption(&self) -> String {
        let hull = if self.hull.is_empty() {
            ""
        } else {
            " The line is the convex hull of the robot's own samples."
        };
        format!(
            "Samples of the tip in cells of {:.2} mm, from above [mm], by family of trajectories; the colour scale is \
             logarithmic, all axes have one scale.{hull}",
            2.0 * self.half / CELLS as f64
        )
    }

    fn legend(&self) -> Vec<LegendEntry> {
        let hull = (!self.hull.is_empty()).then(|| ("convex hull of the robot's samples".to_owned(), HULL));
        hull.into_iter().collect()
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        let groups = self.groups.iter().map(|_| [LEFT + SIDE + 18.0, ABOVE + SIDE + BELOW + 10.0]);
        groups.chain([[BAR, ABOVE + SIDE + 8.0]]).collect()
    }

    fn draw<DB: DrawingBackend>(&self, tile: usize, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let Some(group) = self.groups.get(tile) else {
            let samples = |part: f64| number(self.most.powf(part));
            let labels = [0.0, 0.5, 1.0].map(samples);
            return sheet.part(12.0, ABOVE, BAR - 12.0, SIDE).labelled_bar("samples", &labels);
        };
        self.draw_group(group, sheet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_is_in_a_cell() {
        let points = [(-1.0, -1.0), (1.0, 1.0), (0.99, 0.99), (0.0, -0.5)];
        let counts = counted(&points, [0.0, 0.0], 1.0);
        assert_eq!(counts.iter().sum::<usize>(), 4);
        assert_eq!((counts[0], counts[CELLS * CELLS - 1]), (1, 2));
        assert_eq!(counts[CELLS / 4 * CELLS + CELLS / 2], 1);
    }
}
