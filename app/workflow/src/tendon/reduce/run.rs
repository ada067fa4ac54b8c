//! The recipe: scene to twin, twin to chain, chain against twin, chain to file.

use hysteron_base::{BadInput, Scene};
use hysteron_twin::Twin;
use hysteron_twin::chain::{Chain, ValidationOptions};

use super::options::Options;
use super::outcome::Outcome;
use crate::shared::error::Cancelled;
use crate::shared::outputs::Outputs;
use crate::{Context, WorkflowError};

/// Largest stroke of a validation over the length of the shortest tendon [-].
const STROKE_SHARE: f64 = 0.075;

/// Runs the verb.
///
/// # Errors
/// Bad input; a body that cannot be cut into sections; an interruption; a file that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(reduce(options, context)?)
}

fn reduce(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let scene = Scene::read(&options.scene)?;
    let _lock =
        Outputs::default().scene(&options.scene, &scene).file("--out", &options.out).check(context)?;
    let twin = Twin::from_scene(&scene)?;
    let validation = validation(options, &scene, &twin)?;
    context.listen();
    let mut chain = Chain::new(&twin)?;
    tracing::info!(
        "{}: {} unknowns as {} sections with {}",
        scene.name,
        twin.body.n_unknowns(),
        chain.n_sections(),
        chain.n_unknowns()
    );
    let bar = context.progress("equilibria", validation.count, 0);
    chain.validate(&twin, &validation, |done| {
        bar.set_position(done as u64);
        !context.is_cancelled()
    })?;
    bar.finish();
    if context.is_cancelled() {
        return Err(Cancelled::new("; nothing is written").into());
    }
    let found = chain.validation.clone().unwrap_or_default();
    chain.write(&options.out, &scene.hash, &context.command)?;
    let twin = (scene.hash, twin.body.n_unknowns());
    let outcome = Outcome::new(options.out.clone(), twin, (&chain, &found), context);
    context.wrote(&options.out);
    Ok(outcome)
}

/// Targets of the validation.
fn validation(options: &Options, scene: &Scene, twin: &Twin) -> Result<ValidationOptions, BadInput> {
    let positive = |option: &str, unit: &str, value: f64| {
        if value.is_finite() && value > 0.0 {
            return Ok(());
        }
        Err(BadInput::new(option, format!("a finite number of {unit} above 0"), value.to_string()))
    };
    if let Some(stroke) = options.stroke_mm {
        positive("--stroke-mm", "millimetres", stroke)?;
    }
    positive("--tension-n", "newtons", options.tension_n)?;
    if options.equilibria == 0 {
        return Err(BadInput::new("--equilibria", "at least 1", "0"));
    }
    if twin.n_primary == 0 {
        return Err(BadInput::new("the scene", "at least one tendon", "none"));
    }
    let shortest = twin.cables.rest_lengths[..twin.n_primary].iter().copied().fold(f64::INFINITY, f64::min);
    Ok(ValidationOptions {
        count: options.equilibria as usize,
        stroke: options.stroke_mm.map_or(STROKE_SHARE * shortest, |stroke| 1e-3 * stroke),
        tension: options.tension_n,
        seed: scene.seed,
    })
}
