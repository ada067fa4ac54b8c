//! Where the tip was, from above, as counts that can be merged: square cells, and the convex hull.

use std::collections::BTreeMap;

use hysteron_control::inverse::{Axes, TipWorkspace};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Samples of the tip by cell; the cell (i, j) reaches from i and j to i + 1 and j + 1 times its side.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct CellCounts(pub BTreeMap<[i64; 2], u64>);

impl CellCounts {
    /// Adds samples of the tip [m], to cells of this side [m].
    pub fn add(&mut self, tips: impl Iterator<Item = [f64; 2]>, side: f64) {
        for tip in tips {
            *self.0.entry(tip.map(|x| (x / side).floor() as i64)).or_default() += 1;
        }
    }

    /// Adds the samples of another one.
    pub fn merge(&mut self, other: &Self) {
        other.0.iter().for_each(|(cell, count)| *self.0.entry(*cell).or_default() += count);
    }
}

impl Serialize for CellCounts {
    /// As a list of [i, j, samples].
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.iter().map(|([i, j], count)| (i, j, count)))
    }
}

impl<'de> Deserialize<'de> for CellCounts {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let rows = Vec::<(i64, i64, u64)>::deserialize(deserializer)?;
        Ok(Self(rows.into_iter().map(|(i, j, count)| ([i, j], count)).collect()))
    }
}

/// The convex hull of points [m]: hulls of parts, put together, are the hull of the whole.
pub(super) fn hull(points: impl Iterator<Item = [f64; 2]>) -> TipWorkspace {
    TipWorkspace::new(Axes::Planar, points.map(|[x, y]| [x, y, 0.0]).collect())
}
