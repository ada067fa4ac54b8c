//! The methods: baselines, and the network with and without looking ahead.

use anyhow::Result;
use hysteron_base::Bounds;
use hysteron_control::StrokeLimits;
use hysteron_control::inverse::{
    Dataset, Demonstration, InverseDesign, InverseModel, PathSmoothing, RecurrentOptions, TipPosition,
    fit_recurrent,
};
use hysteron_learn::{SequenceOptions, TrainingSession};

use super::baselines::InverseBaseline;
use super::demonstrations::FTDCR_STEP;
use crate::tendon::numbers::rms;

/// No limits.
const WIDE: StrokeLimits = StrokeLimits { stroke: Bounds { min: -1.0, max: 1.0 }, stroke_rate: 1e6 };

/// Root mean square error over all strokes [mm or degrees] of what was tested, by method.
pub(super) type Errors = [f64; METHODS.len()];
/// Names of the methods.
pub(super) const METHODS: [&str; 5] = [
    "static regression",
    "static regression, delayed",
    "kernel on two tips, delayed",
    "network, no look ahead",
    "network",
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

/// Trains both networks on `known` and tests on `test`, next to baselines with the same data.
pub(super) fn evaluate(
    known: &Dataset,
    test: &[&Demonstration],
    [plain, delayed, kernel]: &[InverseBaseline; 3],
    options: &RecurrentOptions,
) -> Result<InverseScores> {
    let fit = |options: &RecurrentOptions| -> Result<InverseModel> {
        Ok(fit_recurrent(known, options, &mut TrainingSession { file: None, progress: &mut |_| true })?.model)
    };
    let (blind, seeing) = (fit(&without_looking_ahead(options))?, fit(options)?);
    let InverseDesign::Recurrent { features, .. } = &seeing.design else {
        unreachable!("what fit_recurrent makes")
    };
    let by = |model: &InverseModel, path: &[TipPosition]| -> Result<Vec<f64>> {
        Ok(model.command(path, WIDE, &mut |_| true)?.strokes)
    };
    let errors = [
        plain.error,
        delayed.error,
        kernel.error,
        error(test, &|path| by(&blind, path))?,
        error(test, &|path| by(&seeing, path))?,
    ];
    Ok(InverseScores {
        errors,
        delays_s: [plain.delay_s, delayed.delay_s, kernel.delay_s, 0.0, features.delay_s],
    })
}

/// Root mean square of what strokes miss [mm].
fn error(test: &[&Demonstration], strokes: &dyn Fn(&[TipPosition]) -> Result<Vec<f64>>) -> Result<f64> {
    let mut off = Vec::new();
    for one in test {
        let found = strokes(&one.tip)?;
        off.extend(found.iter().zip(&one.strokes).map(|(found, made)| 1e3 * (found - made)));
    }
    Ok(rms(off))
}
