//! Options of `identify-servo`.

use std::path::PathBuf;

use hysteron_actuator::law::{LEARNED_MAP, RISING_MAP};
use hysteron_base::BadInput;

use crate::shared::identification::{Results, positive};

/// Laws that depend on the speed alone.
const LAWS: [&str; 5] = ["stribeck", "coulomb-viscous", "directed-stribeck", LEARNED_MAP, RISING_MAP];
/// Find friction, backlash and load scale of a rig's servos in recordings
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Recordings of the rig with tick_goal_k, tick_present_k and load_k, or folders of them; tension_k_n with them gives the
    /// scale of the loads and the backlash
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Torque of the stalled motor at full load, where no tensions give the scale of the loads [default: an XL430-W250's]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "N_M", default_value_t = 1.4, allow_negative_numbers = true)
    )]
    pub stall_torque: f64,
    /// stribeck, coulomb-viscous, directed-stribeck, learned-map or rising-map
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", default_value = "stribeck"))]
    pub law: String,
    /// Only these servos, by number from 1
    #[cfg_attr(feature = "clap", arg(long, value_name = "K,...", value_delimiter = ',', value_parser = crate::shared::number::count::<64>))]
    pub servos: Vec<usize>,
    /// Where the results go.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub results: Results,
}

impl Options {
    /// # Errors
    /// `BadInput` for a torque that no servo has, or another law.
    pub(super) fn check(&self) -> Result<(), BadInput> {
        positive("--stall-torque", self.stall_torque)?;
        if !LAWS.contains(&self.law.as_str()) {
            let expected = format!("one of {}", LAWS.join(", "));
            return Err(BadInput::new("--law", expected, format!("{:?}", self.law)));
        }
        Ok(())
    }
}
