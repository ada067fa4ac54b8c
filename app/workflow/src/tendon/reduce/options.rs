//! Options of `hysteron reduce`.

use std::path::PathBuf;

use hysteron_base::BadInput;
use hysteron_twin::Twin;
use hysteron_twin::chain::ValidationOptions;

/// Part of the longest tendon that is the largest stroke of the comparison, unless another is asked for [-].
const STROKE_SHARE: f64 = 0.075;

/// Reduce the body of a robot to a chain of condensed sections
///
/// The body is cut across its axis into sections of some 0.4 diameters; each becomes a quadratic and cubic energy of its
/// strain, condensed from the finite elements without any training. The chain is then compared with the finite elements
/// under random strokes; the errors are printed and stored in the file.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Scene file of the robot (scene.toml)
    pub scene: PathBuf,
    /// Equilibria of the mesh that the chain is compared with
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 20, value_parser = crate::shared::number::count::<100_000>))]
    pub count: usize,
    /// Largest stroke of the comparison, either way, within the bounds of the scene [default: 7.5 % of the longest tendon]
    #[cfg_attr(feature = "clap", arg(long, value_name = "MM", value_parser = crate::shared::number::length_mm))]
    pub stroke_mm: Option<f64>,
    /// Largest tension of auxiliary tendons in the comparison, either way, within the bounds of the scene
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 10.0))]
    pub tension_n: f64,
    /// Chain to write, .json; for --reduced, or [reduced] of the scene
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: PathBuf,
}

impl Options {
    /// # Errors
    /// `BadInput` for a tension that is none.
    pub(super) fn check(&self) -> Result<(), BadInput> {
        if self.tension_n >= 0.0 && self.tension_n.is_finite() {
            return Ok(());
        }
        Err(BadInput::new("--tension-n", "a finite number >= 0", self.tension_n.to_string()))
    }

    /// The comparison for this twin.
    pub(super) fn validation(&self, twin: &Twin, seed: u64) -> ValidationOptions {
        ValidationOptions {
            count: self.count,
            stroke: self.stroke_mm.map_or(STROKE_SHARE * twin.cables.longest(), |stroke| 1e-3 * stroke),
            tension: self.tension_n,
            seed,
        }
    }
}
