//! Brings poses and servo samples onto the same instants.
//!
//! A row waits until the tracker has seen the tip after it; its pose is then interpolated between the one before and
//! the one after, linearly in position and along the shorter way in orientation. A row that waits too long, or whose
//! two poses lie too far apart, is written without a pose: the recording's reader fills it in and marks the gap.

use crate::{Pose, Quality};
use std::collections::VecDeque;

/// Numbers of a pose in a row: position, then quaternion.
pub(super) const POSE: usize = 7;

/// Rows on their way to the file.
#[derive(Debug)]
pub(super) struct Aligner {
    /// Values of a row without its pose.
    n_values: usize,
    /// Time [s] and values of each row that waits.
    rows: VecDeque<f64>,
    /// Trusted poses, in order of time; the first may lie before all rows.
    poses: VecDeque<Pose>,
    /// Furthest that two poses may lie apart for one between them [s]: less than two periods, so none is missing.
    bracket_max: f64,
    /// Longest that a row waits for its pose [s].
    wait_max: f64,
    /// The row that is handed out.
    row: Vec<f64>,
}

impl Aligner {
    /// For rows of `n_values`; without a tracker (`rate` of its poses [Hz]) no row waits.
    pub(super) fn new(n_values: usize, rate: Option<f64>, wait_max: f64) -> Self {
        Self {
            n_values,
            rows: VecDeque::with_capacity(256 * (1 + n_values)),
            poses: VecDeque::with_capacity(256),
            bracket_max: rate.map_or(0.0, |rate| 1.5 / rate),
            wait_max: if rate.is_some() { wait_max } else { -1.0 },
            row: Vec::with_capacity(n_values + POSE),
        }
    }

    /// A row at `time` [s] on the rig's clock.
    pub(super) fn push_row(&mut self, time: f64, values: impl Iterator<Item = f64>) {
        self.rows.push_back(time);
        self.rows.extend(values);
        debug_assert_eq!(self.rows.len() % (1 + self.n_values), 0);
    }

    /// Poses, in any quality; only those that can be trusted are used.
    pub(super) fn push_poses(&mut self, poses: &[Pose]) {
        for pose in poses.iter().filter(|pose| pose.quality == Quality::Good) {
            if self.poses.back().is_none_or(|last| pose.time > last.time) {
                self.poses.push_back(*pose);
            }
        }
    }

    /// The next row that is ready at `now`: its time and its values with the pose at their end, NaN if there is none.
    pub(super) fn pop(&mut self, now: f64) -> Option<(f64, &[f64])> {
        let time = *self.rows.front()?;
        while self.poses.len() > 1 && self.poses[1].time <= time {
            self.poses.pop_front();
        }
        let pose = self.pose_at(time);
        if pose.is_none() && !self.is_seen(time) && now - time <= self.wait_max {
            return None;
        }
        self.rows.pop_front();
        self.row.clear();
        self.row.extend(self.rows.drain(..self.n_values));
        self.row.extend(pose.unwrap_or([f64::NAN; POSE]));
        Some((time, &self.row))
    }

    /// Whether the tracker has been heard of after `time`, so that waiting is of no use.
    fn is_seen(&self, time: f64) -> bool {
        self.poses.back().is_some_and(|last| last.time >= time)
    }

    fn pose_at(&self, time: f64) -> Option<[f64; POSE]> {
        let (before, after) = (self.poses.front()?, self.poses.iter().find(|pose| pose.time >= time)?);
        let span = after.time - before.time;
        if before.time > time || span > self.bracket_max {
            return None;
        }
        let part = if span > 0.0 { (time - before.time) / span } else { 0.0 };
        Some(between(before, after, part))
    }
}

/// The pose at `part` of the way, 0 to 1.
fn between(a: &Pose, b: &Pose, part: f64) -> [f64; POSE] {
    let mut row = [0.0; POSE];
    for i in 0..3 {
        row[i] = a.position[i] + part * (b.position[i] - a.position[i]);
    }
    // The same rotation has two quaternions; the nearer one is meant.
    let dot: f64 = a.orientation.iter().zip(&b.orientation).map(|(x, y)| x * y).sum();
    let sign = if dot < 0.0 { -1.0 } else { 1.0 };
    for i in 0..4 {
        row[3 + i] = a.orientation[i] + part * (sign * b.orientation[i] - a.orientation[i]);
    }
    // Within a few degrees, as two successive poses are, this differs from the great circle by less than 1e-5.
    let length = row[3..].iter().map(|x| x * x).sum::<f64>().sqrt();
    row[3..].iter_mut().for_each(|x| *x /= length);
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(time: f64) -> Pose {
        let half = 0.5 * time;
        Pose {
            time,
            position: [time, 2.0 * time, -time],
            orientation: [half.cos(), 0.0, half.sin(), 0.0],
            quality: Quality::Good,
        }
    }

    fn drain(aligner: &mut Aligner, now: f64) -> Vec<(f64, Vec<f64>)> {
        let mut rows = Vec::new();
        while let Some((time, values)) = aligner.pop(now) {
            rows.push((time, values.to_vec()));
        }
        rows
    }

    #[test]
    fn a_linear_motion_is_recovered_at_the_rows() {
        let mut aligner = Aligner::new(1, Some(80.0), 0.5);
        for k in 0..10 {
            aligner.push_row(0.01 * f64::from(k) + 0.001, std::iter::once(f64::from(k)));
        }
        aligner.push_poses(&(0..9).map(|k| pose(0.0125 * f64::from(k))).collect::<Vec<_>>());
        let rows = drain(&mut aligner, 0.1);
        assert_eq!(rows.len(), 10);
        for (k, (time, values)) in rows.iter().enumerate() {
            assert_eq!(values[0], k as f64);
            assert!((values[1] - time).abs() < 1e-15 && (values[2] - 2.0 * time).abs() < 1e-15);
            assert!(
                (values[4] - (0.5 * time).cos()).abs() < 1e-6
                    && (values[6] - (0.5 * time).sin()).abs() < 1e-6
            );
        }
    }

    #[test]
    fn rows_wait_for_the_pose_after_them_but_not_forever() {
        let mut aligner = Aligner::new(1, Some(80.0), 0.5);
        aligner.push_row(0.0, std::iter::once(7.0));
        aligner.push_poses(&[pose(-0.005)]);
        assert!(aligner.pop(0.4).is_none());
        let rows = drain(&mut aligner, 0.6);
        assert_eq!(rows[0].1[0], 7.0);
        assert!(rows[0].1[1].is_nan());
        assert!(aligner.rows.is_empty());
    }

    #[test]
    fn poses_too_far_apart_or_not_to_be_trusted_leave_a_gap() {
        let mut aligner = Aligner::new(1, Some(80.0), 0.5);
        aligner.push_row(0.05, std::iter::once(0.0));
        let doubtful = Pose { quality: Quality::Jump, ..pose(0.05) };
        aligner.push_poses(&[pose(0.0), doubtful, pose(0.1)]);
        assert!(drain(&mut aligner, 0.1)[0].1[1].is_nan());
    }

    #[test]
    fn without_a_tracker_no_row_waits() {
        let mut aligner = Aligner::new(2, None, 0.5);
        aligner.push_row(0.0, [1.0, 2.0].into_iter());
        assert_eq!(drain(&mut aligner, 0.0)[0].1[..2], [1.0, 2.0]);
    }

    #[test]
    fn the_shorter_way_round_is_taken() {
        let a = pose(0.0);
        let b = Pose { orientation: pose(0.1).orientation.map(|x| -x), ..pose(0.1) };
        let row = between(&a, &b, 0.5);
        assert!((row[3] - 0.025_f64.cos()).abs() < 1e-9, "{row:?}");
    }
}
