//! The recipe: scene to twin, twin to chain, chain against twin, chain to file.

use hysteron_base::Scene;
use hysteron_twin::Twin;
use hysteron_twin::chain::{Chain, Validation};

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
    let twin = Twin::from_scene(&scene)?;
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
    chain.write(&options.out, &scene.hash, &context.command)?;
    let errors = chain.validation.clone().unwrap_or_default();
    print(&chain, &errors, context);
    let outcome = Outcome::new(options.out.clone(), &scene.hash, &twin, &chain, errors);
    context.wrote(&options.out);
    Ok(outcome)
}

fn print(chain: &Chain, errors: &Validation, context: &Context) {
    context.print(format_args!("{} sections, {} unknowns", chain.n_sections(), chain.n_unknowns()));
    context.print(format_args!("{} equilibria compared       median       99 %    largest", errors.count));
    let rows = [("tip [%]", 100.0, &errors.tip), ("tensions [%]", 100.0, &errors.tensions)];
    for (name, unit, spread) in
        rows.into_iter().chain([("turn of the tip [deg]", 1f64.to_degrees(), &errors.turn)])
    {
        let [median, most, largest] = [spread.median, spread.percentile_99, spread.largest]
            .map(|error| format!("{:>11.3}", unit * error));
        context.print(format_args!("{name:<22}{median}{most}{largest}"));
    }
}
