//! Panels that several reports share: the tip along every axis, errors, strokes.

use plotters::style::RGBColor;

use crate::lines::{Curve, TimePanel};
use crate::sheet::COLORS;

/// The robot as measured, in every figure over time.
pub const MEASURED: RGBColor = COLORS[6];
/// The twin, or the better of two.
pub const TWIN: RGBColor = COLORS[0];
/// The twin before a correction.
pub const UNCORRECTED: RGBColor = COLORS[1];
/// Where the tip was to go.
pub const TARGET: RGBColor = COLORS[4];

/// Curves in one panel at most, so that their colours differ.
const MAX_CURVES: usize = 6;

/// Coordinates of a tip over time, with a name and a colour.
pub struct TipSeries {
    /// Name in the legend.
    pub name: &'static str,
    /// Colour.
    pub color: RGBColor,
    /// x, y and perhaps z (n_samples each) [mm]; NaN where nothing was measured.
    pub axes: Vec<Vec<f64>>,
}

impl TipSeries {
    /// A tip from coordinates [m].
    pub fn new(name: &'static str, color: RGBColor, axes: &[&[f64]]) -> Self {
        Self { name, color, axes: axes.iter().map(|values| millimetres(values)).collect() }
    }

    /// The same without the samples that were not measured.
    pub fn without_gaps(mut self, gap: &[bool]) -> Self {
        for axis in &mut self.axes {
            axis.iter_mut().zip(gap).filter(|(_, gap)| **gap).for_each(|(value, _)| *value = f64::NAN);
        }
        self
    }

    /// The same, measured from another origin [m].
    pub fn relative_to(mut self, origin: [f64; 3]) -> Self {
        for (axis, origin) in self.axes.iter_mut().zip(origin) {
            axis.iter_mut().for_each(|value| *value -= 1e3 * origin);
        }
        self
    }

    /// Distance from another tip at the same times (n_samples) [mm], over the axes that both have.
    pub fn distance_from(&self, other: &Self) -> Vec<f64> {
        let pairs = || self.axes.iter().zip(&other.axes);
        let n = self.axes.first().map_or(0, Vec::len);
        (0..n).map(|i| pairs().map(|(a, b)| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()).collect()
    }

    fn curve(&self, values: Vec<f64>) -> Curve {
        Curve { name: self.name.to_owned(), color: self.color, width: 1.2, values }
    }
}

/// Values in millimetres.
pub fn millimetres(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| 1e3 * value).collect()
}

/// One panel per axis, all tips in each, the first below.
pub fn tip_panels(tips: &[TipSeries]) -> Vec<TimePanel> {
    let n_axes = tips.iter().map(|tip| tip.axes.len()).max().unwrap_or(0);
    let panel = |c: usize| {
        let curves = tips.iter().filter_map(|tip| Some(tip.curve(tip.axes.get(c)?.clone()))).collect();
        TimePanel::new(format!("tip {} [mm]", ["x", "y", "z"][c]), curves)
    };
    (0..n_axes).map(panel).collect()
}

/// One panel with the distance of every tip from the reference.
pub fn error_panel(reference: &TipSeries, tips: &[TipSeries]) -> TimePanel {
    TimePanel::new("error [mm]", tips.iter().map(|tip| tip.curve(tip.distance_from(reference))).collect())
}

/// Series of one quantity in as few panels as their colours allow: named `STEM 1`, ... in the legend.
pub fn numbered_panels(label: &str, stem: &str, series: Vec<Vec<f64>>) -> Vec<TimePanel> {
    let n_panels = series.len().div_ceil(MAX_CURVES).max(1);
    let in_each = series.len().div_ceil(n_panels).max(1);
    let curve = |(k, values): (usize, Vec<f64>)| Curve::new(format!("{stem} {}", k + 1), k % in_each, values);
    let curves: Vec<Curve> = series.into_iter().enumerate().map(curve).collect();
    curves.chunks(in_each).map(|curves| TimePanel::new(label, curves.to_vec())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_distances_and_gaps_have_none() {
        let (x, y) = ([0.0, 1e-3, 2e-3], [0.0, 0.0, 1e-3]);
        let measured = TipSeries::new("measured", MEASURED, &[&x, &y]).without_gaps(&[false, true, false]);
        let twin = TipSeries::new("twin", TWIN, &[&[3e-3, 1e-3, 2e-3], &[4e-3, 0.0, 0.0]]);
        let error = twin.distance_from(&measured);
        assert!((error[0] - 5.0).abs() < 1e-12 && error[1].is_nan() && (error[2] - 1.0).abs() < 1e-12);
        assert_eq!(error_panel(&measured, &[twin]).curves.len(), 1);
    }

    #[test]
    fn many_series_share_panels_in_which_colours_differ() {
        let panels = numbered_panels("stroke [mm]", "tendon", vec![vec![0.0]; 36]);
        assert_eq!(panels.len(), 6);
        for panel in &panels {
            for (k, curve) in panel.curves.iter().enumerate() {
                assert!(panel.curves[..k].iter().all(|other| other.color != curve.color));
            }
        }
        assert_eq!(panels[5].curves[5].name, "tendon 36");
    }
}
