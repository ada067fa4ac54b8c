//! Rows of dots: a row for each method, a dot for each of its repeats, and their mean; as tables of methods are read.

use plotters::prelude::*;

use crate::figure::{Figure, LegendEntry};
use crate::legend::legend_width;
use crate::sheet::{BELOW, COLORS, NARROW, Sheet};

/// Tiles of rows, each over a quantity of its own.
pub struct DotPlot {
    /// Name of the file.
    pub name: String,
    /// Title.
    pub title: String,
    /// Caption: the content of the figure.
    pub caption: String,
    /// From left to right, then below; one without a finite value is not drawn.
    pub tiles: Vec<DotTile>,
}

/// Rows over one quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct DotTile {
    /// Name of the quantity, with its unit.
    pub quantity: String,
    /// From the top down; one without a finite value is left empty.
    pub rows: Vec<DotRow>,
}

/// One method.
#[derive(Debug, Clone, PartialEq)]
pub struct DotRow {
    /// Name of the method.
    pub name: String,
    /// Values of its repeats.
    pub values: Vec<f64>,
}

/// Width of a tile, and of one that stands alone [px].
const WIDTH: f64 = 520.0;
const ALONE: f64 = 760.0;
/// Height of a row: its name, and its dots below [px].
const ROW: f64 = 38.0;
/// Height of a line of the quantity's name, above the rows [px].
const NAME_LINE: f64 = 18.0;
/// Half the height of the bar at a mean, as a part of a row [-].
const MEAN: f64 = 0.16;
/// Dots stand so high in their row [-].
const DOTS: f64 = 0.26;
/// Room beyond the last value, as a part of the axis [-].
const AIR: f64 = 0.06;

impl DotRow {
    /// A row of these values.
    pub fn new(name: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Self {
        Self { name: name.into(), values: values.into_iter().collect() }
    }

    fn finite(&self) -> impl Iterator<Item = f64> {
        self.values.iter().copied().filter(|value| value.is_finite())
    }

    /// Mean of several values.
    fn mean(&self) -> Option<f64> {
        let n = self.finite().count();
        (n > 1).then(|| self.finite().sum::<f64>() / n as f64)
    }
}

impl DotTile {
    /// A tile of these rows.
    pub fn new(quantity: impl Into<String>, rows: impl IntoIterator<Item = DotRow>) -> Self {
        Self { quantity: quantity.into(), rows: rows.into_iter().collect() }
    }

    /// From zero, or from the smallest value below, to the largest with some air.
    fn range(&self) -> std::ops::Range<f64> {
        let values = || self.rows.iter().flat_map(DotRow::finite);
        let (low, high) = (values().fold(0.0, f64::min), values().fold(0.0, f64::max));
        let air = AIR * if high > low { high - low } else { 1.0 };
        (if low < 0.0 { low - air } else { 0.0 })..high + air
    }

    /// The quantity's name in lines that fit the width [px], and its unit.
    fn heading(&self, width: f64) -> (Vec<String>, &str) {
        let at = self.quantity.rfind('[').unwrap_or(self.quantity.len());
        let (name, unit) = self.quantity.split_at(at);
        let mut lines: Vec<String> = Vec::new();
        for word in name.split_whitespace() {
            match lines.last_mut() {
                Some(line) if legend_width(&format!("{line} {word}")) <= width => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        (lines, unit)
    }

    fn height(&self, width: f64) -> f64 {
        NAME_LINE * self.heading(width).0.len() as f64 + ROW * self.rows.len() as f64 + BELOW
    }

    fn draw<DB: DrawingBackend>(&self, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let (n, (width, height)) = (self.rows.len(), sheet.size());
        let (lines, unit) = self.heading(width);
        for (k, line) in lines.iter().enumerate() {
            sheet.text(line, 0.0, NAME_LINE * (k as f64 + 0.5))?;
        }
        let above = NAME_LINE * lines.len() as f64;
        let sheet = &sheet.part(0.0, above, width, height - above);
        let mut chart = sheet.chart_of_rows(self.range(), n, unit)?;
        for (k, row) in self.rows.iter().enumerate() {
            let foot = (n - 1 - k) as f64;
            let at = foot + DOTS;
            let dot = |x| Circle::new((x, at), sheet.px(3.5), COLORS[0].filled());
            chart.draw_series(row.finite().map(dot))?;
            let bar = |x| PathElement::new(vec![(x, at - MEAN), (x, at + MEAN)], sheet.line(COLORS[1], 2.5));
            chart.draw_series(row.mean().map(bar))?;
        }
        for (k, row) in self.rows.iter().enumerate() {
            sheet.text(&row.name, 8.0, ROW * (k as f64 + 0.3))?;
        }
        Ok(())
    }
}

impl DotPlot {
    fn shown(&self) -> impl Iterator<Item = &DotTile> {
        self.tiles.iter().filter(|tile| tile.rows.iter().any(|row| row.finite().next().is_some()))
    }

    fn sizes(&self, width: f64) -> Vec<[f64; 2]> {
        self.shown().map(|tile| [width, tile.height(width)]).collect()
    }
}

impl Figure for DotPlot {
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
        let has_mean = self.shown().flat_map(|tile| &tile.rows).any(|row| row.mean().is_some());
        let names = [("one repeat", COLORS[0]), ("mean", COLORS[1])];
        let entries = names.map(|(name, color)| (name.to_owned(), color));
        if has_mean { entries.to_vec() } else { Vec::new() }
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        self.sizes(if self.shown().count() == 1 { ALONE } else { WIDTH })
    }

    fn narrow_tiles(&self) -> Vec<[f64; 2]> {
        self.sizes(NARROW)
    }

    fn draw<DB: DrawingBackend>(&self, tile: usize, sheet: &Sheet<DB>) -> anyhow::Result<()>
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
    use crate::figure::{drawn, register_embedded_font};

    #[test]
    fn every_finite_value_is_a_dot_and_several_have_a_mean() {
        register_embedded_font().unwrap();
        let rows = [
            DotRow::new("network", [1.0, 3.0, f64::NAN]),
            DotRow::new("none", []),
            DotRow::new("one", [2.0]),
        ];
        let tile = DotTile::new("error [mm]", rows);
        let means: Vec<Option<f64>> = tile.rows.iter().map(DotRow::mean).collect();
        assert_eq!(means, [Some(2.0), None, None]);
        assert_eq!(tile.range(), 0.0..3.0 + 3.0 * AIR);
        let empty = DotTile::new("error [N]", [DotRow::new("none", [f64::NAN])]);
        let [name, title, caption] = ["methods", "Methods", "Errors."].map(str::to_owned);
        let plot = DotPlot { name, title, caption, tiles: vec![empty, tile] };
        let drawn = drawn(&plot).unwrap();
        assert_eq!(drawn.tiles.len(), 1);
        assert_eq!(drawn.tiles[0].matches("<circle").count(), 3);
        assert!(["network", "none", "error", "[mm]"].iter().all(|text| drawn.tiles[0].contains(text)));
        assert_eq!(drawn.legend.len(), 2);
    }

    #[test]
    fn a_long_name_is_broken_between_words() {
        let name = "error of the strokes, root mean square of all tendons";
        let tile = DotTile::new(format!("{name} [mm]"), []);
        let (lines, unit) = tile.heading(NARROW);
        assert!(lines.len() > 1 && lines.iter().all(|line| legend_width(line) <= NARROW), "{lines:?}");
        assert_eq!((lines.join(" "), unit), (name.to_owned(), "[mm]"));
        assert_eq!(tile.heading(2.0 * ALONE).0, [name]);
    }

    #[test]
    fn what_is_below_zero_and_what_is_all_zero_has_an_axis() {
        let of = |values: [f64; 2]| DotTile::new("gain [-]", [DotRow::new("a", values)]).range();
        assert_eq!(of([0.0, 0.0]), 0.0..AIR);
        let range = of([-1.0, 1.0]);
        assert!(range.start < -1.0 && range.end > 1.0, "{range:?}");
    }
}
