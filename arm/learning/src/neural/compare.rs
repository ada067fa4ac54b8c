//! `BaselineComparison`: an actuator compared with its baselines on trajectories that it was not trained on.

use hysteron_base::{BadInput, parallel};

use super::actuator::NeuralActuator;
use super::baselines::{Positions, copied_goal, positions_of, run_alone};
use super::comparison_scores::{
    ActuatorComparison, ByHorizon, ByMethod, ComparisonFormat, ForceSource, ForcesBySource, METHODS,
    TaskScores, TaskTrace,
};
use super::condition::{ConditionEstimate, DetectorScores, detectors};
use super::data::Trajectory;
use super::details::Baselines;
use super::evaluate::{ArmRollout, PoseScores, condition_scores, force_scores, pose_scores, roll_out};
use super::loss::length;
use super::observations::telemetry;
use super::segment::{Segment, TelemetrySource};
use super::sensing::{SensedTrajectory, Sensing};
use super::simulation::{ArmSimulation, SimulationOptions};
use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::servo_force::BaselineObservers;

/// One task: its trajectories, the positions of every method, and the network's other outputs.
struct ComparedTask {
    name: String,
    trajectories: Vec<Trajectory>,
    positions: Vec<Vec<Positions>>,
    rollouts: Vec<ArmRollout>,
    pure: Vec<ArmRollout>,
    /// Of the network of labels, where there is one.
    sensed: Option<Vec<SensedTrajectory>>,
    /// Forces of either momentum observer, trajectory by trajectory; none where none was identified.
    observed: Option<Vec<[Vec<[f64; 3]>; 2]>>,
}

impl ComparedTask {
    /// Forces and gates of the network, of either observer, and of the network in pure simulation if it has such outputs.
    fn forces(&self, contact: [f64; 2]) -> [Option<Vec<ForceEstimates>>; 4] {
        let of = |rollouts: &[ArmRollout]| {
            rollouts.iter().map(|one| (one.force.clone(), one.gate.clone())).collect()
        };
        let network = self.sensed.as_ref().map(|all| {
            all.iter().map(|one| (one.force.clone(), one.gate.clone())).collect::<Vec<ForceEstimates>>()
        });
        let observer = |k: usize| -> Option<Vec<ForceEstimates>> {
            let gate = |f: &[f64; 3]| f64::from(u8::from(length(f) > contact[k]));
            let one = |own: &[Vec<[f64; 3]>; 2]| (own[k].clone(), own[k].iter().map(gate).collect());
            Some(self.observed.as_ref()?.iter().map(one).collect())
        };
        let pure = self.sensed.is_none().then(|| of(&self.pure));
        [Some(network.unwrap_or_else(|| of(&self.rollouts))), observer(0), observer(1), pure]
    }

    /// How healthy the watched motor is found, sample by sample.
    fn conditions(&self) -> Vec<ConditionEstimate> {
        match &self.sensed {
            Some(all) => all.iter().map(ConditionEstimate::of).collect(),
            None => self.rollouts.iter().map(estimates).collect(),
        }
    }
}

/// Condition estimate of the watched motor by a rollout.
fn estimates(rollout: &ArmRollout) -> ConditionEstimate {
    ConditionEstimate { network: rollout.condition.clone(), ..ConditionEstimate::default() }
}

/// Forces and probabilities of contact, row by row.
type ForceEstimates = (Vec<[f64; 3]>, Vec<f64>);

/// An actuator and its baselines on the trajectories of some tasks.
pub struct BaselineComparison<'a> {
    actuator: &'a NeuralActuator,
    model: &'a Model,
    simulation: ArmSimulation,
    /// The arm as the baselines know it: without the payload that an adaptation has identified.
    without_payload: ArmSimulation,
    baselines: Baselines,
    tasks: Vec<ComparedTask>,
}

/// Checks the output of a method for a trajectory, `n` values of a quantity a sample.
///
/// # Errors
/// `BadInput` naming the first sample where it is not finite.
fn check_finite(
    trajectory: &Trajectory,
    method: &str,
    (quantity, n): (&str, usize),
    values: &[f64],
) -> Result<(), BadInput> {
    let Some(k) = values.iter().position(|value| !value.is_finite()) else { return Ok(()) };
    let number = if n > 1 { format!(" {}", k % n + 1) } else { String::new() };
    let place = format!("{}: sample {}: {quantity}{number}", trajectory.name, k / n + 1);
    Err(BadInput::new(place, format!("a finite number from the method \"{method}\""), values[k].to_string())
        .hint("the model diverges on this recording: train it again, or compare over motion like that of its training"))
}

impl<'a> BaselineComparison<'a> {
    /// Of an actuator for `model`, with no task yet.
    ///
    /// # Errors
    /// `BadInput` for another arm, or an actuator without baselines.
    pub fn new(actuator: &'a NeuralActuator, model: &'a Model) -> Result<Self, BadInput> {
        let (simulation, baselines) = (actuator.simulation(model)?, Baselines::of(actuator)?);
        let options = SimulationOptions { payload: 0.0, ..actuator.simulation.clone() };
        let without_payload = ArmSimulation::new(model, &actuator.features, &options)?;
        Ok(Self { actuator, model, simulation, without_payload, baselines, tasks: Vec::new() })
    }

    /// Adds the trajectories of a task.
    ///
    /// # Errors
    /// `BadInput` where they lack what a method needs.
    pub fn add(&mut self, name: String, trajectories: Vec<Trajectory>) -> Result<(), BadInput> {
        let Self { actuator, model, simulation, .. } = self;
        for one in &trajectories {
            actuator.simulation.check_gain(&one.name, one.position_gain)?;
        }
        let features = &actuator.features;
        let m = features.motors();
        let roll = |telemetry: TelemetrySource<'_>| -> Vec<ArmRollout> {
            parallel::map(&trajectories, |one| roll_out(actuator, simulation, one, telemetry))
        };
        let rollouts = roll(TelemetrySource::Recorded);
        let pure = roll(TelemetrySource::Modelled(&actuator.currents));
        let servo = |trajectory: &Trajectory| -> Result<Positions, BadInput> {
            let segment = Segment::recorded(trajectory, 0);
            let (about, horizon) = ((features, actuator.simulation.period), trajectory.len() - 1);
            let states = match &actuator.simulation.drive {
                Some(_) => run_alone(&self.without_payload, &[segment], horizon),
                None => self.baselines.servo.run(model, about, &[segment], horizon)?,
            };
            Ok(states.chunks_exact(2 * m).flat_map(|state| &state[..m]).copied().collect())
        };
        let positions = vec![
            rollouts.iter().map(|one| one.positions.clone()).collect(),
            pure.iter().map(|one| one.positions.clone()).collect(),
            trajectories.iter().map(|one| copied_goal(features, one)).collect(),
            trajectories
                .iter()
                .map(|one| self.baselines.lag.positions(self.without_payload.model(), features, one))
                .collect(),
            parallel::try_map(&trajectories, servo)?,
        ];
        for (method, of_method) in METHODS.iter().zip(&positions) {
            for (one, values) in trajectories.iter().zip(of_method) {
                check_finite(one, method, ("position of motor", m), values)?;
            }
        }
        for (one, rollout) in trajectories.iter().chain(&trajectories).zip(rollouts.iter().chain(&pure)) {
            check_finite(one, METHODS[0], ("force on axis", 3), rollout.force.as_flattened())?;
            check_finite(one, METHODS[0], ("probability", 1), &rollout.gate)?;
            check_finite(one, METHODS[0], ("probability", 1), &rollout.condition)?;
        }
        let about = (features, actuator.simulation.period);
        let arm = actuator.observed_arm(self.model);
        let along = |sensing: &Sensing| -> Result<Vec<SensedTrajectory>, BadInput> {
            let arm = arm.clone()?;
            parallel::try_map(&trajectories, |one| sensing.along(&arm, about, one))
        };
        let observe = |observers: &BaselineObservers| -> Result<Vec<[Vec<[f64; 3]>; 2]>, BadInput> {
            let arm = arm.clone()?;
            let one = |one: &Trajectory| observers.forces(&arm, &telemetry(features, about.1, one)?);
            parallel::try_map(&trajectories, one)
        };
        let sensed = actuator.sensing.as_ref().map(along).transpose()?;
        let observed = self.baselines.observers.as_ref().map(observe).transpose()?;
        self.tasks.push(ComparedTask { name, trajectories, positions, rollouts, pure, sensed, observed });
        Ok(())
    }

    /// Every number of the comparison.
    pub fn summary(&self) -> ActuatorComparison {
        let Self { actuator, tasks, .. } = self;
        let of_task = |task: &ComparedTask| TaskScores {
            task: task.name.clone(),
            trajectories: task.trajectories.len(),
            poses: ByMethod::from_fn(|method| ByHorizon::from_fn(|h| self.poses(task, method, h))),
            forces: self.forces(&[task]),
        };
        let all: Vec<Trajectory> = tasks.iter().flat_map(|task| task.trajectories.clone()).collect();
        let conditions: Vec<Vec<f64>> =
            tasks.iter().flat_map(ComparedTask::conditions).map(|estimates| estimates.network).collect();
        ActuatorComparison {
            format: ComparisonFormat::Evaluation,
            version: 2,
            mean_deg: self.means(&|own| Some(own.mean_deg())),
            mean_gripper_mm: self.means(&|own| own.gripper_mm),
            forces: self.forces(&tasks.iter().collect::<Vec<_>>()),
            force_from: if actuator.sensing.is_some() { ForceSource::Observer } else { ForceSource::Loop },
            condition_accuracy_auc: condition_scores(&all, &conditions),
            tasks: tasks.iter().map(of_task).collect(),
            left_out: actuator.details.left_out.clone(),
            trained_on: actuator.details.recordings.len(),
        }
    }

    fn poses(&self, task: &ComparedTask, method: usize, horizon: usize) -> PoseScores {
        pose_scores(&self.actuator.features, &task.trajectories, &task.positions[method], horizon)
    }

    /// Scores of the forces of every source, over the trajectories of these tasks.
    fn forces(&self, tasks: &[&ComparedTask]) -> ForcesBySource {
        let contact = self.contact_thresholds();
        let trajectories: Vec<Trajectory> = tasks.iter().flat_map(|task| task.trajectories.clone()).collect();
        let all: Vec<_> = tasks.iter().map(|task| task.forces(contact)).collect();
        ForcesBySource::from_fn(|k| {
            let estimates: Option<Vec<Vec<ForceEstimates>>> =
                all.iter().map(|task| task[k].clone()).collect();
            force_scores(&trajectories, &estimates?.concat(), (usize::MAX, self.actuator.contact))
        })
    }

    /// Forces above which either observer reports a contact [N].
    fn contact_thresholds(&self) -> [f64; 2] {
        self.baselines.observers.as_ref().map_or([f64::INFINITY; 2], |own| own.contact)
    }

    /// Of every method and horizon, the mean over the tasks of a score; `None` where a task has none.
    fn means(&self, of: &dyn Fn(&PoseScores) -> Option<f64>) -> ByMethod<ByHorizon<Option<f64>>> {
        let mean = |method: usize, horizon: usize| -> Option<f64> {
            let one = |task: &ComparedTask| of(&self.poses(task, method, horizon));
            Some(self.tasks.iter().map(one).sum::<Option<f64>>()? / self.tasks.len() as f64)
        };
        ByMethod::from_fn(|method| ByHorizon::from_fn(|horizon| mean(method, horizon)))
    }

    /// Detectors of a degraded motor, fitted to `training`, and the network, on tasks whose name begins so.
    ///
    /// # Errors
    /// `BadInput` where one condition is missing.
    pub fn detectors(&self, begin: &str, training: &[Trajectory]) -> Result<Vec<DetectorScores>, BadInput> {
        let Self { actuator, model, simulation, tasks, .. } = self;
        let with_label = |one: &&Trajectory| one.is_healthy.is_some();
        let training: Vec<Trajectory> = training.iter().filter(with_label).cloned().collect();
        let about = (&actuator.features, actuator.simulation.period);
        let arm = actuator.observed_arm(model);
        let of = |one: &Trajectory| match &actuator.sensing {
            Some(sensing) => {
                Ok(ConditionEstimate::of(&sensing.along(arm.as_ref().map_err(Clone::clone)?, about, one)?))
            }
            None => Ok(estimates(&roll_out(actuator, simulation, one, TelemetrySource::Recorded))),
        };
        let known = parallel::try_map::<_, _, BadInput>(&training, of)?;
        let tasks = || tasks.iter().filter(|task| task.name.starts_with(begin));
        let test: Vec<Trajectory> = tasks().flat_map(|task| task.trajectories.clone()).collect();
        let asked: Vec<ConditionEstimate> = tasks().flat_map(ComparedTask::conditions).collect();
        detectors((self.without_payload.model(), &actuator.features), [&training, &test], [&known, &asked])
    }

    /// The first trajectory of a task over time, with every method's positions [rad] joint by joint and forces along z [N]; `None` without
    /// that task.
    pub fn trace(&self, task: &str, period: f64) -> Option<TaskTrace> {
        let task = self.tasks.iter().find(|one| one.name == task)?;
        let first = task.trajectories.first()?;
        let features = &self.actuator.features;
        let (m, rows) = (features.motors(), first.len() - 1);
        let joints = |positions: &[f64]| -> Vec<Vec<f64>> {
            let joint = |k: usize| positions.iter().skip(k).step_by(m).take(rows).copied().collect();
            (0..features.joints).map(joint).collect()
        };
        let z = |estimates: Option<Vec<ForceEstimates>>| -> Option<Vec<f64>> {
            Some(estimates?.first()?.0.iter().take(rows).map(|force| force[2]).collect())
        };
        Some(TaskTrace {
            task: task.name.clone(),
            time_s: (0..rows).map(|row| period * row as f64).collect(),
            measured_rad: joints(&positions_of(features, first)),
            methods_rad: task.positions.iter().map(|own| joints(&own[0])).collect(),
            label_n: first.force.iter().take(rows).map(|f| f.unwrap_or_default()[2]).collect(),
            forces_n: task.forces(self.contact_thresholds()).into_iter().map(z).collect(),
        })
    }
}
