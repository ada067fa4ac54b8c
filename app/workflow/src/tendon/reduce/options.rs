//! Options of `hysteron reduce`.

use std::path::PathBuf;

/// Reduce the twin of a scene to a chain of condensed sections
///
/// The body is cut across its axis into sections of some 0.4 diameters; each becomes a quadratic and cubic energy of its
/// strain, condensed from the finite elements without any training. The chain is then compared with the finite elements
/// under random strokes; the errors are printed and stored in the file.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Scene file of the robot (scene.toml)
    pub scene: PathBuf,
    /// Chain to write, .json; for hysteron simulate --reduced
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: PathBuf,
    /// Random equilibria in which the chain is compared with the finite elements
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 20, value_parser = crate::shared::number::up_to::<100_000>))]
    pub equilibria: u32,
    /// Largest stroke of these equilibria, either way [default: 7.5 % of the shortest tendon]
    #[cfg_attr(feature = "clap", arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = crate::shared::number::position_mm))]
    pub stroke_mm: Option<f64>,
    /// Largest tension of auxiliary tendons in these equilibria, either way
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 10.0))]
    pub tension_n: f64,
}
