//! Estimators compared with theory and with motions of known arms, and recordings that are none.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod damaged;
mod data_sets;
mod detection;
mod excite;
mod identify;
mod import;
mod observers;
mod recorded;
