//! The simulated three-link arm and the written characters: every variant and seed, parts of the torques, faster motions,
//! less data.

use std::path::Path;
use std::time::Instant;

use hysteron_base::{json, rng};
use hysteron_learn::{Activation, Result, TrainingSession};
use rand::RngExt;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::runner::cells::{Listener, StudyProgress, cell, make_folder};
use hysteron_arm_dynamics::Model;
use hysteron_arm_learning::lagrangian::{
    ArmSamples, Decomposition, InputForm, LearnedDynamics, NetworkShape, Scales, Sinusoids, TorqueScores,
    TrainingOptions, Variant, decompose, sinusoids, train,
};

/// Options of the comparison: models, seeds, data, networks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SimulatedStudy {
    /// Rows of the table.
    pub variants: Vec<Variant>,
    /// Seeds of initial parameters and of minibatches: how many.
    pub seeds: u64,
    /// The first of them.
    pub first_seed: u64,
    /// Training trajectories, validation among them.
    pub trajectories: Vec<usize>,
    /// Speeds of the test, over that of training.
    pub speeds: Vec<f64>,
    /// Units of every hidden layer; none for two layers of as many as the variant was found to need.
    pub hidden: Option<Vec<usize>>,
    /// Between layers.
    pub activation: Activation,
    /// Form of the positions as inputs of networks.
    pub inputs: InputForm,
    /// Dense columns of the factor of a mass matrix, next to its triangle; an inverse mass matrix has none,
    /// for it is no sum of squares of products.
    pub squares: usize,
    /// Whether networks get SI units, as published, or spreads.
    pub units: Units,
    /// How they are trained.
    pub training: TrainingOptions,
}

/// Units of the motions that networks get.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Units {
    /// SI, as published.
    Si,
    /// Spreads of the training data.
    Spread,
}

/// Training of a model, as its file states it.
#[derive(Serialize)]
struct Details<'a> {
    study: &'a SimulatedStudy,
    seed: u64,
    trajectories: usize,
}

/// Σ over joints of mean squared error over variance: the nMSE of table 5 [-].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Parts {
    /// Of the torque.
    pub torque: f64,
    /// Of H q̈.
    pub inertial: f64,
    /// Of c.
    pub coriolis: f64,
    /// Of g.
    pub gravity: f64,
}

impl Parts {
    fn of(n: usize, truth: &Decomposition, found: &Decomposition) -> Self {
        let nmse = |truth: &[f64], found: &[f64]| TorqueScores::of(n, truth, found).sum_nmse();
        Self {
            torque: nmse(&truth.torque, &found.torque),
            inertial: nmse(&truth.inertial, &found.inertial),
            coriolis: nmse(&truth.coriolis, &found.coriolis),
            gravity: nmse(&truth.gravity, &found.gravity),
        }
    }
}

/// One training of the study.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SimulatedRow {
    /// Which model.
    pub variant: Variant,
    /// Of its initial parameters.
    pub seed: u64,
    /// Training trajectories.
    pub trajectories: usize,
    /// For every speed of the test, in the order of [`SimulatedStudy::speeds`].
    pub parts: Vec<Parts>,
    /// Mean squared error over variance of every joint's torque, at the first speed [-].
    pub joints: Vec<f64>,
    /// Mean squared error of the torque over all joints, at the first speed [N² m²].
    pub mse: Parts,
    /// Mean squared error of the power q̇ᵀτ, at the first speed [W²].
    pub power_mse: f64,
    /// Root mean square error on validation trajectories, in spreads [-].
    pub validation: f64,
    /// Epochs of Adam and steps of what follows it until the best parameters.
    pub steps: [usize; 2],
    /// Parameters of the model.
    pub parameters: usize,
    /// Time of the training by the clock [s].
    pub seconds: f64,
}

impl SimulatedRow {
    /// Name of its cell, and of the files next to it.
    pub fn name(&self) -> String {
        name(self.variant, self.trajectories, self.seed)
    }
}

fn name(variant: Variant, trajectories: usize, seed: u64) -> String {
    let spelled = json!(variant);
    format!("{}-{trajectories}-{seed}", spelled.as_str().unwrap_or_default())
}

/// Part of the trajectories that only choose when to stop.
const VALIDATION: usize = 10;

/// Trajectories to learn from and to validate on: every tenth, in an order drawn by the seed, at least one.
fn split(samples: &ArmSamples, seed: u64) -> [ArmSamples; 2] {
    let n = samples.trajectories.len();
    let mut order: Vec<usize> = (0..n).collect();
    let mut rng = rng(seed, "arm/study/validation");
    for i in (1..n).rev() {
        order.swap(i, rng.random_range(0..=i));
    }
    let n_validation = n.div_ceil(VALIDATION).max(1).min(n - 1);
    let (validation, training) = order.split_at(n_validation);
    [samples.select(training.iter().copied()), samples.select(validation.iter().copied())]
}

/// Units of each of two hidden layers that validation preferred on the simulated arm, with products as inputs and squares in the kinetic energy: what the
/// linear path holds needs few.
fn hidden_units(variant: Variant) -> usize {
    match variant {
        Variant::StructuredLagrangian | Variant::Friction | Variant::Augmented => 4,
        Variant::BlackBoxHamiltonian => 24,
        Variant::BlackBoxLagrangian | Variant::StructuredHamiltonian | Variant::FeedForward => 16,
    }
}

/// Steps after Adam, where the other variants have so many: a black box learns an inverse mass matrix slowly, and its error still falls then.
fn steps(variant: Variant, others: usize) -> usize {
    if variant == Variant::BlackBoxHamiltonian { others * 4 / 3 } else { others }
}

type Sets = Vec<(ArmSamples, Decomposition)>;

impl SimulatedStudy {
    fn row(
        &self,
        (variant, seed, all): (Variant, u64, &ArmSamples),
        tests: &Sets,
        model: &Path,
        session: &mut TrainingSession<'_>,
    ) -> Result<Option<SimulatedRow>> {
        let n = all.n_joints;
        let [training, validation] = split(all, seed);
        let scales = match self.units {
            Units::Si => Scales::ones(n),
            Units::Spread => Scales::of(&training, variant, self.inputs),
        };
        let shape = NetworkShape {
            variant,
            hidden: self.hidden.clone().unwrap_or_else(|| vec![hidden_units(variant); 2]),
            activation: self.activation,
            epsilon: 1e-4,
            scales,
            lengths: vec![None; n],
            inputs: self.inputs,
            squares: if variant == Variant::StructuredHamiltonian { 0 } else { self.squares },
        };
        let start = Instant::now();
        let found = train(&shape, [&training, &validation], &self.training_of(variant), seed, session)?;
        if !found.is_finished {
            return Ok(None);
        }
        let seconds = start.elapsed().as_secs_f64();
        let decompositions: Vec<Decomposition> =
            tests.iter().map(|(samples, _)| decompose(&shape, &found.parameters, samples)).collect();
        let parts =
            tests.iter().zip(&decompositions).map(|((_, truth), found)| Parts::of(n, truth, found)).collect();
        let (samples, truth) = &tests[0];
        let mean = |a: &[f64], b: &[f64]| TorqueScores::of(n, a, b).sum_mse() / n as f64;
        let first = &decompositions[0];
        let mse = Parts {
            torque: mean(&truth.torque, &first.torque),
            inertial: mean(&truth.inertial, &first.inertial),
            coriolis: mean(&truth.coriolis, &first.coriolis),
            gravity: mean(&truth.gravity, &first.gravity),
        };
        let joints = TorqueScores::of(n, &truth.torque, &first.torque).nmse;
        let count = found.parameters.len();
        let details = Details { study: self, seed, trajectories: all.trajectories.len() };
        LearnedDynamics { shape, parameters: found.parameters }.write(model, &details)?;
        let power = |tau: &[f64]| -> Vec<f64> {
            let rows = tau.chunks_exact(n).zip(samples.dq.chunks_exact(n));
            rows.map(|(tau, dq)| tau.iter().zip(dq).map(|(t, v)| t * v).sum()).collect()
        };
        Ok(Some(SimulatedRow {
            variant,
            seed,
            trajectories: all.trajectories.len(),
            parts,
            joints,
            mse,
            parameters: count,
            power_mse: TorqueScores::of(1, &power(&truth.torque), &power(&first.torque)).sum_mse(),
            validation: found.validation,
            steps: found.steps,
            seconds,
        }))
    }

    fn training_of(&self, variant: Variant) -> TrainingOptions {
        TrainingOptions { polish: steps(variant, self.training.polish), ..self.training.clone() }
    }

    /// All rows; those that are done are found in `folder`.
    fn rows(
        &self,
        sets: &[ArmSamples],
        tests: &Sets,
        folder: &Path,
        listener: Listener<'_>,
    ) -> Result<Vec<SimulatedRow>> {
        make_folder(folder)?;
        let mut rows = Vec::new();
        let total = sets.len() * self.variants.len() * self.seeds as usize;
        for all in sets {
            for variant in &self.variants {
                for seed in self.first_seed..self.first_seed + self.seeds {
                    let count = all.trajectories.len();
                    let name = name(*variant, count, seed);
                    let done = [rows.len(), total];
                    let identity = json!({
                        "hidden": self.hidden, "inputs": self.inputs, "squares": self.squares, "activation": self.activation, "units": self.units,
                        "training": self.training_of(*variant), "speeds": self.speeds, "variant": variant, "seed": seed,
                        "trajectories": count,
                    });
                    let state = folder.join(format!("{name}.state"));
                    let row = cell(folder, &name, &identity, || {
                        let mut progress = |training: &hysteron_learn::TrainingProgress| {
                            listener(&StudyProgress { cell: &name, done, training: Some(*training) })
                        };
                        let mut session = TrainingSession { file: Some(&state), progress: &mut progress };
                        let model = folder.join(format!("{name}.safetensors"));
                        self.row((*variant, seed, all), tests, &model, &mut session)
                    })?;
                    let Some(row) = row else { return Ok(rows) };
                    rows.push(row);
                    if !listener(&StudyProgress { cell: &name, done: [rows.len(), total], training: None }) {
                        return Ok(rows);
                    }
                }
            }
        }
        Ok(rows)
    }
}

/// The three motions that models are tested on, so many times as fast as those they learn from, and the true parts of their torques.
pub fn simulated_test(model: &Model, speed: f64) -> (ArmSamples, Decomposition) {
    let plan = Sinusoids { speed, ..Sinusoids::published(3) };
    sinusoids(model, &plan, 0, "arm/study/test")
}

/// Table 5, and how models extrapolate in speed and learn from fewer trajectories.
///
/// # Errors
/// Those of training; files in `folder` that belong to another study.
pub fn simulated_study(
    study: &SimulatedStudy,
    model: &Model,
    folder: &Path,
    listener: Listener<'_>,
) -> Result<Vec<SimulatedRow>> {
    let most = study.trajectories.iter().copied().max().unwrap_or(0);
    let (all, _) = sinusoids(model, &Sinusoids::published(most), 0, "arm/study/training");
    let sets: Vec<ArmSamples> = study.trajectories.iter().map(|n| all.select(0..*n)).collect();
    let tests = study.speeds.iter().map(|speed| simulated_test(model, *speed)).collect();
    study.rows(&sets, &tests, folder, listener)
}

/// The written characters, with the published split.
///
/// # Errors
/// As [`simulated_study`].
pub fn characters_study(
    study: &SimulatedStudy,
    [(training, _), test]: [(ArmSamples, Decomposition); 2],
    folder: &Path,
    listener: Listener<'_>,
) -> Result<Vec<SimulatedRow>> {
    study.rows(&[training], &vec![test], folder, listener)
}
