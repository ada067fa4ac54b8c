//! The rigid transform from a tracker's frame to the robot's, on positions and orientations.

use crate::schema::FixedArray;
use crate::{BadInput, Channel};
use serde::Deserialize;

type Check<T> = Result<T, BadInput>;

/// Largest plausible distance between a tracker and a robot [mm].
const MAX_TRANSLATION_MM: f64 = 1e5;
/// A quaternion that is given may be rounded by this much [-].
const UNIT_LENGTH: f64 = 1e-3;

/// p_robot = R (p_tracker − p_origin) + t, and the orientation turned by R.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TrackerTransform {
    /// Quaternion w, x, y, z.
    rotation: Option<FixedArray<f64, 4>>,
    /// Turns about the fixed axes x, then y, then z [deg].
    rotation_deg: Option<FixedArray<f64, 3>>,
    /// t [mm].
    #[serde(default)]
    translation_mm: FixedArray<f64, 3>,
    /// Points that are transformed: the stems of their channels.
    #[serde(default = "tip")]
    points: Vec<String>,
    /// The point whose position in the same row is taken off first, as of a marker on the base.
    origin: Option<String>,
}

fn tip() -> Vec<String> {
    vec!["tip".to_owned()]
}

type Quaternion = [f64; 4];

/// The product of quaternions w, x, y, z.
fn product([a, b, c, d]: Quaternion, [e, f, g, h]: Quaternion) -> Quaternion {
    [
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    ]
}

impl TrackerTransform {
    /// The same, if it is a rigid transform.
    ///
    /// # Errors
    /// `BadInput` naming the key.
    pub(super) fn checked(self) -> Check<Self> {
        if self.rotation.is_some() && self.rotation_deg.is_some() {
            return Err(BadInput::new("tracker", "rotation or rotation_deg", "both"));
        }
        if let Some(q) = self.rotation {
            let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            if length.is_nan() || (length - 1.0).abs() > UNIT_LENGTH {
                let found = format!("one of length {length}");
                return Err(BadInput::new("tracker.rotation", "a quaternion w, x, y, z of length 1", found));
            }
        }
        if !self.rotation_deg.unwrap_or_default().iter().all(|angle| angle.abs() <= 360.0) {
            return Err(BadInput::new("tracker.rotation_deg", "angles up to 360", "another"));
        }
        if !self.translation_mm.iter().all(|x| x.abs() <= MAX_TRANSLATION_MM) {
            let expected = format!("lengths up to {MAX_TRANSLATION_MM}");
            return Err(BadInput::new(
                "tracker.translation_mm",
                expected,
                format!("{:?}", self.translation_mm),
            ));
        }
        Ok(self)
    }

    fn quaternion(&self) -> Quaternion {
        if let Some(q) = self.rotation {
            let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            return q.map(|x| x / length);
        }
        let about = |axis: usize, angle: f64| {
            let (sin, cos) = (0.5 * angle.to_radians()).sin_cos();
            let mut q = [cos, 0.0, 0.0, 0.0];
            q[1 + axis] = sin;
            q
        };
        let [x, y, z] = self.rotation_deg.unwrap_or_default().0;
        product(about(2, z), product(about(1, y), about(0, x)))
    }

    /// Transforms the points' positions [m], and their orientations where they have one.
    ///
    /// # Errors
    /// `BadInput` for a point without x, y and z.
    pub(super) fn apply(&self, channels: &mut [Channel]) -> Check<()> {
        let find =
            |channels: &[Channel], name: &str| channels.iter().position(|channel| channel.name == name);
        let position = |channels: &[Channel], stem: &str| {
            let index = |axis: &str| {
                let name = format!("{stem}_{axis}_m");
                find(channels, &name)
                    .ok_or_else(|| BadInput::new("tracker", format!("a channel {name} to transform"), "none"))
            };
            Ok::<_, BadInput>([index("x")?, index("y")?, index("z")?])
        };
        let q = self.quaternion();
        let [w, x, y, z] = q;
        let shift = self.translation_mm.map(|mm| mm / 1000.0);
        let origin = self.origin.as_ref().map(|stem| position(channels, stem)).transpose()?;
        let origin = origin.map(|indices| indices.map(|k| channels[k].values.clone()));
        for stem in &self.points {
            let point = position(channels, stem)?;
            for row in 0..channels[point[0]].values.len() {
                let from = |axis: usize| origin.as_ref().map_or(0.0, |origin| origin[axis][row]);
                let p: [f64; 3] = std::array::from_fn(|axis| channels[point[axis]].values[row] - from(axis));
                let turned = product(product(q, [0.0, p[0], p[1], p[2]]), [w, -x, -y, -z]);
                for axis in 0..3 {
                    channels[point[axis]].values[row] = turned[1 + axis] + shift[axis];
                }
            }
            let orientation = ["qw", "qx", "qy", "qz"].map(|axis| find(channels, &format!("{stem}_{axis}")));
            if let [Some(i), Some(j), Some(k), Some(l)] = orientation {
                let indices = [i, j, k, l];
                for row in 0..channels[i].values.len() {
                    let turned = product(q, indices.map(|index| channels[index].values[row]));
                    (0..4).for_each(|part| channels[indices[part]].values[row] = turned[part]);
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    fn channels() -> Vec<Channel> {
        let value = |name: &str, value: f64| Channel::new(name, vec![value]);
        vec![
            value("tip_x_m", 1.0),
            value("tip_y_m", 2.0),
            value("tip_z_m", 3.0),
            value("tip_qw", 1.0),
            value("tip_qx", 0.0),
            value("tip_qy", 0.0),
            value("tip_qz", 0.0),
            value("base_x_m", 1.0),
            value("base_y_m", 0.0),
            value("base_z_m", 0.0),
        ]
    }

    fn transformed(toml: &str) -> Vec<f64> {
        let mut channels = channels();
        let tracker: TrackerTransform = toml::from_str(toml).unwrap();
        tracker.checked().unwrap().apply(&mut channels).unwrap();
        channels.iter().map(|channel| channel.values[0]).collect()
    }

    #[test]
    fn a_quarter_turn_about_each_axis_moves_position_and_orientation() {
        let half = 0.5_f64.sqrt();
        for (angles, position, orientation) in [
            ("[90, 0, 0]", [1.0, -3.0, 2.0], [half, half, 0.0, 0.0]),
            ("[0, 90, 0]", [3.0, 2.0, -1.0], [half, 0.0, half, 0.0]),
            ("[0, 0, 90]", [-2.0, 1.0, 3.0], [half, 0.0, 0.0, half]),
            // scipy: Rotation.from_euler("xyz", [90, 0, 90], degrees=True)
            ("[90, 0, 90]", [3.0, 1.0, 2.0], [0.5, 0.5, 0.5, 0.5]),
        ] {
            let found = transformed(&format!("rotation_deg = {angles}"));
            for (found, expected) in found.iter().zip(position.iter().chain(&orientation)) {
                assert!((found - expected).abs() < 1e-15, "{angles}: {found:?} {expected:?}");
            }
        }
    }

    #[test]
    fn an_origin_is_taken_off_before_and_a_translation_added_after() {
        let found = transformed("origin = \"base\"\nrotation = [0, 0, 0, 1]\ntranslation_mm = [1000, 0, 0]");
        assert_eq!(found[..3], [1.0, -2.0, 3.0]);
    }

    #[test]
    fn what_is_no_rigid_transform_is_refused() {
        for (toml, place) in [
            ("rotation = [1, 1, 0, 0]", "tracker.rotation"),
            ("rotation = [nan, 0, 0, 0]", "tracker.rotation"),
            ("rotation_deg = [1e9, 0, 0]", "tracker.rotation_deg"),
            ("translation_mm = [1e9, 0, 0]", "tracker.translation_mm"),
            ("rotation = [1, 0, 0, 0]\nrotation_deg = [0, 0, 0]", "tracker"),
        ] {
            let transform: TrackerTransform = toml::from_str(toml).unwrap();
            assert_eq!(transform.checked().unwrap_err().place, place, "{toml}");
        }
        let without: TrackerTransform = toml::from_str("points = [\"elbow\"]").unwrap();
        let error = without.apply(&mut channels()).unwrap_err().to_string();
        assert!(error.contains("elbow_x_m"), "{error}");
    }
}
