//! Values over time (or over epochs), in panels above each other that share the horizontal axis.

use std::ops::Range;

use anyhow::Result;
use plotters::prelude::*;

use crate::axes::{Abscissas, BELOW_WITHOUT_LABELS, LEFT_OF_NAMED_ABOVE, NAME_ABOVE};
use crate::color::SHADES;
use crate::figure::{Figure, LegendEntry};
use crate::line_style::LineStyle;
use crate::sheet::{BELOW, COLORS, NARROW, Sheet, are_counts, padded};
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

    /// The panel in parts of few enough curves, that all have values.
    fn parts(&self) -> impl Iterator<Item = PanelPart<'_>> {
        let n_parts = self.curves.len().div_ceil(MAX_CURVES).max(1);
        let parts = self.curves.chunks(self.curves.len().div_ceil(n_parts).max(1));
        let parts = parts.map(|curves| PanelPart { label: &self.label, curves });
        parts.filter(|part| part.values().next().is_some())
    }
}

/// One pair of axes as it is drawn.
struct PanelPart<'a> {
    label: &'a str,
    curves: &'a [Curve],
}

impl PanelPart<'_> {
    fn legend(&self) -> Vec<LegendEntry> {
        self.curves.iter().map(|curve| (curve.name.clone(), curve.color)).collect()
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        self.curves.iter().flat_map(Curve::range)
    }
}

/// Values with NaN where `gap` marks a missing measurement, so that their line is interrupted there.
pub fn without_gaps(values: &[f64], gap: &[bool]) -> Vec<f64> {
    values.iter().zip(gap).map(|(value, gap)| if *gap { f64::NAN } else { *value }).collect()
}

/// Most curves in a pair of axes, so that their colours differ; more are split into several.
const MAX_CURVES: usize = 7;
/// Width of a panel [px].
const WIDTH: f64 = 1040.0;
/// Largest distance of a line that is drawn from all its points [px]: it is not visible.
const TOLERANCE: f64 = 0.2;

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

    fn shown(&self) -> impl Iterator<Item = PanelPart<'_>> {
        self.panels.iter().flat_map(TimePanel::parts)
    }

    /// The legend of all panels, if they have the same one.
    fn common_legend(&self) -> Option<Vec<LegendEntry>> {
        let mut legends = self.shown().map(|part| part.legend());
        let first = legends.next()?;
        legends.all(|legend| legend == first).then_some(first)
    }

    /// Height of a pair of axes, without labels [px].
    fn panel_height(&self) -> f64 {
        match self.shown().count() {
            1 => 240.0,
            2 | 3 => 132.0,
            _ => 104.0,
        }
    }

    /// Sizes of all tiles, so wide [px].
    fn sizes(&self, width: f64) -> Vec<[f64; 2]> {
        let n = self.shown().count();
        let below = |k: usize| if k + 1 == n { BELOW } else { BELOW_WITHOUT_LABELS };
        (0..n).map(|k| [width, NAME_ABOVE + self.panel_height() + below(k)]).collect()
    }

    fn draw_panel<DB: DrawingBackend>(
        &self,
        sheet: &Sheet<DB>,
        panel: &PanelPart,
        range: Range<f64>,
        x_name: &str,
    ) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let (first, last) = (self.x[0], self.x[self.x.len() - 1]);
        let end = if last > first { last } else { first + 1.0 };
        let span = range.end - range.start;
        let abscissas =
            if are_counts(self.x.iter().copied()) { Abscissas::Counts } else { Abscissas::Numbers };
        let mut chart =
            sheet.chart_named_above((first..end, abscissas), range.clone(), x_name, panel.label)?;
        let height = self.panel_height();
        let aspect = (sheet.size().0 - LEFT_OF_NAMED_ABOVE) / height;
        for (shaded, color) in self.shaded.iter().zip(SHADES.iter().cycle()) {
            let corners = |[from, to]: &[f64; 2]| [(*from, range.start), (*to, range.end)];
            chart
                .draw_series(shaded.spans.iter().map(|span| Rectangle::new(corners(span), color.filled())))?;
        }
        for curve in panel.curves {
            // Compared where both axes have one scale, in heights of the panel.
            let across = |t: f64| (t - first) / (end - first) * aspect;
            let scaled: Vec<(f64, f64)> = self
                .x
                .iter()
                .zip(&curve.values)
                .map(|(t, value)| (across(*t), (value - range.start) / span))
                .collect();
            for line in scaled.split(|(_, value)| !value.is_finite()).filter(|line| !line.is_empty()) {
                let points = simplified(line, TOLERANCE / height)
                    .into_iter()
                    .map(|(t, value)| (first + t / aspect * (end - first), range.start + value * span));
                chart.draw_series(LineSeries::new(points, sheet.line(curve.color, curve.width)))?;
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

    fn tile_legend(&self, tile: usize) -> Vec<LegendEntry> {
        // One curve alone has its name at the axis.
        let own = self.shown().nth(tile).filter(|part| part.curves.len() > 1);
        if self.common_legend().is_some() { Vec::new() } else { own.map_or(Vec::new(), |part| part.legend()) }
    }

    fn line_style(&self) -> LineStyle {
        LineStyle::ByColor
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        self.sizes(WIDTH)
    }

    fn narrow_tiles(&self) -> Vec<[f64; 2]> {
        self.sizes(NARROW)
    }

    fn draw<DB: DrawingBackend>(&self, tile: usize, sheet: &Sheet<DB>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let Some(panel) = self.shown().nth(tile) else { return Ok(()) };
        let range = match self.scale {
            PanelScale::Common => {
                let parts: Vec<PanelPart> = self.shown().collect();
                padded(parts.iter().flat_map(PanelPart::values))
            }
            PanelScale::Own => padded(panel.values()),
        };
        let x_name = if tile + 1 == self.shown().count() { self.x_name } else { "" };
        self.draw_panel(sheet, &panel, range, x_name)
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
    fn more_curves_than_colours_stand_in_several_panels() {
        let curves = (0..16).map(|k| Curve::new(format!("run {k}"), k, vec![0.0, k as f64]));
        let panels = vec![TimePanel::new("x [mm]", curves.collect())];
        let chart = TimeChart::over_time("many", "Many", "Runs.", &[0.0, 1.0], panels);
        assert_eq!(chart.tiles().len(), 3);
        let legends: Vec<Vec<LegendEntry>> = (0..3).map(|tile| chart.tile_legend(tile)).collect();
        assert_eq!(legends.iter().map(Vec::len).sum::<usize>(), 16);
        for legend in legends {
            assert!((1..legend.len()).all(|k| legend[..k].iter().all(|other| other.1 != legend[k].1)));
        }
    }

    #[test]
    fn a_phone_has_tiles_of_its_own() {
        register_embedded_font().expect("a font");
        let drawn = drawn(&chart([vec![0.0, 1.0], vec![2.0, 4.0]])).expect("a figure");
        assert_eq!(drawn.narrow.len(), drawn.tiles.len());
        assert!(drawn.narrow[0].contains(" width=\"336\""), "{}", drawn.narrow[0]);
        assert!(drawn.narrow[0].contains("&quot;names&quot;:[&quot;&quot;,&quot;x [mm]&quot;]"));
    }

    #[test]
    fn spans_of_flagged_samples_are_half_a_sample_longer() {
        let found = spans(&[0.0, 1.0, 2.0, 3.0, 4.0], &[true, false, true, true, false]);
        assert_eq!(found, [[0.0, 0.5], [1.5, 3.5]]);
    }
}
