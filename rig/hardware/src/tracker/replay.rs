//! A tracker that repeats a recording.

use crate::{Pose, Quality};
use hysteron_base::{BadInput, Recording};

/// The poses of a recording, as time passes.
#[derive(Debug, Clone)]
pub struct Replay {
    poses: Vec<Pose>,
    next: usize,
}

impl Replay {
    /// Repeats the tip of a recording such that its first row is measured at `begin` [s] on the host's clock. Rows
    /// that were filled in are left out; without orientation it is 1, 0, 0, 0.
    ///
    /// # Errors
    /// `BadInput` naming the channel that is missing, or the row whose orientation is no rotation.
    pub fn new(recording: &Recording, begin: f64) -> Result<Self, BadInput> {
        let x = recording.require("tip_x_m")?;
        let y = recording.require("tip_y_m")?;
        let z = recording.require("tip_z_m")?;
        let orientation = recording.tip_orientation();
        let time = recording.time();
        let mut poses = Vec::with_capacity(time.len());
        for i in (0..time.len()).filter(|&i| !recording.gap()[i]) {
            let q = orientation.map_or([1.0, 0.0, 0.0, 0.0], |q| q.map(|channel| channel[i]));
            let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            if (norm - 1.0).abs() > 1e-3 {
                let place = format!("row {}: tip_qw to tip_qz", i + 1);
                return Err(BadInput::new(place, "a unit quaternion", format!("{q:?} of length {norm}")));
            }
            poses.push(Pose {
                time: begin + (time[i] - time[0]),
                position: [x[i], y[i], z[i]],
                orientation: q.map(|x| x / norm),
                quality: Quality::Good,
            });
        }
        Ok(Self { poses, next: 0 })
    }

    /// Appends the poses measured up to `now` [s] that have not been given yet.
    pub fn take_poses(&mut self, now: f64, poses: &mut Vec<Pose>) {
        let n = self.poses[self.next..].partition_point(|pose| pose.time <= now);
        poses.extend_from_slice(&self.poses[self.next..self.next + n]);
        self.next += n;
    }

    /// Whether all has been given.
    pub fn is_over(&self) -> bool {
        self.next == self.poses.len()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;
    use hysteron_base::{Channel, Metadata};

    fn channel(name: &str, values: &[f64]) -> Channel {
        Channel::new(name, values.to_vec())
    }

    fn recording(extra: Vec<Channel>, gap: Vec<bool>) -> Recording {
        let mut channels = vec![
            channel("tip_x_m", &[1.0, 2.0, 3.0]),
            channel("tip_y_m", &[4.0, 5.0, 6.0]),
            channel("tip_z_m", &[7.0, 8.0, 9.0]),
        ];
        channels.extend(extra);
        Recording::new(vec![10.0, 10.5, 11.0], channels, gap, Metadata::default()).unwrap()
    }

    #[test]
    fn poses_come_when_due_and_gaps_stay_out() {
        let mut replay = Replay::new(&recording(vec![], vec![false, true, false]), 3.0).unwrap();
        let mut poses = Vec::new();
        replay.take_poses(2.9, &mut poses);
        assert!(poses.is_empty());
        replay.take_poses(3.0, &mut poses);
        assert_eq!(poses.len(), 1);
        assert!(!replay.is_over());
        replay.take_poses(9.0, &mut poses);
        replay.take_poses(9.0, &mut poses);
        assert!(replay.is_over());
        let orientation = [1.0, 0.0, 0.0, 0.0];
        let pose = |time, position| Pose { time, position, orientation, quality: Quality::Good };
        assert_eq!(poses, [pose(3.0, [1.0, 4.0, 7.0]), pose(4.0, [3.0, 6.0, 9.0])]);
    }

    #[test]
    fn orientation_must_be_a_rotation() {
        let q = |w| {
            let zero = [0.0; 3];
            vec![
                channel("tip_qw", &[1.0, 1.0, w]),
                channel("tip_qx", &zero),
                channel("tip_qy", &zero),
                channel("tip_qz", &zero),
            ]
        };
        assert!(Replay::new(&recording(q(-1.0), vec![]), 0.0).is_ok());
        let bad = Replay::new(&recording(q(0.9), vec![]), 0.0).unwrap_err();
        assert_eq!(bad.place, "row 3: tip_qw to tip_qz");
        let tip = Recording::new(vec![0.0], vec![], vec![], Metadata::default()).unwrap();
        assert!(Replay::new(&tip, 0.0).unwrap_err().expected.contains("tip_x_m"));
    }
}
