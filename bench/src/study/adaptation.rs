//! A robot that changes, or does not, and a minute of data after which its twin has followed: friction half as much
//! again, play grown by 0.3 mm, a tendon that has gone slack by 0.6 mm, a load added.
//!
//! Targets are followed on each robot with the network of the robot as it was, and with what `adapt` kept after a
//! minute of it.
//! The error of the twin on the unchanged robot is the least that exact knowledge of the change would leave,
//! and is the baseline. The plan of that minute (`quick`) has other motion than the training of the network.
#![allow(clippy::print_stdout)] // this program prints tables

use std::path::Path;

use anyhow::{Context, Result};
use hysteron_base::{file, json};
use hysteron_rig::calibration::RigCalibration;
use hysteron_rig::config::RigConfig;
use hysteron_virtual_rig::virtual_rig::{VirtualRobot, rig_file};
use serde_json::Value;

use super::chain::{Chain, FRICTION, scene_path};
use super::population::write_recorded_plan;
use super::write_metrics;
use crate::table::print_cells;

/// A change of the preset `typical`: lines of its file, and the length by which its first tendon is released
/// [m]. A rig finds its zeros before it records; a tendon that has gone slack since is one whose zero in the
/// calibration is not where it was found.
struct Change {
    name: &'static str,
    lines: &'static [(&'static str, &'static str)],
    slack: f64,
}

const CHANGES: [Change; 5] = [
    Change { name: "unchanged", lines: &[], slack: 0.0 },
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

/// How closely a tip followed its target.
#[derive(Debug, Clone, Copy)]
struct Tip {
    rmse_mm: f64,
    aligned_mm: f64,
    nrmse_percent: f64,
}

/// A target on a robot, before and after adaptation; none where the rig did not carry the strokes out.
struct Row {
    change: &'static str,
    target: &'static str,
    kept: String,
    tips: [Option<Tip>; 2],
}

/// Runs the study; quick: a twin fitted to the three minutes of `study population`, without the load.
///
/// # Errors
/// A stage fails.
pub fn run(folder: &Path, quick: bool) -> Result<()> {
    let study = Study::new(folder, quick)?;
    let changes = if quick { &CHANGES[..N_QUICK] } else { &CHANGES[..] };
    let mut rows = Vec::new();
    for change in changes {
        let robot = study.robot(change)?;
        let kept = robot.kept()?;
        for target in TARGETS {
            let tips =
                [robot.track(&study.old, target, "before")?, robot.track(&robot.new, target, "after")?];
            rows.push(Row { change: change.name, target, kept: kept.clone(), tips });
        }
    }
    print(&rows);
    let of_rows: Vec<Value> = rows.iter().map(|row| row.json(unchanged(&rows, row.target))).collect();
    write_metrics(folder, "adaptation", json!({ "rows": of_rows }))
}

struct Study {
    chain: Chain,
    scene: String,
    old: String,
}

impl Study {
    fn new(folder: &Path, quick: bool) -> Result<Self> {
        let chain = if quick { Chain::new(folder)? } else { Chain::of_typical(folder)? };
        let plan = if quick { write_recorded_plan(&chain)? } else { "paper".to_owned() };
        chain.record("typical", &plan, "data")?;
        let old = chain.calibrate(FRICTION.0, FRICTION.1, &chain.training_recordings()?, 1, None)?.remove(0);
        Ok(Self { chain, scene: scene_path(FRICTION.1), old: old.display().to_string() })
    }

    /// A minute of a changed robot, and the adaptation of its twin.
    fn robot(&self, change: &Change) -> Result<Robot<'_>> {
        let stem = format!("adapted/{}", change.name.replace([' ', '.'], "-"));
        let rig = format!("virtual:{}", self.chain.changed_robot(change.lines, &stem)?);
        let path = |name: &str| self.chain.path(&format!("{stem}/{name}"));
        let (found, minute, new) = (path("zeros")?, path("minute")?, path("residual.safetensors")?);
        let record = ["record", "--rig", &rig, "--plan", "quick", "--seed", SEED];
        self.chain.hysteron(&[&record[..], &["--only", "circle", "--out", &found]].concat())?;
        let calibration = path("calibration.toml")?;
        let zeros = Path::new(&found).join("calibration.toml");
        file::write_bytes(Path::new(&calibration), let_go(&zeros, change.slack)?)?;
        let minute_of = ["--calibration", &calibration, "--out", &minute];
        self.chain.hysteron(&[&record[..], &minute_of[..]].concat())?;
        self.chain.once(&new, &["adapt", &self.old, "--scene", &self.scene, &minute, "--out", &new])?;
        Ok(Robot { study: self, stem, rig, calibration, new })
    }
}

/// A calibration whose first tendon is released by `slack` [m].
fn let_go(path: &Path, slack: f64) -> Result<String> {
    let rig = RigConfig::from_toml(&rig_file(&VirtualRobot::preset("typical")?), Path::new(""))?;
    let mut calibration = RigCalibration::read(path, &rig)?;
    let first = calibration.channels.first_mut().context("a calibration without servos")?;
    first.zero = first.ticks(-slack);
    Ok(calibration.to_toml())
}

struct Robot<'a> {
    study: &'a Study,
    stem: String,
    rig: String,
    calibration: String,
    new: String,
}

impl Robot<'_> {
    /// Parts kept by `adapt`, by their name in `metrics.json`.
    fn kept(&self) -> Result<String> {
        let metrics: Value =
            json::from_text(&std::fs::read(Path::new(&self.new).with_extension("").join("metrics.json"))?)?;
        Ok(metrics["kept"].as_str().context("nothing kept in metrics.json")?.to_owned())
    }

    fn track(&self, model: &str, target: &str, when: &str) -> Result<Option<Tip>> {
        let Study { chain, scene, .. } = self.study;
        let out = chain.path(&format!("{}/{}/{when}", self.stem, target.replace(':', "")))?;
        let metrics = Path::new(&out).join("metrics.json");
        let track =
            ["-q", "track", model, "--scene", scene, "--rig", &self.rig, "--calibration", &self.calibration];
        let arguments = [&track[..], &["--seed", SEED, "--target", target, "--out", &out]].concat();
        if !metrics.exists() && chain.hysteron(&arguments).is_err() {
            return Ok(None);
        }
        let found: Value = json::from_text(&std::fs::read(metrics)?)?;
        let number = |key: &str| {
            found["recordings"][0][key].as_f64().with_context(|| format!("no {key} in metrics.json"))
        };
        Ok(Some(Tip {
            rmse_mm: 1e3 * number("rmse_m")?,
            aligned_mm: 1e3 * number("aligned_rmse_m")?,
            nrmse_percent: 100.0 * number("nrmse")?,
        }))
    }
}

/// Error of the twin on the unchanged robot along a target, at equal times [mm].
fn unchanged(rows: &[Row], target: &str) -> Option<f64> {
    let row = rows.iter().find(|row| row.change == CHANGES[0].name && row.target == target)?;
    Some(row.tips[0]?.aligned_mm)
}

impl Row {
    fn json(&self, unchanged_mm: Option<f64>) -> Value {
        let tip = |tip: &Option<Tip>| {
            tip.map(|it| {
                json!({ "rmse_mm": it.rmse_mm, "aligned_rmse_mm": it.aligned_mm, "nrmse_percent": it.nrmse_percent })
            })
        };
        let [before, after] = self.tips.each_ref().map(tip);
        json!({
            "change": self.change, "target": self.target, "kept": self.kept, "before": before, "after": after,
            "gain": self.gain(), "unchanged_robot_aligned_rmse_mm": unchanged_mm,
        })
    }

    /// Part of the error at equal times that adaptation took away [-].
    fn gain(&self) -> Option<f64> {
        let [before, after] = self.tips;
        Some(1.0 - after?.aligned_mm / before?.aligned_mm)
    }
}

fn print(rows: &[Row]) {
    let heading = [
        "Change",
        "Target",
        "kept",
        "RMSE [mm], at equal times [mm], NRMSE [%] before",
        "after a minute of data",
        "gain at equal times [%]",
        "unchanged robot at equal times [mm]",
    ];
    let mut cells = vec![heading.map(str::to_owned).to_vec()];
    for row in rows {
        let tip = |tip: &Option<Tip>| {
            let shown =
                |it: &Tip| format!("{:.2}, {:.2}, {:.2}", it.rmse_mm, it.aligned_mm, it.nrmse_percent);
            tip.as_ref().map_or("-".to_owned(), shown)
        };
        let mut line = vec![row.change.to_owned(), row.target.to_owned(), row.kept.clone()];
        line.extend(row.tips.iter().map(tip));
        let number =
            |value: Option<f64>, digits| value.map_or("-".to_owned(), |value| format!("{value:.digits$}"));
        line.push(number(row.gain().map(|gain| 100.0 * gain), 0));
        line.push(number(unchanged(rows, row.target), 2));
        cells.push(line);
    }
    print_cells(&cells);
}
