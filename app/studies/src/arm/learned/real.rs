//! Recorded arms: learned models compared with simple ones, everything chosen on trajectories of the training
//! data.

use std::ops::Range;
use std::path::Path;

use hysteron_base::{BadInput, json};
use hysteron_learn::{Activation, Result, TrainingSession};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::runner::cells::{Listener, StudyProgress, cell, make_folder};
use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::identify::TorqueResponse;
use hysteron_arm_learning::baselines::{
    GoesOn, MAX_POINTS, RigidFeatures, fit_fourier, fit_gaussian_process, fit_rigid_body,
};
use hysteron_arm_learning::datasets::RealSet;
use hysteron_arm_learning::lagrangian::{
    ArmSamples, InputForm, NetworkShape, Scales, TorqueScores, TrainingOptions, Variant, decompose, train,
};

/// How the models of a set are found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RealOptions {
    /// Learned models.
    pub variants: Vec<Variant>,
    /// Networks whose mean is taken.
    pub members: u64,
    /// Units of every hidden layer.
    pub hidden: Vec<usize>,
    /// Between layers.
    pub activation: Activation,
    /// How networks are trained.
    pub training: TrainingOptions,
    /// Fourier features.
    pub features: usize,
    /// Lengths of theirs that are tried, in spreads.
    pub lengths: Vec<f64>,
    /// Every so many samples are used in fits.
    pub stride: usize,
}

/// One model on one set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RealRow {
    /// Name of the model.
    pub name: String,
    /// Mean squared error of every joint on the test [N² m²].
    pub mse: Vec<f64>,
    /// Their sum.
    pub sum_mse: f64,
    /// (11), about one mean of all joints.
    pub pooled_r2: f64,
    /// Mean over the joints of R² about their own means.
    pub mean_r2: f64,
    /// Validation error that chose it: mean nMSE of a joint on validation trajectories [-].
    pub validation: f64,
    /// The choice, in words.
    pub choice: String,
    /// Torques at [`shown_samples`] of the test, [sample][joint] [N m].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shown: Vec<f32>,
}

/// Samples of a figure at most.
const SHOWN: usize = 400;

/// Samples of the first test trajectory that figures show, evenly spaced.
pub fn shown_samples(test: &ArmSamples) -> impl Iterator<Item = usize> {
    let first = test.trajectories.first().cloned().unwrap_or_default();
    let step = first.len().div_ceil(SHOWN).max(1);
    first.step_by(step)
}

impl RealRow {
    fn new(name: &str, test: &ArmSamples, predicted: &[f64], validation: f64, choice: String) -> Self {
        let scores = TorqueScores::of(test.n_joints, &test.tau, predicted);
        let n = test.n_joints;
        let torques = shown_samples(test).flat_map(|sample| &predicted[n * sample..][..n]);
        Self {
            shown: torques.map(|torque| *torque as f32).collect(),
            name: name.to_owned(),
            sum_mse: scores.sum_mse(),
            pooled_r2: scores.pooled_r2,
            mean_r2: scores.mean_r2(),
            mse: scores.mse,
            validation,
            choice,
        }
    }
}

fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

/// Steps of the search for bodies that can be.
const FEASIBLE_STEPS: usize = 4000;
/// Every so many trajectories one validates.
const VALIDATION: usize = 4;

/// Simple models, learned ones, and learned ones on the residuals of an identified arm.
///
/// # Errors
/// Constant joints, fewer than two trajectories, files of another study.
pub fn real_study(
    set: &RealSet,
    model: &Model,
    options: &RealOptions,
    folder: &Path,
    listener: Listener<'_>,
) -> Result<Vec<RealRow>> {
    make_folder(folder)?;
    if model.n_joints() != set.training.n_joints {
        let expected = format!("{} joints, as recorded", set.training.n_joints);
        return Err(BadInput::new(model.name(), expected, model.n_joints().to_string())
            .hint("lock joints that were not recorded")
            .into());
    }
    set.training.check_variation()?;
    let features = RigidFeatures::new(model, &set.training);
    let total = 8 + 2 * options.variants.len();
    let begins = StudyProgress { cell: "Rigid body, friction, spring", done: [0, total], training: None };
    let found = fit_rigid_body(&features, &set.training, options.stride, &mut || listener(&begins))?;
    let Some((free, choice, sums)) = found else { return Ok(Vec::new()) };
    let body = features.feasible(&sums, choice.penalty, FEASIBLE_STEPS);
    let prior = [&set.training, &set.test].map(|samples| features.predict(&body, samples));
    let penalty = format!("penalty {:.0e}", choice.penalty);
    let mut rows = vec![
        RealRow::new(
            "Rigid body, friction, spring (least squares)",
            &set.test,
            &features.predict(&free, &set.test),
            choice.validation,
            penalty.clone(),
        ),
        RealRow::new(
            "Rigid body, friction, spring (feasible)",
            &set.test,
            &prior[1],
            choice.validation,
            penalty,
        ),
    ];
    let (responded, row) = responded(set, &prior);
    rows.push(row);
    // A cell does not depend on its neighbours.
    let identity = json!({ "options": RealOptions { variants: Vec::new(), ..options.clone() }, "set": set.name, "samples": set.training.len() });
    let zeros = [&set.training, &set.test].map(|samples| vec![0.0; samples.tau.len()]);
    let bodies = [("", "", &zeros), ("Rigid body + ", "rigid-", &prior)];
    let with_response = ("Rigid body with response + ", "response-", &responded);
    for (kind, key) in [(Kernel::Fourier, "fourier"), (Kernel::GaussianProcess, "gaussian-process")] {
        let also = matches!(kind, Kernel::Fourier).then_some(with_response);
        for (prefix, of_key, offset) in bodies.into_iter().chain(also) {
            let name = format!("{prefix}{}", kind.label());
            let begins = StudyProgress { cell: &name, done: [rows.len(), total], training: None };
            let mut continues = || listener(&begins);
            if !continues() {
                return Ok(rows);
            }
            let row = cell(folder, &format!("{of_key}{key}"), &identity, || {
                kernel(set, options, (kind, &name), offset, &mut continues)
            })?;
            let Some(row) = row else { return Ok(rows) };
            rows.push(row);
        }
    }
    for (prefix, of_key, offset) in bodies {
        for variant in &options.variants {
            let name = format!("{prefix}{}", variant.label());
            let key = format!("{of_key}{}", json!(variant).as_str().unwrap_or_default());
            let done = [rows.len(), total];
            let row = cell(folder, &key, &identity, || {
                learned(set, options, (*variant, &name), offset, (folder, &key), done, listener)
            })?;
            let Some(row) = row else { return Ok(rows) };
            rows.push(row);
        }
    }
    Ok(rows)
}

/// Torques of training and test as they would be measured where the rigid arm has `rigid`, and what they leave.
fn responded(set: &RealSet, rigid: &[Vec<f64>; 2]) -> ([Vec<f64>; 2], RealRow) {
    let n = set.training.n_joints;
    let rows = |range: &Range<usize>| n * range.start..n * range.end;
    let parts = |fold: Option<usize>| {
        let trajectories = set.training.trajectories.iter().enumerate();
        let used = trajectories.filter(move |(t, _)| fold.is_none_or(|fold| t % VALIDATION != fold));
        used.map(|(_, range)| [&rigid[0][rows(range)], &set.training.tau[rows(range)]])
    };
    let found = |fold: Option<usize>| TorqueResponse::of_rows(parts(fold), n, 1.0);
    // Each trajectory with the response of those of other folds.
    let folds: Vec<TorqueResponse> = (0..VALIDATION).map(|fold| found(Some(fold))).collect();
    let of_trajectory =
        |(t, range): (usize, &Range<usize>)| folds[t % VALIDATION].applied(&rigid[0][rows(range)]);
    let held_out: Vec<f64> = set.training.trajectories.iter().enumerate().flat_map(of_trajectory).collect();
    let validation = 1.0 - TorqueScores::of(n, &set.training.tau, &held_out).mean_r2();
    let response = found(None);
    let applied = |samples: &ArmSamples, rigid: &[f64]| -> Vec<f64> {
        samples.trajectories.iter().flat_map(|range| response.applied(&rigid[rows(range)])).collect()
    };
    let both = [applied(&set.training, &rigid[0]), applied(&set.test, &rigid[1])];
    let leads: Vec<String> = response.lead.iter().map(|lead| format!("{lead:.1}")).collect();
    let choice = format!("ahead by {} samples", leads.join(", "));
    let name = "Rigid body, friction, spring (feasible), response of measured torques";
    let row = RealRow::new(name, &set.test, &both[1], validation, choice);
    (both, row)
}

/// Linear models of states lifted by a Gaussian kernel.
#[derive(Debug, Clone, Copy)]
enum Kernel {
    Fourier,
    GaussianProcess,
}

impl Kernel {
    fn label(self) -> &'static str {
        match self {
            Self::Fourier => "Fourier features",
            Self::GaussianProcess => "Gaussian process",
        }
    }
}

/// One of them on what `offset` (of training and test) leaves.
fn kernel(
    set: &RealSet,
    options: &RealOptions,
    (kind, name): (Kernel, &str),
    offset: &[Vec<f64>; 2],
    continues: GoesOn<'_>,
) -> Result<Option<RealRow>> {
    let lengths = &options.lengths;
    let (found, validation, choice) = match kind {
        Kernel::Fourier => {
            let size = (options.features, options.stride, 0);
            let fit = fit_fourier(&set.training, &offset[0], lengths, size, continues)?;
            let Some(fit) = fit else { return Ok(None) };
            let choice = format!("length {}, penalty {:.0e}", fit.length, fit.choice.penalty);
            (fit.features.predict(&fit.weights, &set.test), fit.choice.validation, choice)
        }
        Kernel::GaussianProcess => {
            let fit = fit_gaussian_process(&set.training, &offset[0], lengths, MAX_POINTS, continues)?;
            let Some(fit) = fit else { return Ok(None) };
            let [n, of] = [fit.process.n_points(), set.training.len()];
            let choice =
                format!("length {}, noise {:.0e}, {n} of {of} samples", fit.length, fit.choice.penalty);
            (fit.process.predict(&set.test), fit.choice.validation, choice)
        }
    };
    Ok(Some(RealRow::new(name, &set.test, &sum(&found, &offset[1]), validation, choice)))
}

/// The mean of some networks on what `offset` (of training and test) leaves.
fn learned(
    set: &RealSet,
    options: &RealOptions,
    (variant, name): (Variant, &str),
    offset: &[Vec<f64>; 2],
    (folder, key): (&Path, &str),
    done: [usize; 2],
    listener: Listener<'_>,
) -> Result<Option<RealRow>> {
    let mut all = set.training.clone();
    all.tau.iter_mut().zip(&offset[0]).for_each(|(t, o)| *t -= o);
    let n = all.trajectories.len();
    let (mut predicted, mut validation) = (vec![0.0; set.test.tau.len()], 0.0);
    for member in 0..options.members {
        // Each network stops by other trajectories.
        let is_validation = |t: &usize| t % VALIDATION == member as usize % VALIDATION;
        let training = all.select((0..n).filter(|t| !is_validation(t))).thinned(options.stride);
        let evaluated = all.select((0..n).filter(is_validation)).thinned(options.stride);
        let shape = NetworkShape {
            variant,
            hidden: options.hidden.clone(),
            activation: options.activation,
            epsilon: 1e-4,
            scales: Scales::of(&training, variant, InputForm::SinesAndCosines),
            lengths: vec![None; all.n_joints],
            inputs: InputForm::SinesAndCosines,
            squares: 0,
        };
        let state = folder.join(format!("{key}-{member}.state"));
        let mut progress = |training: &hysteron_learn::TrainingProgress| {
            listener(&StudyProgress { cell: name, done, training: Some(*training) })
        };
        let mut session = TrainingSession { file: Some(&state), progress: &mut progress };
        let found = train(&shape, [&training, &evaluated], &options.training, member, &mut session)?;
        if !found.is_finished {
            return Ok(None);
        }
        let torque = decompose(&shape, &found.parameters, &set.test).torque;
        predicted.iter_mut().zip(torque).for_each(|(sum, t)| *sum += t / options.members as f64);
        validation += found.validation.powi(2) / options.members as f64;
    }
    let predicted = sum(&predicted, &offset[1]);
    let choice = format!("{} networks of {:?}", options.members, options.hidden);
    Ok(Some(RealRow::new(name, &set.test, &predicted, validation, choice)))
}
