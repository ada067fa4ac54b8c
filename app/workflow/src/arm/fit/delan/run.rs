//! Trains a model of inverse dynamics.

use std::path::PathBuf;

use hysteron_arm_learning::lagrangian::{
    ArmSamples, InputForm, LearnedDynamics, NetworkShape, Scales, TrainingOptions, samples_of, train,
};
use hysteron_base::BadInput;
use hysteron_base::checks::{CheckContext, Purpose};
use hysteron_learn::{Activation, TrainingProgress, TrainingSession};
use hysteron_report::verdict::{Criterion, Verdict};
use serde::Serialize;

use super::{Options, Outcome};
use crate::shared::outputs::Outputs;
use crate::shared::resume::Unfinished;
use crate::shared::{recording_checks, verdict};
use crate::{Context, WorkflowError};

/// Parts of a single recording.
const PARTS: usize = 8;
/// Every so many recordings, or parts, one is not trained on.
const VALIDATION: usize = 4;

/// Runs the verb.
///
/// # Errors
/// Bad input; an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(fit(options, context)?)
}

fn fit(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let state = options.out.with_extension("training");
    let unfinished = Unfinished::new(&options.out, vec![state.clone()]);
    let outputs = Outputs::reading(&options.recordings).learned("--out", &options.out);
    let _lock = outputs.check(context)?;
    if options.variant.is_hamiltonian() {
        let bad = BadInput::new("--variant", "a model of velocities", options.variant.label());
        return Err(bad.hint("recordings have no momenta").into());
    }
    context.listen();
    let findings = recording_checks::of_files(&options.recordings, &CheckContext::new(Purpose::Fit))?;
    let samples = read(&options.recordings, options.cutoff)?;
    let n = samples.trajectories.len();
    let pick =
        |is_validation: bool| (0..n).filter(move |t| (t % VALIDATION == VALIDATION / 2) == is_validation);
    let (training, validation) = (samples.select(pick(false)), samples.select(pick(true)));
    let inputs = InputForm::of(options.products as usize);
    let shape = NetworkShape {
        variant: options.variant,
        hidden: vec![options.hidden; 2],
        activation: Activation::Softplus,
        epsilon: 1e-4,
        scales: Scales::of(&training, options.variant, inputs),
        lengths: samples.lengths(),
        inputs,
        squares: options.squares as usize,
    };
    let training_options = TrainingOptions {
        polish: options.polish as usize,
        learning_rate: 5e-3,
        ..TrainingOptions::normalised(options.epochs).with_levenberg_marquardt()
    };
    let bar = context.progress("epochs", options.epochs, 0);
    let mut listener = |p: &TrainingProgress| {
        if let TrainingProgress::Epoch(epoch) = p {
            // What follows Adam counts from one again.
            bar.set_length(epoch.of as u64);
            bar.set_position(epoch.number as u64);
            bar.set_message(format!("error {:.3}", epoch.best));
        }
        !context.is_cancelled()
    };
    let mut session = TrainingSession { file: Some(&state), progress: &mut listener };
    let found = train(&shape, [&training, &validation], &training_options, options.seed, &mut session)?;
    bar.finish();
    let names: Vec<String> = options.recordings.iter().map(|path| path.display().to_string()).collect();
    let details = DelanDetails {
        recordings: names,
        seed: options.seed,
        options: training_options,
        validation: found.validation,
        epochs: found.steps[0],
        steps: found.steps[1],
        cutoff_hz: options.cutoff,
        command: &context.command,
    };
    LearnedDynamics { shape, parameters: found.parameters }.write(&options.out, &details)?;
    unfinished.end(found.is_finished, context)?;
    context.print(format_args!(
        "validation error: {:.3e} of the torques' spread, after {} epochs and {} steps",
        found.validation, found.steps[0], found.steps[1]
    ));
    Ok(Outcome {
        validation: found.validation,
        epochs: found.steps[0],
        steps: found.steps[1],
        model: options.out.clone(),
        verdict: assess(found.validation, validation.trajectories.len()),
        recording_warnings: findings.into_warnings(),
    })
}

/// Training of a model, as its file states it.
#[derive(Serialize)]
struct DelanDetails<'a> {
    recordings: Vec<String>,
    seed: u64,
    options: TrainingOptions,
    /// Error on what was not trained on, over the deviation of the torques [-].
    validation: f64,
    epochs: usize,
    steps: usize,
    cutoff_hz: f64,
    command: &'a str,
}

/// Whether the model gives torques: error over their deviation on as many trajectories that were not trained on.
fn assess(error: f64, n: usize) -> Verdict {
    let percent = 100.0 * error;
    let assessment = Verdict::on(format!("torques are given within {percent:.1} % of their deviation"))
        .because(
            Criterion::ErrorOverSpread,
            error,
            format!("the validation error is {percent:.1} % of the deviation of the torques"),
        );
    verdict::repeated(assessment, n, "trajectory in validation").verdict()
}

/// Samples of all recordings; a single one counts as several.
fn read(paths: &[PathBuf], cutoff: f64) -> anyhow::Result<ArmSamples> {
    let mut all: Option<ArmSamples> = None;
    for path in paths {
        let found = samples_of(&crate::shared::memory::recording(path)?, cutoff)
            .map_err(|bad| bad.within(path.display()))?;
        match &mut all {
            None => all = Some(found),
            Some(all) => all.append(&found).map_err(|bad| bad.within(path.display()))?,
        }
    }
    let all = all.ok_or_else(|| BadInput::new("recordings", "one or more", "none"))?;
    Ok(if all.trajectories.len() < VALIDATION { all.parted(PARTS)? } else { all })
}
