//! `hysteron track`: a path, its strokes, the rig, and how closely the tip followed; open loop.

use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, Recording};
use hysteron_control::path::is_recording;
use hysteron_report::verdict::Verdict;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use crate::Context;
use crate::rig::record::{self, source::Source};
use crate::shared::health::{self, Baseline, Health};
use crate::shared::outcome;
use crate::tendon::command::{LimitOverrides, Way};
use crate::tendon::evaluate::{self, Commanded};

/// More than anybody measures in a day.
#[cfg(feature = "clap")]
const MAX_REPEATS: usize = 100;

/// Follow a path open loop on a rig, and measure it
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// The path, and what finds strokes for it.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub way: Way,
    /// Rig file, or virtual:PRESET
    #[cfg_attr(feature = "clap", arg(long, value_name = "RIG"))]
    pub rig: PathBuf,
    /// Folder to write to
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub out: PathBuf,
    /// How often the strokes are carried out
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 1, value_parser = crate::shared::number::count::<MAX_REPEATS>))]
    pub repeats: usize,
    /// Calibration [default: the file that the rig file names; a virtual rig calibrates itself]
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub calibration: Option<PathBuf>,
    /// Seed of a virtual rig's noise; every repeat has the next one
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 1))]
    pub seed: u64,
    /// State of the healthy servos as a baseline: metrics.json of an earlier record or track, or the output of
    /// hysteron identify-servo
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub baseline: Option<PathBuf>,
    /// Write each figure as .png too
    #[cfg_attr(feature = "clap", arg(long))]
    pub png: bool,
}

/// The outcome of `track`: of a path, how closely the tip followed it; of recorded strokes, the recordings.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Outcome {
    /// The score of the repeats.
    Evaluated(Box<evaluate::Outcome>),
    /// The repeats alone.
    Recorded(Recorded),
}

/// Repeats of recorded strokes.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Recorded {
    /// Folder of the recordings.
    pub out: PathBuf,
    /// The recordings.
    pub repeats: Vec<PathBuf>,
    /// Condition of the servos, of a rig that has some.
    pub health: Option<Health>,
}

impl crate::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        match self {
            Self::Evaluated(outcome) => Some(&outcome.verdict),
            Self::Recorded(_) => None,
        }
    }
}

impl<'de> Deserialize<'de> for Outcome {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        outcome::by_key(deserializer, "repeats", Self::Recorded, |outcome| Self::Evaluated(Box::new(outcome)))
    }
}

/// Carries out the verb.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let rig = Source::read(&options.rig)?;
    let n_tendons = rig.rig().tendons.len();
    let baseline = options.baseline.as_deref().map(|path| Baseline::read(path, n_tendons)).transpose()?;
    let limits = &rig.rig().limits;
    let given = LimitOverrides {
        stroke: [Some(limits.stroke_min), Some(limits.stroke_max)],
        rate: Some(limits.stroke_rate_max),
    };
    let strokes = options.out.join("strokes.parquet");
    let repeat = |k: usize| options.out.join(format!("repeat-{}.parquet", k + 1));
    let outputs =
        options.way.reads()?.and(Some(&options.rig)).and(&options.calibration).and(&options.baseline);
    let outputs = outputs.report("--out", Some(&options.out));
    let _claim = outputs.file("--out", &strokes).check(context)?;
    let commanded = options.way.strokes(&given, context)?;
    write_strokes(&commanded, &strokes, (0..options.repeats).map(repeat))?;
    let mut tips = Vec::new();
    for k in 0..options.repeats {
        let out = repeat(k);
        let seed = options.seed.wrapping_add(k as u64);
        let calibration = options.calibration.clone();
        record::run(&record::Options::of_strokes(&options.rig, &strokes, &out, calibration, seed), context)?;
        tips.push(out);
    }
    let health = Health::of_files(&tips, baseline.as_ref())?;
    health.iter().for_each(|health| health::print(health, context));
    let target = &options.way.target;
    if is_recording(target.as_ref())? {
        context.wrote(&options.out);
        return Ok(Outcome::Recorded(Recorded { out: options.out.clone(), repeats: tips, health }));
    }
    let tracked = evaluate::Options::of(target, tips, &options.out, options.png);
    let outcome =
        evaluate::run_commanded(&tracked, Some(&Commanded { health, ..Commanded::of(&commanded) }), context)?;
    context.reported(&options.out);
    Ok(Outcome::Evaluated(Box::new(outcome)))
}

/// Writes the strokes; not over others that were carried out.
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
                "others, for what they are found with has changed",
            )
            .hint("choose another --out")
            .into())
        }
    }
}
