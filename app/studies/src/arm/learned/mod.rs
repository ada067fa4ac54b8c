//! `study simulated`, `characters`, `baxter-circle`, `baxter-helical`, `kuka`, `panda` and `recorded`: learned inverse dynamics of
//! simulated and recorded arms, compared with simple models and with published tables.

mod options;
mod outcome;
mod page;
mod published;
mod real;
mod run;
mod simulated;

pub use options::{
    ActivationName, CharactersOptions, NetworkOptions, PolishName, RecordedOptions, SimulatedOptions,
};
pub use outcome::Outcome;
pub use published::{PublishedRow, published, published_parts};
pub use real::{RealOptions, RealRow, real_study, shown_samples};
pub use run::{RecordedSet, characters, recorded, simulated};
pub use simulated::{
    Parts, SimulatedRow, SimulatedStudy, Units, characters_study, simulated_study, simulated_test,
};
