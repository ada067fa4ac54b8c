//! The run of `study robots`.

use anyhow::Result;
use hysteron_workflow::{Context, WorkflowError};
use rayon::prelude::*;

use super::outcome::RobotsMetrics;
use crate::tendon::commands::{ChainCommands, TESTS};
use crate::tendon::coreact::{PathErrors, TwinAblation, TwinErrors, TwinModels, TwinTable};
use crate::tendon::{Options, Outcome, session};

/// Presets, and the share of the recordings that their twins learn from: every third.
const PRESETS: [&str; 2] = ["mild", "harsh"];
const OF_ALL: usize = 3;
/// Members of the population around `typical`.
const MEMBERS: u64 = 10;

/// Runs the study on the virtual rig; quick: one preset, one member, few epochs, one test.
///
/// # Errors
/// A command fails, or an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome<RobotsMetrics>, WorkflowError> {
    session::run("robots", &options.out, context, || measure(options, context))
}

fn measure(options: &Options, context: &Context) -> Result<RobotsMetrics> {
    let Options { out, quick, repository } = options;
    let (presets, members, tests, epochs) = if *quick {
        (&PRESETS[..1], 1, &TESTS[..1], Some("2"))
    } else {
        (&PRESETS[..], MEMBERS, &TESTS[..], None)
    };
    let mut tables = Vec::new();
    for preset in presets {
        let study =
            TwinAblation { chain: ChainCommands::new(&out.join(preset), repository, context)?, tests };
        study.chain.record(preset, "paper", "data")?;
        let training: Vec<String> = study.chain.training_recordings()?.into_iter().step_by(OF_ALL).collect();
        tables.push(study.roll_out(&study.models(&training, [1; 2], epochs)?, "data", preset)?);
    }
    let study = TwinAblation { chain: ChainCommands::of_typical(out, repository, context)?, tests };
    study.chain.record("typical", "paper", "data")?;
    let models = study.models(&study.chain.training_recordings()?, [1; 2], epochs)?;
    tables.push(population(&study, &models, members)?);
    Ok(RobotsMetrics { ladders: tables })
}

/// The twins of `typical` on robots of the population around it; values of all robots together.
fn population(study: &TwinAblation, models: &[TwinModels], members: u64) -> Result<TwinTable> {
    let evaluate = |member: u64| {
        let data = format!("population-{member}");
        study.chain.record(&format!("typical/{member}"), "paper", &data)?;
        study.roll_out(models, &data, &data)
    };
    let each = (1..=members).into_par_iter().map(evaluate).collect::<Result<Vec<TwinTable>>>()?;
    let together = |(k, twin): (usize, &TwinModels)| {
        let of_test = |t: usize| -> [Vec<f64>; 3] {
            std::array::from_fn(|axis| each.iter().map(|own| own.twins[k].nrmse[t].axes()[axis][0]).collect())
        };
        let nrmse = study.tests.iter().enumerate().map(|(t, test)| PathErrors::new(test, of_test(t)));
        TwinErrors { twin: twin.name.clone(), nrmse: nrmse.collect() }
    };
    let twins = models.iter().enumerate().map(together).collect();
    Ok(TwinTable { robot: "population around typical".to_owned(), twins })
}
