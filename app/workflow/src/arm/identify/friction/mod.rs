//! `hysteron arm identify friction`: a law of friction of one joint.

mod options;
mod outcome;
mod page;
mod run;

pub use options::Options;
pub use outcome::Outcome;
pub use run::run;
