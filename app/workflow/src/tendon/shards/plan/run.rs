//! The recipe: inputs and plan checked, an estimate, inputs stored by their hashes, and the manifest last.

use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, Scene, file};
use hysteron_control::{LazyPlan, MotionPlan};
use hysteron_twin::Twin;

use super::estimate::CostEstimate;
use super::options::Options;
use super::outcome::{Outcome, PlannedInput};
use crate::shared::error::Cancelled;
use crate::shared::network::Network;
use crate::shared::object_store::{PutOutcome, Store};
use crate::shared::plan;
use crate::tendon::generate::{TrajectorySimulator, default_plan};
use crate::tendon::shards::manifest::{FORMAT, InputFile, Manifest, PROGRAM, SetManifest, VERSION};
use crate::tendon::shards::rule::ShardRule;
use crate::tendon::shards::workbench::check_relative;
use crate::{COMMIT, Context, WorkflowError};

/// Samples of a shard, where nothing is said: some 10 MB.
const ROWS_PER_SHARD: u64 = 100_000;
/// Cells of the sketches along the length of the robot.
const CELLS: f64 = 100.0;

/// Runs the verb.
///
/// # Errors
/// Bad input; an interruption; those of the store.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(planned(options, context)?)
}

fn planned(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let scene = options.body.scene(&options.scene)?;
    let twin = Twin::from_scene(&scene)?;
    let network = options.residual.as_deref().map(|path| Network::read(path, &scene, &twin)).transpose()?;
    let (plan, text) = read_plan(options, network.as_ref(), twin.n_primary, context)?;
    plan::check_angles(
        plan.name(),
        plan.angles(),
        &plan::angles_of(&scene),
        &format!("scene {}", scene.name),
    )?;
    plan.check()?;
    let samples = plan.n_samples()?;
    let rule = rule(options, plan.n_trajectories(), samples)?;
    let mesh_name = mesh_name(&options.scene, &scene)?;
    let store = Store::create(&options.to)?;
    context.listen();
    let simulator = TrajectorySimulator {
        scene: &scene,
        twin: &twin,
        network: network.as_ref(),
        limits: plan.limits(),
        command: &context.command,
    };
    let estimate = match options.measure {
        0 => None,
        n => CostEstimate::measured(&simulator, &plan, (n, samples), context)?,
    };
    if context.is_cancelled() {
        return Err(Cancelled::new("; nothing is planned").into());
    }
    let upload = |name: &str, path: &Path| stored(&store, name, std::fs::read(path)?);
    let manifest = Manifest {
        format: FORMAT.to_owned(),
        version: VERSION,
        program: PROGRAM.to_owned(),
        commit: COMMIT.to_owned(),
        command: context.command.clone(),
        robot: scene.name.clone(),
        scene_sha256: scene.hash.clone(),
        plan_name: plan.name().to_owned(),
        seed: plan.seed(),
        samples,
        plan: stored(&store, "plan.toml", text.into_bytes())?,
        scene: upload("scene.toml", &options.scene)?,
        mesh: upload(&mesh_name, &scene.mesh_path)?,
        reduced: scene.reduced_path.as_deref().map(|path| upload("reduced", path)).transpose()?,
        residual: options.residual.as_deref().map(|path| upload("residual", path)).transpose()?,
        rule,
        cell_m: twin.cables.longest() / CELLS,
    };
    let (set, put) = SetManifest::publish(&store, &manifest)?;
    let input = |input: &InputFile| PlannedInput { name: input.name.clone(), sha256: input.sha256.clone() };
    let outcome = Outcome {
        url: options.to.clone(),
        manifest_sha256: set.sha256,
        was_there: put == PutOutcome::AlreadyThere,
        robot: manifest.robot.clone(),
        plan: manifest.plan_name.clone(),
        trajectories: rule.trajectories,
        samples,
        shards: rule.shards,
        inputs: manifest.inputs().map(input).collect(),
        estimate,
    };
    outcome.print(context);
    Ok(outcome)
}

/// The plan and its text: the one that is named, or that which `generate` uses where none is.
fn read_plan(
    options: &Options,
    network: Option<&Network>,
    n_tendons: usize,
    context: &Context,
) -> anyhow::Result<(LazyPlan, String)> {
    let named = options.plan.as_deref();
    let (text, place) = match named {
        Some(named) if Path::new(named).extension().is_some() => {
            (file::read_text(Path::new(named))?, named.to_owned())
        }
        Some(named) => {
            MotionPlan::named(named)?;
            (MotionPlan::text(named).unwrap_or_default().to_owned(), format!("plan {named}"))
        }
        None => {
            let (plan, text, _) =
                default_plan(options.residual.as_deref(), network, &[], n_tendons, context)?;
            (text, format!("plan {}", plan.name))
        }
    };
    Ok((LazyPlan::from_toml(&text, &place)?, text))
}

/// How the trajectories are shared out.
fn rule(options: &Options, trajectories: usize, samples: u64) -> Result<ShardRule, BadInput> {
    let per_shard = options.rows_per_shard.unwrap_or(ROWS_PER_SHARD);
    if per_shard == 0 {
        return Err(BadInput::new("--rows-per-shard", "at least 1", "0"));
    }
    let by_rows = usize::try_from(samples.div_ceil(per_shard)).unwrap_or(usize::MAX).min(trajectories);
    let shards = options.shards.unwrap_or(by_rows);
    if !(1..=trajectories).contains(&shards) {
        let expected = format!("1 to {trajectories}, the trajectories of the plan");
        return Err(BadInput::new("--shards", expected, shards.to_string()));
    }
    Ok(ShardRule { trajectories, shards })
}

/// The mesh's file as the scene names it.
fn mesh_name(path: &Path, scene: &Scene) -> Result<String, BadInput> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let relative = scene.mesh_path.strip_prefix(folder).map(PathBuf::from);
    let name = relative.unwrap_or_else(|_| scene.mesh_path.clone()).display().to_string();
    check_relative(&name).map_err(|bad| bad.within(path.display()))?;
    Ok(name)
}

/// Stores an input by its hash; it may be there already.
fn stored(store: &Store, name: &str, bytes: Vec<u8>) -> anyhow::Result<InputFile> {
    let input = InputFile { name: name.to_owned(), sha256: file::sha256_hex(&bytes) };
    store.put_new(&input.object(), bytes)?;
    Ok(input)
}
