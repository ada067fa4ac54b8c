//! Stroke against tip: the robot's motion out and back, and the twin's for the same strokes.

use plotters::prelude::*;

use crate::figure::{Figure, LegendEntry};
use crate::sheet::{BELOW, COLORS, LEFT, Sheet, padded};
use crate::simplify::{between_sharp_turns, simplified};

const ROBOT: RGBColor = RGBColor(178, 183, 190);
const TWIN: [RGBColor; 2] = [COLORS[1], COLORS[0]];
/// Inside of a pair of axes, line above it, room between columns [px].
const WIDTH: f64 = 244.0;
const HEIGHT: f64 = 260.0;
const ABOVE: f64 = 26.0;
const COLUMN: f64 = LEFT + WIDTH + 8.0;
const NAMES: [&str; 2] = ["without the network", "with the network"];

/// A point per sample: stroke and tip [mm].
pub type StrokePath = Vec<(f64, f64)>;

/// Tip over stroke: a robot in grey, and simulated tips of two kinds, each in a tile of its own.
pub struct HysteresisLoop {
    /// Trajectory of the strokes.
    pub trajectory: String,
    /// The robot.
    pub robot: StrokePath,
    /// Simulated without a network, and with it.
    pub twin: [StrokePath; 2],
}

impl Figure for HysteresisLoop {
    fn name(&self) -> String {
        "hysteresis".into()
    }

    fn title(&self) -> String {
        "Tip over stroke".into()
    }

    fn caption(&self) -> String {
        format!(
            "Trajectory {}, a test path that was used for no fit. Horizontal: stroke of the first tendon [mm]; vertical: \
             displacement of the tip along that tendon's direction [mm]. The wide grey line is the robot: at one stroke its \
             tip has several positions, depending on the motion before (hysteresis). Left, the twin without its network; \
             right, with it.",
            self.trajectory
        )
    }

    fn legend(&self) -> Vec<LegendEntry> {
        let twins = NAMES.iter().zip(TWIN).map(|(name, color)| (format!("twin {name}"), color));
        [("robot".to_owned(), ROBOT)].into_iter().chain(twins).collect()
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        vec![[COLUMN, ABOVE + HEIGHT + BELOW + 6.0]; 2]
    }

    fn draw<DB: DrawingBackend>(&self, tile: usize, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let all = || self.twin.iter().chain([&self.robot]).flatten();
        let (x, y) = (padded(all().map(|point| point.0)), padded(all().map(|point| point.1)));
        let aspect = (x.end - x.start) / (y.end - y.start) * HEIGHT / WIDTH;
        sheet.text(NAMES[tile], 4.0, 12.0)?;
        let part = sheet.part(0.0, ABOVE, LEFT + WIDTH, HEIGHT + BELOW);
        let mut chart = part.chart(x.clone(), y.clone(), "stroke of the first tendon [mm]", "tip [mm]")?;
        for (path, color, width) in [(&self.robot, ROBOT, 4.0), (&self.twin[tile], TWIN[tile], 1.3)] {
            // Compared where both axes have one scale; a sixth of a pixel is not visible.
            let even: StrokePath = path.iter().map(|(x, y)| (*x, aspect * y)).collect();
            let fewer = simplified(&even, 0.15 * (x.end - x.start) / WIDTH);
            for run in between_sharp_turns(&fewer) {
                let points = run.iter().map(|(x, y)| (*x, y / aspect));
                chart.draw_series(LineSeries::new(points, part.line(color, width)))?;
            }
        }
        Ok(())
    }
}
