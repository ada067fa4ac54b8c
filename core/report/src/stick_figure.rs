//! A body as lines from point to point at several times, seen from two sides.

use plotters::prelude::*;

use crate::figure::Figure;
use crate::sheet::{BELOW, LEFT, Sheet, padded, ramp};

/// A body at several times, the colour by the time.
pub struct StickFigure {
    /// Name of the file.
    pub name: String,
    /// Title.
    pub title: String,
    /// Caption: the content of the figure.
    pub caption: String,
    /// Times [s], and lines from point to point [m]; one or more.
    pub poses: Vec<(f64, Vec<[[f64; 3]; 2]>)>,
}

/// Size of a view, and of the bar of colours [px].
const VIEW: [f64; 2] = [320.0, 320.0];
const BAR: [f64; 2] = [100.0, 320.0];
/// Axes to the right and up.
const VIEWS: [[usize; 2]; 2] = [[0, 2], [1, 2]];

impl StickFigure {
    /// From the smallest to the largest coordinate [m].
    fn extent(&self, axis: usize) -> std::ops::Range<f64> {
        padded(self.poses.iter().flat_map(|(_, lines)| lines.iter().flatten()).map(|point| point[axis]))
    }

    /// Part of the time that has passed at pose `k` [-].
    fn part(&self, k: usize) -> f64 {
        k as f64 / (self.poses.len() - 1).max(1) as f64
    }
}

impl Figure for StickFigure {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn title(&self) -> String {
        self.title.clone()
    }

    fn caption(&self) -> String {
        self.caption.clone()
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        vec![VIEW, VIEW, BAR]
    }

    fn draw<DB: DrawingBackend>(&self, tile: usize, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let Some(axes) = VIEWS.get(tile) else {
            let last = self.poses.last().map_or(0.0, |(time, _)| *time);
            return sheet.color_bar("time [s]", self.poses[0].0, last);
        };
        // The same scale along both axes, and in both views.
        let (width, height) = sheet.size();
        let room = f64::min(width - LEFT, height - BELOW);
        let span = (0..3).map(|axis| self.extent(axis)).map(|own| own.end - own.start).fold(0.0, f64::max);
        let range = |axis: usize, px: f64| {
            let own = self.extent(axis);
            let (middle, half) = (0.5 * (own.start + own.end), 0.5 * span * px / room);
            middle - half..middle + half
        };
        let [x, y] = axes.map(|axis| format!("{} [m]", ["x", "y", "z"][axis]));
        let mut chart = sheet.chart(range(axes[0], width - LEFT), range(axes[1], height - BELOW), &x, &y)?;
        for (k, (_, lines)) in self.poses.iter().enumerate() {
            let style = sheet.line(ramp(self.part(k)), 2.5);
            let flat = |point: &[f64; 3]| (point[axes[0]], point[axes[1]]);
            chart.draw_series(
                lines.iter().map(|line| PathElement::new(line.each_ref().map(flat).to_vec(), style)),
            )?;
        }
        Ok(())
    }
}
