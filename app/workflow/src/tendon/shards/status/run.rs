//! The recipe: the manifest, and a listing of what is there.

use super::options::Options;
use super::outcome::Outcome;
use crate::shared::object_store::Store;
use crate::tendon::shards::manifest::SetManifest;
use crate::tendon::shards::shard_set::Listing;
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; those of the store.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(status(options, context)?)
}

fn status(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let store = Store::open(&options.url)?;
    let manifest = SetManifest::read(&store)?.content;
    let shards = manifest.rule.shards;
    let listing = Listing::of(&store, shards)?;
    let done = listing.done.len();
    let missing = shards - done;
    let hours = listing.written_s.map_or(0.0, |[first, last]| (last - first) / 3600.0);
    // The first sketch begins the time that the others took.
    let rate = (done > 1 && hours > 0.0).then(|| (done - 1) as f64 / hours);
    let outcome = Outcome {
        url: options.url.clone(),
        plan: manifest.plan_name,
        shards,
        done,
        missing,
        missing_shards: listing.done.describe_missing(),
        unfinished: listing.unfinished,
        bytes: listing.bytes,
        shards_per_hour: rate,
        hours_left: rate.map(|rate| missing as f64 / rate),
    };
    outcome.print(context);
    Ok(outcome)
}
