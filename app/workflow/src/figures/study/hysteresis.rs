//! Stroke against tip: the robot's way out and back, and what the twin makes of the same strokes.

use hysteron_base::Recording;
use plotters::prelude::*;

use hysteron_report::figure::{Figure, LegendEntry};
use hysteron_report::sheet::{BELOW, COLORS, LEFT, Sheet, padded};
use hysteron_report::simplify::{between_sharp_turns, simplified};

const ROBOT: RGBColor = RGBColor(178, 183, 190);
const TWIN: [RGBColor; 2] = [COLORS[1], COLORS[0]];
/// Inside of a pair of axes, line above it, room between columns [px].
const WIDTH: f64 = 244.0;
const HEIGHT: f64 = 260.0;
const ABOVE: f64 = 26.0;
const COLUMN: f64 = LEFT + WIDTH + 8.0;
const NAMES: [&str; 2] = ["without the network", "with the network"];

/// A point per sample: stroke and tip [mm].
type Path = Vec<(f64, f64)>;

/// See the module.
pub struct Hysteresis {
    trajectory: String,
    robot: Path,
    /// Without the network, and with it.
    twin: [Path; 2],
}

impl Hysteresis {
    /// The tip of the measured and of the two simulated recordings of a trajectory, along the direction of the first
    /// tendon [rad], over that tendon's stroke. `None` where one has no tip.
    pub fn new(
        trajectory: &str,
        direction: f64,
        measured: &Recording,
        simulated: [&Recording; 2],
    ) -> Option<Self> {
        let stroke = *measured.strokes().first()?;
        let path = |recording: &Recording| {
            let [x, y, _] = recording.tip()?;
            let along = x.iter().zip(y).map(|(x, y)| 1e3 * (x * direction.cos() + y * direction.sin()));
            Some(stroke.iter().map(|stroke| 1e3 * stroke).zip(along).collect::<Path>())
        };
        let [without, with] = simulated.map(path);
        Some(Self { trajectory: trajectory.to_owned(), robot: path(measured)?, twin: [without?, with?] })
    }
}

impl Figure for Hysteresis {
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
            let even: Path = path.iter().map(|(x, y)| (*x, aspect * y)).collect();
            let fewer = simplified(&even, 0.15 * (x.end - x.start) / WIDTH);
            for run in between_sharp_turns(&fewer) {
                let points = run.iter().map(|(x, y)| (*x, y / aspect));
                chart.draw_series(LineSeries::new(points, part.line(color, width)))?;
            }
        }
        Ok(())
    }
}
