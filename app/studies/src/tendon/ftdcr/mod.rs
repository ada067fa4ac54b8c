//! `study ftdcr`: a three-segment robot driven by nine strokes, tip error on patterns that were not fitted, in five folds.
//!
//! Compared with each other: a reduced model, three arcs of constant curvature with fitted zeros, compliance
//! and angles of the tendons (twelve numbers), and the same with their plays, its weight and the place of the marker; a kernel
//! ridge and a network with a memory on the residual of that; static regressions of the tip on the strokes and a network, without any model; and on fewer rows the
//! finite-element twin with the reduced model's parameters, with its own, and with auxiliary tendons that
//! bring its marker to the prediction of a regression of its residual (CoReAct), or to the measured place. A
//! pattern and its holds are never divided.

mod fit;
mod fold;
mod lstm;
mod outcome;
mod page;
mod recording;
mod reduced;
mod regression;
mod robot;
mod run;

pub use fold::{N_FOLDS, folds};
pub use outcome::{FoldResult, FtdcrMetrics, MethodError, ParameterValue};
pub use recording::{N_TENDONS, Pattern, Row, read_patterns};
pub use run::run;
