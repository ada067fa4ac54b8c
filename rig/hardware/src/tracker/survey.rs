//! A tracker looked at while the tip rests: pose, rate, noise and jitter, and what cannot be right with them.

use crate::config::TrackerConfig;
use crate::{Pose, Quality};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Nearest to a tracker's origin that a sensor can be [m]: the transmitter itself is larger. What a tracker sends in
/// metres reads as less.
const NEAREST: f64 = 5e-3;
/// Furthest that a tracker sees [m].
const FURTHEST: f64 = 10.0;
/// Least part of the poses per second that the rig file states [-].
const RATE_PART: f64 = 0.8;
/// Largest scatter of the tip at rest [m].
const NOISE_MAX: f64 = 1e-3;
/// Largest scatter of the intervals between stamps, of the period [-].
const JITTER_MAX: f64 = 0.5;
/// Poses below which noise and rate cannot be estimated.
const POSES_MIN: usize = 5;

/// Survey of a tracker with the tip at rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TrackerSurvey {
    /// Poses, and how many of them are not to be trusted.
    pub n_poses: usize,
    /// See `n_poses`.
    pub n_doubtful: usize,
    /// Mean position in the tracker's frame [mm].
    pub position_mm: [f64; 3],
    /// Last orientation, w, x, y, z [-].
    pub orientation_wxyz: [f64; 4],
    /// Poses per second, by their stamps [Hz].
    pub rate_hz: f64,
    /// Root mean square distance from the mean position [mm].
    pub noise_mm: f64,
    /// Root mean square deviation of the intervals between stamps from their mean [ms].
    pub jitter_ms: f64,
    /// Longest interval between stamps [ms].
    pub longest_gap_ms: f64,
    /// Warnings, each with what to do.
    #[serde(rename = "doubts")]
    pub warnings: Vec<String>,
}

impl TrackerSurvey {
    /// Of poses in order of time, in the tracker's frame. `reason` is the tracker's own last trouble, if it had one.
    pub fn of(poses: &[Pose], config: &TrackerConfig, reason: Option<&str>) -> Self {
        let n_doubtful = poses.iter().filter(|pose| pose.quality != Quality::Good).count();
        let position = mean_position(poses);
        let n = poses.len() as f64;
        let square = |pose: &Pose| (0..3).map(|k| (pose.position[k] - position[k]).powi(2)).sum::<f64>();
        let gaps: Vec<f64> = poses.windows(2).map(|pair| pair[1].time - pair[0].time).collect();
        let span: f64 = gaps.iter().sum();
        let period = if gaps.is_empty() { 0.0 } else { span / gaps.len() as f64 };
        let spread = gaps.iter().map(|gap| (gap - period).powi(2)).sum::<f64>() / gaps.len().max(1) as f64;
        let mut survey = Self {
            n_poses: poses.len(),
            n_doubtful,
            position_mm: position.map(|x| 1e3 * x),
            orientation_wxyz: poses.last().map_or([1.0, 0.0, 0.0, 0.0], |pose| pose.orientation),
            rate_hz: if period > 0.0 { 1.0 / period } else { 0.0 },
            noise_mm: if n > 0.0 { 1e3 * (poses.iter().map(square).sum::<f64>() / n).sqrt() } else { 0.0 },
            jitter_ms: 1e3 * spread.sqrt(),
            longest_gap_ms: 1e3 * gaps.iter().copied().fold(0.0, f64::max),
            warnings: Vec::new(),
        };
        survey.warnings = survey.warnings_of(poses, config, reason);
        survey
    }

    fn warnings_of(&self, poses: &[Pose], config: &TrackerConfig, reason: Option<&str>) -> Vec<String> {
        let mut warnings = Vec::new();
        let counted = |quality| poses.iter().filter(|pose| pose.quality == quality).count();
        let (flagged, jumped) = (counted(Quality::Flagged), counted(Quality::Jump));
        if flagged > 0 {
            let why = reason.map_or(String::new(), |reason| format!(": {reason}"));
            warnings.push(format!("{flagged} of {} poses are not valid{why}", self.n_poses));
        }
        if jumped > 0 {
            let fastest = 1e3 * config.speed_max;
            warnings.push(format!(
                "{jumped} of {} poses jump faster than {fastest:.0} mm/s (hint: metal near, a loose sensor, or two senders of one \
                 name; at rest nothing jumps)",
                self.n_poses
            ));
        }
        if self.n_poses < POSES_MIN {
            warnings.push(format!("{} poses: too few for an assessment", self.n_poses));
            return warnings;
        }
        let first = &poses[0];
        let is_same = |pose: &Pose| pose.position == first.position && pose.orientation == first.orientation;
        if poses.iter().all(is_same) {
            warnings.push(format!(
                "frozen: {} poses are the same to the last bit (hint: no sensor has so little noise; is it plugged in, and does \
                 the server measure, or repeat a transform that nobody sets?)",
                self.n_poses
            ));
        }
        let distance = self.position_mm.iter().map(|x| x * x).sum::<f64>().sqrt();
        if distance < 1e3 * NEAREST && flagged < self.n_poses {
            warnings.push(format!(
                "unit: the sensor is {distance:.3} mm from the tracker's origin, inside the transmitter; in metres it would be \
                 {:.0} mm (hint: OpenIGTLink is in millimetres; let the server multiply by 1000)",
                1e3 * distance
            ));
        }
        if distance > 1e3 * FURTHEST {
            warnings.push(format!(
                "unit: the sensor is {:.1} m from the tracker's origin (hint: OpenIGTLink is in millimetres)",
                1e-3 * distance
            ));
        }
        if self.rate_hz < RATE_PART * config.rate {
            warnings.push(format!(
                "slow: {:.1} poses a second where the rig file says {:.1} (hint: tracker.rate_hz, or the server's rate)",
                self.rate_hz, config.rate
            ));
        }
        if self.noise_mm > 1e3 * NOISE_MAX && jumped == 0 {
            warnings.push(format!(
                "noise: {:.2} mm at rest (hint: is the tip at rest? metal and motors near the sensor?)",
                self.noise_mm
            ));
        }
        if self.rate_hz > 0.0 && 1e-3 * self.jitter_ms * self.rate_hz > JITTER_MAX {
            warnings.push(format!(
                "jitter: the stamps scatter by {:.1} ms about a period of {:.1} ms (hint: does the server stamp poses when it forwards \
                 them instead of when it measures them, or skip poses?)",
                self.jitter_ms,
                1e3 / self.rate_hz
            ));
        }
        warnings
    }
}

fn mean_position(poses: &[Pose]) -> [f64; 3] {
    let n = poses.len().max(1) as f64;
    [0, 1, 2].map(|k| poses.iter().map(|pose| pose.position[k]).sum::<f64>() / n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::TrackerSource;
    use hysteron_base::rng;

    const CONFIG: TrackerConfig = TrackerConfig {
        source: TrackerSource::OpenIgtLink(String::new()),
        device: String::new(),
        rate: 80.0,
        latency: 0.0,
        stale: 0.3,
        speed_max: 0.5,
        tip_rest: [0.0; 3],
    };

    /// Two seconds of a tip at rest, 250 mm from the origin times `scale`.
    fn poses(rate: f64, noise: f64, scale: f64) -> Vec<Pose> {
        let mut rng = rng(3, "tests/survey");
        let mut normal = || hysteron_base::normal(&mut rng);
        (0..(2.0 * rate) as usize)
            .map(|i| Pose {
                time: i as f64 / rate,
                position: [0.15, 0.2, 0.0].map(|x| scale * (x + noise * normal())),
                orientation: [1.0, 0.0, 0.0, 0.0],
                quality: Quality::Good,
            })
            .collect()
    }

    fn warnings(poses: &[Pose]) -> Vec<String> {
        TrackerSurvey::of(poses, &CONFIG, None).warnings
    }

    #[test]
    fn rate_noise_and_jitter_of_a_sound_tracker_are_measured_without_warnings() {
        let found = TrackerSurvey::of(&poses(80.0, 5e-5, 1.0), &CONFIG, None);
        assert_eq!(found.warnings, Vec::<String>::new());
        assert!((found.rate_hz - 80.0).abs() < 1e-9 && found.jitter_ms < 1e-9, "{found:?}");
        // Three coordinates of 0.05 mm each: 0.087 mm, to 5 standard errors of 160 poses.
        let expected = 0.05 * 3_f64.sqrt();
        assert!((found.noise_mm - expected).abs() < 5.0 * expected / (2.0 * 480_f64).sqrt(), "{found:?}");
        assert!((found.position_mm[1] - 200.0).abs() < 0.05, "{found:?}");
    }

    #[test]
    fn each_fault_is_reported_and_nothing_else() {
        let sound = poses(80.0, 5e-5, 1.0);
        let frozen: Vec<Pose> = sound.iter().map(|pose| Pose { position: [0.1; 3], ..*pose }).collect();
        let mut jumped = sound.clone();
        jumped[40].quality = Quality::Jump;
        let mut flagged = sound.clone();
        flagged[7].quality = Quality::Flagged;
        let mut late = sound.clone();
        late.iter_mut().skip(1).step_by(2).for_each(|pose| pose.time += 0.011);
        for (what, poses) in [
            ("unit", poses(80.0, 5e-5, 1e-3)),
            ("unit", poses(80.0, 5e-5, 1e3)),
            ("slow", poses(20.0, 5e-5, 1.0)),
            ("noise", poses(80.0, 5e-3, 1.0)),
            ("frozen", frozen),
            ("1 of 160 poses jump", jumped),
            ("1 of 160 poses are not valid", flagged),
            ("jitter", late),
        ] {
            let found = warnings(&poses);
            let is_scaled = what == "unit" && found.len() == 2 && found[1].starts_with("noise");
            assert!(found[0].starts_with(what) && (found.len() == 1 || is_scaled), "{what}: {found:?}");
        }
    }
}
