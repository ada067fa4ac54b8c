//! The run of `study edic`.

use anyhow::Result;
use hysteron_workflow::{Context, WorkflowError};
use rayon::prelude::*;

use super::outcome::{EdicMetrics, EdicPath, MethodRuns, RECORDED};
use crate::tendon::commands::{ChainCommands, FRICTION, Strokes, controllers};
use crate::tendon::path_following::Followed;
use crate::tendon::{Options, Outcome, session};

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

/// How strokes are found.
struct EdicMethod {
    name: &'static str,
    /// Trainings, each from its own seed.
    seeds: u64,
    /// Scene that is steered, if that is how.
    scene: Option<&'static str>,
    /// Checkpoint of a seed, if it learns.
    model: Option<&'static str>,
}

/// The plans that the twin with friction runs.
const PLANS: [&str; 2] = ["synthetic", "roses"];
/// Seeds of networks, and repeats of each path with each of them.
const SEEDS: u64 = 5;
const REPEATS: u64 = 5;
/// The paper's training takes every sample as the end of a window and 256 windows a step: nine noise of two cores. This
/// takes fewer windows, and fewer a step so that there are nearly a thousand steps.
const PAPER_OPTIONS: [&str; 6] = ["--design", "paper", "--stride", "800", "--batch", "32"];

const BASELINE: EdicMethod = EdicMethod { name: RECORDED, seeds: SEEDS, scene: None, model: Some("inverse") };
const PAPER: EdicMethod =
    EdicMethod { name: "the paper's network", seeds: 1, scene: None, model: Some("paper-inverse") };
const HYBRID: EdicMethod =
    EdicMethod { name: "network, hybrid data", seeds: SEEDS, scene: None, model: Some("hybrid") };
const METHODS: [EdicMethod; 5] = [
    EdicMethod { name: "fitted twin", seeds: 1, scene: Some("scene-typical.toml"), model: None },
    BASELINE,
    PAPER,
    HYBRID,
    EdicMethod { name: "calibrated twin", seeds: 1, scene: Some(FRICTION.1), model: Some(FRICTION.0) },
];

/// One method on one path.
struct Cell {
    /// For every seed whose strokes the rig ran, and repeat.
    followed: Vec<Followed>,
    /// Seeds whose strokes it did not.
    refused: u64,
}

/// Runs the study on the virtual rig's `typical`, five repeats of five seeds; quick: one of one, one path.
///
/// # Errors
/// A command fails, or an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome<EdicMetrics>, WorkflowError> {
    session::run("edic", &options.out, context, || {
        let chain = ChainCommands::of_typical(&options.out, &options.repository, context)?;
        let paths = &IDEALS[..if options.quick { 1 } else { IDEALS.len() }];
        let rows = measure(&chain, paths, options.quick)?;
        Ok(EdicMetrics { paths: paths.iter().zip(&rows).map(|(ideal, cells)| ideal.result(cells)).collect() })
    })
}

/// Trains the networks and tracks the paths by every method.
fn measure(chain: &ChainCommands<'_>, paths: &[Ideal], quick: bool) -> Result<Vec<Vec<Cell>>> {
    chain.record("typical", "paper", "data")?;
    let training = chain.training_recordings()?;
    let (model, scene) = FRICTION;
    chain.calibrate(model, scene, &training, 1, None)?;
    let synthetic = PLANS.iter().map(|plan| generate(chain, plan)).collect::<Result<Vec<String>>>()?;
    let hybrid = [&training[..], &synthetic].concat();
    // The longest first.
    let trainings =
        [(&PAPER, &hybrid, &PAPER_OPTIONS[..]), (&HYBRID, &hybrid, &[]), (&BASELINE, &training, &[])];
    trainings
        .iter()
        .flat_map(|training| (1..=if quick { 1 } else { training.0.seeds }).map(move |seed| (training, seed)))
        .par_bridge()
        .try_for_each(|(&(method, recordings, options), seed)| {
            train_inverse(chain, method, seed, recordings, options)
        })?;
    paths
        .par_iter()
        .map(|ideal| METHODS.iter().map(|method| track(chain, method, ideal.path, quick)).collect())
        .collect()
}

impl Ideal {
    /// The path by every method.
    fn result(&self, cells: &[Cell]) -> EdicPath {
        let methods = METHODS.iter().zip(cells).map(|(method, cell)| {
            let all = || cell.followed.iter();
            MethodRuns {
                method: method.name.to_owned(),
                nrmse_percent: all().map(|one| one.nrmse_percent).collect(),
                iou: all().map(|one| one.iou).collect(),
                aligned_rmse_mm: all().map(|one| one.aligned_rmse_mm).collect(),
                lag_ms: all().map(|one| one.lag_ms).collect(),
                seeds_refused: cell.refused,
            }
        });
        EdicPath {
            path: self.path.to_owned(),
            paper_nrmse_percent: self.paper_nrmse,
            paper_iou: self.paper_iou,
            methods: methods.collect(),
        }
    }
}

/// Runs a plan on the calibrated twin.
fn generate(chain: &ChainCommands<'_>, plan: &str) -> Result<String> {
    let (model, scene) = FRICTION;
    let (out, scene) = (chain.path(plan)?, chain.scene_path(scene));
    let model = chain.path(&format!("{model}-1.safetensors"))?;
    chain.command(&["generate", &scene, "--residual", &model, "--plan", plan, "--out", &out])?;
    Ok(out)
}

fn train_inverse(
    chain: &ChainCommands<'_>,
    method: &EdicMethod,
    seed: u64,
    recordings: &[String],
    options: &[&str],
) -> Result<()> {
    let model = method.model.unwrap_or_default();
    let (out, seed) = (chain.path(&format!("{model}-{seed}.safetensors"))?, seed.to_string());
    let mut arguments = vec!["train", "--seed", &seed, "--out", &out];
    arguments.extend(options);
    arguments.extend(controllers(options));
    arguments.extend(recordings.iter().map(String::as_str));
    chain.once(&out, &arguments)
}

/// Strokes by this method for every seed, each run several times, and measured.
fn track(chain: &ChainCommands<'_>, method: &EdicMethod, target: &str, quick: bool) -> Result<Cell> {
    let stem = format!(
        "tracked/{}-{}",
        method.name.replace(|c: char| !c.is_alphanumeric(), ""),
        target.replace(':', "")
    );
    let scene = method.scene.map(|scene| chain.scene_path(scene));
    let (seeds, repeats) = if quick { (1, 1) } else { (method.seeds, REPEATS) };
    let mut cell = Cell { followed: Vec::new(), refused: 0 };
    for seed in 1..=seeds {
        let model =
            method.model.map(|model| chain.path(&format!("{model}-{seed}.safetensors"))).transpose()?;
        let strokes = match (scene.as_deref(), model.as_deref()) {
            (Some(scene), residual) => Strokes::Twin { scene, residual },
            (None, model) => Strokes::Network(model.unwrap_or_default()),
        };
        let noise = [repeats, 100 * seed];
        match chain.track("virtual:typical", strokes, target, noise, &format!("{stem}/{seed}"))? {
            Some(followed) => cell.followed.extend(followed),
            None => cell.refused += 1,
        }
    }
    Ok(cell)
}
