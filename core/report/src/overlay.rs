//! Paths over each other from above: one pair of axes per tile, all to one scale with the origin in the middle.

use plotters::prelude::*;

use crate::figure::{Figure, LegendEntry};
use crate::plane::PlanePath;
use crate::sheet::{BELOW, COLORS, LEFT, Sheet};
use crate::simplify::{between_sharp_turns, simplified};

/// Side of the square inside a pair of axes, height of the lines above it, room between columns [px].
const SIDE: f64 = 240.0;
const ABOVE: f64 = 46.0;
const BETWEEN: f64 = 8.0;
const INDENT: f64 = 4.0;
const COLUMN: f64 = LEFT + SIDE + BETWEEN;
const ROW: f64 = ABOVE + SIDE + BELOW + 10.0;
/// Steps of a line that are drawn at once.
const SEGMENT_STEPS: usize = 6;

/// Tiles that show the same kinds of paths.
pub struct PathOverlay {
    /// Name of the file.
    pub name: String,
    /// Title.
    pub title: String,
    /// Caption: the content of the figure.
    pub caption: String,
    /// Kinds of paths, the last on top.
    pub kinds: Vec<PathKind>,
    /// From left to right, then below.
    pub tiles: Vec<OverlayTile>,
}

/// A kind of path, the same in all tiles.
pub struct PathKind {
    /// Name in the legend.
    pub name: String,
    /// Colour.
    pub color: RGBColor,
    /// Width of the line [px].
    pub width: f64,
}

/// One pair of axes.
pub struct OverlayTile {
    /// Name of the tile.
    pub title: String,
    /// Line below the name.
    pub note: String,
    /// A path for each kind [mm].
    pub paths: Vec<PlanePath>,
}

impl PathKind {
    /// A kind in the `k`-th colour.
    pub fn new(name: impl Into<String>, k: usize, width: f64) -> Self {
        Self { name: name.into(), color: COLORS[k % COLORS.len()], width }
    }
}

impl PathOverlay {
    /// Half the side of every pair of axes [mm].
    fn half(&self) -> f64 {
        let points = self.tiles.iter().flat_map(|tile| &tile.paths).flatten();
        1.08 * points.fold(0.0, |far: f64, (x, y)| far.max(x.abs()).max(y.abs()))
    }
}

impl Figure for PathOverlay {
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
        self.kinds.iter().map(|kind| (kind.name.clone(), kind.color)).collect()
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        vec![[COLUMN, ROW]; self.tiles.len()]
    }

    fn draw<DB: DrawingBackend>(&self, tile: usize, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let OverlayTile { title, note, paths } = &self.tiles[tile];
        let half = self.half();
        sheet.text(title, INDENT, 12.0)?;
        sheet.text(note, INDENT, 31.0)?;
        let part = sheet.part(0.0, ABOVE, LEFT + SIDE, SIDE + BELOW);
        let mut chart = part.chart(-half..half, -half..half, "x [mm]", "y [mm]")?;
        for (path, kind) in paths.iter().zip(&self.kinds) {
            // A tenth of its width is not visible.
            let fewer = simplified(path, 0.1 * kind.width * 2.0 * half / SIDE);
            // In short parts: where a line runs over itself, bitmaps would omit it.
            let lines = between_sharp_turns(&fewer).flat_map(|line| {
                (0..line.len())
                    .step_by(SEGMENT_STEPS)
                    .map(|from| &line[from..line.len().min(from + SEGMENT_STEPS + 1)])
            });
            for line in lines {
                let style = part.line(kind.color, kind.width);
                chart.draw_series(LineSeries::new(line.iter().copied(), style))?;
            }
        }
        Ok(())
    }
}
