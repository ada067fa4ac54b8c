//! The ablation of `coreact` on robots other than `typical`: the twins of other presets, trained on a third
//! of the recordings; and the twins of `typical` on members of the population around it, which were not in
//! their training.

use std::path::Path;

use anyhow::Result;
use hysteron_base::json;
use rayon::prelude::*;
use serde_json::Value;

use super::chain::{Chain, TESTS};
use super::coreact::{Ladder, LadderRow, Rung, Study};
use super::write_metrics;

/// Presets, and the share of the recordings that their twins learn from: every third.
const PRESETS: [&str; 2] = ["mild", "harsh"];
const OF_ALL: usize = 3;
/// Members of the population around `typical`.
const MEMBERS: u64 = 10;

/// Runs the study on the virtual rig; quick: one preset, one member, few epochs, one test.
///
/// # Errors
/// A stage fails.
pub fn run(folder: &Path, quick: bool) -> Result<()> {
    let (presets, members, tests, epochs) = if quick {
        (&PRESETS[..1], 1, &TESTS[..1], Some("2"))
    } else {
        (&PRESETS[..], MEMBERS, &TESTS[..], None)
    };
    let mut ladders = Vec::new();
    for preset in presets {
        let study = Study { chain: Chain::new(&folder.join(preset))?, tests };
        study.chain.record(preset, "paper", "data")?;
        let training: Vec<String> = study.chain.training_recordings()?.into_iter().step_by(OF_ALL).collect();
        let ladder = study.climb(&study.rungs(&training, [1; 2], epochs)?, "data", preset)?;
        ladder.print();
        ladders.push(ladder);
    }
    let study = Study { chain: Chain::of_typical(folder)?, tests };
    study.chain.record("typical", "paper", "data")?;
    let rungs = study.rungs(&study.chain.training_recordings()?, [1; 2], epochs)?;
    let population = population(&study, &rungs, members)?;
    population.print();
    ladders.push(population);
    let ladders: Vec<Value> = ladders.iter().map(Ladder::json).collect();
    write_metrics(folder, "robots", json!({ "ladders": ladders }))
}

/// The twins of `typical` on robots of the population around it; values of all robots side by side.
fn population(study: &Study, rungs: &[Rung], members: u64) -> Result<Ladder> {
    let judge = |member: u64| {
        let data = format!("population-{member}");
        study.chain.record(&format!("typical/{member}"), "paper", &data)?;
        study.climb(rungs, &data, &data)
    };
    let each = (1..=members).into_par_iter().map(judge).collect::<Result<Vec<Ladder>>>()?;
    let together = |k: usize, rung: &Rung| {
        let of_test = |t: usize| -> [Vec<f64>; 3] {
            std::array::from_fn(|axis| each.iter().map(|ladder| ladder.rows[k].nrmse[t].1[axis][0]).collect())
        };
        let nrmse = study.tests.iter().enumerate().map(|(t, test)| (*test, of_test(t))).collect();
        LadderRow { name: rung.name.clone(), nrmse }
    };
    let rows = rungs.iter().enumerate().map(|(k, rung)| together(k, rung)).collect();
    Ok(Ladder { robot: "population around typical".to_owned(), rows })
}
