//! What a recording of a robot says to its twin: strokes in, tip out; checked before anything is computed from it.

use hysteron_base::{BadInput, Recording};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::model::Twin;

type Check<T> = std::result::Result<T, BadInput>;

/// Fewest samples worth learning from.
const FEWEST: usize = 100;
/// Largest share of samples that may have been filled in.
const MOST_GAPS: f64 = 0.2;
/// Farthest that the tip of the resting robot may be from that of the resting twin, over the tip's distance from
/// the origin of the twin.
const REGISTERED: f64 = 0.1;
/// Strokes below this part of their range count as rest.
const AT_REST: f64 = 0.02;

/// Measured motion of a robot at a fixed rate, in the frame of its twin.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Duration of a sample [s].
    pub step: f64,
    /// Strokes of the primary tendons (n_samples × n_primary, row-major) [m].
    pub strokes: Vec<f64>,
    /// Tip (n_samples) [m].
    pub tips: Vec<[f64; 3]>,
    /// Rotation of the tip since rest (n_samples), where recorded; however the sensor is mounted.
    pub orientations: Option<Vec<UnitQuaternion<f64>>>,
    /// True where the tip was not measured but filled in (n_samples).
    pub gap: Vec<bool>,
    n_primary: usize,
}

impl Motion {
    /// Takes strokes and tip out of a recording of the robot that `twin` is of.
    ///
    /// # Errors
    /// Another number of tendons; no tip; too few samples, or too many filled in; no fixed rate; strokes or tips
    /// too large for the robot; a tip or all strokes that never change; a tip at rest away from the twin's, as
    /// after the tracker was moved.
    pub fn new(twin: &Twin, recording: &Recording) -> Check<Self> {
        let strokes = recording.strokes();
        if strokes.len() != twin.n_primary {
            let found = strokes.len().to_string();
            return Err(BadInput::new(
                "stroke columns",
                format!("{}, one per tendon", twin.n_primary),
                found,
            )
            .hint("is it a recording of another robot?"));
        }
        let n = recording.n_samples();
        if n < FEWEST {
            return Err(BadInput::new("rows", format!("at least {FEWEST}"), n.to_string()));
        }
        let rate = recording.rate_hz().ok_or_else(|| {
            BadInput::new("time_s", "a fixed rate", "time steps that differ by more than 1 %")
                .hint("resample it, and set gap to 1 where a row was filled in")
        })?;
        let tips: Vec<[f64; 3]> = {
            let [x, y, z] = recording.tip().ok_or_else(|| missing("tip_x_m"))?;
            (0..n).map(|i| [x[i], y[i], z[i]]).collect()
        };
        let n_gaps = recording.gap().iter().filter(|gap| **gap).count();
        if n_gaps as f64 > MOST_GAPS * n as f64 {
            let expected = format!("at most {:.0} % of rows filled in", 100.0 * MOST_GAPS);
            return Err(BadInput::new("gap", expected, format!("{n_gaps} of {n}")));
        }
        let motion = Self {
            step: 1.0 / rate,
            strokes: (0..n).flat_map(|i| strokes.iter().map(move |values| values[i])).collect(),
            orientations: orientations(twin, recording),
            tips,
            gap: recording.gap().to_vec(),
            n_primary: twin.n_primary,
        };
        motion.check_moves()?;
        motion.check_sizes(twin)?;
        motion.check_registration(twin)?;
        Ok(motion)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.tips.len()
    }

    /// False: a motion has samples.
    pub fn is_empty(&self) -> bool {
        self.tips.is_empty()
    }

    /// Strokes of the primary tendons in a sample [m].
    pub fn strokes_at(&self, sample: usize) -> &[f64] {
        &self.strokes[sample * self.n_primary..(sample + 1) * self.n_primary]
    }

    /// A channel that never changes was not measured, or not moved.
    fn check_moves(&self) -> Check<()> {
        for (axis, name) in ["tip_x_m", "tip_y_m", "tip_z_m"].into_iter().enumerate() {
            if self.tips.iter().all(|tip| tip[axis] == self.tips[0][axis]) {
                return Err(BadInput::new(name, "a measured tip", "the same value in every row")
                    .hint("was the tracker running?"));
            }
        }
        if (1..self.len()).all(|i| self.strokes_at(i) == self.strokes_at(0)) {
            return Err(BadInput::new("stroke columns", "strokes that move", "the same values in every row"));
        }
        Ok(())
    }

    /// Numbers a thousand times too large or of a larger robot.
    fn check_sizes(&self, twin: &Twin) -> Check<()> {
        for i in 0..self.len() {
            for (j, stroke) in self.strokes_at(i).iter().enumerate() {
                let length = twin.cables.rest_lengths[j];
                if stroke.abs() >= length {
                    let expected = format!("less than the tendon's length, {:.1} mm", 1e3 * length);
                    let found = format!("{:.1} mm", 1e3 * stroke);
                    return Err(BadInput::new(format!("row {}: stroke_{}_m", i + 1, j + 1), expected, found)
                        .hint("is the unit of the column its ending, _mm or _m?"));
                }
            }
        }
        let rest = tip_at_rest(twin);
        let reach = 2.5 * rest.norm().max(longest_cable(twin));
        for (i, tip) in self.tips.iter().enumerate() {
            let distance = (Vector3::from(*tip) - rest).norm();
            if distance > reach {
                let expected = format!("a tip within {:.0} mm of rest, as the robot is long", 1e3 * reach);
                let found = format!("{:.0} mm", 1e3 * distance);
                return Err(BadInput::new(format!("row {}: tip", i + 1), expected, found)
                    .hint("other units, another frame, or another robot?"));
            }
        }
        Ok(())
    }

    /// At rest, robot and twin must have their tips in one place.
    fn check_registration(&self, twin: &Twin) -> Check<()> {
        let largest = self.strokes.iter().fold(0.0f64, |max, stroke| max.max(stroke.abs()));
        let is_rest = |i: usize| self.strokes_at(i).iter().all(|stroke| stroke.abs() <= AT_REST * largest);
        let Some(first) = (0..self.len()).find(|&i| is_rest(i) && !self.gap[i]) else { return Ok(()) };
        let rest = tip_at_rest(twin);
        let away = (Vector3::from(self.tips[first]) - rest).norm();
        let allowed = REGISTERED * longest_cable(twin);
        if away <= allowed {
            return Ok(());
        }
        let expected = format!(
            "the tip at rest within {:.1} mm of the twin's, ({:.1}, {:.1}, {:.1}) mm",
            1e3 * allowed,
            1e3 * rest.x,
            1e3 * rest.y,
            1e3 * rest.z
        );
        let found = format!("{:.1} mm away", 1e3 * away);
        Err(BadInput::new(format!("row {}: tip", first + 1), expected, found)
            .hint("was the tracker moved? register it again, or calibrate the rig"))
    }
}

fn missing(name: &str) -> BadInput {
    BadInput::new(name, "the measured tip, tip_x_m, tip_y_m and tip_z_m", "no such column")
}

fn tip_at_rest(twin: &Twin) -> Vector3<f64> {
    Vector3::from(twin.tip_of(&twin.rest()))
}

fn longest_cable(twin: &Twin) -> f64 {
    twin.cables.rest_lengths.iter().copied().fold(0.0, f64::max)
}

/// Rotations since the first sample, in which the robot is taken to stand straight: how the sensor sits in the tip
/// drops out.
fn orientations(twin: &Twin, recording: &Recording) -> Option<Vec<UnitQuaternion<f64>>> {
    let [w, x, y, z] = recording.tip_orientation()?;
    let turned = |i: usize| UnitQuaternion::from_quaternion(Quaternion::new(w[i], x[i], y[i], z[i]));
    let mount = turned(0).inverse() * twin.tip_rotation_of(&twin.rest());
    Some((0..recording.n_samples()).map(|i| turned(i) * mount).collect())
}
