//! The methods: baselines, the network with and without looking ahead, and the controller that a training would write.

use anyhow::Result;
use hysteron_base::Bounds;
use hysteron_control::StrokeLimits;
use hysteron_control::inverse::{
    BaseMap, Dataset, Demonstration, FittedController, Folds, InverseDesign, InverseModel, PathSmoothing,
    RecurrentOptions, fit_base, fit_recurrent,
};
use hysteron_learn::{SequenceOptions, TrainingSession, mean, simplest_within};
use hysteron_workflow::tendon::train::{FOLDS, SAME};

use super::baselines::InverseBaseline;
use super::demonstrations::FTDCR_STEP;
use crate::tendon::numbers::rms;

/// No limits.
const WIDE: StrokeLimits = StrokeLimits { stroke: Bounds { min: -1.0, max: 1.0 }, stroke_rate: 1e6 };

/// Root mean square error over all strokes [mm or degrees] of what was tested, by method.
pub(super) type Errors = [f64; N_METHODS];
/// Methods.
pub(super) const N_METHODS: usize = 7;
/// Names of the methods.
pub(super) const METHODS: [&str; N_METHODS] = [
    "static regression",
    "static regression, delayed",
    "kernel on two tips, delayed",
    "kernel regression",
    "network, no look ahead",
    "network",
    "chosen in folds, fitted to all",
];

/// Errors, and the delays that the methods chose [s].
pub(super) struct InverseScores {
    /// Errors.
    pub errors: Errors,
    /// Delays.
    pub delays_s: Errors,
}

/// How to train on the trunk: its motors run about a quarter of a second ahead of the tip, which the horizons span.
pub(super) fn trunk_options(quick: bool) -> RecurrentOptions {
    let default = RecurrentOptions::default();
    let epochs = if quick { 2 } else { 60 };
    RecurrentOptions { learning: SequenceOptions { epochs, truncation: 100, ..default.learning }, ..default }
}

/// How to train on patterns of some tens of rows, far apart in time.
pub(super) fn ftdcr_options(quick: bool) -> RecurrentOptions {
    let default = RecurrentOptions::default();
    let learning = SequenceOptions {
        hidden: 48,
        epochs: if quick { 2 } else { 600 },
        patience: 200,
        learning_rate: 5e-3,
        ema: 0.05,
        ..default.learning
    };
    RecurrentOptions {
        learning,
        half_width_s: FTDCR_STEP,
        horizons_s: vec![FTDCR_STEP],
        filters_s: vec![2.0, 10.0],
        ..default
    }
}

/// The same for a path that is not known in advance.
fn without_looking_ahead(options: &RecurrentOptions) -> RecurrentOptions {
    RecurrentOptions {
        smoothing: PathSmoothing::Causal,
        horizons_s: Vec::new(),
        largest_delay_s: 0.0,
        ..options.clone()
    }
}

/// Trained controllers.
pub(super) struct Controllers {
    kernel: InverseModel,
    blind: InverseModel,
    seeing: InverseModel,
    shipped: InverseModel,
}

impl Controllers {
    /// Trains on `known`.
    pub fn new(known: &Dataset, options: &RecurrentOptions) -> Result<Self> {
        let kernel = RecurrentOptions { base: BaseMap::Kernel, ..options.clone() };
        Ok(Self {
            kernel: fit_base(known, &kernel)?.model,
            blind: network(known, &without_looking_ahead(options))?.model,
            seeing: network(known, options)?.model,
            shipped: shipped([&known.training[..], &known.validation].concat(), options)?,
        })
    }

    /// Errors on `test`, next to those of baselines with the same data.
    pub fn scores(
        &self,
        test: &[&Demonstration],
        [plain, delayed, kernel]: &[InverseBaseline; 3],
    ) -> Result<InverseScores> {
        let models = [&self.kernel, &self.blind, &self.seeing, &self.shipped];
        let delay = |model: &InverseModel| match &model.design {
            InverseDesign::Recurrent { features, .. } => features.delay_s,
            InverseDesign::Windowed { .. } => 0.0,
        };
        let mut scores = InverseScores { errors: [0.0; N_METHODS], delays_s: [0.0; N_METHODS] };
        for (k, baseline) in [plain, delayed, kernel].into_iter().enumerate() {
            (scores.errors[k], scores.delays_s[k]) = (baseline.error, baseline.delay_s);
        }
        for (k, model) in models.into_iter().enumerate() {
            (scores.errors[3 + k], scores.delays_s[3 + k]) = (error(test, model)?, delay(model));
        }
        Ok(scores)
    }
}

fn network(known: &Dataset, options: &RecurrentOptions) -> Result<FittedController> {
    Ok(fit_recurrent(known, options, &mut TrainingSession { file: None, progress: &mut |_| true })?)
}

/// The controller that `train` writes for such data: static regression, kernel regression or network, the simplest of those that err
/// least on demonstrations left out in folds, fitted to all; a network for as many epochs as in the folds.
fn shipped(all: Vec<Demonstration>, options: &RecurrentOptions) -> Result<InverseModel> {
    let folds = Folds::new(all, FOLDS, options.seed)?;
    let base = |base: BaseMap| RecurrentOptions { base, ..options.clone() };
    let bases = [base(BaseMap::Cubic), base(BaseMap::Kernel)];
    let (mut squares, mut epochs) = ([0.0; 3], Vec::new());
    for k in 0..folds.len() {
        let data = folds.fold(k);
        let learned = network(&data, options)?;
        epochs.push(learned.report.epochs as f64);
        let models = [fit_base(&data, &bases[0])?.model, fit_base(&data, &bases[1])?.model, learned.model];
        let left_out: Vec<&Demonstration> = data.validation.iter().collect();
        for (square, model) in squares.iter_mut().zip(&models) {
            *square += error(&left_out, model)?.powi(2);
        }
    }
    let whole = folds.whole();
    Ok(match simplest_within(SAME, &squares.map(f64::sqrt)) {
        Some(k @ (0 | 1)) => fit_base(&whole, &bases[k])?.model,
        _ => {
            let ends_after = Some((mean(&epochs).round() as usize).max(1));
            let learning = SequenceOptions { ends_after, ..options.learning };
            network(&whole, &RecurrentOptions { learning, ..options.clone() })?.model
        }
    })
}

/// Root mean square of what strokes miss [mm].
fn error(test: &[&Demonstration], model: &InverseModel) -> Result<f64> {
    let mut off = Vec::new();
    for one in test {
        let found = model.command(&one.tip, WIDE, &mut |_| true)?.strokes;
        off.extend(found.iter().zip(&one.strokes).map(|(found, made)| 1e3 * (found - made)));
    }
    Ok(rms(off))
}
