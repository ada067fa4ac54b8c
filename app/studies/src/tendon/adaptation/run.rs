//! The run of `study adaptation`.

use std::path::Path;

use anyhow::{Context as _, Result};
use hysteron_base::file;
use hysteron_rig::calibration::RigCalibration;
use hysteron_rig::config::RigConfig;
use hysteron_twin::residual::AdaptedParts;
use hysteron_virtual_rig::virtual_rig::{VirtualRobot, rig_file};
use hysteron_workflow::tendon::adapt;
use hysteron_workflow::{Context, WorkflowError};

use super::outcome::{AdaptationMetrics, Row, Tip, UNCHANGED};
use crate::tendon::commands::{ChainCommands, FRICTION, read_outcome};
use crate::tendon::population::write_recorded_plan;
use crate::tendon::{Options, Outcome, session};

/// A change of the preset `typical`: lines of its file, and the length by which its first tendon is released
/// [m]. A rig finds its zeros before it records; a tendon that has gone slack since is one whose zero in the
/// calibration is not where it was found.
struct Change {
    name: &'static str,
    lines: &'static [(&'static str, &'static str)],
    slack: f64,
}

const CHANGES: [Change; 5] = [
    Change { name: UNCHANGED, lines: &[], slack: 0.0 },
    Change {
        name: "friction times 1.5",
        lines: &[
            ("friction_coefficient = 0.22", "friction_coefficient = 0.33"),
            ("friction_force_n = 0.10", "friction_force_n = 0.15"),
        ],
        slack: 0.0,
    },
    Change { name: "play +0.3 mm", lines: &[("play_mm = 0.10", "play_mm = 0.40")], slack: 0.0 },
    Change { name: "a tendon slack by 0.6 mm", lines: &[], slack: 0.6e-3 },
    Change {
        name: "load added",
        lines: &[("tip_load_n = [0.0, 0.0, 0.0]", "tip_load_n = [0.30, -0.15, -0.10]")],
        slack: 0.0,
    },
];
/// Of a quick study.
const N_QUICK: usize = 4;

/// As far out as the recordings of a quick study go; the diamond's corners a little further.
const TARGETS: [&str; 3] = ["circle:40", "diamond:50", "lissajous:40"];
/// Where the servos wake up, so that one calibration is for all that is recorded of a robot.
const SEED: &str = "2";

/// Runs the study; quick: a twin fitted to the three minutes of `study population`, without the load.
///
/// # Errors
/// A command fails, or an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome<AdaptationMetrics>, WorkflowError> {
    session::run("adaptation", &options.out, context, || measure(options, context))
}

fn measure(options: &Options, context: &Context) -> Result<AdaptationMetrics> {
    let study = Study::new(options, context)?;
    let changes = if options.quick { &CHANGES[..N_QUICK] } else { &CHANGES[..] };
    let mut rows: Vec<Row> = Vec::new();
    for change in changes {
        let robot = study.robot(change)?;
        let kept = robot.kept()?;
        for target in TARGETS {
            let before = robot.track(&study.old, target, "before")?;
            let after = robot.track(&robot.new, target, "after")?;
            // The first robot is the one that has not changed.
            let unchanged = rows.iter().find(|row| row.target == target);
            let unchanged = unchanged.map_or(before, |row| row.before);
            rows.push(Row {
                change: change.name.to_owned(),
                target: target.to_owned(),
                kept,
                before,
                after,
                gain: before
                    .zip(after)
                    .map(|(before, after)| 1.0 - after.aligned_rmse_mm / before.aligned_rmse_mm),
                unchanged_robot_aligned_rmse_mm: unchanged.map(|tip| tip.aligned_rmse_mm),
            });
        }
    }
    Ok(AdaptationMetrics { rows })
}

struct Study<'a> {
    chain: ChainCommands<'a>,
    scene: String,
    old: String,
}

impl<'a> Study<'a> {
    fn new(options: &'a Options, context: &'a Context<'a>) -> Result<Self> {
        let Options { out, quick, repository } = options;
        let chain = if *quick {
            ChainCommands::new(out, repository, context)?
        } else {
            ChainCommands::of_typical(out, repository, context)?
        };
        let plan = if *quick { write_recorded_plan(&chain)? } else { "paper".to_owned() };
        chain.record("typical", &plan, "data")?;
        let old = chain.calibrate(FRICTION.0, FRICTION.1, &chain.training_recordings()?, 1, None)?.remove(0);
        let scene = chain.scene_path(FRICTION.1);
        Ok(Self { chain, scene, old: old.display().to_string() })
    }

    /// A minute of a changed robot, and the adaptation of its twin.
    fn robot(&self, change: &Change) -> Result<Robot<'_>> {
        let stem = format!("adapted/{}", change.name.replace([' ', '.'], "-"));
        let rig = format!("virtual:{}", self.chain.changed_robot(change.lines, &stem)?);
        let path = |name: &str| self.chain.path(&format!("{stem}/{name}"));
        let (found, minute, new) = (path("zeros")?, path("minute")?, path("residual.safetensors")?);
        let record = ["record", "--rig", &rig, "--plan", "quick", "--seed", SEED];
        self.chain.command(&[&record[..], &["--only", "circle", "--out", &found]].concat())?;
        let calibration = path("calibration.toml")?;
        let zeros = Path::new(&found).join("calibration.toml");
        file::write_bytes(Path::new(&calibration), slackened(&zeros, change.slack)?)?;
        let minute_of = ["--calibration", &calibration, "--out", &minute];
        self.chain.command(&[&record[..], &minute_of[..]].concat())?;
        let mut adapt = vec!["adapt", &self.old, "--scene", &self.scene, &minute, "--out", &new];
        // A lab has a minute of the robot as it was, from when its twin was made.
        let before = self.chain.path(&format!("adapted/{UNCHANGED}/minute"))?;
        if change.name != UNCHANGED {
            adapt.extend(["--reference", &before]);
        }
        self.chain.once(&new, &adapt)?;
        Ok(Robot { study: self, stem, rig, calibration, new })
    }
}

/// A calibration whose first tendon is released by `slack` [m].
fn slackened(path: &Path, slack: f64) -> Result<String> {
    let rig = RigConfig::from_toml(&rig_file(&VirtualRobot::preset("typical")?), Path::new(""))?;
    let mut calibration = RigCalibration::read(path, &rig)?;
    let first = calibration.channels.first_mut().context("a calibration without servos")?;
    first.zero = first.ticks(-slack);
    Ok(calibration.to_toml())
}

struct Robot<'a> {
    study: &'a Study<'a>,
    stem: String,
    rig: String,
    calibration: String,
    new: String,
}

impl Robot<'_> {
    /// Parts kept by `adapt`, by their name in `metrics.json`.
    fn kept(&self) -> Result<AdaptedParts> {
        let found: adapt::Outcome =
            read_outcome(&Path::new(&self.new).with_extension("").join("metrics.json"))?;
        Ok(found.kept)
    }

    fn track(&self, model: &str, target: &str, when: &str) -> Result<Option<Tip>> {
        let Study { chain, scene, .. } = self.study;
        let out = chain.path(&format!("{}/{}/{when}", self.stem, target.replace(':', "")))?;
        let track =
            ["track", model, "--scene", scene, "--rig", &self.rig, "--calibration", &self.calibration];
        let arguments = [&track[..], &["--seed", SEED, "--target", target, "--out", &out]].concat();
        let Some(found) = chain.tracked(&arguments, &out)? else { return Ok(None) };
        let score = &found.recordings.first().context("no recording of a target")?.score;
        let (aligned, nrmse) = score.aligned_rmse_m.zip(score.nrmse).context("a target without NRMSE")?;
        Ok(Some(Tip {
            rmse_mm: 1e3 * score.rmse_m,
            aligned_rmse_mm: 1e3 * aligned,
            nrmse_percent: 100.0 * nrmse,
        }))
    }
}
