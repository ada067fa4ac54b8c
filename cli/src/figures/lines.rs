//! Values over time, in one or several panels above each other.

use anyhow::Result;
use plotters::prelude::*;

use super::Figure;
use super::sheet::{BELOW, Sheet, padded};
use super::simplify::simplified;

/// Panels with a common time axis and a common legend.
pub struct TimeChart {
    /// Name of the file.
    pub name: &'static str,
    /// Title.
    pub title: String,
    /// What it shows.
    pub caption: String,
    /// Times (n_samples) [s].
    pub time: Vec<f64>,
    /// From the top down.
    pub panels: Vec<TimePanel>,
}

/// One pair of axes.
pub struct TimePanel {
    /// Name of the vertical axis.
    pub label: String,
    /// Curves, the last on top.
    pub curves: Vec<Curve>,
}

/// A line.
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Colour.
    pub color: RGBColor,
    /// Width [px].
    pub width: f64,
    /// Values (n_samples), in the unit of the axis.
    pub values: Vec<f64>,
}

const TOP: f64 = 38.0;

impl TimeChart {
    fn panel_height(&self) -> f64 {
        if self.panels.len() == 1 { 270.0 } else { 120.0 }
    }
}

impl Figure for TimeChart {
    fn name(&self) -> &'static str {
        self.name
    }

    fn caption(&self) -> String {
        self.caption.clone()
    }

    fn size(&self) -> (u32, u32) {
        (900, (TOP + self.panel_height() * self.panels.len() as f64 + BELOW) as u32)
    }

    fn draw<DB: DrawingBackend>(&self, sheet: &Sheet<DB>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        sheet.title(&self.title)?;
        // All panels have the same curves; the legend names the topmost first.
        let curves = self.panels.first().map_or(&[][..], |panel| &panel.curves);
        let mut entries: Vec<(String, RGBColor)> =
            curves.iter().map(|curve| (curve.name.clone(), curve.color)).collect();
        if self.panels.len() > 1 {
            entries.reverse();
        }
        sheet.legend(&entries)?;
        let (width, _) = sheet.size();
        let (first, last) = (self.time[0], self.time[self.time.len() - 1]);
        let end = if last > first { last } else { first + 1.0 };
        // One scale for all, so that panels compare.
        let values = || self.panels.iter().flat_map(|panel| &panel.curves).flat_map(|curve| &curve.values);
        let range = padded(values().copied());
        let span = range.end - range.start;
        for (k, panel) in self.panels.iter().enumerate() {
            let is_last = k + 1 == self.panels.len();
            let height = self.panel_height() + if is_last { BELOW - 8.0 } else { 0.0 };
            let part = sheet.part(8.0, TOP + self.panel_height() * k as f64, width - 30.0, height);
            let x_name = if is_last { "time [s]" } else { "" };
            let mut chart = part.chart(first..end, range.clone(), x_name, &panel.label)?;
            for curve in &panel.curves {
                // Compared in parts of the axes; a fifth of a pixel is not seen.
                let scaled: Vec<(f64, f64)> = self
                    .time
                    .iter()
                    .zip(&curve.values)
                    .map(|(t, value)| ((t - first) / (end - first) * 4.0, (value - range.start) / span))
                    .collect();
                let points = simplified(&scaled, 0.0008)
                    .into_iter()
                    .map(|(t, value)| (first + t / 4.0 * (end - first), range.start + value * span));
                chart.draw_series(LineSeries::new(points, sheet.line(curve.color, curve.width)))?;
            }
        }
        Ok(())
    }
}
