//! The outcome of `shards merge`: the card of a set.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome::MetricsFormat;
use crate::tendon::shards::channel_sketch::ChannelSketch;
use crate::tendon::shards::coverage::hull;
use crate::tendon::shards::manifest::Manifest;
use crate::tendon::shards::shard_set::ShardSet;
use crate::tendon::shards::sketch::DataSketch;
use crate::{COMMIT, Context};

/// Trajectories of a family.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FamilySamples {
    /// Trajectories in the set.
    pub made: u64,
    /// Skipped trajectories.
    pub skipped: u64,
    /// Samples.
    pub samples: u64,
}

/// A trajectory that the twin cannot follow.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SkippedExample {
    /// Its name.
    pub name: String,
    /// Why it was skipped.
    pub why: String,
}

/// The values of a channel, in its SI unit.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ChannelStatistics {
    /// Smallest value.
    pub smallest: f64,
    /// Largest value.
    pub largest: f64,
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub deviation: f64,
    /// Values that 1, 50 and 99 % of the samples do not pass, good to a sixteenth of themselves.
    pub quantiles: [f64; 3],
}

impl ChannelStatistics {
    fn of(sketch: &ChannelSketch) -> Self {
        Self {
            smallest: sketch.min,
            largest: sketch.max,
            mean: sketch.mean,
            deviation: sketch.deviation(),
            quantiles: [0.01, 0.5, 0.99].map(|part| sketch.quantile(part)),
        }
    }
}

/// The outcome of `shards merge`: the card of a set.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Place of the set.
    pub url: String,
    /// SHA-256 of its manifest.
    pub manifest_sha256: String,
    /// Name of the robot.
    pub robot: String,
    /// Hash of the scene and its mesh.
    pub scene_sha256: String,
    /// Name of the plan.
    pub plan: String,
    /// Whether all shards are there.
    pub complete: bool,
    /// Shards of the set.
    pub shards: usize,
    /// Shards that are missing.
    pub missing: usize,
    /// The missing shards in words, the first few; empty where none is missing.
    pub missing_shards: String,
    /// Trajectories in the set.
    pub made: u64,
    /// Skipped trajectories.
    pub dropped: u64,
    /// Samples of all.
    pub samples: u64,
    /// Size of all rows [byte].
    pub bytes: u64,
    /// Area that the tip goes over [m²]; convex hull.
    pub area_m2: f64,
    /// Part of the samples in which the network left its training range [-].
    pub extrapolating: f64,
    /// Part of the samples in which a chain was bent further than it was validated [-].
    pub outside_validation: f64,
    /// By family of the motion.
    pub families: BTreeMap<String, FamilySamples>,
    /// By name of the channel.
    pub channels: BTreeMap<String, ChannelStatistics>,
    /// The first of the skipped trajectories.
    pub skipped: Vec<SkippedExample>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl crate::shared::outcome::Outcome for Outcome {}

impl Outcome {
    /// Of the merged sketches of all shards that are there.
    pub(super) fn new(
        url: &str,
        (manifest, manifest_sha256): (&Manifest, &str),
        (there, bytes): (&ShardSet, u64),
        data: &DataSketch,
        context: &Context,
    ) -> Self {
        let sum = |of: fn(&FamilySamples) -> u64, families: &BTreeMap<String, FamilySamples>| {
            families.values().map(of).sum()
        };
        let families = data.families.iter().map(|(name, one)| {
            let counts = FamilySamples { made: one.made, skipped: one.skipped, samples: one.samples };
            (name.clone(), counts)
        });
        let families = families.collect();
        let mean = |name: &str| data.channels.get(name).map_or(0.0, |sketch| sketch.mean);
        let missing = manifest.rule.shards - there.len();
        let skipped = data.reasons.iter();
        let skipped = skipped.map(|(name, why)| SkippedExample { name: name.clone(), why: why.clone() });
        Self {
            format: MetricsFormat,
            version: 1,
            url: url.to_owned(),
            manifest_sha256: manifest_sha256.to_owned(),
            robot: manifest.robot.clone(),
            scene_sha256: manifest.scene_sha256.clone(),
            plan: manifest.plan_name.clone(),
            complete: missing == 0,
            shards: manifest.rule.shards,
            missing,
            missing_shards: there.describe_missing(),
            made: sum(|family| family.made, &families),
            dropped: sum(|family| family.skipped, &families),
            samples: data.samples(),
            bytes,
            area_m2: hull(data.hull_m.iter().copied()).area(),
            extrapolating: mean("extrapolating"),
            outside_validation: mean(hysteron_twin::synthetic::OUTSIDE_VALIDATION),
            families,
            channels: data.channels.iter().map(|(k, v)| (k.clone(), ChannelStatistics::of(v))).collect(),
            skipped: skipped.collect(),
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }

    /// The set in one sentence.
    pub(super) fn conclusion(&self) -> String {
        let Self { made, samples, shards, missing, missing_shards, .. } = self;
        let covered = format!("{made} trajectories, {samples} samples, over {:.1} cm²", 1e4 * self.area_m2);
        match self.complete {
            true => format!("Complete: {covered}."),
            false => format!(
                "Incomplete: {missing} of {shards} shards are missing ({missing_shards}). So far {covered}."
            ),
        }
    }

    /// Prints it.
    pub(super) fn print(&self, context: &Context) {
        context.print(self.conclusion());
        context.print(format_args!(
            "{} trajectories skipped; network outside its training range in {:.1} % of the samples; {:.3} GB, {:.1} bytes a sample",
            self.dropped,
            100.0 * self.extrapolating,
            1e-9 * self.bytes as f64,
            self.bytes as f64 / self.samples.max(1) as f64
        ));
    }
}
