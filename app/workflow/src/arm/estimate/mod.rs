//! `hysteron arm estimate`: torques, force on the tip, contact and condition of a motor, sample by sample, along a
//! recording or on a bus; or external torques with learned dynamics.

mod along;
mod channels;
mod external;
mod live;
mod options;
mod outcome;
mod run;

pub use options::Options;
pub use outcome::{
    ExternalTorques, LiveEstimates, Outcome, RecordingEstimates, TelemetryEstimates, TimePercentiles,
};
pub use run::run;
