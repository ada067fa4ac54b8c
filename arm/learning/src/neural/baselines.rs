//! Baselines of a learned actuator.

use hysteron_base::{BadInput, Bounds};
use hysteron_fit::{Options, Parameter, ParameterScale, least_squares};
use hysteron_learn::ridge::NormalEquations;
use serde::{Deserialize, Serialize};

use super::current::PENALTY;
use super::data::{Trajectory, usual_gain};
use super::features::FeatureLayout;
use super::heat::WindingTemperatures;
use super::loss::wrap;
use super::motors::Motors;
use super::segment::Segment;
use super::servo::{MAX_LOAD_FRICTION, RolloutServo};
use super::simulation::{ArmSimulation, MotorCommand, SimulationOptions};
use hysteron_arm_dynamics::{Data, Model, gravity_torque};

/// A guess of all motors' positions at every row (rows × m) [rad].
pub type Positions = Vec<f64>;

/// The goal itself.
pub fn copied_goal(features: &FeatureLayout, trajectory: &Trajectory) -> Positions {
    let m = features.motors();
    trajectory.inputs.chunks_exact(features.len()).flat_map(|row| &row[..m]).copied().collect()
}

/// Positions as recorded (rows × m).
pub(super) fn positions_of(features: &FeatureLayout, trajectory: &Trajectory) -> Positions {
    let m = features.motors();
    trajectory.states.chunks_exact(2 * m).flat_map(|state| &state[..m]).copied().collect()
}

/// The goal later, smoother and lower: of each motor a delay, a first-order lag, and a line over the gravity torque at the goal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FirstOrderServo {
    /// For each motor, delay [rows] and part of the way to the goal that a row goes.
    pub lag: Vec<(usize, f64)>,
    /// For each motor, droop per gravity torque [rad/(N m)] and at zero [rad].
    pub droop: Vec<[f64; 2]>,
    /// Gain of the position loops for which the droop per torque holds, as the register has it; none where recordings have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_gain: Option<f64>,
}

/// Longest delay tried [rows].
const MAX_DELAY: usize = 10;
/// Parts of the way that are tried.
const LAGS: [f64; 6] = [1.0, 0.8, 0.6, 0.45, 0.3, 0.2];

impl FirstOrderServo {
    /// Fits lag on a grid and droop by least squares to all trajectories.
    ///
    /// # Errors
    /// `BadInput` where there is no row.
    pub fn fit(
        model: &Model,
        features: &FeatureLayout,
        trajectories: &[Trajectory],
    ) -> Result<Self, BadInput> {
        if trajectories.is_empty() {
            return Err(BadInput::new("recordings", "one or more", "none"));
        }
        let m = features.motors();
        let goals: Vec<Positions> = trajectories.iter().map(|one| copied_goal(features, one)).collect();
        let position_gain = usual_gain(trajectories)?;
        let pulled = |(one, goals): (&Trajectory, &Positions)| {
            pull_at(model, features, (goals, one.gain_over(position_gain)))
        };
        let gravity: Vec<Vec<f64>> = trajectories.iter().zip(&goals).map(pulled).collect();
        let mut fitted = Self { lag: vec![(0, 1.0); m], droop: vec![[0.0; 2]; m], position_gain };
        for motor in 0..m {
            let mut best = f64::INFINITY;
            for lag in (0..=MAX_DELAY).flat_map(|delay| LAGS.map(|part| (delay, part))) {
                let mut normal = NormalEquations::new(2, 1);
                let mut square = 0.0;
                for (one, (goals, gravity)) in trajectories.iter().zip(goals.iter().zip(&gravity)) {
                    let lagged = lagged(goals, m, motor, lag, one.state_at(0)[motor]);
                    let off: Vec<f64> =
                        lagged.iter().enumerate().map(|(i, goal)| one.state_at(i)[motor] - goal).collect();
                    let known: Vec<f64> =
                        gravity.iter().skip(motor).step_by(m).flat_map(|gravity| [*gravity, 1.0]).collect();
                    normal.add(&known, &off);
                    square += off.iter().map(|off| off * off).sum::<f64>();
                }
                let found = normal.solve(PENALTY);
                // What is left of a least-squares fit: |y|² − w·Xᵀy.
                let left = square - found.iter().zip(normal.moments()).map(|(w, m)| w * m).sum::<f64>();
                if left < best {
                    best = left;
                    (fitted.lag[motor], fitted.droop[motor]) = (lag, [found[0], found[1]]);
                }
            }
        }
        Ok(fitted)
    }

    /// Positions along a trajectory.
    pub fn positions(&self, model: &Model, features: &FeatureLayout, trajectory: &Trajectory) -> Positions {
        let m = features.motors();
        let goals = copied_goal(features, trajectory);
        let gravity = pull_at(model, features, (&goals, trajectory.gain_over(self.position_gain)));
        let mut all = vec![0.0; goals.len()];
        for motor in 0..m {
            let [per, zero] = self.droop[motor];
            let path = lagged(&goals, m, motor, self.lag[motor], trajectory.state_at(0)[motor]);
            for (i, position) in path.into_iter().enumerate() {
                all[i * m + motor] = position + per * gravity[i * m + motor] + zero;
            }
        }
        all
    }
}

/// The goal of one motor, delayed and smoothed from `first` on.
fn lagged(goals: &[f64], m: usize, motor: usize, (delay, part): (usize, f64), first: f64) -> Vec<f64> {
    let mut now = first;
    (0..goals.len() / m)
        .map(|i| {
            now += part * (goals[i.saturating_sub(delay) * m + motor] - now);
            now
        })
        .collect()
}

/// Gravity torque at every row of positions over the gain that it is held with (rows × m).
fn pull_at(model: &Model, features: &FeatureLayout, (positions, gain): (&[f64], f64)) -> Vec<f64> {
    gravity_at(model, features, positions).into_iter().map(|torque| torque / gain).collect()
}

/// Gravity torque at every row of positions (rows × m); zero for motors that are no joints.
pub(super) fn gravity_at(model: &Model, features: &FeatureLayout, positions: &[f64]) -> Vec<f64> {
    let (m, n) = (features.motors(), features.joints);
    let mut data = Data::new(model, 0.0);
    let mut all = vec![0.0; positions.len()];
    for (row, to) in positions.chunks_exact(m).zip(all.chunks_exact_mut(m)) {
        gravity_torque(model, &mut data, &row[..n], &mut to[..n]);
    }
    all
}

/// Trajectories and rows that the servo is fitted to.
const FITTED: (usize, usize) = (16, 200);

impl RolloutServo {
    /// Fits stiffness, friction and damping of these motors so that rollouts stay close to the trajectories, with `model` as the arm. The
    /// search begins, and has its bounds, in proportion to their armature.
    ///
    /// # Errors
    /// Those of the simulation and of the fit.
    pub fn fit(
        model: &Model,
        (features, period, motors): (&FeatureLayout, f64, &Motors),
        trajectories: &[Trajectory],
        watch: &(dyn Fn(usize, f64) -> bool + Sync),
    ) -> Result<Self, BadInput> {
        let every = trajectories.len().div_ceil(FITTED.0).max(1);
        let segments: Vec<Segment<'_>> =
            trajectories.iter().step_by(every).map(|trajectory| Segment::recorded(trajectory, 0)).collect();
        let horizon = segments.iter().map(|one| one.trajectory.len() - 1).min().unwrap_or(0).min(FITTED.1);
        let m = features.motors();
        let position_gain = usual_gain(trajectories)?;
        let of = |values: &[f64]| Self {
            stiffness: values[..m].to_vec(),
            friction: values[m..2 * m].to_vec(),
            damping: values[2 * m],
            load_friction: values[2 * m + 1..].to_vec(),
            rms: 0.0,
            holds: true,
            motors: *motors,
            position_gain,
        };
        let residuals = |values: &[f64]| -> Result<Vec<Vec<f64>>, BadInput> {
            let states = of(values).run(model, (features, period), &segments, horizon)?;
            let off = |(i, state): (usize, &[f64])| -> Vec<f64> {
                let Segment { trajectory, start, .. } = segments[i % segments.len()];
                let measured = trajectory.state_at(start + i / segments.len());
                (0..m).map(|k| wrap(state[k] - measured[k])).collect()
            };
            Ok(vec![states.chunks_exact(2 * m).enumerate().flat_map(off).collect()])
        };
        let search =
            Options { huber: Some(0.05), smallest_effect: 1e-6, n_nuisance: 0, tolerance: 1e-3, watch };
        let values = least_squares(&parameters(m, motors), &search, residuals)?.values();
        let all = residuals(&values)?;
        let n = all[0].len().max(1) as f64;
        let rms = (all[0].iter().map(|r| r * r).sum::<f64>() / n).sqrt();
        Ok(Self { rms, ..of(&values) })
    }

    /// States along `segments` ((horizon + 1) × trajectories × 2m), from the recorded ones at their beginnings; goals are the only
    /// thing that recordings give.
    ///
    /// # Errors
    /// Those of the simulation.
    pub fn run(
        &self,
        model: &Model,
        (features, period): (&FeatureLayout, f64),
        segments: &[Segment<'_>],
        horizon: usize,
    ) -> Result<Vec<f64>, BadInput> {
        let simulation = ArmSimulation::new(model, features, &SimulationOptions::with_servo(self, period))?;
        Ok(run_alone(&simulation, segments, horizon))
    }
}

/// States along `segments` ((horizon + 1) × trajectories × 2m), from the recorded ones at their beginnings, where no network adds to the servo
/// or drive of the simulation; goals are the only thing that recordings give.
pub(super) fn run_alone(simulation: &ArmSimulation, segments: &[Segment<'_>], horizon: usize) -> Vec<f64> {
    let (options, features) = (simulation.options(), simulation.features());
    let (m, rows) = (features.motors(), segments.len());
    let width = rows * 2 * m;
    let mut states: Vec<f64> =
        segments.iter().flat_map(|one| one.trajectory.state_at(one.start)).copied().collect();
    let (mut next, alone) = (vec![0.0; width], vec![0.0; rows * m]);
    let gains: Vec<f64> =
        segments.iter().map(|one| one.trajectory.gain_over(options.position_gain())).collect();
    let mut heat = WindingTemperatures::new(options, features, segments);
    for step in 0..horizon {
        let goals: Vec<f64> = segments.iter().flat_map(|one| one.goals(step, m)).copied().collect();
        heat.begin(step);
        let now = &states[step * width..];
        let command = MotorCommand { goals: &goals, gains: &gains, windings: heat.at(step), torques: &alone };
        simulation.step(now, command, &mut next);
        heat.pass(now, [&goals, &gains]);
        states.extend_from_slice(&next);
    }
    states
}

/// Stiffness and friction of `m` motors, and their damping, with bounds in proportion to the armature; then the growth of friction, where
/// it is asked for.
fn parameters(m: usize, motors: &Motors) -> Vec<Parameter> {
    let size = motors.size();
    let parameter = |name: String, start: f64, min: f64, max: f64| Parameter {
        name,
        start: size * start,
        bounds: Bounds { min: size * min, max: size * max },
        scale: ParameterScale::Logarithmic,
        prior: None,
    };
    let stiffness = (0..m).map(|k| parameter(format!("stiffness {}", k + 1), 15.0, 1.0, 100.0));
    let friction = (0..m).map(|k| parameter(format!("friction {}", k + 1), 0.1, 1e-3, 2.0));
    let damping = std::iter::once(parameter("damping".to_owned(), 1.0, 0.05, 10.0));
    let share = |k: usize| Parameter {
        name: format!("load friction {}", k + 1),
        start: 0.05,
        bounds: Bounds { min: 0.0, max: MAX_LOAD_FRICTION },
        scale: ParameterScale::Linear,
        prior: None,
    };
    let shares = (0..if motors.load_friction { m } else { 0 }).map(share);
    stiffness.chain(friction).chain(damping).chain(shares).collect()
}
