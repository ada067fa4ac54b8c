//! A figure: tiles side by side and below each other, with a title, a legend and a caption.
//!
//! A file holds the whole figure; a report holds the tiles one by one, so that they are below each other where the
//! window is narrow, and tiles that a phone does not show whole a second time for it. Type keeps its size. Everything is
//! drawn as SVG, at several times its size: plotters rounds to whole pixels, and
//! curves would show it. The same code draws the PNG. Text is measured with an embedded font (`assets/`), so a figure
//! is the same on a machine without fonts; an SVG is shown in the viewer's own sans-serif.

use std::path::Path;
use std::sync::LazyLock;

use plotters::prelude::*;
use plotters::style::register_font;
use png::{ColorType, Encoder};

use crate::color::style;
pub use crate::legend::LegendEntry;
use crate::legend::rows;
use crate::line_style::LineStyle;
use crate::maker::{SIGNATURE, replace};
use crate::sheet::Sheet;
use crate::svg::{SCALE, SvgFrame, svg};

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
    /// Legend of one tile, where tiles differ.
    fn tile_legend(&self, _tile: usize) -> Vec<LegendEntry> {
        Vec::new()
    }
    /// Lines of the curves.
    fn line_style(&self) -> LineStyle {
        LineStyle::Solid
    }
    /// Width and height of every tile [px].
    fn tiles(&self) -> Vec<[f64; 2]>;
    /// The same for a phone; tiles of at most [`NARROW`](crate::sheet::NARROW) need no others.
    fn narrow_tiles(&self) -> Vec<[f64; 2]> {
        self.tiles()
    }
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
    /// Legend of every tile, where tiles differ.
    pub tile_legends: Vec<Vec<LegendEntry>>,
    /// Lines of the curves.
    pub line_style: LineStyle,
    /// One SVG per tile.
    pub tiles: Vec<String>,
    /// The same for a narrow window, where those are too wide.
    pub narrow: Vec<String>,
    /// Caption: the content of the figure.
    pub caption: String,
}

const PNG_SCALE: u32 = 2;
/// Room for the title, and for a row of the legend [px].
const TITLE: f64 = 42.0;
const LEGEND_ROW: f64 = 22.0;
const INDENT: f64 = 14.0;
/// Width of a file at most, if no tile is wider, and air around [px].
const MAX_WIDTH: f64 = 1112.0;
const AIR: f64 = 4.0;
/// Air above a tile and to its right, for labels at the ends of axes [px].
const TILE_AIR: [f64; 2] = [12.0, 8.0];

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
    let rules = style(SCALE);
    let file = SvgFrame { size: layout.size, line_style: figure.line_style(), rules: &rules };
    let svg = svg(&file, |sheet| layout.draw(figure, sheet))?;
    replace(&folder.join(format!("{}.svg", figure.name())), format!("{SIGNATURE}\n{svg}"))?;
    if with_png {
        replace(&folder.join(format!("{}.png", figure.name())), png(figure)?)?;
    }
    drawn(figure)
}

/// The tiles of a figure, for a report.
pub fn drawn(figure: &impl Figure) -> anyhow::Result<Drawn> {
    let [right, above] = TILE_AIR;
    let tile = |(k, [width, height]): (usize, &[f64; 2])| {
        let size = [width + right, height + above];
        let drawing = SvgFrame { size, line_style: figure.line_style(), rules: "" };
        svg(&drawing, |sheet| figure.draw(k, &sheet.part(0.0, above, *width, *height)))
    };
    let all = |sizes: &[[f64; 2]]| sizes.iter().enumerate().map(tile).collect::<anyhow::Result<Vec<_>>>();
    let (sizes, narrow) = (figure.tiles(), figure.narrow_tiles());
    Ok(Drawn {
        title: figure.title(),
        legend: figure.legend(),
        tile_legends: (0..sizes.len()).map(|k| figure.tile_legend(k)).collect(),
        line_style: figure.line_style(),
        tiles: all(&sizes)?,
        narrow: if narrow == sizes { Vec::new() } else { all(&narrow)? },
        caption: figure.caption(),
    })
}

/// Layout of a file.
struct FigureLayout {
    size: [f64; 2],
    legend: Vec<Vec<LegendEntry>>,
    tiles: Vec<TilePlace>,
}

/// Place of a tile: its legend, and itself below.
struct TilePlace {
    at: [f64; 2],
    legend: Vec<Vec<LegendEntry>>,
    size: [f64; 2],
}

impl TilePlace {
    fn outer(&self) -> [f64; 2] {
        let [right, above] = TILE_AIR;
        [self.size[0] + right, self.above() + self.size[1] + if self.legend.is_empty() { 0.0 } else { above }]
    }

    /// Room above the axes [px].
    fn above(&self) -> f64 {
        TILE_AIR[1] + LEGEND_ROW * self.legend.len() as f64
    }
}

impl FigureLayout {
    fn of(figure: &impl Figure) -> Self {
        let sizes = figure.tiles();
        let widest = sizes.iter().map(|[width, _]| *width + TILE_AIR[0]).fold(0.0, f64::max);
        let room = MAX_WIDTH.max(widest);
        let mut tiles: Vec<TilePlace> = Vec::new();
        let (mut x, mut y, mut height, mut width) = (0.0, 0.0, 0.0f64, 0.0f64);
        for (k, size) in sizes.into_iter().enumerate() {
            let legend = rows(figure.tile_legend(k), size[0] - INDENT);
            let mut tile = TilePlace { at: [0.0; 2], legend, size };
            let outer = tile.outer();
            if x + outer[0] > room {
                (x, y, height) = (0.0, y + height, 0.0);
            }
            tile.at = [x, y];
            tiles.push(tile);
            x += outer[0];
            (width, height) = (width.max(x), height.max(outer[1]));
        }
        let width = width.max(480.0) + 2.0 * AIR;
        let legend = rows(figure.legend(), width - 30.0);
        let top = TITLE + LEGEND_ROW * legend.len() as f64;
        tiles.iter_mut().for_each(|tile| tile.at = [tile.at[0] + AIR, tile.at[1] + top]);
        Self { size: [width, top + y + height + AIR], legend, tiles }
    }

    fn draw<DB: DrawingBackend>(&self, figure: &impl Figure, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        sheet.title(&figure.title())?;
        for (k, row) in self.legend.iter().enumerate() {
            sheet.legend(row, INDENT, TITLE + LEGEND_ROW * k as f64)?;
        }
        for (k, tile) in self.tiles.iter().enumerate() {
            let ([x, y], [width, height]) = (tile.at, tile.size);
            for (row, entries) in tile.legend.iter().enumerate() {
                sheet.legend(entries, x + INDENT, y + LEGEND_ROW * (row as f64 + 0.5) + 2.0)?;
            }
            figure.draw(k, &sheet.part(x, y + tile.above(), width, height))?;
        }
        Ok(())
    }
}

/// The whole figure as PNG, with the program in its metadata.
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
            (0..20).map(|k| (format!("entry number {k}"), BLACK)).collect()
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
        for (k, tile) in layout.tiles.iter().enumerate() {
            let (at, size) = (tile.at, tile.outer());
            assert!((0..2).all(|c| at[c] + size[c] <= layout.size[c]));
            for other in &layout.tiles[..k] {
                let (before, its_size) = (other.at, other.outer());
                let overlaps = |c: usize| at[c] < before[c] + its_size[c] && before[c] < at[c] + size[c];
                assert!(!(overlaps(0) && overlaps(1)));
            }
        }
        assert!(layout.tiles[3].at[1] > layout.tiles[0].at[1] + 299.0);
    }
}
