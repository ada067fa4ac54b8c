//! Records a follower that follows the leader in a person's hand.

use hysteron_arm_estimation::POSITION_GAIN;
use hysteron_base::{BadInput, Lock, Metadata};
use hysteron_rig::teleoperation::{ArmPair, ArmsConfig, ArmsOutcome, ArmsRecording, Estimates};

use super::{Options, Outcome};
use crate::arm;
use crate::rig::record::partial_files::keep_partial;
use crate::shared::error::Cancelled;
use crate::shared::watchdog::WatchdogGuard;
use crate::{Context, WorkflowError};

/// Longest recording: a day [s].
const LONGEST: f64 = 86_400.0;
/// Heaviest payload [g].
const HEAVIEST_G: f64 = 100_000.0;

/// Runs the verb.
///
/// # Errors
/// Bad input; arms that do not answer; a limit that was passed.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    let config = ArmsConfig::read(&options.arms).map_err(anyhow::Error::from)?;
    let recorded = record((options, &config), Estimates::none(), context)?;
    Ok(summary(&recorded, context))
}

/// Says what was recorded, and returns it.
pub(in crate::arm) fn summary(outcome: &ArmsOutcome, context: &Context) -> Outcome {
    context.print(format_args!(
        "{}: {} rows, {} of them filled in, {} cycles late",
        outcome.out.display(),
        outcome.n_rows,
        outcome.n_gaps,
        outcome.n_late
    ));
    Outcome::new(outcome)
}

/// Records with further channels that are computed from each row.
///
/// # Errors
/// As [`run`].
pub(in crate::arm) fn record(
    (options, config): (&Options, &ArmsConfig),
    estimates: Estimates<'_>,
    context: &Context,
) -> anyhow::Result<ArmsOutcome> {
    check(options)?;
    let _file = Lock::file(&options.out)?;
    context.listen_on_rig();
    keep_partial(&options.out)?;
    let mut arms = ArmPair::open(config)?;
    arms.prepare()?;
    let mut arms = WatchdogGuard::new(arms, &options.arms, context)?;
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
    let mut meta = arm::meta(context, &format!("arms {}: leader and follower", config.name));
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
    // Without a proportional term there is no gain to note.
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
