//! The recipe: strokes for the path, the rig, and the score of its recordings.

use std::path::{Path, PathBuf};

use hysteron_actuator::health::{Baseline, Health};
use hysteron_base::{BadInput, Recording};
use hysteron_control::inverse::TipPosition;
use hysteron_control::path::is_recording;

use super::feedback::with_feedback;
use super::learning::LearnedPath;
use super::options::Options;
use super::outcome::{Outcome, Recorded};
use crate::rig::record::{self, source::Source};
use crate::shared::{health, memory};
use crate::tendon::command::LimitOverrides;
use crate::tendon::evaluate::{self, Commanded};
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; an interruption; a rig that does not follow its commands.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(follow(options, context)?)
}

/// Finds the strokes, carries them out, and scores what was recorded.
fn follow(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    if options.learn && options.repeats < 2 {
        let found = format!("--repeats {}", options.repeats);
        return Err(BadInput::new("--learn", "at least two repeats", found).hint("--repeats 5").into());
    }
    let rig = Source::read(&options.rig)?;
    let n_tendons = rig.rig().tendons.len();
    let baseline = options.baseline.as_deref().map(|path| Baseline::read(path, n_tendons)).transpose()?;
    let limits = &rig.rig().limits;
    let overrides = LimitOverrides {
        stroke: [Some(limits.stroke_min), Some(limits.stroke_max)],
        rate: Some(limits.stroke_rate_max),
    };
    let repeat = |k: usize| options.out.join(format!("repeat-{}.parquet", k + 1));
    let outputs =
        options.way.reads()?.and(Some(&options.rig)).and(&options.calibration).and(&options.baseline);
    let outputs = outputs.report("--out", Some(&options.out));
    let _lock = outputs.file("--out", strokes_file(options, 0)).check(context)?;
    let goal = options.way.goal()?;
    let mut led = goal.path.clone();
    let commanded = options.way.strokes_led(&goal, &led, &overrides, context)?;
    // All are scored together: of every row time, pose and gap, and of every servo stroke, goal, angle and load.
    memory::check_result(&options.out, commanded.n_samples() * options.repeats, 9 + 4 * n_tendons)?;
    let prepared = |led: &[TipPosition], commanded: Recording| -> anyhow::Result<Recording> {
        if options.feedback {
            return with_feedback((&options.way, &goal, led), &commanded, &overrides, context);
        }
        Ok(commanded)
    };
    let (mut tips, mut learned) = (Vec::new(), LearnedPath::new());
    for k in 0..options.repeats {
        let (out, strokes) = (repeat(k), strokes_file(options, k));
        if k == 0 {
            let commanded = prepared(&led, commanded.clone())?;
            write_strokes(&commanded, &strokes, (0..options.repeats).map(repeat))?;
        } else if options.learn {
            led = learned.next(&goal, led, &repeat(k - 1))?;
            let commanded = options.way.strokes_led(&goal, &led, &overrides, context)?;
            write_strokes(&prepared(&led, commanded)?, &strokes, [out.clone()].into_iter())?;
        }
        let seed = options.seed.wrapping_add(k as u64);
        let calibration = options.calibration.clone();
        let of_strokes = record::Options::of_strokes(&options.rig, &strokes, &out, calibration, seed);
        record::run(&record::Options { feedback: options.feedback, ..of_strokes }, context)?;
        tips.push(out);
    }
    let health = Health::of_files(&tips, baseline.as_ref())?;
    health.iter().for_each(|health| health::print(health, context));
    let target = &options.way.target;
    if is_recording(target.as_ref())? {
        context.wrote(&options.out);
        return Ok(Outcome::Recorded(Recorded { out: options.out.clone(), repeats: tips, health }));
    }
    let mut tracked =
        evaluate::Options { png: options.png, ..evaluate::Options::of(target, tips, &options.out) };
    if options.learn {
        // Each is a result of its own: what they have in common is no repeatability.
        let named = |(k, path): (usize, &String)| format!("repeat {}={path}", k + 1);
        tracked.results = tracked.results.iter().enumerate().map(named).collect();
    }
    let outcome =
        evaluate::run_commanded(&tracked, Some(&Commanded { health, ..Commanded::of(&commanded) }), context)?;
    context.reported(&options.out);
    Ok(Outcome::Evaluated(Box::new(outcome)))
}

/// The file of a repeat's strokes: one for all, or where each repeat teaches the next, one for each.
fn strokes_file(options: &Options, repeat: usize) -> PathBuf {
    match repeat {
        k if options.learn && k > 0 => options.out.join(format!("strokes-{}.parquet", k + 1)),
        _ => options.out.join("strokes.parquet"),
    }
}

/// Writes the strokes; not over others that were run.
fn write_strokes(
    found: &Recording,
    path: &Path,
    mut repeats: impl Iterator<Item = PathBuf>,
) -> anyhow::Result<()> {
    let is_there = path.exists();
    if is_there && Recording::read(path)?.channels() == found.channels() {
        return Ok(());
    }
    match repeats.find(|repeat| is_there && repeat.exists()) {
        None => Ok(found.write(path)?),
        Some(repeat) => {
            let expected = format!("the strokes that {} was measured with", repeat.display());
            Err(BadInput::new(
                path.display().to_string(),
                expected,
                "others, because the inputs of the strokes have changed",
            )
            .hint("choose another --out")
            .into())
        }
    }
}
