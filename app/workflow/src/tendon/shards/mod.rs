//! `hysteron shards`: a set of synthetic data that many machines make, each a part of it at a time, in a folder or an object store.
//!
//! Objects of a set: `manifest.json` (what is made), `inputs/SHA256` (what workers read), `shards/*/*.parquet` (the rows) and
//! `sketches/*/*.json` (a summary of each shard, written after it: a shard with a sketch is done). Every object appears whole and
//! is never replaced, and a shard follows from the manifest and its own number alone. So workers need no coordinator: a shard
//! that two of them make is the same twice, one that a killed worker leaves behind is made again, and nothing is locked.

mod channel_sketch;
mod coverage;
mod manifest;
pub mod merge;
mod order;
pub mod plan;
mod rule;
mod shard_set;
mod sketch;
pub mod status;
pub mod work;
mod workbench;
