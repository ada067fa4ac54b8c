//! What was found of a servo.

use hysteron_actuator::identify::{Backlash, PulleyFit};
use hysteron_actuator::law::{JointFriction, Law, Sliding};
use hysteron_base::{BadInput, json};
use serde_json::Value;

use crate::arm_identify::{Row, rows_json};

/// What was found of a servo, or why nothing was.
pub(crate) struct Found {
    /// Number, from 1.
    pub number: usize,
    /// Radius of its pulley [m].
    pub radius: f64,
    /// The law that was fitted.
    pub law: Option<Law>,
    /// Load scale and friction.
    pub pulley: Result<PulleyFit, BadInput>,
    /// Backlash at the pulley.
    pub backlash: Result<Backlash, BadInput>,
    /// Whether tensions were measured.
    pub has_tension: bool,
    /// Everything by name.
    pub rows: Vec<Row>,
}

impl Found {
    pub(super) fn json(&self) -> Value {
        let mut value = json!({
            "servo": self.number, "radius_mm": 1e3 * self.radius, "has_tension": self.has_tension,
            "estimates": rows_json(&self.rows),
        });
        match &self.pulley {
            Ok(found) => {
                value["samples"] = json!(found.samples.len());
                value["rms_n_m"] = json!(rms(&found.residuals));
                value["misfit"] = json!(found.misfit);
                value["condition"] = json!(found.fit.condition);
            }
            Err(bad) => value["cannot_be_told"] = json!(bad.to_string()),
        }
        if let Ok(backlash) = &self.backlash {
            let widths = backlash.reversals.iter().map(|reversal| 1e3 * self.radius * reversal.width);
            value["reversals_mm"] = widths.collect();
        }
        value
    }

    /// Friction at a speed, as identified [N m]; NaN below the speeds that it was identified from.
    pub fn friction(&self, velocity: f64) -> f64 {
        match (&self.law, &self.pulley) {
            (Some(law), Ok(found)) if found.samples.velocity.iter().any(|v| v.abs() <= velocity.abs()) => {
                law.torque(&found.parameters, &Sliding::at(velocity))
            }
            _ => f64::NAN,
        }
    }
}

/// Root of the mean square.
pub(super) fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
