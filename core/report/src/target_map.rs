//! A target from above: its curve, the paths to it and from it, and which of its points were reached.

use plotters::prelude::*;

use crate::figure::{Figure, LegendEntry};
use crate::plane::{PlanePath, dashes, draw_simplified, square_around};
use crate::sheet::{BELOW, COLORS, LEFT, NARROW, Sheet};

const TARGET: RGBColor = COLORS[0];
const TRANSIT: RGBColor = RGBColor(190, 194, 200);
const MISSED: RGBColor = COLORS[1];
const REACHED: RGBColor = COLORS[2];
/// Width of the tile [px].
const WIDTH: f64 = 520.0;
/// Air to the right [px].
const RIGHT: f64 = 8.0;

/// A target's curve in one pair of axes.
pub struct TargetMap {
    /// Name of the file.
    pub name: String,
    /// Title.
    pub title: String,
    /// Caption: the content of the figure.
    pub caption: String,
    /// The curve, dashed [mm].
    pub curve: PlanePath,
    /// Ways to the curve and from it [mm].
    pub transits: Vec<PlanePath>,
    /// Points that were tried; none where nothing was tried.
    pub goals: Option<Vec<TargetPoint>>,
}

/// A point of a target that was tried.
pub struct TargetPoint {
    /// Where it is [mm].
    pub at: (f64, f64),
    /// Where the tip stopped, if it did not reach the point [mm].
    pub missed_at: Option<(f64, f64)>,
}

/// A tile so wide, with a square inside its axes [px].
fn square_tile(width: f64) -> [f64; 2] {
    [width, width - LEFT - RIGHT + BELOW]
}

impl Figure for TargetMap {
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
        let mut names = vec![("target".to_owned(), TARGET), ("path to it".to_owned(), TRANSIT)];
        let goals = || self.goals.iter().flatten();
        if goals().any(|goal| goal.missed_at.is_none()) {
            names.push(("reached".to_owned(), REACHED));
        }
        if goals().any(|goal| goal.missed_at.is_some()) {
            names.push(("out of reach".to_owned(), MISSED));
        }
        names
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        vec![square_tile(WIDTH)]
    }

    fn narrow_tiles(&self) -> Vec<[f64; 2]> {
        vec![square_tile(NARROW)]
    }

    fn draw<DB: DrawingBackend>(&self, _: usize, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let ([x, y], half) = square_around(self.transits.iter().flatten().chain(&self.curve));
        let side = sheet.size().0 - LEFT - RIGHT;
        let mm_per_px = 2.0 * half / side;
        let part = sheet.part(0.0, 0.0, LEFT + side, side + BELOW);
        let mut chart = part.chart(x - half..x + half, y - half..y + half, "x [mm]", "y [mm]")?;
        for transit in &self.transits {
            draw_simplified(&mut chart, &part, transit, 0.15 * mm_per_px, (TRANSIT, 1.6))?;
        }
        for dash in dashes(&self.curve, 6.0 * mm_per_px) {
            chart.draw_series(LineSeries::new(dash, part.line(TARGET, 1.6)))?;
        }
        for TargetPoint { at, missed_at } in self.goals.iter().flatten() {
            if let Some(tip) = missed_at {
                chart.draw_series(LineSeries::new([*at, *tip], part.line(MISSED, 1.0)))?;
            }
            let color = if missed_at.is_some() { MISSED } else { REACHED };
            chart.draw_series([Circle::new(*at, part.px(2.0), color.filled())])?;
        }
        Ok(())
    }
}
