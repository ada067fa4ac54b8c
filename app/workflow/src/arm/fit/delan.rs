//! `hysteron arm fit delan`: a learned model of inverse dynamics from recordings.

use std::path::PathBuf;

use hysteron_arm::lagrangian::{
    InputForm, LearnedDynamics, NetworkShape, Samples, Scales, TrainingOptions, Variant, samples_of, train,
};
use hysteron_base::checks::{CheckContext, Purpose};
use hysteron_base::{BadInput, Recording, json};
use hysteron_learn::{Activation, Progress, Session};
use hysteron_report::verdict::{Criterion, Verdict};
use serde_json::Value;

use crate::shared::outputs::Outputs;
use crate::shared::recording_checks;
use crate::shared::resume::Unfinished;
use crate::{Context, shared::verdict};

/// Learn inverse dynamics with a model of the DeLaN family
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Recordings to learn from
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Model to write, .safetensors
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: PathBuf,
    /// structured-lagrangian, black-box-lagrangian, feed-forward, friction or augmented
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", default_value = "augmented", value_parser = crate::study::arm::variant))]
    pub variant: Variant,
    /// Units of each of the two hidden layers
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 64, value_parser = crate::shared::number::count::<{ hysteron_learn::MAX_HIDDEN }>))]
    pub hidden: usize,
    /// The network sees products of the sines and cosines of up to so many joints, with a linear path past its hidden layers; 0 for sines and cosines alone
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0, value_parser = crate::shared::number::up_to::<4>))]
    pub products: u32,
    /// Squares in the kinetic energy beyond one for each joint; of a chain of turning joints two for each in a plane, or six, hold it exactly, with --products; up to 32
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0, value_parser = crate::shared::number::up_to::<32>))]
    pub squares: u32,
    /// Epochs of Adam at most
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 200, value_parser = crate::shared::number::count::<{ hysteron_learn::MAX_EPOCHS }>))]
    pub epochs: usize,
    /// Steps of Levenberg and Marquardt's method after Adam at most, in double precision; for up to 8000 parameters
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0, value_parser = crate::shared::number::up_to::<100_000>))]
    pub polish: u32,
    /// Velocities above this are noise, where accelerations are differences of them
    #[cfg_attr(feature = "clap", arg(long, value_name = "HZ", default_value_t = 10.0, value_parser = crate::shared::number::cutoff_hz))]
    pub cutoff: f64,
    /// Of initial parameters and of minibatches
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0))]
    pub seed: u64,
}

/// Parts of a single recording.
const PARTS: usize = 8;
/// Every so many recordings, or parts, one is not trained on.
const VALIDATION: usize = 4;

/// Carries out the verb.
///
/// # Errors
/// Bad input; an interruption.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Value> {
    let state = options.out.with_extension("training");
    let unfinished = Unfinished::new(&options.out, vec![state.clone()]);
    let outputs = Outputs::reading(&options.recordings).learned("--out", &options.out);
    let _claim = outputs.check(context)?;
    if options.variant.is_hamiltonian() {
        let bad = BadInput::new("--variant", "a model of velocities", options.variant.label());
        return Err(bad.hint("recordings have no momenta").into());
    }
    context.listen();
    let findings = recording_checks::of_files(&options.recordings, &CheckContext::new(Purpose::Fit))?;
    let samples = read(&options.recordings, options.cutoff)?;
    let n = samples.trajectories.len();
    let pick = |held: bool| (0..n).filter(move |t| (t % VALIDATION == VALIDATION / 2) == held);
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
    let mut listener = |p: &Progress| {
        if let Progress::Epoch(epoch) = p {
            // What follows Adam counts from one again.
            bar.set_length(epoch.of as u64);
            bar.set_position(epoch.number as u64);
            bar.set_message(format!("error {:.3}", epoch.best));
        }
        !context.is_cancelled()
    };
    let mut session = Session { file: Some(&state), progress: &mut listener };
    let found = train(&shape, [&training, &validation], &training_options, options.seed, &mut session)?;
    bar.finish();
    let names: Vec<String> = options.recordings.iter().map(|path| path.display().to_string()).collect();
    let details = json!({
        "recordings": names, "seed": options.seed, "options": training_options, "validation": found.validation,
        "epochs": found.steps[0], "steps": found.steps[1], "cutoff_hz": options.cutoff, "command": context.command,
    });
    let model = LearnedDynamics { shape, parameters: found.parameters, details };
    model.write(&options.out)?;
    unfinished.end(found.is_finished, context)?;
    context.print(format_args!(
        "error on what was not trained on: {:.3e} of the torques' spread, after {} epochs and {} steps",
        found.validation, found.steps[0], found.steps[1]
    ));
    let verdict = judged(found.validation, validation.trajectories.len());
    Ok(json!({
        "validation": found.validation, "epochs": found.steps[0], "steps": found.steps[1], "model": options.out,
        "verdict": verdict, "recording_warnings": findings,
    }))
}

/// Whether the model gives torques: error over their deviation on as many trajectories that were not trained on.
fn judged(error: f64, n: usize) -> Verdict {
    let percent = 100.0 * error;
    let judged = Verdict::on(format!("torques are given within {percent:.1} % of their deviation")).because(
        Criterion::ErrorOverSpread,
        error,
        format!("on what was not trained on, the error is {percent:.1} % of the deviation of the torques"),
    );
    verdict::repeated(judged, n, "trajectory in validation").verdict()
}

/// Samples of all recordings; a single one counts as several.
fn read(paths: &[PathBuf], cutoff: f64) -> anyhow::Result<Samples> {
    let mut all: Option<Samples> = None;
    for path in paths {
        let found = samples_of(&Recording::read(path)?, cutoff).map_err(|bad| bad.within(path.display()))?;
        match &mut all {
            None => all = Some(found),
            Some(all) => all.append(&found).map_err(|bad| bad.within(path.display()))?,
        }
    }
    let all = all.ok_or_else(|| BadInput::new("recordings", "one or more", "none"))?;
    Ok(if all.trajectories.len() < VALIDATION { all.parted(PARTS)? } else { all })
}
