//! Training: minibatches of Adam in single precision, then L-BFGS over many samples in double precision.

use hysteron_base::BadInput;
use hysteron_learn::{
    Adam, Decay, Epoch, Lbfgs, LevenbergMarquardt, Objective, Result, Schedule, TrainingProgress,
    TrainingSession, minimise,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{ArmSamples, JointWeights, NetworkShape, TorqueObjective};

/// Samples that Levenberg and Marquardt's method fits.
const CURVATURE_SAMPLES: usize = 4000;

/// How a model is trained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TrainingOptions {
    /// Epochs of Adam at most.
    pub epochs: usize,
    /// Epochs without a better error on validation data after which Adam ends.
    pub patience: usize,
    /// Samples of a step.
    pub batch: usize,
    /// Step size at the start.
    pub learning_rate: f64,
    /// Whether the step size stays, or decays along half a cosine.
    pub decay: StepDecay,
    /// Penalty on weights.
    pub weight_decay: f64,
    /// How joints are weighed.
    pub weights: JointWeights,
    /// λ of (10).
    pub penalty: f64,
    /// Optimiser that continues after Adam, in double precision.
    pub polish_by: Polish,
    /// Steps of it at most.
    pub polish: usize,
    /// Samples that it sees, spread evenly.
    pub polish_samples: usize,
}

/// Optimiser that refines the weights after Adam.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Polish {
    /// L-BFGS: for any number of parameters.
    Lbfgs,
    /// Levenberg and Marquardt's method, with the second derivatives of so many samples in every step: much deeper, for some thousand parameters.
    LevenbergMarquardt {
        /// Samples that the second derivatives are of.
        batch: usize,
    },
}

/// Schedule of the learning rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StepDecay {
    /// Nothing.
    Constant,
    /// Half a cosine down to a hundredth.
    Cosine,
}

impl TrainingOptions {
    /// As published: Adam with 1e-4, penalty 1e-5, 512 samples a step, the plain mean squared error (5).
    ///
    /// # Reference
    /// Li et al. (2025), section 4.1.2. The number of epochs is not printed.
    pub fn published(epochs: usize) -> Self {
        Self {
            epochs,
            patience: epochs,
            batch: 512,
            learning_rate: 1e-4,
            decay: StepDecay::Constant,
            weight_decay: 1e-5,
            weights: JointWeights::Equal,
            penalty: 0.0,
            polish_by: Polish::Lbfgs,
            polish: 0,
            polish_samples: 0,
        }
    }

    /// Ours: errors in units of every joint's variance, a decaying step size, no penalty on weights, L-BFGS for the last digits.
    pub fn normalised(epochs: usize) -> Self {
        Self {
            learning_rate: 3e-3,
            batch: 256,
            decay: StepDecay::Cosine,
            weight_decay: 0.0,
            weights: JointWeights::InverseVariance,
            polish: 1000,
            polish_samples: 8000,
            ..Self::published(epochs)
        }
    }

    /// The same with Levenberg and Marquardt's method for the last digits, on fewer samples and with the second derivatives of all of them: of a part of
    /// them they are too rough for its last, quadratically converging steps.
    pub fn with_levenberg_marquardt(self) -> Self {
        let polish_samples = CURVATURE_SAMPLES;
        Self { polish_samples, polish_by: Polish::LevenbergMarquardt { batch: polish_samples }, ..self }
    }

    fn schedule(&self) -> Schedule {
        let adam =
            Adam { learning_rate: self.learning_rate, weight_decay: self.weight_decay, ..Adam::default() };
        let decay = match self.decay {
            StepDecay::Constant => Decay::Step { epochs: usize::MAX, factor: 1.0 },
            StepDecay::Cosine => Decay::Cosine,
        };
        Schedule { epochs: self.epochs, patience: self.patience, adam, decay, ema: None }
    }
}

/// A trained model.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainedLagrangian {
    /// In the layout of the [`NetworkShape`].
    pub parameters: Vec<f64>,
    /// Root mean square error on validation data, in standard deviations of the training torques [-].
    pub validation: f64,
    /// Epochs of Adam and steps of what follows it until the best parameters.
    pub steps: [usize; 2],
    /// False where it was stopped early and can resume from its file.
    pub is_finished: bool,
}

/// Trains a model; parameters are chosen on validation data. Training resumes from a session's file.
///
/// # Errors
/// `BadInput` for a shape or setting out of its range, constant joints, or a file of another training; [`hysteron_learn::Error::NotFinite`].
pub fn train(
    shape: &NetworkShape,
    [training, validation]: [&ArmSamples; 2],
    options: &TrainingOptions,
    seed: u64,
    session: &mut TrainingSession<'_>,
) -> Result<TrainedLagrangian> {
    shape.check()?;
    training.check_variation()?;
    let [count, most] = [shape.n_parameters(), LevenbergMarquardt::MAX_PARAMETERS];
    if matches!(options.polish_by, Polish::LevenbergMarquardt { .. }) && options.polish > 0 && count > most {
        let expected = format!("at most {most} parameters for Levenberg and Marquardt's method");
        let bad = BadInput::new("network", expected, count.to_string());
        return Err(bad.hint("fewer units, or L-BFGS").into());
    }
    let begin = shape.initial_parameters(seed).into_iter().map(|p| p as f32).collect();
    let identity = TrainingIdentity {
        network: shape,
        seed,
        options,
        training: DataIdentity::of(training),
        validation: DataIdentity::of(validation),
    };
    let mut objective =
        TorqueObjective::<f32>::new(shape, [training, validation], options.weights, options.penalty);
    let found =
        minimise(&mut objective, begin, (seed, options.batch), &options.schedule(), &identity, session)?;
    let mut trained = TrainedLagrangian {
        parameters: found.model.into_values().into_iter().map(f64::from).collect(),
        validation: found.validation,
        steps: [found.epochs, 0],
        is_finished: found.is_finished,
    };
    if found.is_finished && options.polish > 0 {
        polish(shape, [training, validation], options, seed, &mut trained, session);
    }
    Ok(trained)
}

/// Goes on in double precision over many samples at once; keeps what does best on validation data.
fn polish(
    shape: &NetworkShape,
    samples: [&ArmSamples; 2],
    options: &TrainingOptions,
    seed: u64,
    trained: &mut TrainedLagrangian,
    session: &mut TrainingSession<'_>,
) {
    let mut objective = TorqueObjective::<f64>::new(shape, samples, options.weights, options.penalty);
    let mut evaluator = TorqueObjective::<f64>::new(shape, samples, options.weights, options.penalty);
    let n = samples[0].len();
    let taken = options.polish_samples.clamp(1, n);
    let rows: Vec<usize> = (0..taken).map(|i| i * n / taken).collect();
    let mut parameters = trained.parameters.clone();
    trained.validation = evaluator.validate(&parameters);
    let mut is_going_on = true;
    let look = match options.polish_by {
        Polish::Lbfgs => 25,
        Polish::LevenbergMarquardt { .. } => 2,
    };
    let mut after = |step: usize, loss: f64, p: &[f64]| {
        if step.is_multiple_of(look) {
            let validation = evaluator.validate(p);
            if validation < trained.validation {
                (trained.validation, trained.steps[1]) = (validation, step);
                trained.parameters = p.to_vec();
            }
            let (number, of) = (step, options.polish);
            let epoch = Epoch { number, of, training: loss.sqrt(), validation, best: trained.validation };
            is_going_on = (session.progress)(&TrainingProgress::Epoch(epoch));
        }
        is_going_on
    };
    match options.polish_by {
        Polish::Lbfgs => {
            let lbfgs = Lbfgs { memory: 30, iterations: options.polish, gradient_tolerance: 0.0 };
            let mut value = |p: &[f64], gradient: &mut [f64]| objective.gradient(p, &rows, gradient);
            lbfgs.minimise(&mut value, &mut parameters, &mut after);
        }
        Polish::LevenbergMarquardt { batch } => {
            let method = LevenbergMarquardt { iterations: options.polish, batch, damping: 1e-3 };
            method.minimise(&mut objective, &rows, seed, &mut parameters, &mut after);
        }
    }
    trained.is_finished = is_going_on;
}

/// Identity of a training that a file to resume from must match.
#[derive(Serialize)]
struct TrainingIdentity<'a> {
    network: &'a NetworkShape,
    seed: u64,
    options: &'a TrainingOptions,
    #[serde(rename = "training data")]
    training: DataIdentity,
    #[serde(rename = "validation data")]
    validation: DataIdentity,
}

/// Number of samples, and weighted sums of their positions and torques.
#[derive(Serialize)]
struct DataIdentity(usize, f64, f64);

impl DataIdentity {
    fn of(samples: &ArmSamples) -> Self {
        let sum =
            |values: &[f64]| values.iter().enumerate().map(|(i, v)| v * (1.0 + (i % 97) as f64)).sum::<f64>();
        Self(samples.len(), sum(&samples.q), sum(&samples.tau))
    }
}
