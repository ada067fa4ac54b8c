//! Verbs of tendon-driven robots, one room each.

pub mod adapt;
pub mod check;
pub mod command;
pub mod evaluate;
pub mod fit_material;
pub mod fit_residual;
pub mod fit_sensor;
pub mod generate;
pub mod identify;
pub mod mesh;
pub mod reach;
pub mod reduce;
pub mod sense;
pub mod shards;
pub mod simulate;
pub mod target;
pub mod track;
pub mod train;
