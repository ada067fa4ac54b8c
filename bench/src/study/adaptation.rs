//! A robot that changes, and a minute of data after which its twin has followed: play grown, friction grown, a load added.
//! (Tendons that are tensioned anew change nothing here: a virtual rig finds their zeros by itself every day.)
//!
//! Targets are followed on the robot as it was, on the changed one, and there again with a network that has learned from
//! a minute of it.
#![allow(clippy::print_stdout)] // this program prints tables

use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};

use super::chain::{Chain, FRICTION, Strokes, scene_path};
use super::write_metrics;
use crate::table::print_cells;

/// A change of the preset `typical`, by lines of its file.
struct Change {
    name: &'static str,
    lines: &'static [(&'static str, &'static str)],
}

const CHANGES: [Change; 3] = [
    Change { name: "play grown", lines: &[("play_mm = 0.10", "play_mm = 0.50")] },
    Change {
        name: "friction grown",
        lines: &[
            ("friction_coefficient = 0.22", "friction_coefficient = 0.44"),
            ("friction_force_n = 0.10", "friction_force_n = 0.40"),
        ],
    },
    Change {
        name: "load added",
        lines: &[("tip_load_n = [0.0, 0.0, 0.0]", "tip_load_n = [0.30, -0.15, -0.10]")],
    },
];

const TARGETS: [&str; 3] = ["circle:40", "diamond:60", "lissajous:60"];

/// Runs the study; quick: one target.
///
/// # Errors
/// A stage fails.
pub fn run(folder: &Path, quick: bool) -> Result<()> {
    let (chain, targets) = (Chain::of_typical(folder)?, &TARGETS[..if quick { 1 } else { TARGETS.len() }]);
    chain.record("typical", "paper", "data")?;
    chain.calibrate(FRICTION.0, FRICTION.1, &chain.training_recordings()?, 1, None)?;
    let (old, scene) = (chain.path("friction-1.safetensors")?, scene_path(FRICTION.1));
    let mut rows = Vec::new();
    for change in &CHANGES {
        let stem = format!("adapted/{}", change.name.replace(' ', "-"));
        let rig = format!("virtual:{}", chain.changed_robot(change.lines, &stem)?);
        let minute = chain.path(&format!("{stem}/minute"))?;
        chain.hysteron(&["record", "--rig", &rig, "--plan", "quick", "--out", &minute])?;
        let new = chain.path(&format!("{stem}/residual.safetensors"))?;
        chain.once(&new, &["adapt", &old, "--scene", &scene, &minute, "--out", &new])?;
        for target in targets {
            let follow = |rig: &str, model: &str, when: &str| -> Result<Option<f64>> {
                let strokes = Strokes { scene: Some(&scene), model: Some(model) };
                let name = format!("{stem}/{}/{when}", target.replace(':', ""));
                let found = chain.track(rig, strokes, target, [1, 1], &name)?;
                Ok(found.map(|repeats| repeats[0].nrmse_percent))
            };
            let found = [
                follow("virtual:typical", &old, "as-it-was")?,
                follow(&rig, &old, "changed")?,
                follow(&rig, &new, "adapted")?,
            ];
            rows.push((change.name, *target, found));
        }
    }
    print(&rows);
    let row = |(change, target, [was, changed, adapted]): &(&str, &str, [Option<f64>; 3])| {
        json!({
            "change": change, "target": target,
            "nrmse_percent": { "as it was": was, "changed": changed, "adapted": adapted },
        })
    };
    write_metrics(folder, "adaptation", json!({ "rows": rows.iter().map(row).collect::<Vec<Value>>() }))
}

fn print(rows: &[(&str, &str, [Option<f64>; 3])]) {
    let heading = ["Change", "Target", "NRMSE [%] before", "after the change", "after a minute of data"];
    let mut cells = vec![heading.map(str::to_owned).to_vec()];
    for (change, target, found) in rows {
        let number = |value: &Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
        let names = [change, target].map(|name| (*name).to_owned());
        cells.push(names.into_iter().chain(found.iter().map(number)).collect());
    }
    print_cells(&cells);
}
