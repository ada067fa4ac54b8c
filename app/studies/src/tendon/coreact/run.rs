//! The run of `study coreact`.

use hysteron_workflow::{Context, WorkflowError};

use super::outcome::CoreactMetrics;
use super::twins::{SCENES, TwinAblation, TwinModels};
use crate::tendon::commands::{ChainCommands, TESTS};
use crate::tendon::{Options, Outcome, session};

/// Random plans for the stability of the loop.
const N_RANDOM: usize = 100;

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
/// A command fails, or an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome<CoreactMetrics>, WorkflowError> {
    let size = if options.quick {
        Size { seeds: [1; 2], epochs: Some("2"), n_random: 2, tests: &TESTS[..1] }
    } else {
        Size { seeds: [1, 5], epochs: None, n_random: N_RANDOM, tests: &TESTS }
    };
    session::run("coreact", &options.out, context, || measure(options, &size, context))
}

fn measure(options: &Options, size: &Size, context: &Context) -> anyhow::Result<CoreactMetrics> {
    let chain = ChainCommands::of_typical(&options.out, &options.repository, context)?;
    let study = TwinAblation { chain, tests: size.tests };
    study.chain.record("typical", "paper", "data")?;
    let training = study.chain.training_recordings()?;
    let mut models = study.models(&training, size.seeds, size.epochs)?;
    let best = models.len() - 1;
    let paper = study.train_paper(size.epochs)?;
    models.push(TwinModels {
        name: "twin + paper's network".to_owned(),
        scene: SCENES[0].1.to_owned(),
        models: vec![Some(paper)],
    });
    let typical = study.roll_out(&models, "data", "typical")?;
    let steady = study.steady(&models[best..=best])?;
    let stability = study.stability(size.n_random)?;
    Ok(CoreactMetrics { ladders: vec![typical, steady], stability })
}
