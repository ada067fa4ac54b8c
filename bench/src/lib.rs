//! Code shared by the targets, the studies, the benchmarks and the comparison tests.
//!
//! `columns` reads tables, `scenes` builds the robots in code, `drive` makes their commands, `measure` times
//! steps, `table` prints and writes figures, `rig` drives the virtual rig, `coreact` identifies and rolls
//! out, `fit` fits a scene, `growth` times the readers on larger and larger files, `learn` trains a network,
//! `study` compares with other programs and with a real robot.

pub mod columns;
pub mod coreact;
pub mod drive;
pub mod fit;
pub mod growth;
pub mod learn;
pub mod measure;
pub mod rig;
pub mod scenes;
pub mod study;
pub mod table;
pub mod targets;
