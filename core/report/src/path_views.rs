//! A path in space from three sides, coloured by time; the two axes of each view to one scale.

use anyhow::Result;
use plotters::prelude::*;

use crate::figure::{Figure, LegendEntry};
use crate::plane::{PlanePath, draw_simplified, spaced};
use crate::sheet::{BAR, BELOW, COLORS, LEFT, Sheet, padded, ramp};

/// Parts of the path that have a colour of their own.
const N_SEGMENTS: usize = 80;
const GOALS: RGBColor = COLORS[5];
const REFERENCE: RGBColor = RGBColor(190, 194, 200);

/// Axes of the views, and their sizes [px].
const VIEWS: [([usize; 2], [f64; 2]); 3] =
    [([0, 1], [320.0, 300.0]), ([0, 2], [320.0, 300.0]), ([1, 2], [320.0, 300.0])];

/// Views of a path, from above and from two sides.
pub struct PathViews {
    /// Name of the file.
    pub name: String,
    /// Title.
    pub title: String,
    /// Caption: the content of the figure.
    pub caption: String,
    /// The path, coloured by time.
    pub path: SpacePath,
    /// Points that it was to go through, as dots below it.
    pub goals: Option<SpacePath>,
    /// A path to compare with, as a wide line below it.
    pub reference: Option<SpacePath>,
    /// First and last time of the path [s].
    pub time: [f64; 2],
}

/// A path with its name in the legend.
pub struct SpacePath {
    /// Name in the legend.
    pub name: String,
    /// Coordinates x, y, z (n_samples each) [mm].
    pub axes: [Vec<f64>; 3],
}

impl SpacePath {
    /// Points projected on two of the axes.
    fn projected(&self, axes: [usize; 2]) -> PlanePath {
        self.axes[axes[0]].iter().copied().zip(self.axes[axes[1]].iter().copied()).collect()
    }
}

impl PathViews {
    /// Range of everything shown along an axis [mm].
    fn range(&self, axis: usize) -> std::ops::Range<f64> {
        let others = self.goals.iter().chain(&self.reference).flat_map(|path| &path.axes[axis]);
        padded(self.path.axes[axis].iter().chain(others).copied())
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
        let points = self.path.projected(axes);
        if let Some(goals) = &self.goals {
            // Dots below, wide enough to show on both sides of a path that meets them.
            let apart = spaced(&goals.projected(axes), 2.0 * mm_per_px);
            let dots = apart.into_iter().map(|at| Circle::new(at, sheet.px(3.0), GOALS.filled()));
            chart.draw_series(dots)?;
        }
        let tolerance = 0.15 * mm_per_px;
        if let Some(reference) = &self.reference {
            draw_simplified(&mut chart, sheet, &reference.projected(axes), tolerance, (REFERENCE, 3.0))?;
        }
        let length = points.len().div_ceil(N_SEGMENTS).max(1);
        for start in (0..points.len()).step_by(length) {
            let end = (start + length + 1).min(points.len());
            let color = ramp((start + end) as f64 / 2.0 / points.len() as f64);
            draw_simplified(&mut chart, sheet, &points[start..end], tolerance, (color, 1.3))?;
        }
        let mark = sheet.px(4.0);
        chart.draw_series([Circle::new(points[0], mark, sheet.line(ramp(0.0), 2.0))])?;
        let last = points[points.len() - 1];
        chart.draw_series([TriangleMarker::new(last, mark + sheet.px(1.5), ramp(1.0).filled())])?;
        Ok(())
    }
}

impl Figure for PathViews {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn title(&self) -> String {
        self.title.clone()
    }

    fn caption(&self) -> String {
        self.caption.clone()
    }

    fn legend(&self) -> Vec<LegendEntry> {
        let entry = |path: &SpacePath, color: RGBColor| (path.name.clone(), color);
        let goals = self.goals.iter().map(|path| entry(path, GOALS));
        let reference = self.reference.iter().map(|path| entry(path, REFERENCE));
        if self.goals.is_none() && self.reference.is_none() {
            return Vec::new();
        }
        goals.chain(reference).chain([entry(&self.path, ramp(0.5))]).collect()
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        let mut tiles = VIEWS.map(|(_, size)| size).to_vec();
        tiles.push([BAR, 300.0]);
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
