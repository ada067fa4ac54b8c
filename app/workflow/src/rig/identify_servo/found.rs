//! Result of identifying a servo.

use hysteron_actuator::identify::{Backlash, PulleyFit};
use hysteron_actuator::law::{JointFriction, Law, Sliding};
use hysteron_base::BadInput;
use hysteron_report::verdict::{Criterion, Verdict};

use super::outcome::ServoEstimates;
use crate::shared::identification::{Row, assessed, deviation, estimates};
use crate::shared::verdict::{AssessedParameter, parameters};

/// Result of identifying a servo, or the reason why there is none.
pub(super) struct IdentifiedPulley {
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

impl IdentifiedPulley {
    /// As the outcome holds it.
    pub(super) fn estimates(&self) -> ServoEstimates {
        let pulley = self.pulley.as_ref();
        let width = |width: f64| 1e3 * self.radius * width;
        let reversals = self.backlash.as_ref().map(|backlash| backlash.reversals.iter());
        ServoEstimates {
            servo: self.number,
            radius_mm: 1e3 * self.radius,
            has_tension: self.has_tension,
            estimates: estimates(&self.rows),
            samples: pulley.ok().map(|found| found.samples.len()),
            rms_n_m: pulley.ok().map(|found| rms(&found.residuals)),
            misfit: pulley.ok().map(|found| found.misfit),
            condition: pulley.ok().map(|found| found.fit.condition),
            failure: pulley.err().map(ToString::to_string),
            reversals_mm: reversals.ok().map(|all| all.map(|reversal| width(reversal.width)).collect()),
        }
    }

    /// Everything that was found, by name and servo.
    fn assessed(&self) -> Vec<AssessedParameter<'_>> {
        assessed(&self.rows, Some("it is assumed, not measured"))
            .into_iter()
            .map(|assessed| AssessedParameter {
                name: format!("{} of servo {}", assessed.name, self.number),
                ..assessed
            })
            .collect()
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

/// Whether what was found of all servos can be used.
pub(super) fn verdict(found: &[IdentifiedPulley]) -> Verdict {
    let none = found.iter().filter(|servo| servo.pulley.is_err()).count();
    let share = |servo: &IdentifiedPulley| {
        let pulley = servo.pulley.as_ref().ok()?;
        Some((rms(&pulley.residuals) / deviation(&pulley.friction), servo.number))
    };
    let worst = found.iter().filter_map(share).max_by(|a, b| a.0.total_cmp(&b.0));
    let fitted = found.iter().filter(|servo| servo.pulley.is_ok());
    let rows: Vec<AssessedParameter> = fitted.flat_map(IdentifiedPulley::assessed).collect();
    let assessed = Verdict::on(format!("friction and backlash of {} servos are known", found.len() - none))
        .because(
            Criterion::Missing,
            none as f64 / found.len().max(1) as f64,
            format!("friction of {none} of {} servos cannot be identified", found.len()),
        )
        .because_of(Criterion::ErrorOverSpread, worst.map(|worst| worst.0), |share| {
            let number = worst.map_or(0, |worst| worst.1);
            format!("the error of servo {number} is {:.0} % of the deviation of its friction", 100.0 * share)
        });
    parameters(assessed, &rows).verdict()
}

/// Root of the mean square.
pub(super) fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
