//! Layouts of auxiliary tendons: the paper's 36 compared with fewer, longer ones.
//!
//! The singular values of ∂tip/∂s* say in which directions a layout moves the tip, and how evenly; the
//! identification, and a network trained on it on the tests of `coreact`, measure the benefit.
#![allow(clippy::print_stdout)] // this program prints tables

use std::path::Path;

use anyhow::{Context, Result};
use hysteron_base::{Recording, json};
use nalgebra::Matrix3xX;
use serde_json::Value;

use super::chain::{Chain, FRICTION, TESTS};
use super::coreact::{Rung, Study};
use super::write_metrics;
use crate::measure::percentile;
use crate::table::print_cells;

/// Segments of two tendons each between the same ends, and their length [mm]: the paper's, and fewer.
const LAYOUTS: [(usize, f64); 4] = [(18, 4.0), (6, 12.0), (4, 18.0), (2, 36.0)];
/// Every third recording is a training recording, in one pass.
const OF_ALL: usize = 3;

/// Result of the identification with a layout.
struct Reach {
    /// Singular values of ∂tip/∂s*, in the median of all samples [-].
    singular: [f64; 3],
    /// Median and 99th percentile of the distance left, each in the mean of the recordings [mm].
    left_mm: [f64; 2],
}

/// Runs the study on the virtual rig's `typical`; quick: two layouts, one test, few epochs.
///
/// # Errors
/// A stage fails.
pub fn run(folder: &Path, quick: bool) -> Result<()> {
    let chain = Chain::of_typical(folder)?;
    chain.record("typical", "paper", "data")?;
    let training: Vec<String> = chain.training_recordings()?.into_iter().step_by(OF_ALL).collect();
    let (layouts, tests, epochs) =
        if quick { (&LAYOUTS[2..], &TESTS[..1], Some("2")) } else { (&LAYOUTS[..], &TESTS[..], None) };
    let (mut reaches, mut rungs) = (Vec::new(), Vec::new());
    for &(segments, length) in layouts {
        let n_tendons = 2 * segments;
        let (name, scene) = (format!("layout-{n_tendons}"), write_scene(&chain, segments, length)?);
        let identified = chain.identify(&name, &scene, None, &training)?;
        reaches.push(reach(Path::new(&identified), n_tendons)?);
        let models = chain.train(&name, &identified, 1, epochs)?.into_iter().map(Some).collect();
        rungs.push(Rung { name: format!("{n_tendons} auxiliary tendons"), scene, models });
    }
    let ladder =
        Study { chain, tests }.climb(&rungs, "data", "typical, one pass on a third of the recordings")?;
    print(&rungs, &reaches);
    ladder.print();
    let of_layout = |(rung, reach): (&Rung, &Reach)| json!({ "layout": rung.name, "singular_values": reach.singular, "left_median_p99_mm": reach.left_mm });
    let layouts: Vec<Value> = rungs.iter().zip(&reaches).map(of_layout).collect();
    write_metrics(folder, "layouts", json!({ "layouts": layouts, "ladder": ladder.json() }))
}

/// Writes the scene with friction with other auxiliary tendons; gives its path.
fn write_scene(chain: &Chain, segments: usize, length: f64) -> Result<String> {
    let meshes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../meshes/tpu80").canonicalize()?;
    let text = std::fs::read_to_string(meshes.join(FRICTION.1))?;
    let mesh = format!("file = \"{}\"", meshes.join("tpu80.msh").display());
    let lines = [
        ("segments = 18", &format!("segments = {segments}")[..]),
        ("segment_length_mm = 4.0", &format!("segment_length_mm = {length:?}")),
        ("file = \"tpu80.msh\"", &mesh),
    ];
    chain.write_changed(&text, &lines, &format!("layouts/{segments}.toml"))
}

fn reach(identified: &Path, n_tendons: usize) -> Result<Reach> {
    let metrics: Value = json::from_text(&std::fs::read(identified.join("metrics.json"))?)?;
    let rows = metrics["recordings"].as_array().context("no recordings in metrics.json")?;
    let mean = |key: &str| -> Result<f64> {
        let values = rows.iter().map(|row| row.pointer(key).and_then(Value::as_f64));
        let values = values.collect::<Option<Vec<f64>>>().context("no residuals in metrics.json")?;
        Ok(1e3 * values.iter().sum::<f64>() / values.len() as f64)
    };
    let left_mm = [mean("/after/median_m")?, mean("/after/p99_m")?];
    let mut singular: [Vec<f64>; 3] = Default::default();
    for entry in std::fs::read_dir(identified.join("sensitivity"))? {
        let recording = Recording::read(entry?.path())?;
        let mut rows = Vec::new();
        for axis in ["x", "y", "z"] {
            for k in 1..=n_tendons {
                rows.push(recording.require(&format!("sensitivity_{axis}_{k:02}_ratio"))?);
            }
        }
        for i in 0..recording.n_samples() {
            let matrix = Matrix3xX::from_fn(n_tendons, |axis, k| rows[axis * n_tendons + k][i]);
            let values = matrix.singular_values();
            singular.iter_mut().zip(values.iter()).for_each(|(all, value)| all.push(*value));
        }
    }
    Ok(Reach { singular: singular.map(|values| percentile(&values, 0.5)), left_mm })
}

fn print(rungs: &[Rung], reaches: &[Reach]) {
    let heading = [
        "",
        "singular values of ∂tip/∂s* [-]",
        "largest over smallest",
        "tip left off: median [mm]",
        "99 % [mm]",
    ];
    let mut cells = vec![heading.map(str::to_owned).to_vec()];
    for (rung, reach) in rungs.iter().zip(reaches) {
        let [first, second, third] = reach.singular;
        cells.push(vec![
            rung.name.clone(),
            format!("{first:.2}, {second:.2}, {third:.3}"),
            format!("{:.0}", first / third),
            format!("{:.3}", reach.left_mm[0]),
            format!("{:.3}", reach.left_mm[1]),
        ]);
    }
    print_cells(&cells);
}
