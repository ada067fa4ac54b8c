//! What was commanded, and what the tip made of it: one pair of axes per recording, all to one scale.

use hysteron_base::{BadInput, Recording};
use hysteron_control::shape::{Shape, ShapeNumbers};
use plotters::prelude::*;
use serde::Serialize;

use super::Figure;
use super::sheet::{BELOW, COLORS, LEFT, Sheet};
use super::simplify::simplified;
use super::tip::between_sharp_turns;

const COMMAND: RGBColor = COLORS[4];
const TIP: RGBColor = COLORS[0];
/// Side of the square inside a pair of axes, height of the lines above it, room between columns [px].
const SIDE: f64 = 240.0;
const ABOVE: f64 = 44.0;
const BETWEEN: f64 = 16.0;
const TOP: f64 = 38.0;
const COLUMN: f64 = LEFT + SIDE + BETWEEN;
const ROW: f64 = ABOVE + SIDE + BELOW + 10.0;
const MOST_COLUMNS: usize = 3;
/// Steps of a line that are drawn at once.
const PIECE: usize = 6;

/// Command and tip of several recordings.
pub struct CommandAndTip {
    /// Name of each, and its shape.
    shapes: Vec<(String, Shape)>,
}

/// Numbers of one recording, for `metrics.json`.
#[derive(Debug, Clone, Serialize)]
pub struct NamedShape {
    /// Name of the recording.
    pub name: String,
    /// Its numbers.
    #[serde(flatten)]
    pub numbers: ShapeNumbers,
}

impl CommandAndTip {
    /// The figure of at least one recording, each with its name, for tendons at these angles [rad] about z.
    pub fn new(angles: &[f64], recordings: &[(&str, &Recording)]) -> Result<Self, BadInput> {
        let shape = |(name, recording): &(&str, &Recording)| {
            Ok(((*name).to_owned(), Shape::of(recording, angles).map_err(|bad| bad.within(name))?))
        };
        Ok(Self { shapes: recordings.iter().map(shape).collect::<Result<_, BadInput>>()? })
    }

    /// What it shows, in numbers.
    pub fn numbers(&self) -> Vec<NamedShape> {
        self.shapes
            .iter()
            .map(|(name, shape)| NamedShape { name: name.clone(), numbers: shape.numbers })
            .collect()
    }

    fn columns(&self) -> usize {
        self.shapes.len().min(MOST_COLUMNS)
    }
}

/// The numbers in one line.
fn line(numbers: &ShapeNumbers) -> String {
    let ratio = numbers.diamond_ratio.map_or(String::new(), |ratio| format!("diamond {ratio:.3}, "));
    format!("{ratio}rest missed by {:.2} %", 100.0 * numbers.rest_miss)
}

impl Figure for CommandAndTip {
    fn name(&self) -> &'static str {
        "command-tip"
    }

    fn caption(&self) -> String {
        "Commanded path in tendon space, brought over the tip by one factor, and path of the tip from where it \
         rested, from above; all axes have one scale. Diamond: radius over the commanded one, towards the \
         diagonals over towards the axes. Rest missed by: distance of the last rest from the first, over the \
         largest displacement."
            .to_owned()
    }

    fn size(&self) -> (u32, u32) {
        let rows = self.shapes.len().div_ceil(self.columns());
        let width = (COLUMN * self.columns() as f64 + 16.0).max(480.0);
        (width as u32, (TOP + ROW * rows as f64 + 6.0) as u32)
    }

    fn draw<DB: DrawingBackend>(&self, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        sheet.title("Command and tip")?;
        sheet.legend(&[("command, scaled".into(), COMMAND), ("tip".into(), TIP)])?;
        let paths: Vec<[Vec<(f64, f64)>; 2]> = self.shapes.iter().map(|(_, shape)| paths(shape)).collect();
        let reach =
            paths.iter().flatten().flatten().fold(0.0, |far: f64, (x, y)| far.max(x.abs()).max(y.abs()));
        let half = 1.08 * reach;
        for (k, ((name, shape), paths)) in self.shapes.iter().zip(paths).enumerate() {
            let (row, column) = (k / self.columns(), k % self.columns());
            let (x, y) = (4.0 + COLUMN * column as f64, TOP + ROW * row as f64);
            sheet.text(name, x + LEFT, y + 12.0)?;
            sheet.text(&line(&shape.numbers), x + LEFT, y + 30.0)?;
            let part = sheet.part(x, y + ABOVE, LEFT + SIDE, SIDE + BELOW);
            let mut chart = part.chart(-half..half, -half..half, "x [mm]", "y [mm]")?;
            for (path, color, width) in [(&paths[0], COMMAND, 3.0), (&paths[1], TIP, 1.2)] {
                // A tenth of its width is not seen.
                let fewer = simplified(path, 0.1 * width * 2.0 * half / SIDE);
                // In short pieces: where a line runs over itself, bitmaps would leave it out.
                let lines = between_sharp_turns(&fewer).flat_map(|line| {
                    (0..line.len()).step_by(PIECE).map(|from| &line[from..line.len().min(from + PIECE + 1)])
                });
                for line in lines {
                    chart.draw_series(LineSeries::new(line.iter().copied(), part.line(color, width)))?;
                }
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
        super::super::register_embedded_font().unwrap();
        let svg = super::super::svg_of(&figure).unwrap();
        for (name, numbers) in named.iter().map(|(name, _)| name).zip(figure.numbers()) {
            assert_eq!(&numbers.name, name);
            assert!(svg.contains(*name) && svg.contains(&line(&numbers.numbers)), "{name}");
        }
        let circle = &figure.numbers()[2].numbers;
        assert!(circle.diamond_ratio.unwrap() < 0.97 && circle.rest_miss < 0.01, "{circle:?}");
        assert!(super::super::png_of(&figure).unwrap().starts_with(b"\x89PNG"));
    }

    #[test]
    fn a_recording_without_a_shape_is_named() {
        let recordings = recordings();
        let bad = CommandAndTip::new(&even_angles(3), &[("circle", &recordings[2].1)]).err().unwrap();
        assert_eq!(bad.place, "circle: recording");
    }
}
