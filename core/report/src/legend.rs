//! Legends: names and colours of a figure.

use plotters::style::RGBColor;

/// A name and its colour.
pub type LegendEntry = (String, RGBColor);

/// Room for an entry of a legend [px].
pub fn legend_width(name: &str) -> f64 {
    46.0 + 8.4 * name.chars().count() as f64
}

/// A legend in rows that fit a width [px].
pub(crate) fn rows(entries: Vec<LegendEntry>, width: f64) -> Vec<Vec<LegendEntry>> {
    let mut rows: Vec<Vec<LegendEntry>> = Vec::new();
    let mut used = f64::INFINITY;
    for entry in entries {
        let own = legend_width(&entry.0);
        if used + own > width {
            rows.push(Vec::new());
            used = 0.0;
        }
        used += own;
        if let Some(row) = rows.last_mut() {
            row.push(entry);
        }
    }
    rows
}
