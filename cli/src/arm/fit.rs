//! `hysteron arm fit delan` and `hysteron arm evaluate`: a learned model of inverse dynamics from recordings, and on
//! others.

use std::path::PathBuf;

use hysteron_arm::lagrangian::{
    LearnedDynamics, NetworkShape, Samples, Scales, Scores, TrainingOptions, Variant, samples_of, train,
};
use hysteron_arm::{Quantity, Recorded};
use hysteron_base::{BadInput, Channel, Recording};
use hysteron_learn::{Activation, MOST_EPOCHS, MOST_HIDDEN, Progress, Session};
use serde_json::{Value, json};

use hysteron_workflow::outputs::Outputs;
use hysteron_workflow::{Caller, number};
use hysteron_workflow::{arm, arm_study};

use crate::terminal::say;

const FIT_HELP: &str = "\
Needs recordings (.csv or .parquet) with time_s and q_k_rad, dq_k_rad_s, tau_k_n_m of every joint, as hysteron arm import writes them. \
Accelerations are ddq_k_rad_s2, or differences of the velocities below --cutoff. Every fourth recording, or every fourth part of a single \
one, is not trained on: it tells when to stop.

Writes a model for `hysteron arm evaluate`. Ctrl-C ends the training; the same command goes on from OUT.training.

Example, from the root of the repository:
  hysteron arm simulate three-link --torques arm/tests/data/torques.csv --start 0.3,-0.4,0.5 --out out/arm/motion.csv
  hysteron arm fit delan out/arm/motion.csv --epochs 20 --out out/arm/model.safetensors

Exit codes: 0 done, 1 failed or interrupted, 2 bad input.";

/// Learn a model from recordings
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    Delan(FitArguments),
}

/// Learn inverse dynamics with a model of the DeLaN family
#[derive(Debug, clap::Args)]
#[command(after_help = FIT_HELP)]
struct FitArguments {
    /// Recordings to learn from
    #[arg(required = true, value_name = "REC")]
    recordings: Vec<PathBuf>,
    /// Model to write, .safetensors
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// structured-lagrangian, black-box-lagrangian, feed-forward, friction or augmented
    #[arg(long, value_name = "NAME", default_value = "augmented", value_parser = arm_study::variant)]
    variant: Variant,
    /// Units of each of the two hidden layers
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = number::count::<MOST_HIDDEN>)]
    hidden: usize,
    /// Epochs of Adam at most
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = number::count::<MOST_EPOCHS>)]
    epochs: usize,
    /// Velocities above this are noise, where accelerations are differences of them
    #[arg(long, value_name = "HZ", default_value_t = 10.0)]
    cutoff: f64,
    /// Of initial parameters and of minibatches
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
}

/// Parts of a single recording.
const PARTS: usize = 8;
/// Every so many recordings, or parts, one is not trained on.
const VALIDATION: usize = 4;

/// Carries out the verb.
pub fn run(Arguments { what: What::Delan(arguments) }: &Arguments, caller: &Caller) -> anyhow::Result<Value> {
    let state = arguments.out.with_extension("training");
    let outputs = Outputs::reading(&arguments.recordings).file("--out", &arguments.out);
    let _claim = outputs.check(caller)?;
    if arguments.variant.is_hamiltonian() {
        let bad = BadInput::new("--variant", "a model of velocities", arguments.variant.label());
        return Err(bad.hint("recordings have no momenta").into());
    }
    caller.listen()?;
    let samples = read(&arguments.recordings, arguments.cutoff)?;
    let n = samples.trajectories.len();
    let pick = |held: bool| (0..n).filter(move |t| (t % VALIDATION == VALIDATION / 2) == held);
    let (training, validation) = (samples.select(pick(false)), samples.select(pick(true)));
    let shape = NetworkShape {
        variant: arguments.variant,
        hidden: vec![arguments.hidden; 2],
        activation: Activation::Softplus,
        epsilon: 1e-4,
        scales: Scales::of(&training, arguments.variant),
        lengths: vec![None; samples.n_joints],
    };
    let options =
        TrainingOptions { polish: 0, learning_rate: 5e-3, ..TrainingOptions::normalised(arguments.epochs) };
    let bar = caller.progress("epochs", arguments.epochs, 0);
    let mut listener = |p: &Progress| {
        if let Progress::Epoch(epoch) = p {
            bar.set_position(epoch.number as u64);
            bar.set_message(format!("error {:.3}", epoch.best));
        }
        !caller.is_cancelled()
    };
    let mut session = Session { file: Some(&state), progress: &mut listener };
    let found = train(&shape, [&training, &validation], &options, arguments.seed, &mut session)?;
    bar.finish();
    let names: Vec<String> = arguments.recordings.iter().map(|path| path.display().to_string()).collect();
    let details = json!({
        "recordings": names, "seed": arguments.seed, "options": options, "validation": found.validation,
        "epochs": found.steps[0], "cutoff_hz": arguments.cutoff, "command": caller.command,
    });
    let model = LearnedDynamics { shape, parameters: found.parameters, details };
    model.write(&arguments.out)?;
    if !found.is_finished {
        anyhow::bail!(
            "interrupted; the best model so far is {}: the same command goes on",
            arguments.out.display()
        );
    }
    // The model is whole: what it could go on from is not needed.
    std::fs::remove_file(&state)
        .or_else(|e| if e.kind() == std::io::ErrorKind::NotFound { Ok(()) } else { Err(e) })?;
    say(format_args!(
        "error on what was not trained on: {:.4} of the torques' spread, after {} epochs: {}",
        found.validation,
        found.steps[0],
        arguments.out.display()
    ));
    Ok(json!({ "validation": found.validation, "epochs": found.steps[0], "model": arguments.out }))
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

const EVALUATE_HELP: &str = "\
Needs a model by hysteron arm fit, and recordings as that. Prints the error of every joint, over the variance of its torque too, and R²: \
pooled over all joints, as some publications do, and of each joint about its own mean.

With --out the parts of the torque go to a recording: tau_k_n_m of the model, inertial_k_n_m, coriolis_k_n_m, gravity_k_n_m, other_k_n_m.

Example, after that of `hysteron arm fit delan --help`:
  hysteron arm evaluate out/arm/model.safetensors out/arm/motion.csv --out out/arm/parts.csv

Exit codes: 0 done, 1 failed, 2 bad input (nothing is written).";

/// Compare a learned model's torques with recorded ones, and part them
#[derive(Debug, clap::Args)]
#[command(after_help = EVALUATE_HELP)]
pub struct EvaluateArguments {
    /// Model by hysteron arm fit
    model: PathBuf,
    /// Recording to compare with
    #[arg(value_name = "REC")]
    recording: PathBuf,
    /// Where the parts of the torque go, .csv or .parquet
    #[arg(long, value_name = "REC")]
    out: Option<PathBuf>,
    /// Velocities above this are noise, where accelerations are differences of them
    #[arg(long, value_name = "HZ", default_value_t = 10.0)]
    cutoff: f64,
}

/// Carries out the verb.
pub fn evaluate(arguments: &EvaluateArguments, caller: &Caller) -> anyhow::Result<Value> {
    let outputs = Outputs::reading([&arguments.model, &arguments.recording]);
    let outputs = arguments.out.iter().fold(outputs, |outputs, out| outputs.file("--out", out));
    let _claim = outputs.check(caller)?;
    let model = LearnedDynamics::read(&arguments.model)?;
    let recording = Recording::read(&arguments.recording)?;
    let within = |bad: BadInput| bad.within(arguments.recording.display());
    let samples = samples_of(&recording, arguments.cutoff).map_err(within)?;
    let parts = model.decompose(&samples).map_err(within)?;
    let n = samples.n_joints;
    let scores = Scores::of(n, &samples.tau, &parts.torque);
    for j in 0..n {
        say(format_args!(
            "joint {}: mean squared error {:.4e}, over the variance {:.4e}",
            j + 1,
            scores.mse[j],
            scores.nmse[j]
        ));
    }
    say(format_args!("R² pooled {:.4}, mean of the joints {:.4}", scores.pooled_r2, scores.mean_r2()));
    let summary = json!({
        "mse_n2_m2": scores.mse, "nmse": scores.nmse, "pooled_r2": scores.pooled_r2, "mean_r2": scores.mean_r2(),
    });
    let Some(out) = &arguments.out else { return Ok(summary) };
    let recorded = Recorded::of(&recording).map_err(within)?;
    let kept: Vec<bool> = recorded.gap.iter().map(|gap| !gap).collect();
    let time: Vec<f64> =
        recorded.time.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(t, _)| *t).collect();
    let sets = [&parts.torque, &parts.inertial, &parts.coriolis, &parts.gravity, &parts.other];
    let mut channels = Vec::new();
    for (name, values) in ["tau", "inertial", "coriolis", "gravity", "other"].into_iter().zip(sets) {
        for (j, joint) in recorded.joints.iter().enumerate() {
            let torque = Quantity::Torque.channel(joint.kind, j);
            let column = values.iter().skip(j).step_by(n).copied().collect();
            channels.push(Channel::new(torque.replacen("tau", name, 1), column));
        }
    }
    let gap = vec![false; time.len()];
    let meta = arm::meta(caller, "learned inverse dynamics");
    Recording::new(time, channels, gap, meta)?.write(out)?;
    say(format_args!("{} rows: {}", samples.len(), out.display()));
    Ok(summary)
}
