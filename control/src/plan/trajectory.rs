//! One trajectory of a plan: from a motion in tendon space to the strokes of all tendons.

use super::CurveMotion;
use super::envelope::rise;
use crate::Result;
use hysteron_base::{BadInput, Channel, Metadata, Recording};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Range;

/// Purpose of a trajectory. Data are split by whole trajectories, never by windows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrajectoryRole {
    /// For the fit.
    Training,
    /// For validation, within the amplitudes of the training.
    Validation,
    /// For tests beyond them.
    OutOfRange,
}

impl TrajectoryRole {
    /// Name as in a plan file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Training => "training",
            Self::Validation => "validation",
            Self::OutOfRange => "out_of_range",
        }
    }
}

/// Space of the curves of a plan.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Space {
    /// Tendon space: commanded strokes.
    #[default]
    Tendons,
    /// Where the tip shall go, in x and y; strokes that bring it there are found by a twin.
    Tip,
}

/// How tendons follow a point (a, b) of tendon space; the same for all trajectories of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct TendonMapping {
    /// Angles of the tendons about the body [rad], at least two.
    pub angles: Vec<f64>,
    /// By how much a tendon is released, over what it would be pulled, >= 0 [-].
    pub release: f64,
    /// Pull that all have in common while the robot moves [m], >= 0; it comes in the second half of the rest
    /// before the motion, and goes in the first half of the rest after it.
    pub co_contraction: f64,
}

impl TendonMapping {
    /// Stroke of tendon `k` [m], positive when pulled, at the point (a, b) [m]: its pull is a cos φ + b sin φ, and
    /// a negative one is multiplied by `release`.
    pub fn stroke(&self, k: usize, point: [f64; 2]) -> f64 {
        self.stroke_along(self.angles[k].sin_cos(), point)
    }

    /// Strokes of all tendons (one for each angle) [m] at the point (a, b) [m].
    pub fn strokes_into(&self, point: [f64; 2], strokes: &mut [f64]) {
        strokes.iter_mut().enumerate().for_each(|(k, stroke)| *stroke = self.stroke(k, point));
    }

    /// The stroke of a tendon by the sine and the cosine of its angle.
    fn stroke_along(&self, (sin, cos): (f64, f64), [a, b]: [f64; 2]) -> f64 {
        let pull = a * cos + b * sin;
        if pull < 0.0 { self.release * pull } else { pull }
    }
}

/// One trajectory, ready to be sampled.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// Name, its own within the plan; letters, digits, `-` and `_`.
    pub name: String,
    /// Its purpose.
    pub role: TrajectoryRole,
    /// Space of its curve.
    pub space: Space,
    /// The curve, its size and timing.
    pub motion: CurveMotion,
    /// Time at rest before the motion [s], >= 0.
    pub rest_before: f64,
    /// Time at rest after the motion [s], >= 0.
    pub rest_after: f64,
    /// Samples per second [Hz], > 0.
    pub rate_hz: f64,
    /// How tendons follow.
    pub tendons: TendonMapping,
    /// The plan it comes from.
    pub(super) plan_name: String,
    /// SHA-256 of the plan file.
    pub(super) plan_hash: String,
    /// Seed of the plan.
    pub(super) seed: u64,
}

/// A trajectory with the sines and cosines of its angles, which are those of all samples.
pub(super) struct Sampler<'a> {
    trajectory: &'a Trajectory,
    orientation: (f64, f64),
    /// Of the tendons (n_tendons).
    directions: Vec<(f64, f64)>,
}

impl<'a> Sampler<'a> {
    pub(super) fn new(trajectory: &'a Trajectory) -> Self {
        let directions = trajectory.tendons.angles.iter().map(|angle| angle.sin_cos()).collect();
        Self { trajectory, orientation: trajectory.motion.orientation.sin_cos(), directions }
    }

    /// Writes the strokes of all tendons (n_tendons) [m] at time `t` [s].
    pub(super) fn strokes_into(&self, t: f64, strokes: &mut [f64]) {
        let Trajectory { motion, tendons, rest_before, .. } = self.trajectory;
        let position = motion.position_about(self.orientation, t - rest_before);
        let common = self.trajectory.co_contraction_at(t);
        for (stroke, direction) in strokes.iter_mut().zip(&self.directions) {
            *stroke = tendons.stroke_along(*direction, position) + common;
        }
    }
}

impl Trajectory {
    /// Time from rest to rest [s].
    pub fn duration(&self) -> f64 {
        self.rest_before + self.motion.envelope.duration() + self.rest_after
    }

    /// Number of samples: at 0, 1 / rate, …; the last one is at the end or less than a step after it.
    pub fn n_samples(&self) -> usize {
        (self.duration() * self.rate_hz - 1e-6).ceil() as usize + 1
    }

    /// Time of sample `i` [s].
    pub fn time(&self, i: usize) -> f64 {
        i as f64 / self.rate_hz
    }

    /// Point (a, b) of tendon space, or the tip's x and y [m], at time `t` [s].
    pub fn position_at(&self, t: f64) -> [f64; 2] {
        self.motion.position_at(t - self.rest_before)
    }

    /// Strokes of all tendons (n_tendons) [m] at time `t` [s]; positive pulls.
    pub fn strokes_at(&self, t: f64) -> Vec<f64> {
        let mut strokes = vec![0.0; self.tendons.angles.len()];
        Sampler::new(self).strokes_into(t, &mut strokes);
        strokes
    }

    /// Samples of which the step before lies within the time of full size too; empty where there are none.
    pub(super) fn sustained(&self) -> Range<usize> {
        let grown = self.rest_before + self.motion.envelope.attack;
        let first = (grown * self.rate_hz).ceil() as usize + 1;
        let end = ((grown + self.motion.envelope.sustain) * self.rate_hz).floor() as usize;
        first..end.min(self.n_samples()).max(first)
    }

    /// A rate of strokes that is never passed at full size [m/s].
    pub(super) fn sustained_rate_bound(&self) -> f64 {
        let CurveMotion { amplitude, frequency, family, .. } = self.motion;
        amplitude * frequency * family.speed_bound() * self.tendons.release.max(1.0)
    }

    /// Common pull of all tendons [m] at time `t` [s].
    fn co_contraction_at(&self, t: f64) -> f64 {
        if self.tendons.co_contraction == 0.0 {
            return 0.0;
        }
        let (half_before, half_after) = (0.5 * self.rest_before, 0.5 * self.rest_after);
        let grown = rise((t - half_before) / half_before);
        let left = self.duration() - half_after - t;
        // A rounding before its end is its end.
        let kept = if left <= 1e-9 { 0.0 } else { rise(left / half_after) };
        self.tendons.co_contraction * grown.min(kept)
    }

    /// A stroke that is never passed, in either direction [m].
    pub fn stroke_bound(&self) -> f64 {
        self.motion.amplitude * self.tendons.release.max(1.0) + self.tendons.co_contraction
    }

    /// A rate of strokes that is never passed [m/s].
    pub fn stroke_rate_bound(&self) -> f64 {
        let moving = self.motion.speed_bound() * self.tendons.release.max(1.0);
        // Outside the motion only the common pull changes.
        let common = match self.tendons.co_contraction {
            0.0 => 0.0,
            pull => pull * std::f64::consts::PI / self.rest_before.min(self.rest_after),
        };
        moving.max(common)
    }

    /// The commands as a recording: `time_s` and `stroke_1_m`, `stroke_2_m`, … . Its metadata name the plan with
    /// its hash and seed, the trajectory, its role and its motion.
    ///
    /// # Errors
    /// `BadInput` for a trajectory whose numbers were changed after its plan was checked, or one of the tip.
    pub fn commands(&self) -> Result<Recording> {
        self.check_space()?;
        let n = self.n_samples();
        let time: Vec<f64> = (0..n).map(|i| self.time(i)).collect();
        let mut columns = vec![Vec::with_capacity(n); self.tendons.angles.len()];
        let (mut strokes, sampler) = (vec![0.0; columns.len()], Sampler::new(self));
        for t in &time {
            sampler.strokes_into(*t, &mut strokes);
            for (column, stroke) in columns.iter_mut().zip(&strokes) {
                column.push(*stroke);
            }
        }
        let channels = columns.into_iter().enumerate();
        let channels =
            channels.map(|(k, values)| Channel::new(format!("stroke_{}_m", k + 1), values)).collect();
        Ok(Recording::new(time, channels, vec![], self.metadata())?)
    }

    /// Refuses a trajectory of the tip, which has no strokes.
    pub(super) fn check_space(&self) -> Result<()> {
        match self.space {
            Space::Tendons => Ok(()),
            Space::Tip => Err(BadInput::new(format!("plan {}: space", self.plan_name), "tendons", "tip")
                .hint("`hysteron generate` finds strokes for it, with a twin")
                .into()),
        }
    }

    /// The plan with its hash and seed, the trajectory, its role and its motion.
    pub fn metadata(&self) -> Metadata {
        let extra = [
            ("plan.name", self.plan_name.clone()),
            ("plan.sha256", self.plan_hash.clone()),
            ("plan.trajectory", self.name.clone()),
            ("plan.role", self.role.name().to_owned()),
            ("plan.family", self.motion.family.name().to_owned()),
            ("plan.amplitude_m", self.motion.amplitude.to_string()),
            ("plan.frequency_hz", self.motion.frequency.to_string()),
            ("plan.orientation_rad", self.motion.orientation.to_string()),
        ];
        Metadata {
            seed: Some(self.seed),
            source: format!("plan {}, trajectory {}", self.plan_name, self.name),
            extra: extra.into_iter().map(|(key, value)| (key.to_owned(), value)).collect::<BTreeMap<_, _>>(),
            ..Metadata::default()
        }
    }
}
