//! The recipe: scene to twin, twin to chain, chain against twin, chain to file.

use hysteron_base::Scene;
use hysteron_twin::Twin;
use hysteron_twin::chain::Chain;

use super::options::Options;
use super::outcome::Outcome;
use crate::shared::error::Cancelled;
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
    let scene = Scene::read(&options.scene)?;
    let twin = Twin::new(&scene, &hysteron_twin::read_body(&scene)?.0)?;
    let outputs = Outputs::default().scene(&options.scene, &scene).file("--out", &options.out);
    let _lock = outputs.check(context)?;
    let mut chain = Chain::new(&twin)?;
    context.listen();
    let bar = context.progress("equilibria", options.count, 0);
    chain.validate(&twin, &options.validation(&twin, scene.seed), |done| {
        bar.set_position(done as u64);
        !context.is_cancelled()
    })?;
    bar.finish();
    if context.is_cancelled() {
        return Err(Cancelled::new("; nothing is written").into());
    }
    chain.write(&options.out, &context.command)?;
    let errors = chain.validation.clone().unwrap_or_default();
    let outcome = Outcome::new(options.out.clone(), &scene.hash, &twin, &chain, errors);
    context.wrote(&options.out);
    Ok(outcome)
}
