//! CoReAct end to end, as a user runs it: record, identify, train, roll out; on trajectories that nothing was
//! trained on.
//!
//! Every stage is the program itself, and what it wrote is kept, so that the study goes on where it was stopped. Each
//! table row is one twin: uncorrected, with friction, with the residual network, with both, and with the paper's
//! network. `robots` runs the same ablation on others.
#![allow(clippy::print_stdout)] // this program prints tables

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use hysteron_base::{Recording, json, rng};
use hysteron_control::score::score;
use rand::RngExt;
use rayon::prelude::*;
use serde_json::Value;

use super::chain::{Chain, FRICTION, TESTS, scene_path};
use super::{rms, write_metrics};
use crate::table::print_cells;

/// The twin without and with friction.
const SCENES: [(&str, &str); 2] = [("twin", "scene-typical.toml"), FRICTION];
/// The paper's training takes every sample as the end of a window; this takes every fortieth, for its time.
const PAPER_STRIDE: &str = "40";
/// Random plans for the stability of the loop, and how long each lasts [s].
const N_RANDOM: usize = 100;
const RANDOM_S: f64 = 60.0;

/// How much is done.
struct Size {
    /// Networks of the twin without and with friction.
    seeds: [u64; 2],
    epochs: Option<&'static str>,
    n_random: usize,
    tests: &'static [&'static str],
}

/// Runs the study on the virtual rig's `typical`; quick: one seed, few epochs, one test.
///
/// # Errors
/// A stage fails.
pub fn run(folder: &Path, quick: bool) -> Result<()> {
    let size = if quick {
        Size { seeds: [1; 2], epochs: Some("2"), n_random: 2, tests: &TESTS[..1] }
    } else {
        Size { seeds: [1, 5], epochs: None, n_random: N_RANDOM, tests: &TESTS }
    };
    let study = Study { chain: Chain::of_typical(folder)?, tests: size.tests };
    study.chain.record("typical", "paper", "data")?;
    let training = study.chain.training_recordings()?;
    let mut rungs = study.rungs(&training, size.seeds, size.epochs)?;
    let best = rungs.len() - 1;
    let paper = study.train_paper(size.epochs)?;
    rungs.push(Rung {
        name: "twin + paper's network".to_owned(),
        scene: SCENES[0].1.to_owned(),
        models: vec![Some(paper)],
    });
    let typical = study.climb(&rungs, "data", "typical")?;
    typical.print();
    let steady = study.steady(&rungs[best..=best])?;
    steady.print();
    let stability = study.stability(size.n_random)?;
    println!("{}", stability.text);
    let ladders: Vec<Value> = [typical, steady].iter().map(Ladder::json).collect();
    write_metrics(folder, "coreact", json!({ "ladders": ladders, "stability": stability.json }))
}

/// A twin: what it is, and its networks, one for each seed; none in the place of one where there is none.
pub(super) struct Rung {
    pub name: String,
    /// Its scene, in the robot's folder or by its whole path.
    pub scene: String,
    pub models: Vec<Option<PathBuf>>,
}

/// All twins of a robot, or of several, on the tests.
pub(super) struct Ladder {
    pub robot: String,
    pub rows: Vec<LadderRow>,
}

impl Ladder {
    pub fn json(&self) -> Value {
        json!({ "robot": self.robot, "twins": self.rows.iter().map(LadderRow::json).collect::<Vec<_>>() })
    }

    /// Prints a row for each twin.
    pub fn print(&self) {
        println!("{}", self.robot);
        let tests = self.rows.first().map_or(&[][..], |row| &row.nrmse);
        let heading = tests
            .iter()
            .flat_map(|(test, _)| [format!("{test} x [%]"), "y [%]".to_owned(), "z [%]".to_owned()]);
        let mut cells = vec![std::iter::once("NRMSE".to_owned()).chain(heading).collect::<Vec<_>>()];
        let spread = |values: &Vec<f64>| {
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let variance =
                values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / f64::max(n - 1.0, 1.0);
            if values.len() > 1 {
                format!("{mean:.2} ± {:.2}", variance.sqrt())
            } else {
                format!("{mean:.2}")
            }
        };
        for row in &self.rows {
            let values = row.nrmse.iter().flat_map(|(_, axes)| axes.each_ref().map(spread));
            cells.push(std::iter::once(row.name.clone()).chain(values).collect());
        }
        print_cells(&cells);
    }
}

/// NRMSE of x, y and z on each test, one for each seed or robot [%].
pub(super) struct LadderRow {
    pub name: String,
    pub nrmse: Vec<(&'static str, [Vec<f64>; 3])>,
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
pub(super) struct Study {
    pub chain: Chain,
    pub tests: &'static [&'static str],
}

impl Study {
    /// The twins of a robot, without and with networks trained on `training`; with friction and network comes
    /// last.
    ///
    /// # Errors
    /// The program fails.
    pub fn rungs(&self, training: &[String], seeds: [u64; 2], epochs: Option<&str>) -> Result<Vec<Rung>> {
        let mut rungs = Vec::new();
        for ((name, scene), seeds) in SCENES.into_iter().zip(seeds) {
            let bare = Rung { name: name.to_owned(), scene: scene.to_owned(), models: vec![None] };
            let models = self.chain.calibrate(name, scene, training, seeds, epochs)?;
            let models = models.into_iter().map(Some).collect();
            let learned = Rung { name: format!("{name} + CoReAct"), scene: scene.to_owned(), models };
            rungs.extend([bare, learned]);
        }
        Ok(rungs)
    }

    fn train_paper(&self, epochs: Option<&str>) -> Result<PathBuf> {
        let [out, identified] =
            ["paper.safetensors", "identified-twin-first"].map(|name| self.chain.path(name));
        let (out, identified) = (out?, identified?);
        let mut arguments =
            vec!["fit-residual", &identified, "--design", "paper", "--stride", PAPER_STRIDE, "--out", &out];
        arguments.extend(epochs.iter().flat_map(|epochs| ["--epochs", epochs]));
        self.chain.once(&out, &arguments)?;
        Ok(PathBuf::from(out))
    }

    /// Rolls out every model of every twin on every test among the recordings in `data`.
    ///
    /// # Errors
    /// The program fails.
    pub fn climb(&self, rungs: &[Rung], data: &str, robot: &str) -> Result<Ladder> {
        let rows = rungs.iter().map(|rung| self.evaluate(rung, data)).collect::<Result<_>>()?;
        Ok(Ladder { robot: robot.to_owned(), rows })
    }

    fn evaluate(&self, rung: &Rung, data: &str) -> Result<LadderRow> {
        let mut row = LadderRow { name: rung.name.clone(), nrmse: Vec::new() };
        for test in self.tests {
            let strokes = self.chain.path(&format!("{data}/{test}.parquet"))?;
            let of_model = |model: &Option<PathBuf>| -> Result<[f64; 3]> {
                let stem = model.as_ref().and_then(|path| path.file_stem());
                let stem = stem.map_or_else(|| rung.name.as_str().into(), |stem| stem.to_string_lossy());
                let name = format!("rollouts-{data}/{stem}-{test}");
                let found = self.simulate(&rung.scene, &strokes, model.as_deref(), &name)?;
                let mut nrmse = [0.0; 3];
                for (axis, value) in nrmse.iter_mut().enumerate() {
                    let part = found.pointer(&format!("/run/against_measured/axes/{axis}/nrmse"));
                    *value = 100.0 * part.and_then(Value::as_f64).context("no NRMSE in metrics.json")?;
                }
                Ok(nrmse)
            };
            let found = rung.models.par_iter().map(of_model).collect::<Result<Vec<[f64; 3]>>>()?;
            row.nrmse.push((test, std::array::from_fn(|axis| found.iter().map(|of| of[axis]).collect())));
        }
        Ok(row)
    }

    /// The tests where the tracker does not drift; and what its drift is, the tip measured with it against the one
    /// without.
    fn steady(&self, rungs: &[Rung]) -> Result<Ladder> {
        let robot = self.chain.changed_robot(&[("bias_mm = 0.15", "bias_mm = 0.0")], "steady-robot")?;
        self.chain.record(&robot, "paper", "steady")?;
        let mut ladder = self.climb(rungs, "steady", "typical, by a tracker without drift")?;
        let drift = |test: &&'static str| -> Result<_> {
            let [with, without] = ["data", "steady"].map(|data| -> Result<Recording> {
                Ok(Recording::read(self.chain.path(&format!("{data}/{test}.parquet"))?)?)
            });
            let (with, without) = (with?, without?);
            let tips = without.tip().zip(with.tip());
            let (measured, drifting) = tips.context("no tip in a recording")?;
            let found = score(measured, drifting, without.gap());
            Ok((*test, found.axes.map(|axis| vec![100.0 * axis.nrmse.unwrap_or(0.0)])))
        };
        let nrmse = self.tests.iter().map(drift).collect::<Result<_>>()?;
        ladder.rows.insert(0, LadderRow { name: "the drift alone".to_owned(), nrmse });
        Ok(ladder)
    }

    /// Simulates and gives back its `metrics.json`.
    fn simulate(&self, scene: &str, strokes: &str, model: Option<&Path>, name: &str) -> Result<Value> {
        let (scene, out, figures) =
            (scene_path(scene), self.chain.path(&format!("{name}.parquet"))?, self.chain.path(name)?);
        let model = model.map(|path| path.display().to_string());
        let mut arguments = vec!["-q", "--threads", "1", "simulate", &scene, "--strokes", strokes];
        arguments.extend(["--out", &out, "--figures", &figures]);
        arguments.extend(model.iter().flat_map(|path| ["--residual", path]));
        let metrics = Path::new(&figures).join("metrics.json");
        if !metrics.exists() {
            self.chain.hysteron(&arguments)?;
        }
        Ok(json::from_text(&std::fs::read(metrics)?)?)
    }

    /// Rollouts on random plans, half of them within the amplitudes of training and half up to 20 % beyond.
    fn stability(&self, n: usize) -> Result<Stability> {
        let model = PathBuf::from(self.chain.path("friction-1.safetensors")?);
        let plan = self.chain.path("random.toml")?;
        std::fs::write(&plan, random_plan(n))?;
        self.chain.record("typical", &plan, &format!("random-{n}"))?;
        let gain = |k: usize| -> Result<f64> {
            let strokes = self.chain.path(&format!("random-{n}/random-{k}.parquet"))?;
            let rmse = |model: Option<&Path>, name: &str| -> Result<f64> {
                let found = self.simulate(SCENES[1].1, &strokes, model, &format!("stability/{name}-{k}"))?;
                found.pointer("/run/against_measured/rmse_m").and_then(Value::as_f64).context("no RMSE")
            };
            Ok(rmse(Some(&model), "residual")? / rmse(None, "bare")?)
        };
        let gains = (0..n).into_par_iter().map(gain).collect::<Result<Vec<f64>>>()?;
        let worse: Vec<usize> = (0..n).filter(|&k| gains[k] > 1.1).collect();
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
