//! Tensions at the pulleys: the twin's, corrected by the servos' loads while they move.
//!
//! The twin knows how a tension changes with the strokes, not what it is to the newton: zeros, stiffness and friction are known to a
//! few per cent. Its error changes where its tension does, so a random walk over the changes of tension describes it; a load corrects it
//! while its servo moves steadily, and at rest, where friction hides the tension from the servo, it stays.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Errors of twin and loads.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TensionErrors {
    /// Tension of the robot over the twin's [-]: not observable from a tip, for strokes and shape are the
    /// same with all forces doubled.
    pub force_scale: f64,
    /// Random walk of the twin's error over a change of tension [√N].
    pub walk_sqrt_n: f64,
    /// Largest standard deviation of that error [N].
    pub model_n: f64,
    /// Standard deviation of a tension from a load [N]; neighbours have correlated errors, so it counts as often as it is
    /// new.
    pub load_n: f64,
}

/// Random walk at rest: creep [N/√s].
const CREEP: f64 = 0.05;

/// The tension of one tendon, sample by sample.
#[derive(Debug, Clone, PartialEq)]
pub struct TensionFilter {
    errors: TensionErrors,
    period: f64,
    /// Error of the twin's scaled tension [N], and its variance [N²].
    error: f64,
    variance: f64,
    twin: Option<f64>,
}

impl TensionFilter {
    /// For samples every `period` [s].
    pub fn new(errors: TensionErrors, period: f64) -> Self {
        Self { errors, period, error: 0.0, variance: errors.model_n.powi(2), twin: None }
    }

    /// Advances by one sample: tension of the twin [N], and while the servo moves steadily the tension from its load and the twin's tension
    /// at that time [N]. Returns the tension at the pulley and its standard error [N].
    pub fn step(&mut self, twin: f64, measured: Option<(f64, f64)>) -> (f64, f64) {
        let scale = self.errors.force_scale;
        let change = self.twin.replace(twin).map_or(0.0, |before| scale * (twin - before).abs());
        let grown = self.variance + self.errors.walk_sqrt_n.powi(2) * change + CREEP.powi(2) * self.period;
        self.variance = grown.min(self.errors.model_n.powi(2));
        if let Some((tension, twin_then)) = measured {
            let gain = self.variance / (self.variance + self.errors.load_n.powi(2));
            self.error += gain * (tension - scale * twin_then - self.error);
            self.variance *= 1.0 - gain;
        }
        ((scale * twin + self.error).max(0.0), self.variance.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ERRORS: TensionErrors =
        TensionErrors { force_scale: 1.2, walk_sqrt_n: 0.5, model_n: 3.0, load_n: 1.5 };

    #[test]
    fn loads_correct_the_twins_error_and_rest_keeps_the_correction() {
        let mut filter = TensionFilter::new(ERRORS, 0.01);
        // The robot has 1.2 times the twin's tension and 2 N more.
        for _ in 0..400 {
            filter.step(10.0, Some((14.0, 10.0)));
        }
        let (tension, moving) = filter.step(10.0, None);
        assert!((tension - 14.0).abs() < 0.05, "{tension}");
        let mut rest = (tension, moving);
        for _ in 0..500 {
            rest = filter.step(10.0, None);
        }
        assert_eq!(rest.0, tension);
        assert!(rest.1 > moving && rest.1 < 0.3, "{rest:?}");
        // The filter follows the twin's changes, and its slack.
        assert!((filter.step(15.0, None).0 - 20.0).abs() < 0.05);
        assert_eq!(filter.step(-5.0, None).0, 0.0);
    }
}
