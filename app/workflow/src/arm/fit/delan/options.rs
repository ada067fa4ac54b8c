//! Options of `arm fit delan`.

use std::path::PathBuf;

use hysteron_arm_learning::lagrangian::Variant;
use hysteron_base::json;

/// Learn inverse dynamics with a model of the DeLaN family
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Recordings to learn from
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Model to write, .safetensors
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: PathBuf,
    /// structured-lagrangian, black-box-lagrangian, feed-forward, friction or augmented
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", default_value = "augmented", value_parser = variant))]
    pub variant: Variant,
    /// Units of each of the two hidden layers
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 64, value_parser = crate::shared::number::count::<{ hysteron_learn::MAX_HIDDEN }>))]
    pub hidden: usize,
    /// Inputs are products of the sines and cosines of up to so many joints, with a linear path past its hidden layers; 0 for sines and cosines alone
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0, value_parser = crate::shared::number::up_to::<4>))]
    pub products: u32,
    /// Squares in the kinetic energy beyond one for each joint; of a chain of turning joints two for each in a plane, or six, hold it exactly, with --products; up to 32
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0, value_parser = crate::shared::number::up_to::<32>))]
    pub squares: u32,
    /// Epochs of Adam at most
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 200, value_parser = crate::shared::number::count::<{ hysteron_learn::MAX_EPOCHS }>))]
    pub epochs: usize,
    /// Steps of Levenberg and Marquardt's method after Adam at most, in double precision; for up to 8000 parameters
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0, value_parser = crate::shared::number::up_to::<100_000>))]
    pub polish: u32,
    /// Velocities above this are noise, where accelerations are differences of them
    #[cfg_attr(feature = "clap", arg(long, value_name = "HZ", default_value_t = 10.0, value_parser = crate::shared::number::cutoff_hz))]
    pub cutoff: f64,
    /// Of initial parameters and of minibatches
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0))]
    pub seed: u64,
}

/// A model by the name that files have for it.
///
/// # Errors
/// The names there are.
pub fn variant(text: &str) -> Result<Variant, String> {
    json::from_value(&text.into()).map_err(|e| e.to_string())
}
