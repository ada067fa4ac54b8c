//! Command and tip: one pair of axes per recording, all to one scale.

use hysteron_base::{BadInput, Recording};
use hysteron_control::shape::{Shape, ShapeNumbers};
use plotters::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use hysteron_report::figure::{Entry, Figure};
use hysteron_report::sheet::{BELOW, COLORS, LEFT, Sheet};
use hysteron_report::simplify::{between_sharp_turns, simplified};

const COMMAND: RGBColor = COLORS[4];
const TIP: RGBColor = COLORS[0];
/// Side of the square inside a pair of axes, height of the lines above it, room between columns [px].
const SIDE: f64 = 240.0;
const ABOVE: f64 = 44.0;
const BETWEEN: f64 = 18.0;
const COLUMN: f64 = LEFT + SIDE + BETWEEN;
const ROW: f64 = ABOVE + SIDE + BELOW + 10.0;
/// Steps of a line that are drawn at once.
const PIECE: usize = 6;

/// Command and tip of several recordings.
pub struct CommandAndTip {
    /// Name of each, and its shape.
    shapes: Vec<(String, Shape)>,
}

/// Numbers of one recording, for `metrics.json`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct NamedShape {
    /// Name of the recording.
    pub name: String,
    /// See [`ShapeNumbers::excursion_m`].
    pub excursion_m: f64,
    /// See [`ShapeNumbers::tip_per_stroke`].
    pub tip_per_stroke: f64,
    /// See [`ShapeNumbers::diamond_ratio`].
    pub diamond_ratio: Option<f64>,
    /// See [`ShapeNumbers::return_error`].
    pub return_error: f64,
}

impl NamedShape {
    fn new(name: &str, numbers: &ShapeNumbers) -> Self {
        let ShapeNumbers { excursion_m, tip_per_stroke, diamond_ratio, return_error } = *numbers;
        Self { name: name.to_owned(), excursion_m, tip_per_stroke, diamond_ratio, return_error }
    }

    /// Headings of [`NamedShape::cells`].
    pub const HEADINGS: [&'static str; 5] = [
        "Shape",
        "Largest displacement [mm]",
        "Tip over command [-]",
        "Diamond ratio [-]",
        "Return error at rest [%]",
    ];

    /// The numbers as text.
    pub fn cells(&self) -> Vec<String> {
        let Self { ref name, excursion_m, tip_per_stroke, diamond_ratio, return_error } = *self;
        vec![
            name.clone(),
            format!("{:.2}", 1e3 * excursion_m),
            format!("{tip_per_stroke:.2}"),
            diamond_ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.3}")),
            format!("{:.2}", 100.0 * return_error),
        ]
    }
}

impl CommandAndTip {
    /// The figure of at least one recording, each with its name, for tendons at these angles [rad] about z.
    pub fn new(angles: &[f64], recordings: &[(&str, &Recording)]) -> Result<Self, BadInput> {
        let shape = |(name, recording): &(&str, &Recording)| {
            Ok(((*name).to_owned(), Shape::of(recording, angles).map_err(|bad| bad.within(name))?))
        };
        Ok(Self { shapes: recordings.iter().map(shape).collect::<Result<_, BadInput>>()? })
    }

    /// Figures of the shapes, by name.
    pub fn numbers(&self) -> Vec<NamedShape> {
        self.shapes.iter().map(|(name, shape)| NamedShape::new(name, &shape.numbers)).collect()
    }

    /// Half the side of every pair of axes [mm].
    fn half(&self) -> f64 {
        let paths = self.shapes.iter().flat_map(|(_, shape)| paths(shape));
        let reach = paths.flatten().fold(0.0, |far: f64, (x, y)| far.max(x.abs()).max(y.abs()));
        1.08 * reach
    }
}

/// The numbers in one line.
fn line(numbers: &ShapeNumbers) -> String {
    let ratio = numbers.diamond_ratio.map_or(String::new(), |ratio| format!("diamond {ratio:.3}, "));
    format!("{ratio}return error {:.2} %", 100.0 * numbers.return_error)
}

impl Figure for CommandAndTip {
    fn name(&self) -> String {
        "command-tip".into()
    }

    fn title(&self) -> String {
        "Command and tip".into()
    }

    fn caption(&self) -> String {
        "Commanded path in tendon space, brought over the tip by one factor, and path of the tip from where it \
         rested, from above; all axes have one scale. Diamond: radius over the commanded one, towards the \
         diagonals over towards the axes. Return error: distance of the last rest from the first, over the \
         largest displacement (hysteresis at rest)."
            .to_owned()
    }

    fn legend(&self) -> Vec<Entry> {
        vec![("command, scaled".into(), COMMAND), ("tip".into(), TIP)]
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        vec![[COLUMN, ROW]; self.shapes.len()]
    }

    fn draw<DB: DrawingBackend>(&self, tile: usize, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let (name, shape) = &self.shapes[tile];
        let half = self.half();
        sheet.text(name, LEFT, 12.0)?;
        sheet.text(&line(&shape.numbers), LEFT, 30.0)?;
        let part = sheet.part(0.0, ABOVE, LEFT + SIDE, SIDE + BELOW);
        let mut chart = part.chart(-half..half, -half..half, "x [mm]", "y [mm]")?;
        for (path, color, width) in
            paths(shape).iter().zip([(COMMAND, 3.0), (TIP, 1.2)]).map(|(p, (c, w))| (p, c, w))
        {
            // A tenth of its width is not visible.
            let fewer = simplified(path, 0.1 * width * 2.0 * half / SIDE);
            // In short parts: where a line runs over itself, bitmaps would omit it.
            let lines = between_sharp_turns(&fewer).flat_map(|line| {
                (0..line.len()).step_by(PIECE).map(|from| &line[from..line.len().min(from + PIECE + 1)])
            });
            for line in lines {
                chart.draw_series(LineSeries::new(line.iter().copied(), part.line(color, width)))?;
            }
        }
        Ok(())
    }
}

/// Command, as scaled, and tip [mm].
fn paths(shape: &Shape) -> [Vec<(f64, f64)>; 2] {
    let scaled =
        |points: &[[f64; 2]], factor: f64| points.iter().map(|p| (factor * p[0], factor * p[1])).collect();
    [scaled(&shape.command, 1e3 * shape.numbers.tip_per_stroke), scaled(&shape.tip, 1e3)]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;
    use hysteron_base::{Channel, Metadata};
    use hysteron_control::Plan;
    use hysteron_control::shape::even_angles;

    use hysteron_report::figure::{drawn, png, register_embedded_font};

    /// The trajectories of the plan `quick`, and a tip that is drawn towards a diamond and comes late.
    fn recordings() -> Vec<(String, Recording)> {
        let tip = |[a, b]: [f64; 2]| {
            let size = a.hypot(b);
            let factor = if size > 0.0 { 5.0 * (0.7 + 0.3 * size / (a.abs() + b.abs())) } else { 0.0 };
            [factor * a, factor * b]
        };
        let plan = Plan::named("quick").unwrap();
        let recorded = |trajectory: &hysteron_control::Trajectory| {
            let commands = trajectory.commands().unwrap();
            let tips: Vec<[f64; 2]> =
                commands.time().iter().map(|t| tip(trajectory.position_at(t - 0.1))).collect();
            let mut channels = commands.channels().to_vec();
            for (c, name) in ["tip_x_m", "tip_y_m"].into_iter().enumerate() {
                channels.push(Channel::new(name, tips.iter().map(|tip| tip[c]).collect()));
            }
            let time = commands.time().to_vec();
            (trajectory.name.clone(), Recording::new(time, channels, vec![], Metadata::default()).unwrap())
        };
        plan.trajectories().iter().map(recorded).collect()
    }

    #[test]
    fn every_family_is_drawn_with_its_numbers() {
        let recordings = recordings();
        let named: Vec<(&str, &Recording)> =
            recordings.iter().map(|(name, it)| (name.as_str(), it)).collect();
        let figure = CommandAndTip::new(&even_angles(4), &named).unwrap();
        register_embedded_font().unwrap();
        let tiles = drawn(&figure).unwrap().tiles;
        for ((svg, (name, _)), (_, shape)) in tiles.iter().zip(&named).zip(&figure.shapes) {
            assert!(svg.contains(*name) && svg.contains(&line(&shape.numbers)), "{name}");
        }
        let circle = &figure.numbers()[2];
        assert_eq!(circle.name, "circle");
        assert!(circle.diamond_ratio.unwrap() < 0.97 && circle.return_error < 0.01, "{circle:?}");
        assert!(png(&figure).unwrap().starts_with(b"\x89PNG"));
    }

    #[test]
    fn a_recording_without_a_shape_is_named() {
        let recordings = recordings();
        let bad = CommandAndTip::new(&even_angles(3), &[("circle", &recordings[2].1)]).err().unwrap();
        assert_eq!(bad.place, "circle: recording");
    }
}
