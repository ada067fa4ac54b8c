//! Options of `arm identify servo`.

use std::path::PathBuf;

use crate::shared::identification::Results;

/// Motor, supply, heat and friction of a servo that swings a weight
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Recordings to fit
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Recordings that are not fitted, to test on
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC", num_args = 1..))]
    pub test: Vec<PathBuf>,
    /// Name of a drive, or a file of TOML
    #[cfg_attr(feature = "clap", arg(long, value_name = "DRIVE", default_value = "xl330-m288"))]
    pub drive: String,
    /// Law of friction: coulomb-viscous, stribeck, directed-stribeck, m1 to m6 [default: the drive's]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub law: Option<String>,
    /// Mass of the weight [default: from the recordings]
    #[cfg_attr(feature = "clap", arg(long, value_name = "KG", allow_negative_numbers = true))]
    pub mass_kg: Option<f64>,
    /// Distance of the weight from the axis [default: from the recordings]
    #[cfg_attr(feature = "clap", arg(long, value_name = "M", allow_negative_numbers = true))]
    pub length_m: Option<f64>,
    /// Proportional gain as the register has it [default: from the recordings]
    #[cfg_attr(feature = "clap", arg(long, value_name = "P", allow_negative_numbers = true))]
    pub gain: Option<f64>,
    /// Longest step of the simulation
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "S", default_value_t = 1e-3, allow_negative_numbers = true)
    )]
    pub step: f64,
    /// The drive with what was found, a file for --drive of this and other verbs
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub drive_out: Option<PathBuf>,
    /// Where the results go.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub results: Results,
}
