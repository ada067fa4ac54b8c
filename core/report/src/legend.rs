//! Legends: names and colours of a figure.

use plotters::style::RGBColor;

/// A name and its colour.
pub type LegendEntry = (String, RGBColor);

/// Room for an entry of a legend [px].
pub fn legend_width(name: &str) -> f64 {
    46.0 + 7.4 * name.chars().count() as f64
}
