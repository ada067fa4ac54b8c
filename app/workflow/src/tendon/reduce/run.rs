//! The recipe: scene to twin, twin to chain, chain against twin, chain to file.

use hysteron_base::Scene;
use hysteron_twin::Twin;
use hysteron_twin::chain::Chain;

use super::equilibria::{equilibria, saved_beside};
use super::options::Options;
use super::outcome::Outcome;
use crate::shared::outputs::Outputs;
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; an interruption; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(reduce(options, context)?)
}

fn reduce(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    options.check()?;
    let scene = Scene::read_unreduced(&options.scene)?;
    let twin = Twin::new(&scene, &hysteron_twin::read_body(&scene)?.0)?;
    let outputs = Outputs::default().scene(&options.scene, &scene).file("--out", &options.out);
    let _lock = outputs.check(context)?;
    let mut chain = Chain::new(&twin)?;
    context.listen();
    let comparison = options.validation(&twin, scene.seed);
    let exact = equilibria(&twin, &scene.hash, &comparison, &options.out, context)?;
    chain.validate(&twin, &comparison, &exact)?;
    chain.write(&options.out, &context.command)?;
    // The equilibria are of use until then; where there are none, no file was written.
    let _ = std::fs::remove_file(saved_beside(&options.out));
    let errors = chain.validation.clone().unwrap_or_default();
    let outcome = Outcome::new(options.out.clone(), &scene.hash, &twin, &chain, errors);
    context.wrote(&options.out);
    Ok(outcome)
}
