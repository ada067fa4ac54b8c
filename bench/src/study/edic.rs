//! Open-loop tracking of ideal paths (paper 003, tables II to IV): strokes found in one way or another, carried out on the
//! virtual rig without a sensor, and measured.
//!
//! Works in the folder of the study `coreact`, whose recordings and residual networks it takes, and trains what is
//! missing. No path is in any training.
#![allow(clippy::print_stdout)] // this program prints tables

use std::path::Path;

use anyhow::{Context, Result};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::chain::Chain;
use super::write_metrics;
use crate::table::print_cells;

/// A path by its name and size [mm], and what the paper reached there.
struct Ideal {
    path: &'static str,
    /// NRMSE of the paper's EDIC [%].
    paper_nrmse: f64,
    /// Its overlap [-].
    paper_iou: f64,
}

const fn ideal(path: &'static str, paper_nrmse: f64, paper_iou: f64) -> Ideal {
    Ideal { path, paper_nrmse, paper_iou }
}

/// Tables II to IV.
const IDEALS: [Ideal; 15] = [
    ideal("circle:40", 3.4, 0.849),
    ideal("circle:50", 2.0, 0.908),
    ideal("circle:60", 2.3, 0.893),
    ideal("circle:70", 4.1, 0.803),
    ideal("circle:80", 3.9, 0.82),
    ideal("diamond:50", 3.3, 0.788),
    ideal("diamond:60", 2.2, 0.86),
    ideal("diamond:70", 2.2, 0.883),
    ideal("diamond:80", 3.0, 0.86),
    ideal("diamond:90", 4.1, 0.809),
    ideal("lissajous:56", 3.0, 0.768),
    ideal("lissajous:60", 3.2, 0.759),
    ideal("lissajous:64", 3.3, 0.761),
    ideal("lissajous:68", 3.8, 0.748),
    ideal("lissajous:72", 5.3, 0.698),
];

/// A way to strokes.
struct Way {
    name: &'static str,
    /// Scene that is steered, if that is how.
    scene: Option<&'static str>,
    /// Checkpoint of a seed, if it learns.
    model: Option<&'static str>,
}

const WAYS: [Way; 4] = [
    Way { name: "nominal twin", scene: Some("scene-typical.toml"), model: None },
    Way { name: "network, recorded data", scene: None, model: Some("inverse") },
    Way { name: "calibrated twin", scene: Some("scene-typical.toml"), model: Some("twin") },
    Way { name: "+ friction", scene: Some("scene-typical-friction.toml"), model: Some("friction") },
];

/// One way on one path, for every seed; nothing where the rig would not carry the strokes out.
struct Cell {
    nrmse_percent: Vec<f64>,
    iou: Vec<f64>,
}

/// Runs the study on the virtual rig's `typical`; quick: one seed, one path.
///
/// # Errors
/// A stage fails.
pub fn run(folder: &Path, quick: bool) -> Result<()> {
    let seeds = if quick { 1 } else { 5 };
    let chain = Chain::new(folder)?;
    chain.record("typical", "paper", "data")?;
    let training = chain.training_recordings()?;
    for way in WAYS.iter() {
        match (way.scene, way.model) {
            (Some(scene), Some(model)) => {
                let identified = chain.identify(model, scene, &training)?;
                chain.train(model, &identified, seeds, None)?;
            }
            (None, Some(model)) => train_inverse(&chain, model, &training, seeds)?,
            (_, None) => {}
        }
    }
    let paths = &IDEALS[..if quick { 1 } else { IDEALS.len() }];
    let rows = paths
        .par_iter()
        .map(|ideal| {
            WAYS.iter().map(|way| track(&chain, way, ideal.path, seeds)).collect::<Result<Vec<Cell>>>()
        })
        .collect::<Result<Vec<Vec<Cell>>>>()?;
    print(paths, &rows);
    let json_row = |(ideal, cells): (&Ideal, &Vec<Cell>)| {
        let ways = WAYS.iter().zip(cells);
        let ways = ways.map(
            |(way, cell)| json!({ "way": way.name, "nrmse_percent": cell.nrmse_percent, "iou": cell.iou }),
        );
        json!({
            "path": ideal.path, "paper_nrmse_percent": ideal.paper_nrmse, "paper_iou": ideal.paper_iou,
            "ways": ways.collect::<Vec<Value>>(),
        })
    };
    let json_rows: Vec<Value> = paths.iter().zip(&rows).map(json_row).collect();
    write_metrics(folder, "edic", json!({ "paths": json_rows }))
}

fn train_inverse(chain: &Chain, model: &str, training: &[String], seeds: u64) -> Result<()> {
    for seed in 1..=seeds {
        let (out, seed) = (chain.path(&format!("{model}-{seed}.safetensors"))?, seed.to_string());
        let mut arguments = vec!["train", "--seed", &seed, "--out", &out];
        arguments.extend(training.iter().map(String::as_str));
        chain.once(&out, &arguments)?;
    }
    Ok(())
}

/// Strokes by this way for every seed, each carried out on a day of the rig of its own, and measured together.
fn track(chain: &Chain, way: &Way, target: &str, seeds: u64) -> Result<Cell> {
    let stem = format!("tracked/{}-{}", way.name.replace([' ', ',', '+'], ""), target.replace(':', ""));
    let mut tips = Vec::new();
    for seed in 1..=seeds {
        let strokes = chain.path(&format!("{stem}/strokes/{seed}.parquet"))?;
        let tip = chain.path(&format!("{stem}/tips/{seed}.parquet"))?;
        let scene = way.scene.map(|scene| format!("meshes/tpu80/{scene}"));
        let model = way.model.map(|model| chain.path(&format!("{model}-{seed}.safetensors"))).transpose()?;
        let mut arguments = vec!["-q", "--threads", "1", "command", "--target", target, "--out", &strokes];
        arguments.extend(scene.iter().flat_map(|scene| ["--scene", scene]));
        arguments.extend(model.as_deref());
        chain.once(&strokes, &arguments)?;
        let day = seed.to_string();
        let record = ["-q", "record", "--rig", "virtual:typical", "--strokes", &strokes, "--seed", &day];
        // The program has said why; so far the servos' load is what a far path ends at.
        if chain.once(&tip, &[&record[..], &["--out", &tip]].concat()).is_err() {
            return Ok(Cell { nrmse_percent: Vec::new(), iou: Vec::new() });
        }
        tips.push(tip);
    }
    let report = chain.path(&format!("{stem}/report"))?;
    let mut arguments = vec!["-q", "evaluate", "--target", target, "--out", &report];
    arguments.extend(tips.iter().map(String::as_str));
    let metrics = Path::new(&report).join("metrics.json");
    if !metrics.exists() {
        chain.hysteron(&arguments)?;
    }
    let found: Value = serde_json::from_slice(&std::fs::read(metrics)?)?;
    let recordings = found["recordings"].as_array().context("no recordings in metrics.json")?;
    let number = |key: &str| -> Result<Vec<f64>> {
        recordings
            .iter()
            .map(|row| row[key].as_f64().with_context(|| format!("no {key} in metrics.json")))
            .collect()
    };
    Ok(Cell {
        nrmse_percent: number("nrmse")?.into_iter().map(|part| 100.0 * part).collect(),
        iou: number("iou")?,
    })
}

fn print(paths: &[Ideal], rows: &[Vec<Cell>]) {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let shown = |pairs: Vec<[f64; 2]>| match pairs.len() {
        0 => "-".to_owned(),
        _ => {
            let [nrmse, iou] = [0, 1].map(|c| mean(&pairs.iter().map(|pair| pair[c]).collect::<Vec<f64>>()));
            format!("{nrmse:.2}, {iou:.3}")
        }
    };
    let pairs = |cell: &Cell| -> Vec<[f64; 2]> {
        cell.nrmse_percent.iter().zip(&cell.iou).map(|(nrmse, iou)| [*nrmse, *iou]).collect()
    };
    let paper = |ideal: &Ideal| [ideal.paper_nrmse, ideal.paper_iou];
    let mut cells = vec![vec!["NRMSE [%], IoU".to_owned(), "paper's EDIC".to_owned()]];
    cells[0].extend(WAYS.iter().map(|way| way.name.to_owned()));
    for (ideal, row) in paths.iter().zip(rows) {
        let mut line = vec![ideal.path.to_owned(), shown(vec![paper(ideal)])];
        line.extend(row.iter().map(|cell| shown(pairs(cell))));
        cells.push(line);
    }
    let mut line = vec!["mean of those tracked".to_owned(), shown(paths.iter().map(paper).collect())];
    line.extend((0..WAYS.len()).map(|way| shown(rows.iter().flat_map(|row| pairs(&row[way])).collect())));
    cells.push(line);
    print_cells(&cells);
}
