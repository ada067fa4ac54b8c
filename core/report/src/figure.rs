//! A figure: tiles side by side and below each other, with a title, a legend and a caption.
//!
//! A file holds the whole figure; a report holds the tiles one by one, so that they stand below each other where the
//! window is narrow. Everything is drawn once as SVG, at several times its size: plotters rounds to whole pixels, and
//! curves would show it. The same code draws the PNG. Text is measured with an embedded font (`assets/`), so a figure
//! is the same on a machine without fonts; an SVG is shown in the viewer's own sans-serif.

use std::path::Path;
use std::sync::LazyLock;

use plotters::prelude::*;
use plotters::style::register_font;
use png::{ColorType, Encoder};

pub use crate::legend::LegendEntry;
use crate::legend::legend_width;
use crate::maker::{SIGNATURE, replace};
use crate::sheet::Sheet;

/// Something to be drawn on any backend.
pub trait Figure {
    /// Name of the file, without ending.
    fn name(&self) -> String;
    /// A few words.
    fn title(&self) -> String;
    /// Caption: the content of the figure, for a reader.
    fn caption(&self) -> String;
    /// Legend: names and colours of all tiles.
    fn legend(&self) -> Vec<LegendEntry> {
        Vec::new()
    }
    /// Width and height of every tile [px].
    fn tiles(&self) -> Vec<[f64; 2]>;
    /// Draws a tile.
    fn draw<DB: DrawingBackend>(&self, tile: usize, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static;
}

/// A figure as it goes into a report.
pub struct Drawn {
    /// A few words.
    pub title: String,
    /// Legend: names and colours.
    pub legend: Vec<LegendEntry>,
    /// One SVG per tile.
    pub tiles: Vec<String>,
    /// Whether the tiles are too wide to be shrunk to a narrow window.
    pub is_wide: bool,
    /// Caption: the content of the figure.
    pub caption: String,
}

const SVG_SCALE: u32 = 5;
const PNG_SCALE: u32 = 2;
/// Room for the title, and for a row of the legend [px].
const TITLE: f64 = 38.0;
const LEGEND_ROW: f64 = 20.0;
/// Wider tiles are scrolled, not shrunk, where a window is narrow [px].
const WIDE: f64 = 600.0;
/// Width of a file at most, if no tile is wider, and air around [px].
const MAX_WIDTH: f64 = 944.0;
const AIR: f64 = 4.0;

/// Registers the font that figures are measured with; once is enough for a program.
pub fn register_embedded_font() -> anyhow::Result<()> {
    static IS_READABLE: LazyLock<bool> = LazyLock::new(|| {
        let font = include_bytes!("../assets/DejaVuSans-subset.ttf");
        register_font("sans-serif", FontStyle::Normal, font).is_ok()
    });
    anyhow::ensure!(*IS_READABLE, "the embedded font cannot be read");
    Ok(())
}

/// Writes a figure as `NAME.svg`, and as `NAME.png` where asked, to `folder`.
pub fn save(folder: &Path, figure: &impl Figure, with_png: bool) -> anyhow::Result<Drawn> {
    let layout = FigureLayout::of(figure);
    let svg = svg(layout.size, |sheet| layout.draw(figure, sheet))?;
    replace(&folder.join(format!("{}.svg", figure.name())), format!("{SIGNATURE}\n{svg}"))?;
    if with_png {
        replace(&folder.join(format!("{}.png", figure.name())), png(figure)?)?;
    }
    drawn(figure)
}

/// The tiles of a figure, for a report.
pub fn drawn(figure: &impl Figure) -> anyhow::Result<Drawn> {
    let tile = |(k, size): (usize, &[f64; 2])| svg(*size, |sheet| figure.draw(k, sheet));
    Ok(Drawn {
        title: figure.title(),
        legend: figure.legend(),
        tiles: figure.tiles().iter().enumerate().map(tile).collect::<anyhow::Result<_>>()?,
        is_wide: figure.tiles().iter().any(|[width, _]| *width > WIDE),
        caption: figure.caption(),
    })
}

/// Where everything stands in a file.
struct FigureLayout {
    size: [f64; 2],
    legend: Vec<Vec<LegendEntry>>,
    /// Upper left corner and size of every tile.
    places: Vec<([f64; 2], [f64; 2])>,
}

impl FigureLayout {
    fn of(figure: &impl Figure) -> Self {
        let tiles = figure.tiles();
        let widest = tiles.iter().map(|[width, _]| *width).fold(0.0, f64::max);
        let room = MAX_WIDTH.max(widest);
        let mut places: Vec<([f64; 2], [f64; 2])> = Vec::new();
        let (mut x, mut y, mut height, mut width) = (0.0, 0.0, 0.0f64, 0.0f64);
        for tile in tiles {
            if x + tile[0] > room {
                (x, y, height) = (0.0, y + height, 0.0);
            }
            places.push(([x, y], tile));
            x += tile[0];
            (width, height) = (width.max(x), height.max(tile[1]));
        }
        let width = width.max(480.0) + 2.0 * AIR;
        let legend = rows(figure.legend(), width - 30.0);
        let top = TITLE + LEGEND_ROW * legend.len() as f64;
        places.iter_mut().for_each(|(at, _)| *at = [at[0] + AIR, at[1] + top]);
        Self { size: [width, top + y + height + AIR], legend, places }
    }

    fn draw<DB: DrawingBackend>(&self, figure: &impl Figure, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        sheet.title(&figure.title())?;
        for (k, row) in self.legend.iter().enumerate() {
            sheet.legend(row, 14.0, TITLE + LEGEND_ROW * k as f64)?;
        }
        for (k, ([x, y], [width, height])) in self.places.iter().enumerate() {
            figure.draw(k, &sheet.part(*x, *y, *width, *height))?;
        }
        Ok(())
    }
}

/// A legend in rows that fit a width [px].
fn rows(entries: Vec<LegendEntry>, width: f64) -> Vec<Vec<LegendEntry>> {
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

fn svg(
    [width, height]: [f64; 2],
    draw: impl FnOnce(&Sheet<SVGBackend>) -> anyhow::Result<()>,
) -> anyhow::Result<String> {
    let (width, height) = (width.ceil() as u32, height.ceil() as u32);
    let large = (width * SVG_SCALE, height * SVG_SCALE);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, large).into_drawing_area();
        draw(&Sheet::new(root.clone(), f64::from(SVG_SCALE))?)?;
        root.present()?;
    }
    // Shown at normal size; the view box keeps the fine coordinates.
    let own = format!("width=\"{}\" height=\"{}\"", large.0, large.1);
    let shown = format!("width=\"{width}\" height=\"{height}\"");
    Ok(svg.replacen(&own, &shown, 1))
}

/// The whole figure as PNG, which says by which program it is.
pub fn png(figure: &impl Figure) -> anyhow::Result<Vec<u8>> {
    let layout = FigureLayout::of(figure);
    let [width, height] = layout.size.map(|length| length.ceil() as u32 * PNG_SCALE);
    let mut pixels = vec![0; 3 * width as usize * height as usize];
    {
        let root = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
        layout.draw(figure, &Sheet::new(root.clone(), f64::from(PNG_SCALE))?)?;
        root.present()?;
    }
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.add_text_chunk("Software".to_owned(), "hysteron".to_owned())?;
    encoder.write_header()?.write_image_data(&pixels)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Tiles(Vec<[f64; 2]>);

    impl Figure for Tiles {
        fn name(&self) -> String {
            "tiles".into()
        }

        fn title(&self) -> String {
            "Tiles".into()
        }

        fn caption(&self) -> String {
            String::new()
        }

        fn legend(&self) -> Vec<LegendEntry> {
            (0..12).map(|k| (format!("entry number {k}"), BLACK)).collect()
        }

        fn tiles(&self) -> Vec<[f64; 2]> {
            self.0.clone()
        }

        fn draw<DB: DrawingBackend>(&self, _: usize, _: &Sheet<DB>) -> anyhow::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn tiles_and_legends_fit_the_file_and_do_not_overlap() {
        let layout =
            FigureLayout::of(&Tiles(vec![[310.0, 300.0], [310.0, 280.0], [310.0, 300.0], [900.0, 120.0]]));
        assert!(layout.legend.len() > 1);
        for (k, (at, size)) in layout.places.iter().enumerate() {
            assert!((0..2).all(|c| at[c] + size[c] <= layout.size[c]));
            for (other, other_size) in &layout.places[..k] {
                let overlaps = |c: usize| at[c] < other[c] + other_size[c] && other[c] < at[c] + size[c];
                assert!(!(overlaps(0) && overlaps(1)));
            }
        }
        assert!(layout.places[3].0[1] > layout.places[0].0[1] + 299.0);
    }
}
