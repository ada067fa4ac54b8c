//! What the colours of a figure stand for.

use plotters::style::RGBColor;

/// A name and the colour of what it stands for.
pub type Entry = (String, RGBColor);

/// Room for an entry of a legend [px].
pub fn legend_width(name: &str) -> f64 {
    46.0 + 7.4 * name.chars().count() as f64
}
