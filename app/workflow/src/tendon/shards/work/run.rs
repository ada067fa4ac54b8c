//! The recipe: the set's inputs, the shards that are missing, each built in memory and stored as a whole.

use std::time::Instant;

use super::options::Options;
use super::outcome::Outcome;
use crate::shared::error::Cancelled;
use crate::shared::object_store::{PutOutcome, Store};
use crate::tendon::shards::order::WorkOrder;
use crate::tendon::shards::rule::{rows_name, sketch_name};
use crate::tendon::shards::shard_set::{Listing, ShardSet};
use crate::tendon::shards::sketch::ShardSketch;
use crate::tendon::shards::workbench::Workbench;
use crate::{Context, WorkflowError};

/// Shards that others have made meanwhile, after which all are listed again.
const RELIST_AFTER: usize = 64;

/// Runs the verb.
///
/// # Errors
/// Bad input; an interruption; those of the store.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(work(options, context)?)
}

fn work(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let start = Instant::now();
    let store = Store::open(&options.url)?;
    let bench = Workbench::fetch(&store)?;
    let rule = bench.manifest.content.rule;
    let mut there = Listing::of(&store, rule.shards)?.done;
    // A set that another manifest has begun is refused before work is spent on it.
    if let Some(first) = (0..rule.shards).find(|shard| there.has(*shard)) {
        ShardSketch::read(&store, first, &bench.manifest)?;
    }
    let order = match options.worker {
        Some(part) => WorkOrder::of_part(part, rule.shards),
        None => WorkOrder::of_worker(rand::random(), rule.shards),
    };
    tracing::info!("{}: {} of {} shards are there already", options.url, there.len(), rule.shards);
    context.listen();
    let bar = context.progress("shards", rule.shards, there.len());
    let mut outcome = Outcome {
        url: options.url.clone(),
        made: 0,
        made_twice: 0,
        already_there: 0,
        samples: 0,
        seconds: 0.0,
    };
    let mut found_meanwhile = 0;
    for shard in order {
        if is_there(&store, &mut there, shard, &mut found_meanwhile)? {
            outcome.already_there += 1;
            continue;
        }
        let Some(built) = bench.build(shard, &|| !context.is_cancelled())? else {
            let kept = format!("; {} shards of this worker are stored; run it again to go on", outcome.made);
            return Err(Cancelled::new(kept).into());
        };
        outcome.samples += built.n_samples();
        match bench.store(&store, built)? {
            PutOutcome::Written => outcome.made += 1,
            PutOutcome::AlreadyThere => outcome.made_twice += 1,
        }
        bar.inc(1);
    }
    bar.finish();
    outcome.seconds = start.elapsed().as_secs_f64();
    outcome.print(context);
    Ok(outcome)
}

/// Whether a shard is there, also one that another worker has made since the last listing.
fn is_there(
    store: &Store,
    there: &mut ShardSet,
    shard: usize,
    found_meanwhile: &mut usize,
) -> anyhow::Result<bool> {
    if there.has(shard) {
        return Ok(true);
    }
    if !store.has(&sketch_name(shard))? || !store.has(&rows_name(shard))? {
        return Ok(false);
    }
    *found_meanwhile += 1;
    there.insert(shard);
    if (*found_meanwhile).is_multiple_of(RELIST_AFTER) {
        *there = Listing::of(store, there.n())?.done;
    }
    Ok(true)
}
