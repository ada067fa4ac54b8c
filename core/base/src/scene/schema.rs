//! A scene exactly as typed: one field per key, units still in the names.
//!
//! Only `convert.rs` reads these. A key that may be left out, or that comes in several units, is an `Option`.

use super::{MaterialLaw, PrescribedQuantity};
use crate::schema::FixedArray;
use crate::units::LengthUnit;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    pub format: String,
    pub version: i64,
    pub name: String,
    pub seed: u64,
    pub mesh: MeshTable,
    pub reduced: Option<ReducedTable>,
    pub clamp: Clamp,
    pub material: MaterialTable,
    #[serde(default)]
    pub insert: Vec<InsertTable>,
    pub gravity: Gravity,
    #[serde(default)]
    pub point_force: Vec<PointForceTable>,
    pub tip: TipTable,
    pub tracker: Option<TrackerTable>,
    #[serde(default)]
    pub tendon: Vec<TendonTable>,
    pub friction: Option<TendonFrictionTable>,
    pub auxiliary: Option<AuxiliaryTable>,
    pub solver: Option<SolverTable>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshTable {
    pub file: String,
    pub unit: LengthUnit,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ReducedTable {
    pub file: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Clamp {
    pub group: Option<String>,
    pub box_min_mm: Option<FixedArray<f64, 3>>,
    pub box_max_mm: Option<FixedArray<f64, 3>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialTable {
    pub law: MaterialLaw,
    pub youngs_modulus_pa: Option<f64>,
    pub youngs_modulus_kpa: Option<f64>,
    pub youngs_modulus_mpa: Option<f64>,
    pub youngs_modulus_gpa: Option<f64>,
    pub poisson_ratio: f64,
    pub density_kg_m3: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct InsertTable {
    pub group: Option<String>,
    pub box_min_mm: Option<FixedArray<f64, 3>>,
    pub box_max_mm: Option<FixedArray<f64, 3>>,
    pub modulus_ratio: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Gravity {
    pub acceleration_m_s2: FixedArray<f64, 3>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PointForceTable {
    pub at_mm: FixedArray<f64, 3>,
    pub force_n: FixedArray<f64, 3>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TipTable {
    pub group: Option<String>,
    pub point_mm: Option<FixedArray<f64, 3>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TrackerTable {
    pub turn_deg: Option<FixedArray<f64, 3>>,
    pub shift_mm: Option<FixedArray<f64, 3>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TendonTable {
    pub name: String,
    pub points_mm: Vec<TendonPoint>,
    pub drive: PrescribedQuantity,
    pub tension_min_n: f64,
    pub tension_max_n: f64,
    pub stroke_min_mm: f64,
    pub stroke_max_mm: f64,
    pub attach_within_mm: f64,
    pub ring_mm: Option<f64>,
    pub anchor_radius_mm: Option<f64>,
    pub compliance_mm_per_n: Option<f64>,
    pub zero_mm: Option<f64>,
}

/// A point as an array, or as a table with more keys.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum TendonPoint {
    Carried(FixedArray<f64, 3>),
    Table(PointTable),
}

/// By hand, so that errors keep their place within the point.
impl<'de> Deserialize<'de> for TendonPoint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PointVisitor;

        impl<'de> Visitor<'de> for PointVisitor {
            type Value = TendonPoint;

            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                write!(f, "a point [x, y, z], or {{ at_mm = [x, y, z], fixed = true }}")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<TendonPoint, A::Error> {
                Deserialize::deserialize(SeqAccessDeserializer::new(seq)).map(TendonPoint::Carried)
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<TendonPoint, A::Error> {
                Deserialize::deserialize(MapAccessDeserializer::new(map)).map(TendonPoint::Table)
            }
        }

        deserializer.deserialize_any(PointVisitor)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PointTable {
    pub at_mm: FixedArray<f64, 3>,
    #[serde(default)]
    pub fixed: bool,
}

impl TendonPoint {
    pub(super) fn at_mm(self) -> [f64; 3] {
        match self {
            Self::Carried(at_mm) | Self::Table(PointTable { at_mm, .. }) => at_mm.0,
        }
    }

    pub(super) fn is_fixed(self) -> bool {
        matches!(self, Self::Table(PointTable { fixed: true, .. }))
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TendonFrictionTable {
    pub points: Option<i64>,
    pub coefficient: Option<f64>,
    pub coulomb_n: Option<f64>,
    pub sheath_exponent: Option<f64>,
    pub sheath_coulomb_n: Option<f64>,
    pub sheath_compliance_share: Option<f64>,
    pub backlash_mm: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AuxiliaryTable {
    pub segments: i64,
    pub segment_length_mm: f64,
    pub start_mm: f64,
    pub radius_mm: f64,
    pub cables_per_segment: i64,
    pub first_plane_deg: f64,
    pub plane_step_deg: f64,
    pub drive: PrescribedQuantity,
    pub tension_min_n: f64,
    pub tension_max_n: f64,
    pub stroke_min_mm: f64,
    pub stroke_max_mm: f64,
    pub stroke_rate_max_mm_s: Option<f64>,
    pub attach_within_mm: f64,
    pub anchor_radius_mm: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SolverTable {
    pub relative_residual: Option<f64>,
    pub stroke_tolerance_mm: Option<f64>,
}
