//! Clouds of points with lines and error bars: one quantity over another, a tile for each pair of axes.

use anyhow::Result;
use plotters::prelude::*;

use crate::axes::Abscissas;
use crate::figure::{Figure, LegendEntry};
use crate::line_style::LineStyle;
use crate::sheet::{COLORS, NARROW, Sheet, are_counts, padded};

/// Tiles with axes of their own.
pub struct ScatterChart {
    /// Name of the file.
    pub name: String,
    /// Title.
    pub title: String,
    /// Caption: the content of the figure.
    pub caption: String,
    /// From left to right, then below; one without a finite point is not drawn.
    pub tiles: Vec<Scatter>,
}

/// One pair of axes.
pub struct Scatter {
    /// Name of the horizontal axis, with its unit.
    pub x_name: String,
    /// Name of the vertical axis, with its unit.
    pub y_name: String,
    /// Marks to draw, the last on top.
    pub marks: Vec<Marks>,
}

/// Shape of the marks.
#[derive(Clone, Copy, PartialEq)]
pub enum MarkShape {
    /// A dot for each.
    Dots,
    /// A line through all, interrupted where one is not finite.
    Line,
    /// A dot with a vertical bar so far to both sides.
    Bars,
}

/// Points of one kind.
pub struct Marks {
    /// Name in the legend.
    pub name: String,
    /// Colour.
    pub color: RGBColor,
    /// Shape of the marks.
    pub shape: MarkShape,
    /// Abscissa, ordinate and, for [`MarkShape::Bars`], half the length of the bar.
    pub points: Vec<[f64; 3]>,
}

/// Most dots of a cloud: more only fill the file.
const MAX_DOTS: usize = 3000;
/// Width and height of a tile, and of a single one [px].
const TILE: [f64; 2] = [520.0, 320.0];
const ALONE: [f64; 2] = [1040.0, 360.0];
const ON_PHONE: [f64; 2] = [NARROW, 300.0];

impl Marks {
    /// A cloud in the `k`-th colour, thinned evenly where it has too many dots.
    pub fn dots(name: impl Into<String>, k: usize, x: &[f64], y: &[f64]) -> Self {
        let every = x.len().div_ceil(MAX_DOTS).max(1);
        let points = x.iter().zip(y).step_by(every).map(|(x, y)| [*x, *y, 0.0]).collect();
        Self::new(name, k, MarkShape::Dots, points)
    }

    /// A line in the `k`-th colour.
    pub fn line(name: impl Into<String>, k: usize, x: &[f64], y: &[f64]) -> Self {
        let points = x.iter().zip(y).map(|(x, y)| [*x, *y, 0.0]).collect();
        Self::new(name, k, MarkShape::Line, points)
    }

    /// Dots with bars in the `k`-th colour: abscissa, ordinate, half length.
    pub fn bars(name: impl Into<String>, k: usize, points: Vec<[f64; 3]>) -> Self {
        Self::new(name, k, MarkShape::Bars, points)
    }

    fn new(name: impl Into<String>, k: usize, shape: MarkShape, points: Vec<[f64; 3]>) -> Self {
        Self { name: name.into(), color: COLORS[k % COLORS.len()], shape, points }
    }

    fn finite(&self) -> impl Iterator<Item = &[f64; 3]> {
        self.points.iter().filter(|point| point.iter().all(|x| x.is_finite()))
    }
}

impl Scatter {
    fn range(&self, of: impl Fn(&[f64; 3]) -> [f64; 2]) -> std::ops::Range<f64> {
        padded(self.marks.iter().flat_map(Marks::finite).flat_map(of))
    }

    fn draw<DB: DrawingBackend>(&self, sheet: &Sheet<DB>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let x = self.range(|[x, ..]| [*x; 2]);
        let y = self.range(|[_, y, half]| [y - half, y + half]);
        let abscissas = self.marks.iter().flat_map(Marks::finite).map(|[x, ..]| *x);
        let abscissas = if are_counts(abscissas) { Abscissas::Counts } else { Abscissas::Numbers };
        let mut chart = sheet.chart_named_above((x, abscissas), y, &self.x_name, &self.y_name)?;
        for marks in &self.marks {
            let dot = |point: &[f64; 3], px: f64| {
                Circle::new((point[0], point[1]), sheet.px(px), marks.color.filled())
            };
            match marks.shape {
                MarkShape::Dots => {
                    chart.draw_series(marks.finite().map(|point| dot(point, 1.2)))?;
                }
                MarkShape::Bars => {
                    let bar = |[x, y, half]: &[f64; 3]| {
                        PathElement::new(vec![(*x, y - half), (*x, y + half)], sheet.line(marks.color, 1.5))
                    };
                    chart.draw_series(marks.finite().map(bar))?;
                    chart.draw_series(marks.finite().map(|point| dot(point, 3.0)))?;
                }
                MarkShape::Line => {
                    for part in marks.points.split(|point| point.iter().any(|x| !x.is_finite())) {
                        let line = part.iter().map(|[x, y, _]| (*x, *y));
                        chart.draw_series(LineSeries::new(line, sheet.line(marks.color, 2.0)))?;
                    }
                }
            }
        }
        Ok(())
    }
}

impl ScatterChart {
    fn shown(&self) -> impl Iterator<Item = &Scatter> {
        let has_points = |tile: &&Scatter| tile.marks.iter().any(|marks| marks.finite().next().is_some());
        self.tiles.iter().filter(has_points)
    }
}

impl Figure for ScatterChart {
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
        let mut entries: Vec<LegendEntry> = Vec::new();
        for marks in self.shown().flat_map(|tile| &tile.marks) {
            let entry = (marks.name.clone(), marks.color);
            if !entries.contains(&entry) {
                entries.push(entry);
            }
        }
        entries
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        match self.shown().count() {
            1 => vec![ALONE],
            n => vec![TILE; n],
        }
    }

    fn narrow_tiles(&self) -> Vec<[f64; 2]> {
        vec![ON_PHONE; self.shown().count()]
    }

    fn line_style(&self) -> LineStyle {
        // A bar is short: dashes would hide its ends.
        let has_bars = self.shown().flat_map(|tile| &tile.marks).any(|marks| marks.shape == MarkShape::Bars);
        if has_bars { LineStyle::Solid } else { LineStyle::ByColor }
    }

    fn draw<DB: DrawingBackend>(&self, tile: usize, sheet: &Sheet<DB>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        self.shown().nth(tile).map_or(Ok(()), |tile| tile.draw(sheet))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may stop where it stands
mod tests {
    use super::*;
    use crate::figure::drawn;

    #[test]
    fn tiles_without_points_are_left_out_and_bars_stay_inside() {
        let tile = |points: Vec<[f64; 3]>| Scatter {
            x_name: "speed [rad/s]".into(),
            y_name: "torque [N m]".into(),
            marks: vec![Marks::bars("measured", 0, points)],
        };
        let full = tile(vec![[0.0, 1.0, 0.5], [1.0, 2.0, 3.0]]);
        assert_eq!(full.range(|[_, y, half]| [y - half, y + half]), -1.3..5.3);
        let chart = ScatterChart {
            name: "cloud".into(),
            title: "Cloud".into(),
            caption: "Points.".into(),
            tiles: vec![tile(vec![[f64::NAN, 1.0, 0.0]]), full],
        };
        let drawn = drawn(&chart).unwrap();
        assert_eq!(drawn.tiles.len(), 1);
        assert!(drawn.tiles[0].contains("<circle"));
    }
}
