//! The recipe: which shards are there, their sketches merged one after the other, the card.

use hysteron_base::BadInput;
use hysteron_report::folder::ReportFolder;

use super::options::Options;
use super::outcome::Outcome;
use super::page;
use crate::shared::error::Cancelled;
use crate::shared::object_store::Store;
use crate::shared::outputs::Outputs;
use crate::tendon::shards::manifest::SetManifest;
use crate::tendon::shards::rule::{shard_of, sketch_name};
use crate::tendon::shards::shard_set::Listing;
use crate::tendon::shards::sketch::{DataSketch, ShardSketch};
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input, an incomplete set too; an interruption; those of the store; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(merge(options, context)?)
}

fn merge(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let store = Store::open(&options.url)?;
    let manifest = SetManifest::read(&store)?;
    let shards = manifest.content.rule.shards;
    let listing = Listing::of(&store, shards)?;
    let done = listing.done.len();
    if done < shards && !options.partial {
        let missing =
            format!("{done} of them; {} missing: {}", shards - done, listing.done.describe_missing());
        return Err(BadInput::new(&options.url, format!("all {shards} shards"), missing)
            .hint(format!(
                "hysteron shards work {} makes them; --partial makes a card without them",
                options.url
            ))
            .into());
    }
    let _lock = Outputs::default().report("--out", Some(&options.out)).check(context)?;
    context.listen();
    let bar = context.progress("shards", done, 0);
    let (mut data, mut bytes) = (DataSketch::default(), 0);
    let names = (0..shards).filter(|shard| listing.done.has(*shard)).map(sketch_name);
    store.get_each(names, |name, found| {
        if context.is_cancelled() {
            return Err(Cancelled::new("; nothing is written").into());
        }
        let shard = shard_of(name).unwrap_or_default();
        let sketch = ShardSketch::from_bytes(&found, &store.place(name), shard, &manifest)?;
        data.merge(&sketch.data);
        bytes += sketch.rows_bytes;
        bar.inc(1);
        Ok(())
    })?;
    bar.finish();
    // The rows that are there are those that the sketches are of.
    if bytes != listing.bytes && listing.unfinished == 0 {
        let expected = format!("{bytes} bytes of rows, the sum of the sketches");
        return Err(BadInput::new(store.place("shards"), expected, listing.bytes.to_string())
            .hint("rows were changed or lost: delete the sketches of those shards, and work again")
            .into());
    }
    let set = (&manifest.content, &*manifest.sha256);
    let outcome = Outcome::new(&options.url, set, (&listing.done, bytes), &data, context);
    let folder = ReportFolder { path: &options.out, png: options.png };
    page::write(&folder, &outcome, (&data, manifest.content.cell_m))?;
    outcome.print(context);
    context.reported(&options.out);
    Ok(outcome)
}
