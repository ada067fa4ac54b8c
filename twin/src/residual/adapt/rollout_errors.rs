//! Motions along which a twin was rolled out, as arrays of its errors.

use hysteron_base::parallel;

use crate::Result;
use crate::coreact::AuxiliaryLimits;
use crate::model::Twin;
use crate::motion::RobotMotion;
use crate::plant::Plant;
use crate::residual::{CorrectedRollout, ResidualModel, RobotChange};

/// A motion from its beginning on.
#[derive(Debug, Clone)]
pub(super) struct RolloutErrors {
    /// Measured tip less the twin's, by axis [m].
    pub missed: [Vec<f64>; 3],
    /// Terms of the linear correction (n × n_terms).
    pub terms: Vec<f64>,
    /// False where the tip was filled in.
    pub is_measured: Vec<bool>,
    /// True where an input of the network was outside its training range.
    pub is_extrapolating: Vec<bool>,
}

/// A rollout to be made: a motion, by number, up to a sample, with a change of the robot.
pub(super) struct RolloutTask {
    pub motion: usize,
    pub n_samples: usize,
    pub change: RobotChange,
}

/// A twin with its network, and the motions of the robot.
#[derive(Clone, Copy)]
pub(super) struct TwinWithNetwork<'a> {
    pub twin: &'a Twin,
    pub auxiliary: &'a AuxiliaryLimits,
    pub model: &'a ResidualModel,
    pub motions: &'a [RobotMotion],
    /// Called after every sample; ends the rollouts where it returns false.
    pub on_sample: &'a (dyn Fn() -> bool + Sync),
}

impl TwinWithNetwork<'_> {
    /// Makes rollouts in parallel; none where they were ended.
    pub fn roll(&self, tasks: &[RolloutTask]) -> Result<Option<Vec<RolloutErrors>>> {
        Ok(parallel::try_map(tasks, |task| self.roll_one(task))?.into_iter().collect())
    }

    fn roll_one(&self, task: &RolloutTask) -> Result<Option<RolloutErrors>> {
        let motion = &self.motions[task.motion];
        let model = ResidualModel { change: Some(task.change.clone()), ..self.model.clone() };
        let mut rollout = CorrectedRollout::new(self.twin, self.auxiliary, &model, motion.step)?;
        let mut rolled = RolloutErrors {
            missed: Default::default(),
            terms: Vec::new(),
            is_measured: motion.gap[..task.n_samples].iter().map(|gap| !gap).collect(),
            is_extrapolating: Vec::with_capacity(task.n_samples),
        };
        for i in 0..task.n_samples {
            let step = rollout.step(motion.strokes_at(i))?;
            for (c, series) in rolled.missed.iter_mut().enumerate() {
                series.push(motion.tips[i][c] - step.tip[c]);
            }
            rolled.terms.extend_from_slice(rollout.terms());
            rolled.is_extrapolating.push(step.is_extrapolating);
            if !(self.on_sample)() {
                return Ok(None);
            }
        }
        Ok(Some(rolled))
    }
}

impl RolloutErrors {
    /// Samples that count in a fit: measured, with the network within its training range.
    pub fn is_used(&self) -> Vec<bool> {
        self.is_measured
            .iter()
            .zip(&self.is_extrapolating)
            .map(|(measured, outside)| *measured && !outside)
            .collect()
    }

    /// Error of a sample, by axis [m].
    pub fn missed_at(&self, sample: usize) -> [f64; 3] {
        self.missed.each_ref().map(|series| series[sample])
    }

    /// Terms of the linear correction in a sample.
    pub fn terms_at(&self, sample: usize) -> &[f64] {
        let n = self.terms.len() / self.missed[0].len();
        &self.terms[sample * n..(sample + 1) * n]
    }
}
