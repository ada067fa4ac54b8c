//! Values over time (or over epochs), in panels above each other that share the horizontal axis.

use std::ops::Range;

use anyhow::Result;
use plotters::prelude::*;

use crate::figure::{Figure, LegendEntry};
use crate::sheet::{BELOW, COLORS, LEFT, Sheet, are_counts, padded};
use crate::simplify::simplified;

/// Panels with a common horizontal axis.
pub struct TimeChart {
    /// Name of the file.
    pub name: String,
    /// Title.
    pub title: String,
    /// Caption: the content of the figure.
    pub caption: String,
    /// Name of the horizontal axis, as `time [s]`.
    pub x_name: &'static str,
    /// Times (n_samples), in increasing order.
    pub x: Vec<f64>,
    /// From the top down; a panel without values is not drawn.
    pub panels: Vec<TimePanel>,
    /// Spans of time that are shaded in all panels.
    pub shaded: Vec<Shaded>,
    /// Vertical scale of the panels: common or their own.
    pub scale: PanelScale,
}

/// Whether panels have one vertical scale.
#[derive(Clone, Copy, PartialEq)]
pub enum PanelScale {
    /// One for all: panels of one quantity compare.
    Common,
    /// Each its own.
    Own,
}

/// Spans of time with a name in the legend.
pub struct Shaded {
    /// Name in the legend.
    pub name: String,
    /// Begin and end of each, in the order of time.
    pub spans: Vec<[f64; 2]>,
}

/// One pair of axes.
pub struct TimePanel {
    /// Name of the vertical axis, with its unit.
    pub label: String,
    /// Curves, the last on top.
    pub curves: Vec<Curve>,
}

/// A line.
#[derive(Clone)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Colour.
    pub color: RGBColor,
    /// Width [px].
    pub width: f64,
    /// Values (n_samples), in the unit of the axis; the line is interrupted where one is not finite.
    pub values: Vec<f64>,
}

impl Curve {
    /// A curve of the usual width in the `k`-th colour.
    pub fn new(name: impl Into<String>, k: usize, values: Vec<f64>) -> Self {
        Self { name: name.into(), color: COLORS[k % COLORS.len()], width: 1.2, values }
    }

    fn range(&self) -> impl Iterator<Item = f64> {
        self.values.iter().copied().filter(|value| value.is_finite())
    }
}

impl TimePanel {
    /// A panel of some curves.
    pub fn new(label: impl Into<String>, curves: Vec<Curve>) -> Self {
        Self { label: label.into(), curves }
    }

    fn legend(&self) -> Vec<LegendEntry> {
        self.curves.iter().map(|curve| (curve.name.clone(), curve.color)).collect()
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        self.curves.iter().flat_map(Curve::range)
    }
}

/// Values with NaN where `gap` says that nothing was measured, so that their line is interrupted there.
pub fn without_gaps(values: &[f64], gap: &[bool]) -> Vec<f64> {
    values.iter().zip(gap).map(|(value, gap)| if *gap { f64::NAN } else { *value }).collect()
}

/// Width of a panel, and air to its right [px].
const WIDTH: f64 = 900.0;
const RIGHT: f64 = 16.0;
/// Room for a panel's own legend [px].
const LEGEND: f64 = 22.0;
const SHADES: [RGBColor; 2] = [RGBColor(246, 222, 206), RGBColor(214, 226, 240)];

impl TimeChart {
    /// A chart over time [s] whose panels have scales of their own.
    pub fn over_time(
        name: impl Into<String>,
        title: impl Into<String>,
        caption: impl Into<String>,
        time: &[f64],
        panels: Vec<TimePanel>,
    ) -> Self {
        Self {
            name: name.into(),
            title: title.into(),
            caption: caption.into(),
            x_name: "time [s]",
            x: time.to_vec(),
            panels,
            shaded: Vec::new(),
            scale: PanelScale::Own,
        }
    }

    fn shown(&self) -> impl Iterator<Item = &TimePanel> {
        self.panels.iter().filter(|panel| panel.values().next().is_some())
    }

    /// The legend of all panels, if they have the same one.
    fn common_legend(&self) -> Option<Vec<LegendEntry>> {
        let mut legends = self.shown().map(TimePanel::legend);
        let first = legends.next()?;
        legends.all(|legend| legend == first).then_some(first)
    }

    fn panel_height(&self) -> f64 {
        match self.shown().count() {
            1 => 270.0,
            2 | 3 => 150.0,
            _ => 118.0,
        }
    }

    /// Room for a panel's own legend; one curve alone has its name at the axis.
    fn legend_height(&self, panel: &TimePanel) -> f64 {
        if self.common_legend().is_some() || panel.curves.len() == 1 { 0.0 } else { LEGEND }
    }

    fn draw_panel<DB: DrawingBackend>(
        &self,
        part: &Sheet<DB>,
        panel: &TimePanel,
        range: Range<f64>,
        x_name: &str,
    ) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let (first, last) = (self.x[0], self.x[self.x.len() - 1]);
        let end = if last > first { last } else { first + 1.0 };
        let span = range.end - range.start;
        let mut chart = part.chart_over(
            first..end,
            are_counts(self.x.iter().copied()),
            range.clone(),
            x_name,
            &panel.label,
        )?;
        for (shaded, color) in self.shaded.iter().zip(SHADES.iter().cycle()) {
            let corners = |[from, to]: &[f64; 2]| [(*from, range.start), (*to, range.end)];
            chart
                .draw_series(shaded.spans.iter().map(|span| Rectangle::new(corners(span), color.filled())))?;
        }
        for curve in &panel.curves {
            // Compared in parts of the axes; a fifth of a pixel is not visible.
            let scaled: Vec<(f64, f64)> = self
                .x
                .iter()
                .zip(&curve.values)
                .map(|(t, value)| ((t - first) / (end - first) * 4.0, (value - range.start) / span))
                .collect();
            for line in scaled.split(|(_, value)| !value.is_finite()).filter(|line| !line.is_empty()) {
                let points = simplified(line, 0.0008)
                    .into_iter()
                    .map(|(t, value)| (first + t / 4.0 * (end - first), range.start + value * span));
                chart.draw_series(LineSeries::new(points, part.line(curve.color, curve.width)))?;
            }
        }
        Ok(())
    }
}

impl Figure for TimeChart {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn caption(&self) -> String {
        self.caption.clone()
    }

    fn title(&self) -> String {
        self.title.clone()
    }

    fn legend(&self) -> Vec<LegendEntry> {
        let shades = self.shaded.iter().zip(SHADES.iter().cycle());
        let shades = shades.filter(|(shaded, _)| !shaded.spans.is_empty());
        let shades = shades.map(|(shaded, color)| (shaded.name.clone(), *color));
        self.common_legend().into_iter().flatten().chain(shades).collect()
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        let n = self.shown().count();
        let below = |k: usize| if k + 1 == n { BELOW - 8.0 } else { 0.0 };
        let height = |panel| self.panel_height() + self.legend_height(panel);
        self.shown().enumerate().map(|(k, panel)| [WIDTH, height(panel) + below(k)]).collect()
    }

    fn draw<DB: DrawingBackend>(&self, tile: usize, sheet: &Sheet<DB>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let Some(panel) = self.shown().nth(tile) else { return Ok(()) };
        let (width, height) = sheet.size();
        let legend = self.legend_height(panel);
        if legend > 0.0 {
            sheet.legend(&panel.legend(), LEFT, 0.5 * legend)?;
        }
        let range = match self.scale {
            PanelScale::Common => padded(self.shown().flat_map(TimePanel::values)),
            PanelScale::Own => padded(panel.values()),
        };
        let x_name = if tile + 1 == self.shown().count() { self.x_name } else { "" };
        let part = sheet.part(0.0, legend, width - RIGHT, height - legend);
        self.draw_panel(&part, panel, range, x_name)
    }
}

/// Begin and end of every run of samples that are flagged, each half a sample longer to either side.
pub fn spans(time: &[f64], flagged: &[bool]) -> Vec<[f64; 2]> {
    let n = time.len();
    let half = if n > 1 { 0.5 * (time[n - 1] - time[0]) / (n - 1) as f64 } else { 0.5 };
    let mut spans: Vec<[f64; 2]> = Vec::new();
    for i in (0..n).filter(|i| flagged.get(*i) == Some(&true)) {
        match spans.last_mut() {
            Some(span) if i > 0 && flagged[i - 1] => span[1] = time[i] + half,
            _ => spans.push([(time[i] - half).max(time[0]), time[i] + half]),
        }
    }
    spans.iter_mut().for_each(|span| span[1] = span[1].min(time[n - 1]));
    spans
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{drawn, register_embedded_font};

    fn chart(values: [Vec<f64>; 2]) -> TimeChart {
        let time: Vec<f64> = (0..values[0].len()).map(|i| 0.1 * i as f64).collect();
        let panels = values.map(|values| TimePanel::new("x [mm]", vec![Curve::new("tip", 0, values)]));
        TimeChart::over_time("chart", "Chart", "A chart.", &time, panels.into())
    }

    #[test]
    fn panels_have_scales_of_their_own_and_what_was_not_measured_is_not_drawn() {
        register_embedded_font().expect("a font");
        let large: Vec<f64> = (0..40).map(f64::from).collect();
        let small = (0..40).map(|i| if i % 7 == 4 { f64::NAN } else { 1e-3 * f64::from(i % 2) }).collect();
        let tiles = drawn(&chart([large, small])).expect("a figure").tiles;
        assert!(tiles[0].contains(">\n20\n<") && !tiles[1].contains(">\n20\n<"));
        assert!(
            tiles[1].contains(">\n0.5\n<") && tiles[1].contains("x [mm] \u{d7} 1e\u{2212}3"),
            "{}",
            tiles[1]
        );
        assert!(tiles.iter().all(|svg| !svg.contains("NaN")));
        let lines = |svg: &str| svg.matches("stroke=\"#0072B2\"").count();
        assert_eq!([lines(&tiles[0]), lines(&tiles[1])], [1, 6]);
    }

    #[test]
    fn a_panel_without_values_is_left_out() {
        register_embedded_font().expect("a font");
        let drawn = drawn(&chart([vec![f64::NAN; 4], vec![2.0; 4]])).expect("a figure");
        assert_eq!(drawn.tiles.len(), 1);
    }

    #[test]
    fn spans_of_flagged_samples_are_half_a_sample_longer() {
        let found = spans(&[0.0, 1.0, 2.0, 3.0, 4.0], &[true, false, true, true, false]);
        assert_eq!(found, [[0.0, 0.5], [1.5, 3.5]]);
    }
}
