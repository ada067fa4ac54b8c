//! The run of `study cloning`.

use hysteron_arm_dynamics::Model;
use hysteron_arm_learning::neural::{LiveEstimator, NeuralActuator};
use hysteron_learn::MlpTape;
use hysteron_virtual_rig::virtual_arm::{ArmControl, VirtualArm};
use hysteron_workflow::shared::outputs::Outputs;
use hysteron_workflow::{Context, WorkflowError};

use super::outcome::{Outcome, Setting};
use super::policy::{EPOCHS, HIDDEN, Observed, Policy, PolicyStep, Senses, clone_expert};
use super::score::{Row, Task};
use super::trial::{ARM, Expert, HEAVIEST, STAYS, Trial, led};
use super::{options::Options, page};
use crate::runner::{self, Listener, StudyProgress};

/// Demonstrations of a policy, and of its validation.
const DEMONSTRATIONS: [usize; 2] = [60, 12];
/// Trials of each task.
const TRIALS: usize = 400;
/// Of `--quick`.
const QUICK: ([usize; 2], usize) = ([10, 3], 12);
/// How near the tip must be to where the object belongs [m].
const NEAR: f64 = 5e-3;

/// Runs the study.
///
/// # Errors
/// An actuator of another arm, files that cannot be written, an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    let inputs = Outputs::default().and(&options.actuator);
    runner::run(
        &options.out,
        inputs,
        context,
        |_, listener| rows(options, listener),
        |rows| {
            let outcome = Outcome::new(rows, setting(options), context);
            page::write(&options.out, &outcome)?;
            Ok(outcome)
        },
    )
}

/// Size of the study: demonstrations, trials, policies.
fn size(options: &Options) -> ([usize; 2], usize, usize) {
    let (demonstrations, trials) = if options.quick { QUICK } else { (DEMONSTRATIONS, TRIALS) };
    (demonstrations, trials, if options.quick { 1 } else { options.seeds })
}

fn setting(options: &Options) -> Setting {
    let (demonstrations, trials, policies) = size(options);
    Setting {
        arm: ARM.0.to_owned(),
        demonstrations,
        trials,
        policies,
        near_mm: 1e3 * NEAR,
        stays_s: STAYS,
        heaviest_kg: HEAVIEST,
        hidden: HIDDEN,
        epochs: EPOCHS,
    }
}

/// All rows of the table; `None` where the listener ended the study.
fn rows(options: &Options, listener: Listener<'_>) -> anyhow::Result<Option<Vec<Row>>> {
    let actuator = options.actuator.as_deref().map(NeuralActuator::read).transpose()?;
    let model = Model::builtin(ARM.0)?;
    let observed = actuator.as_ref().map(|actuator| actuator.observed_arm(&model)).transpose()?;
    let estimator = match (&actuator, &observed, &options.actuator) {
        (Some(actuator), Some(model), Some(path)) => {
            Some(LiveEstimator::new(actuator, model).map_err(|bad| bad.within(path.display()))?)
        }
        _ => None,
    };
    let (demonstrations, trials, policies) = size(options);
    let arm = VirtualArm::preset(ARM.0)?.individual(ARM.1);
    let study = Study { arm, estimator, demonstrations, trials, seeds: policies as u64 };
    let has_row = |observed: Observed| observed != Observed::EstimatedForce || study.estimator.is_some();
    let methods: Vec<Observed> = Observed::ALL.into_iter().filter(|it| has_row(*it)).collect();
    let mut rows = Vec::new();
    for task in [Task::Place, Task::Stay] {
        if !study.add_rows(task, &methods, &mut rows, listener)? {
            return Ok(None);
        }
    }
    Ok(Some(rows))
}

/// Setting of the study, and its size.
struct Study<'a> {
    arm: VirtualArm,
    estimator: Option<LiveEstimator<'a>>,
    demonstrations: [usize; 2],
    trials: usize,
    seeds: u64,
}

impl Study<'_> {
    /// Adds the rows of a task: goals as planned, the expert, and a policy for each observation. False where the listener ended
    /// the study.
    fn add_rows(
        &self,
        task: Task,
        methods: &[Observed],
        rows: &mut Vec<Row>,
        listener: Listener<'_>,
    ) -> anyhow::Result<bool> {
        let all = 2 * (methods.len() + 2);
        let mut continues = |cell: &str, rows: &[Row]| {
            listener(&StudyProgress { cell, done: [rows.len(), all], training: None })
        };
        let planned = self.every(task, &|_| Box::new(|_, planned, _| *planned));
        rows.push(Row::of(task, "goals as planned", (&planned, NEAR), None));
        let expert = self.every(task, &|_| {
            let mut expert = Expert::default();
            Box::new(move |reading, planned, _| expert.control(reading, planned))
        });
        rows.push(Row::of(task, "expert", (&expert, NEAR), None));
        let shown: Vec<_> =
            (0..self.seeds).map(|seed| [0, 1].map(|set| self.demonstrated(task, seed, set))).collect();
        let mut nothing: Option<Vec<f64>> = None;
        for observed in methods {
            if !continues(observed.name(), rows) {
                return Ok(false);
            }
            let distances = self.cloned(task, *observed, &shown)?;
            rows.push(Row::of(task, observed.name(), (&distances, NEAR), nothing.as_deref()));
            nothing.get_or_insert(distances);
        }
        Ok(continues("", rows))
    }

    /// Distances of all trials of a task under policies that are cloned from these demonstrations, seed by seed.
    fn cloned(
        &self,
        task: Task,
        observed: Observed,
        shown: &[[Vec<Vec<PolicyStep>>; 2]],
    ) -> anyhow::Result<Vec<f64>> {
        let estimator = self.estimator.as_ref();
        let policies: Vec<Policy> = (0..self.seeds)
            .zip(shown)
            .map(|(seed, shown)| clone_expert(estimator, shown, observed, seed))
            .collect::<anyhow::Result<_>>()?;
        Ok(self.every(task, &|number| {
            let policy = &policies[number % policies.len()];
            let (mut tape, mut senses) = (MlpTape::new(&policy.mlp), Senses::new(estimator));
            Box::new(move |reading, planned, force| {
                let raw = senses.observe(observed, (reading, planned), force);
                led(planned, &policy.lead(&mut tape, &raw))
            })
        }))
    }

    /// Distances of all trials of a task under the controllers that `control` makes for their numbers.
    fn every<'c>(&self, task: Task, control: &dyn Fn(usize) -> Box<ArmControl<'c>>) -> Vec<f64> {
        let one = |number: usize| {
            Trial::draw(&self.arm, task, "test", number).run(&self.arm, &mut *control(number))
        };
        (0..self.trials).map(one).collect()
    }

    /// Steps of the expert, demonstration by demonstration.
    fn demonstrated(&self, task: Task, seed: u64, set: usize) -> Vec<Vec<PolicyStep>> {
        let one = |number: usize| {
            let trial = Trial::draw(&self.arm, task, &format!("demonstration-{seed}-{set}"), number);
            let (mut expert, mut steps) = (Expert::default(), Vec::new());
            trial.run(&self.arm, &mut |reading, planned, force| {
                let goals = expert.control(reading, planned);
                steps.push(PolicyStep { reading: *reading, planned: *planned, force, lead: expert.lead });
                goals
            });
            steps
        };
        (0..self.demonstrations[set]).map(one).collect()
    }
}
