//! Options of `arm identify friction`.

use std::path::PathBuf;

use hysteron_actuator::identify::FrictionMethod;
use hysteron_actuator::law::{LAW_NAMES, LEARNED_MAP, RISING_MAP};
use hysteron_base::BadInput;

use crate::shared::identification::{Results, positive};

/// Laws that do not depend on the torque through the gear.
const LAWS_OF_SPEED: usize = 3;

/// A law of friction of one joint
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Recordings to fit
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Number of the joint, from 1
    #[cfg_attr(feature = "clap", arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=64)))]
    pub joint: u16,
    /// coulomb-viscous, stribeck, directed-stribeck, learned-map: a curve of any shape, or rising-map: a monotone curve
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", default_value = "stribeck"))]
    pub law: String,
    /// least-squares, pso, de, anfis or fnn
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", default_value = "least-squares"))]
    pub method: String,
    /// Folds of cross-validation
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub folds: Option<usize>,
    /// Error from which on a sample counts linearly rather than squared
    #[cfg_attr(feature = "clap", arg(long, value_name = "N_M", allow_negative_numbers = true))]
    pub huber: Option<f64>,
    /// Seed of populations
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 1))]
    pub seed: u64,
    /// Where the results go.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub results: Results,
}

impl Options {
    /// The method, of options that can be met.
    ///
    /// # Errors
    /// `BadInput` naming the option.
    pub(super) fn method(&self) -> anyhow::Result<FrictionMethod> {
        let laws = [&LAW_NAMES[..LAWS_OF_SPEED], &[LEARNED_MAP, RISING_MAP]].concat();
        if !laws.contains(&self.law.as_str()) {
            let expected = format!("one of {}", laws.join(", "));
            return Err(BadInput::new("--law", expected, format!("{:?}", self.law)).into());
        }
        if let Some(huber) = self.huber {
            positive("--huber", huber)?;
        }
        let n = self.recordings.len();
        if let Some(k) = self.folds.filter(|k| !(2..=n).contains(k)) {
            let expected = match n {
                1 => "two or more recordings with it".to_owned(),
                _ => format!("2 to {n}, the number of recordings"),
            };
            return Err(BadInput::new("--folds", expected, k.to_string()).into());
        }
        let method = FrictionMethod::named(&self.method)
            .map_err(|bad| BadInput { place: "--method".into(), ..bad })?;
        if self.huber.is_some() && method != FrictionMethod::LeastSquares {
            return Err(
                BadInput::new("--huber", "--method least-squares with it", self.method.clone()).into()
            );
        }
        Ok(method)
    }
}
