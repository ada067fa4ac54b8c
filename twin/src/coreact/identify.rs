//! Identification: sample by sample, the auxiliary strokes that bring the twin's tip to the measured one.

use hysteron_base::{BadInput, Bounds, Channel, Metadata, Recording, json};
use nalgebra::{DVector, UnitQuaternion, Vector3};

use super::problem::{AuxiliaryProblem, LinearisedTip, SampleSolution, WeightedSample, allowed, bound_of};
use super::sensitivity::sensitivity;
use super::{AuxiliaryLimits, Bound, DistanceSummary, IdentificationSummary};
use crate::friction_points::FrictionPoints;
use crate::model::{Target, Twin};
use crate::motion::RobotMotion;
use crate::plant::{PhysicsTwin, Plant};
use crate::report::StepReport;
use crate::solver::TipMotion;
use crate::stepper::{FrictionMemory, Stepper};
use crate::{Error, Result, TwinState};
use hysteron_fit::qp::{BoxedRows, QpStatus, RowQp};

/// How strokes are chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IdentifyOptions {
    /// γ of eq. 8 over the mean squared sensitivity of the tip to a stroke [-].
    pub regularisation: f64,
    /// Weight of a radian between twin and robot, compared with a metre [m]; `None` leaves orientations
    /// alone.
    pub orientation: Option<f64>,
    /// Rounds of a sample at most: one, and more where the tip is then elsewhere than the linearised twin
    /// predicted.
    pub rounds: usize,
    /// Distance of the two that needs no further round [m].
    pub tolerance: f64,
}

impl Default for IdentifyOptions {
    fn default() -> Self {
        Self { regularisation: 1e-4, orientation: None, rounds: 2, tolerance: 1e-5 }
    }
}

/// Where the tip was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TipMeasurement {
    /// Position [m].
    pub position: [f64; 3],
    /// Rotation since rest.
    pub orientation: Option<UnitQuaternion<f64>>,
}

/// Result of a sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct IdentifiedSample {
    /// Tip of the body [m].
    pub tip: [f64; 3],
    /// Distance from the goal of the tip that the twin reports [m]; zero without one.
    pub distance: f64,
    /// Status of each QP.
    pub statuses: Vec<QpStatus>,
    /// The active bound of each auxiliary stroke, if any (n_aux).
    pub bounds: Vec<Option<Bound>>,
    /// How far a chain was bent beyond what was validated, see [`StepReport::outside`] [-].
    pub outside: f64,
}

/// A twin that chooses the strokes of its auxiliary tendons sample by sample: to follow measurements, or as a
/// network predicts.
pub trait AuxiliaryPolicy {
    /// Goes on by one sample of `duration` [s]: primary tendons to their strokes (n_primary) [m], auxiliary ones as
    /// chosen. Without a goal nothing was measured.
    ///
    /// # Errors
    /// Those of [`Stepper::step`].
    fn step(
        &mut self,
        primary: &[f64],
        goal: Option<&TipMeasurement>,
        duration: f64,
    ) -> Result<IdentifiedSample>;

    /// Auxiliary strokes now (n_aux) [m].
    fn strokes(&self) -> &[f64];

    /// ∂tip/∂s at the present equilibrium (3 × n_aux, row by row) [-], taut tendons held at their strokes, friction
    /// points slipping.
    fn sensitivity(&mut self) -> Option<[Vec<f64>; 3]>;
}

/// A twin that follows measurements by its auxiliary tendons.
#[derive(Debug)]
pub struct Identifier<'a> {
    twin: &'a Twin,
    auxiliary: &'a AuxiliaryLimits,
    options: IdentifyOptions,
    stepper: Stepper,
    /// Auxiliary strokes now (n_aux) [m].
    strokes: Vec<f64>,
    targets: Vec<Target>,
    /// Length that makes QPs dimensionless: a thousandth of the longest tendon [m].
    length: f64,
    /// Friction and backlash at the sample before: every round of a sample starts from there.
    memory: FrictionMemory,
    problem: AuxiliaryProblem,
}

impl<'a> Identifier<'a> {
    /// Starts from rest, all auxiliary strokes zero.
    pub fn new(twin: &'a Twin, auxiliary: &'a AuxiliaryLimits, options: IdentifyOptions) -> Self {
        Self {
            twin,
            auxiliary,
            options,
            stepper: Stepper::new(twin),
            strokes: vec![0.0; auxiliary.len()],
            targets: Vec::new(),
            length: 1e-3 * twin.cables.longest(),
            memory: FrictionMemory::default(),
            problem: AuxiliaryProblem::new(twin),
        }
    }

    /// Where the twin is now.
    pub fn state(&self) -> &TwinState {
        self.stepper.state()
    }

    /// The QP that was solved last.
    pub fn last_qp(&self) -> Option<RowQp> {
        self.problem.last.as_ref().map(BoxedRows::to_row_qp)
    }

    /// ∂tip/∂s at the present equilibrium (3 × n_aux, row by row) [-], tendons that are taut held at their strokes.
    pub fn sensitivity_where(&mut self, friction: FrictionPoints) -> Option<[Vec<f64>; 3]> {
        sensitivity(&mut self.stepper, self.twin, self.auxiliary, friction)
    }

    fn balance(&mut self, primary: &[f64]) -> Result<StepReport> {
        self.auxiliary.targets_into(primary, &self.strokes, &mut self.targets);
        self.stepper.step_again(self.twin, &self.targets, &self.memory)
    }

    /// The auxiliary strokes for this sample, by the twin linearised where it is now; `None` where there is no
    /// stiffness to linearise.
    fn solve(
        &mut self,
        primary: &[f64],
        goal: &TipMeasurement,
        allowed: &[Bounds],
    ) -> Option<SampleSolution> {
        let weight = self.weight(goal);
        let tip = weight.map_or(TipMotion::Displacement, |_| TipMotion::Pose);
        let error = self.error(goal);
        self.auxiliary.targets_into(primary, &self.strokes, &mut self.targets);
        let conditions = self.stepper.conditions(self.twin, &self.targets, &self.memory, tip)?;
        self.problem.set_conditions(self.twin, &conditions);
        let at = LinearisedTip::new(self.twin, self.auxiliary, &conditions.response, weight);
        let sample = WeightedSample {
            error: &error,
            strokes: &self.strokes,
            allowed,
            regularisation: self.options.regularisation,
            length: self.length,
        };
        self.problem.solve(&at, &sample)
    }

    /// From the tip to the goal, as the rows of [`LinearisedTip`].
    fn error(&self, goal: &TipMeasurement) -> Vec<f64> {
        let tip = self.twin.tip_of(self.state());
        let mut error: Vec<f64> = (0..3).map(|c| goal.position[c] - tip[c]).collect();
        if let (Some(weight), Some(orientation)) = (self.weight(goal), goal.orientation) {
            let turn = orientation * self.twin.tip_rotation_of(self.state()).inverse();
            error.extend((weight * turn.scaled_axis()).iter());
        }
        error
    }

    /// Weight of a radian [m], where the orientation counts.
    fn weight(&self, goal: &TipMeasurement) -> Option<f64> {
        self.options.orientation.filter(|_| goal.orientation.is_some())
    }

    fn distance(&self, goal: &TipMeasurement) -> f64 {
        distance(goal.position, self.twin.tip_of(self.state()))
    }
}

impl AuxiliaryPolicy for Identifier<'_> {
    fn step(
        &mut self,
        primary: &[f64],
        goal: Option<&TipMeasurement>,
        duration: f64,
    ) -> Result<IdentifiedSample> {
        let mut done = IdentifiedSample::default();
        let allowed = allowed(self.auxiliary, &self.strokes, duration);
        self.stepper.memory_into(&mut self.memory);
        // At rest nothing is in balance yet: there is nothing to linearise.
        let rounds = if self.state().load == 1.0 { self.options.rounds } else { 0 };
        if let Some(goal) = goal {
            for round in 0..rounds {
                let found = self.solve(primary, goal, &allowed);
                done.statuses.push(found.as_ref().map_or(QpStatus::Failed, |answer| answer.status));
                let Some(answer) = found.filter(|answer| answer.status == QpStatus::Solved) else { break };
                self.strokes = answer.strokes;
                done.outside = self.balance(primary)?.outside;
                if round + 1 == rounds
                    || (DVector::from_vec(self.error(goal)) - answer.left).norm() <= self.options.tolerance
                {
                    break;
                }
            }
        }
        if done.statuses.first() != Some(&QpStatus::Solved) {
            done.outside = self.balance(primary)?.outside;
        }
        let strokes = self.strokes.iter().zip(&allowed).zip(&self.auxiliary.bounds);
        done.bounds = strokes
            .map(|((stroke, allowed), whole)| bound_of(*stroke, allowed, whole, self.length))
            .collect();
        done.tip = self.twin.tip_of(self.state());
        done.distance = goal.map_or(0.0, |goal| self.distance(goal));
        Ok(done)
    }

    fn strokes(&self) -> &[f64] {
        &self.strokes
    }

    fn sensitivity(&mut self) -> Option<[Vec<f64>; 3]> {
        self.sensitivity_where(FrictionPoints::Slipping)
    }
}

pub(crate) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (Vector3::from(a) - Vector3::from(b)).norm()
}

/// Samples between two rows of sensitivities: they change with the shape, slowly.
const SENSITIVITY_EVERY: usize = 5;

/// An identified recording.
#[derive(Debug, Clone)]
pub struct AuxiliaryIdentification {
    /// Strokes and measured tip as they came, `aux_kk_m` (s*), the twin's tip with them, `twin_x_m`.., and without,
    /// `bare_x_m`..
    pub recording: Recording,
    /// ∂tip/∂s*, `sensitivity_x_kk_ratio`.. [-], every 5th sample.
    pub sensitivities: Recording,
    /// Counts and residuals.
    pub summary: IdentificationSummary,
}

/// Takes `policy`, which is at rest, through all samples of a motion. `on_sample` is called after each and ends the
/// run where it returns false.
///
/// # Errors
/// Those of [`Stepper::step`], with the row; `Ok(None)` where `on_sample` ended it.
pub fn identify(
    twin: &Twin,
    policy: &mut dyn AuxiliaryPolicy,
    motion: &RobotMotion,
    mut meta: Metadata,
    on_sample: &mut dyn FnMut() -> bool,
) -> Result<Option<AuxiliaryIdentification>> {
    let n = motion.len();
    let n_aux = policy.strokes().len();
    let mut uncorrected = PhysicsTwin::new(twin);
    let mut summary = IdentificationSummary { samples: n, ..IdentificationSummary::default() };
    let (mut before, mut after) = (Vec::with_capacity(n), Vec::with_capacity(n));
    let mut columns = ResultColumns::default();
    let mut sensitivities = ResultColumns::default();
    for i in 0..n {
        let primary = motion.strokes_at(i);
        let orientation = motion.orientations.as_ref().map(|orientations| orientations[i]);
        let goal = (!motion.gap[i]).then_some(TipMeasurement { position: motion.tips[i], orientation });
        let step = policy.step(primary, goal.as_ref(), motion.step).map_err(|error| in_row(i, error))?;
        let without = uncorrected.step(primary).map_err(|error| in_row(i, error))?.tip;
        if let Some(goal) = goal {
            after.push(step.distance);
            before.push(distance(goal.position, without));
        } else {
            summary.gaps += 1;
        }
        step.statuses.iter().for_each(|status| summary.count_status(*status));
        summary.count_bounds(&step.bounds);
        summary.samples_outside_validation += usize::from(step.outside > 0.0);
        columns.push(
            primary.iter().chain(&motion.tips[i]).chain(policy.strokes()).chain(&step.tip).chain(&without),
        );
        if i % SENSITIVITY_EVERY == 0 {
            let rows = policy.sensitivity().ok_or_else(|| singular(i))?;
            sensitivities.push(rows.iter().flatten());
        }
        if !on_sample() {
            return Ok(None);
        }
    }
    summary.before = DistanceSummary::of(before);
    summary.after = DistanceSummary::of(after);
    summary.share_at_bound = summary.share_at_bound.map(|count| count / (n * n_aux) as f64);
    let summary_json = json::to_line(&summary).unwrap_or_default();
    meta.extra.insert("identify.summary".to_owned(), summary_json);
    let time = |every: usize| (0..n).step_by(every).map(|i| i as f64 * motion.step).collect::<Vec<f64>>();
    let recording =
        columns.into_recording(time(1), names(twin.n_primary, n_aux), motion.gap.clone(), meta.clone())?;
    let sensitivities =
        sensitivities.into_recording(time(SENSITIVITY_EVERY), sensitivity_names(n_aux), Vec::new(), meta)?;
    Ok(Some(AuxiliaryIdentification { recording, sensitivities, summary }))
}

/// Rows that become channels.
#[derive(Debug, Default)]
struct ResultColumns {
    values: Vec<Vec<f64>>,
}

impl ResultColumns {
    fn push<'a>(&mut self, row: impl Iterator<Item = &'a f64>) {
        for (k, value) in row.enumerate() {
            if self.values.len() == k {
                self.values.push(Vec::new());
            }
            self.values[k].push(*value);
        }
    }

    fn into_recording(
        self,
        time: Vec<f64>,
        names: Vec<String>,
        gap: Vec<bool>,
        meta: Metadata,
    ) -> Result<Recording> {
        let channels = names.into_iter().zip(self.values).map(|(name, values)| Channel::new(name, values));
        Ok(Recording::new(time, channels.collect(), gap, meta)?)
    }
}

fn names(n_primary: usize, n_aux: usize) -> Vec<String> {
    let axes = |of: &'static str| ["x", "y", "z"].map(|axis| format!("{of}_{axis}_m"));
    let strokes = (1..=n_primary).map(|k| format!("stroke_{k}_m"));
    let aux = (1..=n_aux).map(|k| format!("aux_{k:02}_m"));
    strokes.chain(axes("tip")).chain(aux).chain(axes("twin")).chain(axes("bare")).collect()
}

fn sensitivity_names(n_aux: usize) -> Vec<String> {
    let row =
        |axis: &str| (1..=n_aux).map(|k| format!("sensitivity_{axis}_{k:02}_ratio")).collect::<Vec<_>>();
    ["x", "y", "z"].into_iter().flat_map(row).collect()
}

fn in_row(row: usize, error: Error) -> Error {
    match error {
        Error::BadInput(bad) => bad.within(format!("row {}", row + 1)).into(),
        Error::NoEquilibrium { reached, relative_residual, cause, hint } => {
            let hint = format!("row {}: {hint}", row + 1);
            Error::NoEquilibrium { reached, relative_residual, cause, hint }
        }
        other => other,
    }
}

fn singular(row: usize) -> Error {
    BadInput::new(format!("row {}", row + 1), "tendons that pull differently", "two that pull the same way")
        .into()
}
