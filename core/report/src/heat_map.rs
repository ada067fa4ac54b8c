//! How many samples lie where, from above: a tile for each group, all to one scale and one logarithmic colour bar.

use plotters::prelude::*;

use crate::figure::{Figure, LegendEntry};
use crate::plane::{PlanePath, square_around};
use crate::sheet::{BAR, BELOW, COLORS, LEFT, Sheet, number, ramp};

const OUTLINE: RGBColor = COLORS[6];
/// Side of the square inside a pair of axes, height of the line above it [px].
const SIDE: f64 = 240.0;
const ABOVE: f64 = 26.0;
const INDENT: f64 = 4.0;
/// Cells along the side of the square.
const CELLS: usize = 60;
const SHADES: usize = 16;

/// Cells of a plane, each with its samples.
pub type CellCount = Vec<([i64; 2], usize)>;

/// Samples counted in square cells.
pub struct HeatMap {
    /// Name of the file.
    pub name: String,
    /// Title.
    pub title: String,
    /// Caption: the content of the figure.
    pub caption: String,
    /// Name in the legend of a line that is drawn over all tiles.
    outline_name: String,
    /// Corners of that line [mm]; none where there is none.
    outline: PlanePath,
    /// Middle of the square that all tiles show, and half its side [mm].
    middle: [f64; 2],
    half: f64,
    groups: Vec<HeatMapGroup>,
    /// Most samples in a cell.
    most: f64,
}

/// Samples of a tile by cell.
struct HeatMapGroup {
    title: String,
    /// By row from below, then by column (CELLS × CELLS).
    counts: Vec<usize>,
}

impl HeatMap {
    /// The samples of each group with its title [mm], and the corners of a closed line with its name [mm]; no caption yet.
    pub fn new(
        name: impl Into<String>,
        title: impl Into<String>,
        groups: Vec<(String, PlanePath)>,
        (outline_name, outline): (&str, PlanePath),
    ) -> Self {
        let (middle, half) = square_around(groups.iter().flat_map(|(_, points)| points));
        let groups = groups
            .into_iter()
            .map(|(title, points)| HeatMapGroup { title, counts: counted(&points, middle, half) })
            .collect();
        Self::of_groups((name.into(), title.into()), groups, (middle, half), (outline_name, outline))
    }

    /// Samples that are counted already: of each group, with its title, the cells (i, j) and their samples; a cell reaches from i
    /// and j to i + 1 and j + 1 times its side [mm]. Where they are too small to be drawn, several are drawn as one.
    pub fn of_cells(
        name: impl Into<String>,
        title: impl Into<String>,
        groups: Vec<(String, CellCount)>,
        side: f64,
        outline: (&str, PlanePath),
    ) -> Self {
        let edges = [0, 1].map(|axis| {
            let along = groups.iter().flat_map(|(_, cells)| cells.iter().map(move |(cell, _)| cell[axis]));
            along.fold(None, |found: Option<[i64; 2]>, at| {
                Some(found.map_or([at, at], |[low, high]| [low.min(at), high.max(at)]))
            })
        });
        let edges = edges.map(|found| found.unwrap_or([0, 0]));
        let widest = edges.iter().map(|[low, high]| high - low + 1).max().unwrap_or(1);
        // Cells of the figure are so many of these wide; the square begins where one of them does.
        let per_cell = widest.div_euclid(CELLS as i64) + 1;
        let first = edges.map(|[low, high]| (low + high + 1 - per_cell * CELLS as i64).div_euclid(2));
        let half = 0.5 * side * (per_cell * CELLS as i64) as f64;
        let middle = first.map(|first| side * first as f64 + half);
        let counted = |(title, cells): (String, CellCount)| {
            let mut counts = vec![0; CELLS * CELLS];
            for ([i, j], count) in cells {
                let at = |cell: i64, first: i64| ((cell - first) / per_cell) as usize;
                counts[at(j, first[1]) * CELLS + at(i, first[0])] += count;
            }
            HeatMapGroup { title, counts }
        };
        let groups = groups.into_iter().map(counted).collect();
        Self::of_groups((name.into(), title.into()), groups, (middle, half), outline)
    }

    fn of_groups(
        (name, title): (String, String),
        groups: Vec<HeatMapGroup>,
        (middle, half): ([f64; 2], f64),
        (outline_name, outline): (&str, PlanePath),
    ) -> Self {
        let most = groups.iter().flat_map(|group| &group.counts).max().map_or(1.0, |most| *most as f64);
        Self {
            name,
            title,
            caption: String::new(),
            outline_name: outline_name.to_owned(),
            outline,
            middle,
            half,
            groups,
            most,
        }
    }

    /// Side of a cell [mm].
    pub fn cell(&self) -> f64 {
        2.0 * self.half / CELLS as f64
    }

    /// Shade of a cell, 1 to SHADES; 0 where there is no sample. Equal steps are equal factors.
    fn shade(&self, count: usize) -> usize {
        if count == 0 {
            return 0;
        }
        let part = (count as f64).ln() / self.most.ln().max(f64::MIN_POSITIVE);
        1 + ((part * SHADES as f64) as usize).min(SHADES - 1)
    }

    fn draw_group<DB: DrawingBackend>(&self, group: &HeatMapGroup, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let ([x, y], half) = (self.middle, self.half);
        sheet.text(&group.title, INDENT, 12.0)?;
        let part = sheet.part(0.0, ABOVE, LEFT + SIDE, SIDE + BELOW);
        let mut chart = part.chart(x - half..x + half, y - half..y + half, "x [mm]", "y [mm]")?;
        let cell = self.cell();
        for (row, counts) in group.counts.chunks(CELLS).enumerate() {
            let shades: Vec<usize> = counts.iter().map(|count| self.shade(*count)).collect();
            let bottom = y - half + cell * row as f64;
            let mut column = 0;
            // Neighbours of one shade are one rectangle.
            for run in shades.chunk_by(|a, b| a == b) {
                let left = x - half + cell * column as f64;
                column += run.len();
                if run[0] > 0 {
                    let corners = [(left, bottom), (left + cell * run.len() as f64, bottom + cell)];
                    let color = ramp((run[0] as f64 - 0.5) / SHADES as f64);
                    chart.draw_series([Rectangle::new(corners, color.filled())])?;
                }
            }
        }
        let outline = self.outline.iter().chain(self.outline.first()).copied();
        chart.draw_series(LineSeries::new(outline, part.line(OUTLINE, 1.2)))?;
        Ok(())
    }
}

/// Samples in every cell of a square.
fn counted(points: &[(f64, f64)], [x, y]: [f64; 2], half: f64) -> Vec<usize> {
    let mut counts = vec![0; CELLS * CELLS];
    let cell = |value: f64, middle: f64| {
        let at = (value - middle + half) / (2.0 * half) * CELLS as f64;
        (at as usize).min(CELLS - 1)
    };
    points.iter().for_each(|point| counts[cell(point.1, y) * CELLS + cell(point.0, x)] += 1);
    counts
}

impl Figure for HeatMap {
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
        let outline = (!self.outline.is_empty()).then(|| (self.outline_name.clone(), OUTLINE));
        outline.into_iter().collect()
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        let groups = self.groups.iter().map(|_| [LEFT + SIDE + 8.0, ABOVE + SIDE + BELOW + 10.0]);
        groups.chain([[BAR, ABOVE + SIDE + 8.0]]).collect()
    }

    fn draw<DB: DrawingBackend>(&self, tile: usize, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let Some(group) = self.groups.get(tile) else {
            let samples = |part: f64| number(self.most.powf(part));
            let labels = [0.0, 0.5, 1.0].map(samples);
            return sheet.part(12.0, ABOVE, BAR - 12.0, SIDE).labelled_bar("samples", &labels);
        };
        self.draw_group(group, sheet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_is_in_a_cell() {
        let points = [(-1.0, -1.0), (1.0, 1.0), (0.99, 0.99), (0.0, -0.5)];
        let counts = counted(&points, [0.0, 0.0], 1.0);
        assert_eq!(counts.iter().sum::<usize>(), 4);
        assert_eq!((counts[0], counts[CELLS * CELLS - 1]), (1, 2));
        assert_eq!(counts[CELLS / 4 * CELLS + CELLS / 2], 1);
    }

    #[test]
    fn counted_cells_lie_where_their_samples_do() {
        for far in [1, 29, 30, 31, 200] {
            let cells = vec![([-far, 0], 2), ([far, 3], 5), ([0, -1], 1)];
            let map = HeatMap::of_cells("a", "a", vec![("all".into(), cells)], 0.5, ("line", vec![]));
            let counts = &map.groups[0].counts;
            assert_eq!(counts.iter().sum::<usize>(), 8);
            // The middle of the rightmost cell is in the cell of the figure that has its samples.
            let at = |x: f64, middle: f64| ((x - middle + map.half) / map.cell()) as usize;
            let right = [0.5 * (far as f64 + 0.5), 0.5 * 3.5];
            assert_eq!(counts[at(right[1], map.middle[1]) * CELLS + at(right[0], map.middle[0])], 5, "{far}");
        }
    }
}
