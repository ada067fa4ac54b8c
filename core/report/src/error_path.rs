//! Paths on their target: the target dashed, each path coloured by its distance from it (CoReAct paper, Figs. 4 to 6).

use plotters::prelude::*;

use crate::figure::Figure;
use crate::plane::{PlanePath, dashes, draw_simplified, square_around};
use crate::sheet::{BAR, BELOW, COLORS, LEFT, Sheet, number, ramp};

const TARGET: RGBColor = COLORS[0];
/// Side of the square inside a pair of axes, height of the line above it, room between columns [px].
const SIDE: f64 = 240.0;
const ABOVE: f64 = 26.0;
const INDENT: f64 = 4.0;
const COLUMN: f64 = LEFT + SIDE + 8.0;
const ROW: f64 = ABOVE + SIDE + BELOW + 10.0;
/// Colours that can be distinguished along a path.
const SHADES: f64 = 24.0;

/// A tile for each path, all to one scale and with one colour bar.
pub struct ErrorPaths {
    /// Name of the file.
    pub name: String,
    /// Title.
    pub title: String,
    /// Caption: the content of the figure.
    pub caption: String,
    /// The target [mm].
    pub target: PlanePath,
    /// The paths.
    pub paths: Vec<ErrorPath>,
}

/// A path compared with its target.
pub struct ErrorPath {
    /// Name of the tile.
    pub name: String,
    /// Points of the path (n_points) [mm].
    pub path: PlanePath,
    /// Distance of each point from the target (n_points) [mm].
    pub errors: Vec<f64>,
}

impl ErrorPaths {
    /// Largest distance from the target in all tiles [mm].
    fn largest(&self) -> f64 {
        self.paths.iter().flat_map(|path| &path.errors).fold(1e-6, |most: f64, error| most.max(*error))
    }

    fn draw_path<DB: DrawingBackend>(&self, shown: &ErrorPath, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let paths = self.paths.iter().flat_map(|shown| &shown.path);
        let ([x, y], half) = square_around(self.target.iter().chain(paths));
        let mm_per_px = 2.0 * half / SIDE;
        let most = shown.errors.iter().copied().fold(0.0, f64::max);
        sheet.text(&format!("{}: at most {} mm off", shown.name, number(most)), INDENT, 12.0)?;
        let part = sheet.part(0.0, ABOVE, LEFT + SIDE, SIDE + BELOW);
        let mut chart = part.chart(x - half..x + half, y - half..y + half, "x [mm]", "y [mm]")?;
        for (shade, line) in shades(shown, self.largest()) {
            draw_simplified(&mut chart, &part, &line, 0.15 * mm_per_px, (ramp(shade), 2.2))?;
        }
        for dash in dashes(&self.target, 5.0 * mm_per_px) {
            chart.draw_series(LineSeries::new(dash, part.line(TARGET, 1.2)))?;
        }
        Ok(())
    }
}

impl Figure for ErrorPaths {
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
        let paths = self.paths.iter().map(|_| [COLUMN, ROW]);
        paths.chain([[BAR, ABOVE + SIDE + 8.0]]).collect()
    }

    fn draw<DB: DrawingBackend>(&self, tile: usize, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        match self.paths.get(tile) {
            Some(path) => self.draw_path(path, sheet),
            None => sheet.part(12.0, ABOVE, BAR - 12.0, SIDE).color_bar("error [mm]", 0.0, self.largest()),
        }
    }
}

/// Parts of a path of one shade each, 0 to 1 for errors from 0 to `largest`.
fn shades(shown: &ErrorPath, largest: f64) -> Vec<(f64, PlanePath)> {
    let level = |i: usize| (0.5 * (shown.errors[i] + shown.errors[i + 1]) / largest * SHADES).floor();
    let mut segments: Vec<(f64, PlanePath)> = Vec::new();
    let mut last = f64::NAN;
    for i in 0..shown.path.len() - 1 {
        if level(i) != last {
            last = level(i);
            segments.push(((last + 0.5) / SHADES, vec![shown.path[i]]));
        }
        if let Some((_, line)) = segments.last_mut() {
            line.push(shown.path[i + 1]);
        }
    }
    segments
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_of_a_path_is_drawn_in_its_shade() {
        let path: PlanePath = (0..10).map(|i| (f64::from(i), 0.0)).collect();
        let errors = path.iter().map(|(x, _)| if *x < 5.0 { 0.0 } else { 1.0 }).collect();
        let segments = shades(&ErrorPath { name: String::new(), path, errors }, 1.0);
        // Low, the step between, high.
        let ends: Vec<(f64, f64)> =
            segments.iter().map(|(_, line)| (line[0].0, line[line.len() - 1].0)).collect();
        assert_eq!(ends, [(0.0, 4.0), (4.0, 5.0), (5.0, 9.0)]);
        assert!(segments[0].0 < segments[1].0 && segments[1].0 < segments[2].0);
    }
}
