//! Adapts a twin to a little motion of its robot, and keeps only the changes that test blocks confirm.
//!
//! Two kinds of change are sought. The physical one ([`RobotChange`]: zeros of the tendons, play, friction)
//! is a least-squares fit on the rollout with a prior around no change; what is left, a correction linear in
//! strokes and plays ([`Adaptation`]) may follow. The errors of a minute of motion are correlated from beginning to end: its
//! tracker drifts, and the twin has errors of its own in it that are no change of the robot. So the errors
//! are whitened before they are fitted, and blocks of the motion take turns: a change is fitted to the
//! training blocks and evaluated on the test block. How strong the prior is, and whether either kind is kept,
//! is decided by the errors in all test blocks, beyond the drift of the tracker in each.

mod blocks;
mod ridge;
mod rollout_errors;
mod whitening;

use hysteron_base::{BadInput, Bounds, parallel};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::adaptation::AdaptationFilter;
use super::adapted_parts::AdaptedParts;
use super::{AdaptOptions, Adaptation, ResidualDesign, ResidualModel, RobotChange};
use crate::Result;
use crate::coreact::AuxiliaryLimits;
use crate::model::Twin;
use crate::motion::RobotMotion;
use blocks::{MotionBlock, blocks};
use ridge::GaussNewtonSystem;
use rollout_errors::{RolloutErrors, RolloutTask, TwinWithNetwork};
use whitening::Whitening;

/// Root mean square distance of the twin's tip from the measured one [m].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MotionErrors {
    /// Name of the motion.
    pub name: String,
    /// With the model as it was.
    pub before_m: f64,
    /// With the adapted model, this motion in its training; as before where nothing was kept.
    pub after_m: f64,
    /// Part of the samples in which the network was outside its training range; the fit does not use them
    /// [-].
    pub extrapolating: f64,
}

/// Motions of a robot.
#[derive(Debug, Clone, Copy)]
pub struct AdaptMotions<'a> {
    /// As it is now: the twin is adapted to these.
    pub now: &'a [RobotMotion],
    /// As it was when its twin was calibrated, of the same kinds; may be empty.
    pub before: &'a [RobotMotion],
}

/// Result of an adaptation.
#[derive(Debug, Clone, PartialEq)]
pub struct Adapted {
    /// The model, with the parts that are kept.
    pub model: ResidualModel,
    /// Parts that are kept.
    pub kept: AdaptedParts,
    /// Root mean square distance of the tip over all blocks, each as test block [m], by the parts that would
    /// be kept; without a mean of each block that the tracker's drift explains.
    pub held_out_m: Vec<(AdaptedParts, f64)>,
    /// Error of the twin on the robot as it was [m]: along the motions from before, or else of the networks in validation; none where
    /// neither is known. An error that is no larger shows no change.
    pub known_error_m: Option<f64>,
    /// Blocks, by the name of their motion and their first and last time [s].
    pub blocks: Vec<(String, [f64; 2])>,
    /// The change that was found, kept or not, beyond what the model had.
    pub found: RobotChange,
    /// Weight of the prior, chosen on the test blocks.
    pub prior_weight: f64,
    /// Errors of every motion.
    pub motions: Vec<MotionErrors>,
}

/// Weights of the prior to choose from, strongest first: a weaker one has to do better.
const WEIGHTS: [f64; 4] = [30.0, 10.0, 3.0, 1.0];
/// Differences of the parameters for derivatives of the rollout: far above its accuracy, well below what matters.
const ZERO_STEP: f64 = 2e-4;
const PLAY_STEP: f64 = 2e-4;
const FRICTION_STEP: f64 = 0.2;
/// How far a change may go.
const ZEROS: Bounds = Bounds { min: -3e-3, max: 3e-3 };
const MAX_PLAY: f64 = 2e-3;
const FRICTION: Bounds = Bounds { min: 0.2, max: 5.0 };
/// Standard errors by which the gain of a change must be above zero: 95 % for many blocks.
const SIGNIFICANT: f64 = 2.0;
/// Times that the fit to all motion repeats its own rollout: a tendon that has gone slack is not linear in
/// its zero.
const ROUNDS: usize = 2;

/// Fits a change and keeps the parts that test blocks confirm. `on_sample` is called after every sample of a
/// rollout, at most [`n_samples`] times; where it returns false, there is no result.
///
/// # Errors
/// Less than two blocks of motion; a model of another robot or rate; those of [`crate::Stepper::step`].
pub fn adapt(
    twin: &Twin,
    auxiliary: &AuxiliaryLimits,
    model: &ResidualModel,
    motions: AdaptMotions<'_>,
    options: &AdaptOptions,
    on_sample: &(dyn Fn() -> bool + Sync),
) -> Result<Option<Adapted>> {
    let rig = TwinWithNetwork { twin, auxiliary, model, motions: motions.now, on_sample };
    let mut search = AdaptSearch::new(rig, options)?;
    if !motions.before.is_empty() {
        let Some(error) = search.error_before(motions.before)? else { return Ok(None) };
        search.known_error = Some(error);
    }
    let Some(start) = search.linearise()? else { return Ok(None) };
    let Some(evaluated) = search.evaluate(&start)? else { return Ok(None) };
    search.finish(&start, evaluated)
}

/// Samples of rollouts that [`adapt`] makes at most.
pub fn n_samples(twin: &Twin, motions: AdaptMotions<'_>) -> usize {
    let of = |motions: &[RobotMotion]| -> usize { motions.iter().map(RobotMotion::len).sum() };
    let all = of(motions.now);
    let parameters = twin.n_primary + 1 + usize::from(!twin.friction.is_empty());
    // The model as it is, a difference for each parameter, the test blocks (each motion up to its end at
    // most), the rounds of the fit to all.
    let held_out: usize = blocks(motions.now).iter().map(|block| block.samples.end).sum();
    all * (1 + parameters + ROUNDS) + held_out + of(motions.before)
}

/// The constants of the search.
struct AdaptSearch<'a> {
    rig: TwinWithNetwork<'a>,
    options: &'a AdaptOptions,
    blocks: Vec<MotionBlock>,
    before: RobotChange,
    /// See [`Adapted::known_error_m`].
    known_error: Option<f64>,
    /// Prior deviation, bounds and difference of each parameter: zeros, play, and friction where there is any.
    deviations: Vec<f64>,
    bounds: Vec<Bounds>,
    steps: Vec<f64>,
}

/// Every motion with the model as it was, and what each parameter does to it.
struct Linearisation {
    motions: Vec<RolloutErrors>,
    /// By motion, by parameter: ∂(error)/∂p, by axis [m over the parameter's unit].
    columns: Vec<Vec<[Vec<f64>; 3]>>,
    /// By block: normal equations of the whitened errors.
    normals: Vec<GaussNewtonSystem>,
}

/// Errors on the test blocks, and the decision.
struct TestEvaluation {
    kept: AdaptedParts,
    held_out_m: Vec<(AdaptedParts, f64)>,
    weight: f64,
}

impl<'a> AdaptSearch<'a> {
    fn new(rig: TwinWithNetwork<'a>, options: &'a AdaptOptions) -> Result<Self> {
        options.check()?;
        let blocks = blocks(rig.motions);
        if blocks.len() < 2 {
            return Err(BadInput::new("recordings", "two of them, or one of 8 s or more", "less")
                .hint("a change fitted to one must improve another")
                .into());
        }
        let n = rig.twin.n_primary;
        let before = rig.model.change.clone().unwrap_or_else(|| RobotChange::none(n));
        let mut search = Self {
            deviations: vec![options.zero_m; n],
            bounds: vec![ZEROS; n],
            steps: vec![ZERO_STEP; n],
            known_error: validation_error(rig.model),
            rig,
            options,
            blocks,
            before,
        };
        search.deviations.push(options.play_m);
        search.bounds.push(Bounds { min: -search.before.play_m, max: MAX_PLAY });
        search.steps.push(PLAY_STEP);
        if !rig.twin.friction.is_empty() {
            let had = search.before.friction_ratio;
            search.deviations.push(options.friction_ratio);
            search.bounds.push(Bounds { min: FRICTION.min - had, max: FRICTION.max - had });
            search.steps.push(FRICTION_STEP);
        }
        Ok(search)
    }

    /// The change that the parameters `p` add to what was known.
    fn change(&self, p: &[f64]) -> RobotChange {
        let n = self.before.zeros_m.len();
        RobotChange {
            zeros_m: self.before.zeros_m.iter().zip(p).map(|(zero, more)| zero + more).collect(),
            play_m: (self.before.play_m + p[n]).max(0.0),
            friction_ratio: self.before.friction_ratio + p.get(n + 1).copied().unwrap_or(0.0),
        }
    }

    /// Error of the twin as it is along motions of the robot as it was; none where the rollout was ended.
    fn error_before(&self, motions: &[RobotMotion]) -> Result<Option<f64>> {
        let task = |(motion, of): (usize, &RobotMotion)| RolloutTask {
            motion,
            n_samples: of.len(),
            change: self.before.clone(),
        };
        let tasks: Vec<RolloutTask> = motions.iter().enumerate().map(task).collect();
        let Some(rolled) = (TwinWithNetwork { motions, ..self.rig }).roll(&tasks)? else { return Ok(None) };
        let squares = rolled.iter().enumerate().map(|(motion, rolled)| {
            let whole = MotionBlock { motion, samples: 0..rolled.is_measured.len() };
            Squares::of(rolled, &whole, None, self.options.drift_m)
        });
        Ok(Some(squares.fold(Squares::default(), Squares::plus).root_mean()))
    }

    fn whole(&self, p: &[f64]) -> Vec<RolloutTask> {
        let task = |motion| RolloutTask {
            motion,
            n_samples: self.rig.motions[motion].len(),
            change: self.change(p),
        };
        (0..self.rig.motions.len()).map(task).collect()
    }

    fn whitening(&self, motion: usize) -> Whitening {
        let step = self.rig.motions[motion].step;
        let noise = self.options.noise_m.powi(2) * (self.options.noise_time_s / step).max(1.0);
        Whitening { drift: self.options.drift_m, drift_time: self.options.drift_time_s, noise, step }
    }

    /// Rolls out all motions, as they are and with every parameter a little off.
    fn linearise(&self) -> Result<Option<Linearisation>> {
        let n = self.deviations.len();
        let mut points = vec![vec![0.0; n]];
        points.extend((0..n).map(|k| (0..n).map(|l| if k == l { self.steps[k] } else { 0.0 }).collect()));
        let tasks: Vec<RolloutTask> = points.iter().flat_map(|p: &Vec<f64>| self.whole(p)).collect();
        let Some(mut motions) = self.rig.roll(&tasks)? else { return Ok(None) };
        let varied = motions.split_off(self.rig.motions.len());
        let column = |motion: usize, k: usize| -> [Vec<f64>; 3] {
            let (from, to) = (&motions[motion], &varied[k * motions.len() + motion]);
            std::array::from_fn(|c| {
                to.missed[c]
                    .iter()
                    .zip(&from.missed[c])
                    .map(|(to, from)| (to - from) / self.steps[k])
                    .collect()
            })
        };
        let columns: Vec<Vec<_>> =
            (0..motions.len()).map(|motion| (0..n).map(|k| column(motion, k)).collect()).collect();
        let normals = self.normals(&motions, &columns);
        Ok(Some(Linearisation { motions, columns, normals }))
    }

    /// Normal equations of each block.
    fn normals(&self, motions: &[RolloutErrors], columns: &[Vec<[Vec<f64>; 3]>]) -> Vec<GaussNewtonSystem> {
        let mut normals = vec![GaussNewtonSystem::zeros(self.deviations.len()); self.blocks.len()];
        for (m, motion) in motions.iter().enumerate() {
            let (whitening, is_used) = (self.whitening(m), motion.is_used());
            for c in 0..3 {
                let white = |series: &[f64]| whitening.apply(series.iter().copied(), &is_used);
                let errors = white(&motion.missed[c]);
                let columns: Vec<Vec<f64>> = columns[m].iter().map(|column| white(&column[c])).collect();
                for (block, normal) in
                    self.blocks.iter().zip(&mut normals).filter(|(block, _)| block.motion == m)
                {
                    let part = |values: &[f64]| values[block.samples.clone()].to_vec();
                    let columns: Vec<Vec<f64>> = columns.iter().map(|column| part(column)).collect();
                    normal.add(&part(&errors), &columns);
                }
            }
        }
        normals
    }

    /// The parameters that fit all blocks but `held_out`.
    fn fit(&self, normals: &[GaussNewtonSystem], held_out: Option<usize>, weight: f64) -> Vec<f64> {
        let mut sum = GaussNewtonSystem::zeros(self.deviations.len());
        for (_, normal) in normals.iter().enumerate().filter(|(k, _)| Some(*k) != held_out) {
            sum.square += &normal.square;
            sum.right += &normal.right;
        }
        sum.solve(weight, &self.deviations, &self.bounds)
    }

    /// The weight of the prior with the least error on test blocks, whitened and to first order.
    fn choose_weight(&self, normals: &[GaussNewtonSystem]) -> f64 {
        let left = |weight: f64| -> f64 {
            let of_block = |(k, normal): (usize, &GaussNewtonSystem)| {
                let p = nalgebra::DVector::from_vec(self.fit(normals, Some(k), weight));
                2.0 * normal.right.dot(&p) + p.dot(&(&normal.square * &p))
            };
            normals.iter().enumerate().map(of_block).sum()
        };
        let better = |best: [f64; 2], &weight: &f64| {
            let sum = left(weight);
            if sum < best[1] { [weight, sum] } else { best }
        };
        WEIGHTS.iter().fold([WEIGHTS[0], f64::INFINITY], better)[0]
    }

    /// The linear correction that motions ask for, one after the other, but for a block; none where the design has
    /// none.
    fn correction(&self, motions: &[RolloutErrors], held_out: Option<&MotionBlock>) -> Option<Adaptation> {
        let ResidualDesign::Recurrent { features, .. } = &self.rig.model.design else { return None };
        let mut filter = AdaptationFilter::new(features, *self.options);
        for (m, motion) in motions.iter().enumerate() {
            let is_used = motion.is_used();
            let is_held_out =
                |i: usize| held_out.is_some_and(|block| block.motion == m && block.samples.contains(&i));
            for i in (0..is_used.len()).filter(|&i| is_used[i] && !is_held_out(i)) {
                filter.update(motion.terms_at(i), motion.missed_at(i));
            }
        }
        Some(filter.correction())
    }

    /// Evaluates all that may be kept on every block in turn.
    fn evaluate(&self, start: &Linearisation) -> Result<Option<TestEvaluation>> {
        let weight = self.choose_weight(&start.normals);
        let fits: Vec<Vec<f64>> =
            (0..self.blocks.len()).map(|k| self.fit(&start.normals, Some(k), weight)).collect();
        let task = |(block, p): (&MotionBlock, &Vec<f64>)| RolloutTask {
            motion: block.motion,
            n_samples: block.samples.end,
            change: self.change(p),
        };
        let tasks: Vec<RolloutTask> = self.blocks.iter().zip(&fits).map(task).collect();
        let Some(changed) = self.rig.roll(&tasks)? else { return Ok(None) };
        let drift = self.options.drift_m;
        let of_block = |k: usize| -> Vec<(AdaptedParts, Option<Squares>)> {
            let (block, p) = (&self.blocks[k], &fits[k]);
            // Errors on the training blocks under the change, to first order.
            let left: Vec<RolloutErrors> =
                start.motions.iter().zip(&start.columns).map(|(m, c)| moved(m, c, p)).collect();
            let corrections =
                [self.correction(&start.motions, Some(block)), self.correction(&left, Some(block))];
            let squares = |kept: AdaptedParts| {
                let rolled = if kept.has_change() { &changed[k] } else { &start.motions[block.motion] };
                let correction = corrections[usize::from(kept.has_change())].as_ref();
                match (kept.has_correction(), correction) {
                    (false, _) => Some(Squares::of(rolled, block, None, drift)),
                    (true, Some(correction)) => Some(Squares::of(rolled, block, Some(correction), drift)),
                    (true, None) => None,
                }
            };
            AdaptedParts::ALL.map(|kept| (kept, squares(kept))).into()
        };
        let all: Vec<Vec<_>> = parallel::map_indices(self.blocks.len(), of_block);
        let error = |number: usize| -> Option<f64> {
            let sum =
                all.iter().try_fold(Squares::default(), |sum, block| Some(sum.plus(block[number].1?)))?;
            Some(sum.root_mean())
        };
        let held_out_m: Vec<(AdaptedParts, f64)> = AdaptedParts::ALL
            .iter()
            .enumerate()
            .filter_map(|(number, kept)| Some((*kept, error(number)?)))
            .collect();
        let of_blocks = |kept: AdaptedParts| -> Vec<f64> {
            let number = AdaptedParts::ALL.iter().position(|parts| *parts == kept).unwrap_or(0);
            all.iter().filter_map(|block| Some(block[number].1?.root_mean())).collect()
        };
        let kept = self.decide(&held_out_m, &of_blocks);
        Ok(Some(TestEvaluation { kept, held_out_m, weight }))
    }

    /// Parts with a smaller error on test blocks than all with fewer numbers, by enough and beyond what blocks scatter.
    fn decide(
        &self,
        held_out_m: &[(AdaptedParts, f64)],
        of_blocks: &dyn Fn(AdaptedParts) -> Vec<f64>,
    ) -> AdaptedParts {
        let mut best = held_out_m[0];
        // A twin has errors of its own, which a change can make up for along these motions and make worse along others.
        let largest = (1.0 + self.options.least_gain) * self.known_error.unwrap_or(0.0);
        if best.1 <= largest {
            return AdaptedParts::Nothing;
        }
        for candidate in &held_out_m[1..] {
            let is_gain = candidate.1 < (1.0 - self.options.least_gain) * best.1;
            if is_gain && is_consistent(&of_blocks(best.0), &of_blocks(candidate.0)) {
                best = *candidate;
            }
        }
        best.0
    }

    /// Fits to all motion what is kept.
    fn finish(&self, start: &Linearisation, evaluated: TestEvaluation) -> Result<Option<Adapted>> {
        let n = self.deviations.len();
        let mut p = self.fit(&start.normals, None, evaluated.weight);
        let found = p.clone();
        let mut last = start.motions.clone();
        if evaluated.kept.has_change() {
            for round in 0..ROUNDS {
                let Some(rolled) = self.rig.roll(&self.whole(&p))? else { return Ok(None) };
                last = rolled;
                if round + 1 < ROUNDS {
                    // Errors as they are now, less what the parameters did to first order: as if from the beginning.
                    let back: Vec<f64> = p.iter().map(|p| -p).collect();
                    let from_start: Vec<RolloutErrors> = last
                        .iter()
                        .zip(&start.columns)
                        .map(|(motion, columns)| moved(motion, columns, &back))
                        .collect();
                    p = self.fit(&self.normals(&from_start, &start.columns), None, evaluated.weight);
                }
            }
        }
        let kept_p = if evaluated.kept.has_change() { p.clone() } else { vec![0.0; n] };
        let correction = evaluated.kept.has_correction().then(|| self.correction(&last, None)).flatten();
        let errors = |motion: usize, rolled: &RolloutErrors, correction: Option<&Adaptation>| {
            let whole = MotionBlock { motion, samples: 0..rolled.is_measured.len() };
            Squares::of(rolled, &whole, correction, 0.0).root_mean()
        };
        let motion_errors = |m: usize| MotionErrors {
            name: self.rig.motions[m].name.clone(),
            before_m: errors(m, &start.motions[m], None),
            after_m: errors(m, &last[m], correction.as_ref()),
            extrapolating: mean_of(&start.motions[m].is_extrapolating),
        };
        let motions = (0..last.len()).map(motion_errors).collect();
        let change = self.change(&kept_p);
        let before = self.rig.model.adaptation.as_ref();
        let model = ResidualModel {
            change: if change.is_none() { None } else { Some(change) },
            adaptation: correction.as_ref().map(|it| it.added_to(before)).or_else(|| before.cloned()),
            ..self.rig.model.clone()
        };
        let of_block = |block: &MotionBlock| {
            let motion = &self.rig.motions[block.motion];
            let ends = [block.samples.start, block.samples.end - 1].map(|i| motion.time[i]);
            (motion.name.clone(), ends)
        };
        let (n_primary, p) = (self.before.zeros_m.len(), if evaluated.kept.has_change() { p } else { found });
        Ok(Some(Adapted {
            model,
            kept: evaluated.kept,
            held_out_m: evaluated.held_out_m,
            known_error_m: self.known_error,
            blocks: self.blocks.iter().map(of_block).collect(),
            found: RobotChange {
                zeros_m: p[..n_primary].to_vec(),
                play_m: p[n_primary],
                friction_ratio: 1.0 + p.get(n_primary + 1).copied().unwrap_or(0.0),
            },
            prior_weight: evaluated.weight,
            motions,
        }))
    }
}

/// Error in validation of the networks that a model is the mean of [m]; none where it is not known.
fn validation_error(model: &ResidualModel) -> Option<f64> {
    let members = &model.training.members;
    let squares: f64 = members.iter().map(|member| (1e-3 * member.held_out_rmse_mm).powi(2)).sum();
    (!members.is_empty()).then(|| (squares / members.len() as f64).sqrt())
}

/// Errors of a motion when the parameters move by `p`, to first order.
fn moved(motion: &RolloutErrors, columns: &[[Vec<f64>; 3]], p: &[f64]) -> RolloutErrors {
    let mut moved = motion.clone();
    for (column, p) in columns.iter().zip(p) {
        for (series, column) in moved.missed.iter_mut().zip(column) {
            series.iter_mut().zip(column).for_each(|(missed, slope)| *missed += p * slope);
        }
    }
    moved
}

/// Whether errors fall from block to block by more than chance would have it: the mean of ln(before / after) is above its
/// standard error [`SIGNIFICANT`] times.
fn is_consistent(before: &[f64], after: &[f64]) -> bool {
    let gains: Vec<f64> = before.iter().zip(after).map(|(before, after)| (before / after).ln()).collect();
    let n = gains.len() as f64;
    let mean = gains.iter().sum::<f64>() / n;
    let variance = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / (n - 1.0);
    mean > SIGNIFICANT * (variance / n).sqrt()
}

fn mean_of(flags: &[bool]) -> f64 {
    flags.iter().filter(|flag| **flag).count() as f64 / flags.len().max(1) as f64
}

/// Squared distances of the tip, and how many.
#[derive(Debug, Clone, Copy, Default)]
struct Squares {
    sum: f64,
    count: f64,
}

impl Squares {
    /// Of a block, less a correction, and less a mean along each axis of up to `drift` [m]: a tracker that is
    /// off by that much for the whole of a block carries no information on the robot.
    fn of(rolled: &RolloutErrors, block: &MotionBlock, correction: Option<&Adaptation>, drift: f64) -> Self {
        let left = |i: usize| -> [f64; 3] {
            let correction_at = correction.map_or([0.0; 3], |it| it.displacement(rolled.terms_at(i)));
            let missed = rolled.missed_at(i);
            std::array::from_fn(|c| missed[c] - correction_at[c])
        };
        let errors: Vec<[f64; 3]> =
            block.samples.clone().filter(|&i| rolled.is_measured[i]).map(left).collect();
        let count = errors.len() as f64;
        let aside: [f64; 3] = std::array::from_fn(|c| {
            let mean = errors.iter().map(|error| error[c]).sum::<f64>() / count.max(1.0);
            mean.clamp(-drift, drift)
        });
        let square = |error: &[f64; 3]| (0..3).map(|c| (error[c] - aside[c]).powi(2)).sum::<f64>();
        Self { sum: errors.iter().map(square).sum(), count }
    }

    fn plus(self, other: Self) -> Self {
        Self { sum: self.sum + other.sum, count: self.count + other.count }
    }

    fn root_mean(self) -> f64 {
        (self.sum / self.count.max(1.0)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gain_on_one_motion_and_a_loss_on_another_is_chance() {
        assert!(is_consistent(&[1.0, 1.2, 0.9], &[0.6, 0.8, 0.5]));
        // Better in the mean of the squares by far more than a tenth, and worse on two of three motions.
        assert!(!is_consistent(&[2.0, 0.5, 0.5], &[1.0, 0.7, 0.6]));
        // Two motions tell where they agree.
        assert!(is_consistent(&[1.0, 1.0], &[0.7, 0.65]));
        assert!(!is_consistent(&[1.0, 1.0], &[0.95, 0.5]));
        assert!(!is_consistent(&[1.0, 1.0], &[1.0, 1.0]));
    }
}
