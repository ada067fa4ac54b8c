//! CoReAct end to end, as a user runs it: record, identify, train, roll out; on trajectories that nothing was trained on.
//!
//! Every stage is the program itself, and what it wrote is kept, so that the study goes on where it was stopped. Each
//! table row is one twin: bare, with friction, with the residual network, with both, and with the paper's network.
#![allow(clippy::print_stdout)] // this program prints tables

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use hysteron_base::rng;
use rand::RngExt;
use serde_json::{Value, json};

use super::chain::{Chain, TESTS};
use super::{rms, write_metrics};
use crate::table::print_cells;

/// The twin without and with friction.
const SCENES: [(&str, &str); 2] =
    [("twin", "scene-typical.toml"), ("friction", "scene-typical-friction.toml")];
/// The paper's training takes every sample as the end of a window; this takes every fortieth, for its time.
const PAPER_STRIDE: &str = "40";
/// Random plans for the stability of the loop, and how long each lasts [s].
const N_RANDOM: usize = 100;
const RANDOM_S: f64 = 60.0;

/// How much is done.
struct Size {
    seeds: u64,
    epochs: Option<&'static str>,
    n_random: usize,
    tests: &'static [&'static str],
}

/// Runs the study on the virtual rig's `typical`: about half an hour on two cores; quick: one seed, few epochs.
///
/// # Errors
/// A stage fails.
pub fn run(folder: &Path, quick: bool) -> Result<()> {
    let size = if quick {
        Size { seeds: 1, epochs: Some("2"), n_random: 2, tests: &TESTS[..1] }
    } else {
        Size { seeds: 5, epochs: None, n_random: N_RANDOM, tests: &TESTS }
    };
    let study = Study { chain: Chain::new(folder)? };
    study.chain.record("typical", "paper", "data")?;
    let training = study.chain.training_recordings()?;
    let mut rows = Vec::new();
    for (name, scene) in SCENES {
        rows.push(study.evaluate(name, scene, &[None], size.tests)?);
        let models = study.chain.calibrate(name, scene, &training, size.seeds, size.epochs)?;
        let models: Vec<Option<&Path>> = models.iter().map(|path| Some(path.as_path())).collect();
        rows.push(study.evaluate(&format!("{name} + CoReAct"), scene, &models, size.tests)?);
    }
    let paper = study.train_paper(&folder.join("identified-twin-first"), size.epochs)?;
    rows.push(study.evaluate("twin + paper's network", SCENES[0].1, &[Some(&paper)], size.tests)?);
    print(&rows, size.tests);
    let stability = study.stability(&folder.join("friction-1.safetensors"), size.n_random)?;
    println!("{}", stability.text);
    let ladder: Vec<Value> = rows.iter().map(LadderRow::json).collect();
    write_metrics(folder, "coreact", json!({ "ladder": ladder, "stability": stability.json }))
}

/// NRMSE of x, y and z on each test, one for each seed [%].
struct LadderRow {
    name: String,
    nrmse: Vec<(String, [Vec<f64>; 3])>,
}

impl LadderRow {
    fn json(&self) -> Value {
        let paths = self
            .nrmse
            .iter()
            .map(|(path, [x, y, z])| json!({ "path": path, "x_percent": x, "y_percent": y, "z_percent": z }));
        json!({ "twin": self.name, "nrmse": paths.collect::<Vec<_>>() })
    }
}

/// The chain, and what is asked of it.
struct Study {
    chain: Chain,
}

impl Study {
    fn train_paper(&self, identified: &Path, epochs: Option<&str>) -> Result<PathBuf> {
        let out = self.chain.path("paper.safetensors")?;
        let identified = identified.canonicalize()?.display().to_string();
        let mut arguments =
            vec!["fit-residual", &identified, "--design", "paper", "--stride", PAPER_STRIDE, "--out", &out];
        arguments.extend(epochs.iter().flat_map(|epochs| ["--epochs", epochs]));
        self.chain.once(&out, &arguments)?;
        Ok(PathBuf::from(out))
    }

    /// Rolls out every model on every test.
    fn evaluate(
        &self,
        name: &str,
        scene: &str,
        models: &[Option<&Path>],
        tests: &[&str],
    ) -> Result<LadderRow> {
        let mut row = LadderRow { name: name.to_owned(), nrmse: Vec::new() };
        for test in tests {
            let strokes = self.chain.path(&format!("data/{test}.parquet"))?;
            let mut nrmse = [Vec::new(), Vec::new(), Vec::new()];
            for model in models {
                let stem = model
                    .and_then(Path::file_stem)
                    .map_or_else(|| name.into(), |stem| stem.to_string_lossy());
                let found = self.simulate(scene, &strokes, *model, &format!("rollouts/{stem}-{test}"))?;
                for (axis, values) in nrmse.iter_mut().enumerate() {
                    let part = found.pointer(&format!("/run/against_measured/axes/{axis}/nrmse"));
                    values.push(100.0 * part.and_then(Value::as_f64).context("no NRMSE in metrics.json")?);
                }
            }
            row.nrmse.push(((*test).to_owned(), nrmse));
        }
        Ok(row)
    }

    /// Simulates and gives back its `metrics.json`.
    fn simulate(&self, scene: &str, strokes: &str, model: Option<&Path>, name: &str) -> Result<Value> {
        let (scene, out, figures) = (
            format!("meshes/tpu80/{scene}"),
            self.chain.path(&format!("{name}.parquet"))?,
            self.chain.path(name)?,
        );
        let model = model.map(|path| path.display().to_string());
        let mut arguments =
            vec!["simulate", &scene, "--strokes", strokes, "--out", &out, "--figures", &figures];
        arguments.extend(model.iter().flat_map(|path| ["--residual", path]));
        let metrics = Path::new(&figures).join("metrics.json");
        if !metrics.exists() {
            self.chain.hysteron(&arguments)?;
        }
        Ok(serde_json::from_slice(&std::fs::read(metrics)?)?)
    }

    /// Rollouts on random plans, half of them within the amplitudes of training and half up to 20 % beyond.
    fn stability(&self, model: &Path, n: usize) -> Result<Stability> {
        let plan = self.chain.path("random.toml")?;
        std::fs::write(&plan, random_plan(n))?;
        self.chain.record("typical", &plan, &format!("random-{n}"))?;
        let (mut worse, mut gains) = (Vec::new(), Vec::new());
        for k in 0..n {
            let strokes = self.chain.path(&format!("random-{n}/random-{k}.parquet"))?;
            let rmse = |model: Option<&Path>, name: &str| -> Result<f64> {
                let found = self.simulate(SCENES[1].1, &strokes, model, &format!("stability/{name}-{k}"))?;
                found.pointer("/run/against_measured/rmse_m").and_then(Value::as_f64).context("no RMSE")
            };
            let (bare, residual) = (rmse(None, "bare")?, rmse(Some(model), "residual")?);
            gains.push(residual / bare);
            if residual > 1.1 * bare {
                worse.push(k);
            }
        }
        let largest = gains.iter().copied().fold(0.0, f64::max);
        let text = format!(
            "{n} random plans of {RANDOM_S} s: all rolled out; tip error over the bare twin's {:.2} (rms), at most \
             {largest:.2}; more than 10 % worse in {}",
            rms(gains.iter().copied()),
            worse.len()
        );
        Ok(Stability { text, json: json!({ "ratio_to_bare": gains, "worse_by_10_percent": worse }) })
    }
}

struct Stability {
    text: String,
    json: Value,
}

/// Sinusoids, circles, ellipses and squares with drawn amplitude, frequency and orientation.
fn random_plan(n: usize) -> String {
    let mut text = "format = \"hysteron-plan\"\nversion = 1\nname = \"random\"\nseed = 1\nrate_hz = 100\n\
                    tendon_angles_deg = [0, 90, 180, 270]\nrelease = 1.0\nscale = 1.3\nrest_before_s = 1.32\n\
                    rest_after_s = 2\nstroke_max_mm = 9\nstroke_rate_max_mm_s = 9\n"
        .to_owned();
    let mut stream = rng(1, "bench/random-plan");
    // Largest amplitude of training, 5 mm before scaling.
    let mut draw = |low: f64, high: f64| stream.random_range(low..high);
    for k in 0..n {
        let family = ["sinusoid", "circle", "ellipse", "square"][k % 4];
        let amplitude = if k % 2 == 0 { draw(1.5, 5.0) } else { draw(5.0, 6.0) };
        let frequency = draw(0.05, 0.15);
        text += &format!(
            "\n[[trajectory]]\nname = \"random-{k}\"\nrole = \"validation\"\nfamily = \"{family}\"\n\
             amplitude_mm = {amplitude:.3}\nfrequency_hz = {frequency:.4}\n{} = {:.1}\nattack_s = 10\n\
             sustain_s = {}\ndecay_s = 10\n",
            if family == "circle" { "phase_deg" } else { "orientation_deg" },
            draw(0.0, 180.0),
            RANDOM_S - 23.32
        );
        if family == "ellipse" {
            text += &format!("aspect = {:.2}\n", draw(0.3, 0.9));
        }
        if family != "sinusoid" {
            text += "direction = \"clockwise\"\n";
        }
    }
    text
}

fn print(rows: &[LadderRow], tests: &[&str]) {
    let heading =
        tests.iter().flat_map(|test| [format!("{test} x [%]"), "y [%]".to_owned(), "z [%]".to_owned()]);
    let mut cells = vec![std::iter::once("NRMSE".to_owned()).chain(heading).collect::<Vec<_>>()];
    let spread = |values: &Vec<f64>| {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance =
            values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / f64::max(n - 1.0, 1.0);
        if values.len() > 1 { format!("{mean:.2} ± {:.2}", variance.sqrt()) } else { format!("{mean:.2}") }
    };
    for row in rows {
        let values = row.nrmse.iter().flat_map(|(_, axes)| axes.each_ref().map(spread));
        cells.push(std::iter::once(row.name.clone()).chain(values).collect());
    }
    print_cells(&cells);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recordings_of_random_plans_are_as_long_as_they_say() -> Result<()> {
        let plan = hysteron_control::Plan::from_toml(&random_plan(8), "random")?;
        assert_eq!(plan.trajectories().len(), 8);
        for trajectory in plan.trajectories() {
            assert!((trajectory.duration() - RANDOM_S).abs() < 0.02, "{}", trajectory.duration());
        }
        Ok(())
    }
}
