//! The recipe: the set's inputs, the shards that are missing, each built in memory and stored as a whole.

use std::time::Instant;

use super::options::Options;
use super::outcome::Outcome;
use crate::shared::error::Cancelled;
use crate::shared::object_store::{PutOutcome, Store};
use crate::tendon::shards::order::WorkOrder;
use crate::tendon::shards::rule::{rows_name, sketch_name};
use crate::tendon::shards::shard_set::Listing;
use crate::tendon::shards::sketch::ShardSketch;
use crate::tendon::shards::workbench::Workbench;
use crate::{Context, WorkflowError};

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
    let mut order = match options.worker {
        Some(part) => WorkOrder::of_part(part, rule.shards),
        None => WorkOrder::of_worker(rand::random(), rule.shards),
    };
    tracing::info!("{}: {} of {} shards are there already", options.url, there.len(), rule.shards);
    context.listen();
    let bar = context.progress("shards", rule.shards, there.len());
    let (mut made, mut made_twice, mut samples) = (0, 0, 0);
    while let Some(shard) = order.next(&there) {
        // Another worker may have made it since the last listing, and others with it.
        if store.has(&sketch_name(shard))? && store.has(&rows_name(shard))? {
            there = Listing::of(&store, rule.shards)?.done;
            there.insert(shard);
            continue;
        }
        let Some(built) = bench.build(shard, &|| !context.is_cancelled())? else {
            let kept = format!("; {made} shards of this worker are stored; run it again to go on");
            return Err(Cancelled::new(kept).into());
        };
        samples += built.n_samples();
        match bench.store(&store, built)? {
            PutOutcome::Written => made += 1,
            PutOutcome::AlreadyThere => {
                made_twice += 1;
                there = Listing::of(&store, rule.shards)?.done;
                order.leave_stretch();
            }
        }
        there.insert(shard);
        bar.set_position(there.len() as u64);
    }
    bar.finish();
    let already_there = order.n_shards() - made - made_twice;
    let seconds = start.elapsed().as_secs_f64();
    let outcome = Outcome { url: options.url.clone(), made, made_twice, already_there, samples, seconds };
    outcome.print(context);
    Ok(outcome)
}
