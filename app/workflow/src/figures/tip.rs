//! The path of the tip from three sides, over its goals where it had any; the two axes of each to one scale.

use anyhow::{Context as _, Result};
use plotters::prelude::*;

use crate::shared::run::Run;
use hysteron_report::figure::{Entry, Figure};
use hysteron_report::series::millimetres;
use hysteron_report::sheet::{BELOW, COLORS, LEFT, Sheet, padded, ramp};
use hysteron_report::simplify::{between_sharp_turns, simplified};

/// Parts of the path that have a colour of their own.
const PIECES: usize = 80;
const GOALS: RGBColor = COLORS[5];
const MEASURED: RGBColor = RGBColor(190, 194, 200);

/// Axes of the views, and their sizes [px].
const VIEWS: [([usize; 2], [f64; 2]); 3] =
    [([0, 1], [430.0, 440.0]), ([0, 2], [430.0, 300.0]), ([1, 2], [430.0, 300.0])];
const BAR: [f64; 2] = [90.0, 300.0];

/// The path of the tip, coloured by time.
pub struct TipPath {
    /// Coordinates x, y, z (n_samples each) [mm].
    tip: [Vec<f64>; 3],
    /// Where it was to go (n_samples each) [mm].
    goals: Option<[Vec<f64>; 3]>,
    /// Where the robot's own tip was measured (n_samples each) [mm].
    measured: Option<[Vec<f64>; 3]>,
    /// First and last time [s].
    time: [f64; 2],
}

impl TipPath {
    /// The path of a run.
    pub fn new(run: &Run) -> Result<Self> {
        let tip = run.recording.tip().context("the recording has no tip")?;
        let time = run.recording.time();
        Ok(Self {
            tip: tip.map(millimetres),
            goals: run.goals.map(|goals| goals.positions().map(millimetres)),
            measured: run.measured.map(|measured| measured.map(millimetres)),
            time: [time[0], time[time.len() - 1]],
        })
    }

    /// Range of everything shown along an axis [mm].
    fn range(&self, axis: usize) -> std::ops::Range<f64> {
        let others = self.goals.iter().chain(&self.measured).flat_map(|path| &path[axis]);
        padded(self.tip[axis].iter().chain(others).copied())
    }

    /// One view of two axes, its path in the middle.
    fn view<DB: DrawingBackend>(&self, sheet: &Sheet<DB>, axes: [usize; 2], mm_per_px: f64) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let (width, height) = sheet.size();
        let range = |axis: usize, px: f64| {
            let own = self.range(axis);
            let (middle, half) = (0.5 * (own.start + own.end), 0.5 * px * mm_per_px);
            middle - half..middle + half
        };
        let names = axes.map(|axis| format!("{} [mm]", ["x", "y", "z"][axis]));
        let (x, y) = (range(axes[0], width - LEFT), range(axes[1], height - BELOW));
        let mut chart = sheet.chart(x, y, &names[0], &names[1])?;
        let points = seen(&self.tip, axes);
        if let Some(goals) = &self.goals {
            // Dots below, wide enough to show on both sides of a path that meets them.
            let apart = spaced(&seen(goals, axes), 2.0 * mm_per_px);
            let dots = apart.into_iter().map(|at| Circle::new(at, sheet.px(3.0), GOALS.filled()));
            chart.draw_series(dots)?;
        }
        if let Some(measured) = &self.measured {
            let line = simplified(&seen(measured, axes), 0.15 * mm_per_px);
            for run in between_sharp_turns(&line) {
                chart.draw_series(LineSeries::new(run.iter().copied(), sheet.line(MEASURED, 3.0)))?;
            }
        }
        let piece = points.len().div_ceil(PIECES).max(1);
        for start in (0..points.len()).step_by(piece) {
            let end = (start + piece + 1).min(points.len());
            let color = ramp((start + end) as f64 / 2.0 / points.len() as f64);
            let line = simplified(&points[start..end], 0.15 * mm_per_px);
            for run in between_sharp_turns(&line) {
                chart.draw_series(LineSeries::new(run.iter().copied(), sheet.line(color, 1.3)))?;
            }
        }
        let mark = sheet.px(4.0);
        chart.draw_series([Circle::new(points[0], mark, sheet.line(ramp(0.0), 2.0))])?;
        let last = points[points.len() - 1];
        chart.draw_series([TriangleMarker::new(last, mark + sheet.px(1.5), ramp(1.0).filled())])?;
        Ok(())
    }
}

/// Points along two of the axes.
fn seen(path: &[Vec<f64>; 3], axes: [usize; 2]) -> Vec<(f64, f64)> {
    path[axes[0]].iter().copied().zip(path[axes[1]].iter().copied()).collect()
}

/// The first point, and each that is this far from the one taken before.
fn spaced(points: &[(f64, f64)], distance: f64) -> Vec<(f64, f64)> {
    let mut taken: Vec<(f64, f64)> = Vec::new();
    for point in points {
        if taken.last().is_none_or(|last| (point.0 - last.0).hypot(point.1 - last.1) >= distance) {
            taken.push(*point);
        }
    }
    taken
}

impl Figure for TipPath {
    fn name(&self) -> String {
        "tip-path".into()
    }

    fn title(&self) -> String {
        "Path of the tip".into()
    }

    fn caption(&self) -> String {
        "Path of the tip from above and from two sides [mm], coloured by time; the two axes of a view have one scale. \
         Circle: first sample; triangle: last."
            .to_owned()
            + if self.goals.is_some() { " Blue dots below: the goals." } else { "" }
            + if self.measured.is_some() { " Wide grey line below: the tip as measured on the robot." } else { "" }
    }

    fn legend(&self) -> Vec<Entry> {
        let goals = self.goals.as_ref().map(|_| ("goals".to_owned(), GOALS));
        let measured = self.measured.as_ref().map(|_| ("measured".to_owned(), MEASURED));
        let simulated = [("simulated".to_owned(), ramp(0.5))];
        if goals.is_none() && measured.is_none() {
            return Vec::new();
        }
        goals.into_iter().chain(measured).chain(simulated).collect()
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        let mut tiles = VIEWS.map(|(_, size)| size).to_vec();
        tiles.push(BAR);
        tiles
    }

    fn draw<DB: DrawingBackend>(&self, tile: usize, sheet: &Sheet<DB>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let Some((axes, size)) = VIEWS.get(tile) else {
            let (width, height) = sheet.size();
            let bar = sheet.part(14.0, 8.0, width - 14.0, height.min(230.0) - 8.0);
            return bar.color_bar("time [s]", self.time[0], self.time[1]);
        };
        let length = |axis: usize| {
            let range = self.range(axis);
            range.end - range.start
        };
        // A tip at rest would be magnified without end.
        let fits = |[a, b]: [usize; 2], [width, height]: [f64; 2]| {
            (length(a) / (width - LEFT)).max(length(b) / (height - BELOW)).max(1e-3)
        };
        // The two from the side have one scale.
        let mm_per_px = match tile {
            0 => fits(*axes, *size),
            _ => VIEWS[1..].iter().map(|(axes, size)| fits(*axes, *size)).fold(0.0, f64::max),
        };
        self.view(sheet, *axes, mm_per_px)
    }
}
