//! Errors of a chain against the finite elements that it was made from, as its file has them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Errors of a chain against its finite elements.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Validation {
    /// Equilibria that were compared.
    pub count: usize,
    /// Targets under which the finite elements had no equilibrium, and others under which the chain had none.
    pub refused: [usize; 2],
    /// Largest stroke asked for [m].
    #[serde(rename = "stroke_m")]
    pub stroke: f64,
    /// Largest tension of auxiliary tendons asked for [N].
    #[serde(rename = "tension_n")]
    pub tension: f64,
    /// Seed of the targets.
    pub seed: u64,
    /// Distance of the tips over the tip's displacement, or over a fortieth of the body's length where it moves less [-].
    pub tip: ErrorSpread,
    /// Largest error of a tension over the largest tension, or over a fortieth of the largest of all where that is more [-].
    pub tensions: ErrorSpread,
    /// Angle between the rotations of the tip [rad].
    #[serde(rename = "turn_rad")]
    pub turn: ErrorSpread,
    /// Largest strain of a section [-].
    pub strain: f64,
}

/// A distribution of errors.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ErrorSpread {
    /// Half of the errors are below this.
    pub median: f64,
    /// 99 of 100 are below this.
    pub percentile_99: f64,
    /// Largest error.
    pub largest: f64,
}

impl ErrorSpread {
    /// Of these errors.
    pub(super) fn new(mut errors: Vec<f64>) -> Self {
        errors.sort_by(f64::total_cmp);
        let at = |part: f64| {
            let place = (part * errors.len().saturating_sub(1) as f64).ceil() as usize;
            errors.get(place).copied().unwrap_or_default()
        };
        Self { median: at(0.5), percentile_99: at(0.99), largest: at(1.0) }
    }
}
