//! Command and tip of recordings over each other: their numbers and their figure.

use hysteron_base::{BadInput, Recording};
use hysteron_control::shape::{HysteresisShape, ShapeNumbers};
use hysteron_report::overlay::{OverlayTile, PathKind, PathOverlay};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Command and tip of several recordings.
pub struct TipShapes {
    /// Name of each, and its shape.
    shapes: Vec<(String, HysteresisShape)>,
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

impl TipShapes {
    /// Those of at least one recording, each with its name, for tendons at these angles [rad] about z.
    pub fn new(angles: &[f64], recordings: &[(&str, &Recording)]) -> Result<Self, BadInput> {
        let shape = |(name, recording): &(&str, &Recording)| {
            Ok(((*name).to_owned(), HysteresisShape::of(recording, angles).map_err(|bad| bad.within(name))?))
        };
        Ok(Self { shapes: recordings.iter().map(shape).collect::<Result<_, BadInput>>()? })
    }

    /// Figures of the shapes, by name.
    pub fn numbers(&self) -> Vec<NamedShape> {
        self.shapes.iter().map(|(name, shape)| NamedShape::new(name, &shape.numbers)).collect()
    }

    /// The figure: one pair of axes per recording, all to one scale.
    pub fn figure(&self) -> PathOverlay {
        let tile = |(name, shape): &(String, HysteresisShape)| OverlayTile {
            title: name.clone(),
            note: line(&shape.numbers),
            paths: paths(shape).into(),
        };
        PathOverlay {
            name: "command-tip".to_owned(),
            title: "Command and tip".to_owned(),
            caption: "Commanded path in tendon space, brought over the tip by one factor, and path of the tip from where it \
                      rested, from above; all axes have one scale. Diamond: radius over the commanded one, towards the \
                      diagonals over towards the axes. Return error: distance of the last rest from the first, over the \
                      largest displacement (hysteresis at rest)."
                .to_owned(),
            kinds: vec![PathKind::new("command, scaled", 4, 3.0), PathKind::new("tip", 0, 1.2)],
            tiles: self.shapes.iter().map(tile).collect(),
        }
    }
}

/// The numbers in one line.
fn line(numbers: &ShapeNumbers) -> String {
    let ratio = numbers.diamond_ratio.map_or(String::new(), |ratio| format!("diamond {ratio:.3}, "));
    format!("{ratio}return error {:.2} %", 100.0 * numbers.return_error)
}

/// Command, as scaled, and tip [mm].
fn paths(shape: &HysteresisShape) -> [Vec<(f64, f64)>; 2] {
    let scaled =
        |points: &[[f64; 2]], factor: f64| points.iter().map(|p| (factor * p[0], factor * p[1])).collect();
    [scaled(&shape.command, 1e3 * shape.numbers.tip_per_stroke), scaled(&shape.tip, 1e3)]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;
    use std::f64::consts::TAU;

    use hysteron_base::{Channel, Metadata};
    use hysteron_control::MotionPlan;

    use hysteron_report::figure::{drawn, png, register_embedded_font};

    /// The trajectories of the plan `quick`, and a tip that is drawn towards a diamond and comes late.
    fn recordings() -> Vec<(String, Recording)> {
        let tip = |[a, b]: [f64; 2]| {
            let size = a.hypot(b);
            let factor = if size > 0.0 { 5.0 * (0.7 + 0.3 * size / (a.abs() + b.abs())) } else { 0.0 };
            [factor * a, factor * b]
        };
        let plan = MotionPlan::named("quick").unwrap();
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
        let shapes = TipShapes::new(&[0.0, 0.25, 0.5, 0.75].map(|turn| turn * TAU), &named).unwrap();
        let figure = shapes.figure();
        register_embedded_font().unwrap();
        let tiles = drawn(&figure).unwrap().tiles;
        for ((svg, (name, _)), (_, shape)) in tiles.iter().zip(&named).zip(&shapes.shapes) {
            assert!(svg.contains(*name) && svg.contains(&line(&shape.numbers)), "{name}");
        }
        let circle = &shapes.numbers()[2];
        assert_eq!(circle.name, "circle");
        assert!(circle.diamond_ratio.unwrap() < 0.97 && circle.return_error < 0.01, "{circle:?}");
        assert!(png(&figure).unwrap().starts_with(b"\x89PNG"));
    }

    #[test]
    fn a_recording_without_a_shape_is_named() {
        let recordings = recordings();
        let bad = TipShapes::new(
            &[0.0, 1.0 / 3.0, 2.0 / 3.0].map(|turn| turn * TAU),
            &[("circle", &recordings[2].1)],
        )
        .err()
        .unwrap();
        assert_eq!(bad.place, "circle: recording");
    }
}
