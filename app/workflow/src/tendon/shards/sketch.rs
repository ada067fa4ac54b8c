//! The sketch of a shard: what the card of a set needs of its rows, small, and merged in any number.

use std::collections::BTreeMap;

use hysteron_base::{BadInput, Recording, json};
use serde::{Deserialize, Serialize};

use super::channel_sketch::ChannelSketch;
use super::coverage::{CellCounts, hull};
use super::manifest::SetManifest;
use super::rule::sketch_name;
use crate::shared::object_store::Store;
use crate::tendon::generate::tip_of;

/// Format and version of a sketch.
const FORMAT: &str = "hysteron-shard-sketch";
const VERSION: u32 = 1;
/// Skipped trajectories whose reasons are kept.
const MAX_REASONS: usize = 20;

/// Trajectories of a family.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FamilyCount {
    /// Trajectories in the set.
    pub made: u64,
    /// Skipped trajectories.
    pub skipped: u64,
    /// Samples.
    pub samples: u64,
}

/// A summary of recordings.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DataSketch {
    /// By family of the motion.
    pub families: BTreeMap<String, FamilyCount>,
    /// The first trajectories that were skipped, and why.
    pub reasons: Vec<(String, String)>,
    /// By name of the channel.
    pub channels: BTreeMap<String, ChannelSketch>,
    /// By family: where the tip was.
    pub cells: BTreeMap<String, CellCounts>,
    /// Corners of the convex hull of the tip's x and y [m].
    pub hull_m: Vec<[f64; 2]>,
}

/// The sketch of a shard, and the rows that it is of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ShardSketch {
    format: String,
    version: u32,
    /// Number of the shard.
    pub shard: usize,
    /// SHA-256 of the manifest by which it was made.
    pub manifest_sha256: String,
    /// SHA-256 of its rows.
    pub rows_sha256: String,
    /// Size of its rows [byte].
    pub rows_bytes: u64,
    /// The summary.
    pub data: DataSketch,
}

impl DataSketch {
    /// Adds the recordings of a shard, each with its family; the side of a cell of the tip is `side` [m].
    pub fn add(&mut self, recordings: &[(String, &Recording)], side: f64) -> Result<(), BadInput> {
        let mut tips = std::mem::take(&mut self.hull_m);
        for (family, recording) in recordings {
            let tip = tip_of(recording)?;
            let counts = self.families.entry(family.clone()).or_default();
            counts.made += 1;
            counts.samples += tip.len() as u64;
            self.cells.entry(family.clone()).or_default().add(tip.iter().copied(), side);
            tips.extend(tip);
            for channel in recording.channels() {
                let sketch = self.channels.entry(channel.name.clone()).or_default();
                sketch.merge(&ChannelSketch::of(&channel.values));
            }
        }
        self.hull_m = hull(tips.into_iter()).corners().to_vec();
        Ok(())
    }

    /// Adds a skipped trajectory.
    pub fn skip(&mut self, family: &str, trajectory: &str, why: &str) {
        self.families.entry(family.to_owned()).or_default().skipped += 1;
        if self.reasons.len() < MAX_REASONS {
            self.reasons.push((trajectory.to_owned(), why.to_owned()));
        }
    }

    /// Adds the recordings of another sketch.
    pub fn merge(&mut self, other: &Self) {
        for (family, counts) in &other.families {
            let own = self.families.entry(family.clone()).or_default();
            own.made += counts.made;
            own.skipped += counts.skipped;
            own.samples += counts.samples;
        }
        let room = MAX_REASONS.saturating_sub(self.reasons.len());
        self.reasons.extend(other.reasons.iter().take(room).cloned());
        for (name, sketch) in &other.channels {
            self.channels.entry(name.clone()).or_default().merge(sketch);
        }
        for (family, cells) in &other.cells {
            self.cells.entry(family.clone()).or_default().merge(cells);
        }
        let corners = self.hull_m.iter().chain(&other.hull_m).copied();
        self.hull_m = hull(corners).corners().to_vec();
    }

    /// Samples of all families.
    pub fn samples(&self) -> u64 {
        self.families.values().map(|family| family.samples).sum()
    }
}

impl ShardSketch {
    /// Of the rows of a shard.
    pub fn new(shard: usize, manifest_sha256: String, rows: &[u8], data: DataSketch) -> Self {
        Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            shard,
            manifest_sha256,
            rows_sha256: hysteron_base::file::sha256_hex(rows),
            rows_bytes: rows.len() as u64,
            data,
        }
    }

    /// The bytes of its object.
    pub fn to_bytes(&self) -> anyhow::Result<Vec<u8>> {
        Ok(json::to_line(self)?.into_bytes())
    }

    /// The sketch in the bytes of an object, `place`, of the shard `shard` of this manifest.
    ///
    /// # Errors
    /// `BadInput` for other content, or a sketch by another manifest.
    pub fn from_bytes(
        bytes: &[u8],
        place: &str,
        shard: usize,
        manifest: &SetManifest,
    ) -> Result<Self, BadInput> {
        let found: Self = json::from_text(bytes)
            .map_err(|error| BadInput::new(place, "the sketch of a shard", error.to_string()))?;
        if (&*found.format, found.version, found.shard) != (FORMAT, VERSION, shard) {
            let expected = format!("{FORMAT} {VERSION} of shard {shard}");
            let found = format!("{} {} of shard {}", found.format, found.version, found.shard);
            return Err(BadInput::new(place, expected, found));
        }
        if found.manifest_sha256 != manifest.sha256 {
            let expected = format!("{}, the manifest that is there", manifest.sha256);
            return Err(BadInput::new(format!("{place}: manifest_sha256"), expected, found.manifest_sha256)
                .hint("the manifest was changed after shards were made: bring it back, or plan again in another place"));
        }
        Ok(found)
    }

    /// Reads the sketch of a shard.
    ///
    /// # Errors
    /// Those of the store; as [`ShardSketch::from_bytes`], `BadInput` also where it is not there.
    pub fn read(store: &Store, shard: usize, manifest: &SetManifest) -> anyhow::Result<Self> {
        let name = sketch_name(shard);
        let place = store.place(&name);
        let Some(bytes) = store.get(&name)? else {
            return Err(BadInput::new(place, "the sketch of a shard", "nothing there").into());
        };
        Ok(Self::from_bytes(&bytes, &place, shard, manifest)?)
    }
}
