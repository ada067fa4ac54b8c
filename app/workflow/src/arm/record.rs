//! `hysteron arm record`: a follower follows the leader that a person moves, and is recorded.

use std::path::PathBuf;

use hysteron_arm::POSITION_GAIN;
use hysteron_base::{BadInput, Lock, Metadata};
use hysteron_rig::teleoperation::{Arms, ArmsConfig, ArmsOutcome, ArmsRecording, Estimates};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Context;
use crate::rig::record::partial_files::rescue;
use crate::shared::error::Cancelled;
use crate::shared::watchdog::Watched;

/// Longest recording: a day [s].
const LONGEST: f64 = 86_400.0;
/// Heaviest payload [g].
const HEAVIEST_G: f64 = 100_000.0;

/// Record a follower that follows the leader in your hand
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of both arms (.toml)
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub arms: PathBuf,
    /// Recording to write, .parquet or .csv
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
    /// End after that many seconds [default: at Ctrl-C]
    #[cfg_attr(feature = "clap", arg(long, value_name = "SECONDS", allow_negative_numbers = true))]
    pub seconds: Option<f64>,
    /// What the follower carries; the recording says so
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "G", default_value_t = 0.0, allow_negative_numbers = true)
    )]
    pub payload_g: f64,
    /// A motor of the follower is degraded; the recording says so
    #[cfg_attr(feature = "clap", arg(long))]
    pub degraded: bool,
}

/// The outcome of `arm record`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// The recording.
    pub recording: PathBuf,
    /// Number of samples.
    pub rows: usize,
    /// Samples that were not measured and are filled in.
    pub filled_in: usize,
    /// Cycles that came late.
    pub late_cycles: usize,
}

impl crate::shared::outcome::Outcome for Outcome {}

/// Carries out the verb.
///
/// # Errors
/// Bad input; arms that do not answer; a limit that was passed.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let config = ArmsConfig::read(&options.arms)?;
    let outcome = record((options, &config), Estimates::none(), context)?;
    Ok(summary(&outcome, context))
}

/// Says what was recorded, and returns it.
pub(crate) fn summary(outcome: &ArmsOutcome, context: &Context) -> Outcome {
    context.print(format_args!(
        "{}: {} rows, {} of them filled in, {} cycles late",
        outcome.out.display(),
        outcome.n_rows,
        outcome.n_gaps,
        outcome.n_late
    ));
    Outcome {
        recording: outcome.out.clone(),
        rows: outcome.n_rows,
        filled_in: outcome.n_gaps,
        late_cycles: outcome.n_late,
    }
}

/// Records with further channels that are computed from each row.
///
/// # Errors
/// As [`run`].
pub(crate) fn record(
    (options, config): (&Options, &ArmsConfig),
    estimates: Estimates<'_>,
    context: &Context,
) -> anyhow::Result<ArmsOutcome> {
    check(options)?;
    let _file = Lock::file(&options.out)?;
    context.listen_on_rig();
    rescue(&options.out)?;
    let mut arms = Arms::open(config)?;
    arms.prepare()?;
    let mut arms = Watched::new(arms, &options.arms, context)?;
    let meta = metadata(options, config, context);
    let recording = ArmsRecording::begin(config, &options.out, &meta, estimates)?;
    context.print(format_args!(
        "{} joints at {:.0} Hz; the follower goes to the leader first{}",
        config.joints.len(),
        1.0 / config.period,
        if options.seconds.is_none() { "; Ctrl-C ends the recording" } else { "" }
    ));
    let total = options.seconds.map_or(0, |seconds| (seconds / config.period).round() as usize);
    let bar = context.progress("samples", total, 0);
    let outcome = recording.run(&mut arms, options.seconds, &|| context.is_cancelled(), &mut |passed| {
        bar.set_position((passed / config.period).round() as u64);
    })?;
    bar.finish();
    if outcome.is_released {
        arms.close();
    }
    ended(&outcome)?;
    Ok(outcome)
}

fn check(options: &Options) -> anyhow::Result<()> {
    let out = &options.out;
    if out.exists() {
        let hint = "a measurement is never overwritten; move it away or choose another --out";
        return Err(BadInput::new(out.display().to_string(), "a new file", "one that exists")
            .hint(hint)
            .into());
    }
    if !matches!(out.extension().and_then(|ending| ending.to_str()), Some("parquet" | "csv")) {
        return Err(BadInput::new("--out", "a file .parquet or .csv", out.display().to_string()).into());
    }
    if let Some(seconds) = options.seconds
        && !(seconds > 0.0 && seconds <= LONGEST)
    {
        return Err(BadInput::new("--seconds", format!("0 < x <= {LONGEST}"), seconds.to_string()).into());
    }
    if !(0.0..=HEAVIEST_G).contains(&options.payload_g) {
        let found = options.payload_g.to_string();
        return Err(BadInput::new("--payload-g", format!("0 to {HEAVIEST_G}"), found).into());
    }
    Ok(())
}

/// Provenance, in the words of recordings that are imported.
fn metadata(options: &Options, config: &ArmsConfig, context: &Context) -> Metadata {
    let mut meta = super::meta(context, &format!("arms {}: leader and follower", config.name));
    let names: Vec<&str> = config.joints.iter().map(|joint| joint.name.as_str()).collect();
    let condition = if options.degraded { "degraded" } else { "healthy" };
    for (key, value) in [
        ("robot", config.name.clone()),
        ("arms.sha256", config.hash.clone()),
        ("joint_names", names.join(", ")),
        ("payload_kg", (1e-3 * options.payload_g).to_string()),
        ("condition", condition.to_owned()),
    ] {
        meta.extra.insert(key.to_owned(), value);
    }
    // Without proportional part there is no gain to tell.
    if let gain @ 1.. = config.follower.gains[0] {
        meta.extra.insert(POSITION_GAIN.to_owned(), gain.to_string());
    }
    meta
}

/// Whether the recording came to its end; if not, why not, and where what was recorded is.
fn ended(outcome: &ArmsOutcome) -> anyhow::Result<()> {
    if let Some(trouble) = &outcome.torque_trouble {
        anyhow::bail!("follower: {trouble}; switch its supply off");
    }
    anyhow::ensure!(
        outcome.is_released,
        "the follower's torque is not known to be off; switch its supply off"
    );
    let kept = if outcome.n_rows == 0 {
        "nothing was recorded yet".to_owned()
    } else {
        format!("{} rows are in {}", outcome.n_rows, outcome.out.display())
    };
    if let Some(error) = &outcome.stopped {
        anyhow::bail!("{error} ({kept})");
    }
    if outcome.was_interrupted {
        return Err(Cancelled::new(format!(" ({kept})")).into());
    }
    Ok(())
}
