//! The assessment of a material fit: its verdict, and warnings about it.

use hysteron_base::Scene;
use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_twin::RobotMotion;
use hysteron_twin::fit::{Identifiability, IdentifiedParameter, MaterialFit, ParameterScale, Selected};

use crate::shared::recording_checks::Findings;
use crate::shared::verdict::{AssessedParameter, Kind, parameters};

/// A fit with what it was asked and given.
pub(super) struct FinishedFit<'a> {
    /// The scene as given.
    pub scene: &'a Scene,
    /// Motions that were compared.
    pub motions: &'a [RobotMotion],
    /// Parameters that were fitted.
    pub selected: &'a [Selected],
    /// The outcome.
    pub found: &'a MaterialFit,
    /// Warnings of the checks of the recordings.
    pub findings: &'a Findings,
    /// Time it took [s].
    pub wall_s: f64,
    /// Recordings skipped for their role.
    pub n_other_role: usize,
    /// Largest tension that each tendon can be pulled with [N].
    pub tension_max: Vec<f64>,
}

/// Part of the largest tension allowed from which on a tendon is reported as overloaded.
const STRAINED: f64 = 0.8;

impl FinishedFit<'_> {
    /// Whether the fitted scene can replace the robot.
    pub fn verdict(&self) -> Verdict {
        let (found, fit) = (self.found, &self.found.fit);
        let error = found.errors[1].distance;
        let assessment = |(selected, estimate)| {
            let Selected { parameter, quantity, .. }: &Selected = selected;
            let kind = if parameter.scale == ParameterScale::Logarithmic { Kind::Size } else { Kind::Place };
            let consequence = consequence(quantity.name);
            AssessedParameter::new(parameter.name.clone(), estimate, kind, consequence)
        };
        let assessment: Vec<AssessedParameter> =
            self.selected.iter().zip(&fit.estimates).map(assessment).collect();
        let claim = format!("the fitted scene follows the measured tip within {:.2} mm (RMSE)", 1e3 * error);
        let spread = found.measured_spread;
        let strain = found.tensions.iter().zip(&self.tension_max).map(|(tension, most)| tension / most);
        let strained =
            strain.clone().filter(|share| *share > 1.0).count() as f64 / found.tensions.len().max(1) as f64;
        let verdict = Verdict::on(claim).because(
            Criterion::ErrorOverSpread,
            error / spread,
            format!(
                "the error is {:.0} % of the {:.1} mm by which the tip moved about its mean",
                100.0 * error / spread,
                1e3 * spread
            ),
        );
        parameters(verdict, &assessment)
            .because(
                Criterion::ParametersOverResiduals,
                assessment.len() as f64 / fit.n_effective,
                format!("{} parameters from {:.0} independent residuals", assessment.len(), fit.n_effective),
            )
            .because(
                Criterion::ConditionNumber,
                fit.condition,
                format!("the condition number of the parameters is {:.0}", fit.condition),
            )
            .because(
                Criterion::NotConverged,
                f64::from(u8::from(!fit.is_converged)),
                match fit.is_converged {
                    true => "the search ended at a minimum".to_owned(),
                    false => format!("the search has {}", fit.ended),
                },
            )
            .because(
                Criterion::AtLimit,
                strained,
                format!("{:.0} % of the tendons would need more than they can pull", 100.0 * strained),
            )
            .verdict()
    }

    /// Warnings about the outcome, and other explanations of the remaining errors.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let at_bound = |estimate: &&IdentifiedParameter| estimate.identifiability == Identifiability::AtBound;
        for estimate in self.found.fit.estimates.iter().filter(at_bound) {
            warnings
                .push(format!("{} ended at a bound: an assumption of the scene may be wrong", estimate.name));
        }
        for ((tendon, tension), most) in
            self.scene.tendons.iter().zip(&self.found.tensions).zip(&self.tension_max)
        {
            if *tension > STRAINED * most {
                let name = &tendon.name;
                warnings
                    .push(format!("{name} would need {tension:.1} N of the {most:.1} N that it can pull"));
            }
        }
        for hint in &self.found.hints {
            let [now, then] = hint.rms.map(|rms| 1e3 * rms);
            let how = if hint.fit.is_empty() { String::new() } else { format!(" (--fit {})", hint.fit) };
            let what = &hint.instead;
            warnings.push(format!(
                "another explanation of the errors: {what}, {now:.3} -> {then:.3} mm per coordinate{how}"
            ));
        }
        warnings
    }
}

/// Consequence for the user where the data do not determine a quantity, and the recording that would.
fn consequence(quantity: &str) -> Option<&'static str> {
    let consequence = match quantity {
        "youngs_modulus" => {
            "under strokes the tip hardly depends on it, but tensions and forces of the twin are as uncertain as it is; record tensions, \
             or the tip under a known weight"
        }
        "poisson_ratio" => "a tip hardly depends on it: keep that of the material",
        "density" | "gravity" => {
            "the twin sags as the scene says; record the robot at rest and bent to all sides, lying and hanging"
        }
        "tracker_turn" | "tracker_shift" => {
            "a frame that is off looks like another robot; record motions to all sides, and the rest between them"
        }
        "zero" | "common_zero" => {
            "where a tendon gets taut is that of the scene; release every tendon until it is slack, and pull it again"
        }
        "compliance" | "sheath_compliance_share" => {
            "how far tendons stretch is that of the scene; record large pulls, with opposite tendons taut and slack, or tensions"
        }
        "coefficient" | "coulomb" | "sheath_exponent" | "sheath_coulomb" | "backlash" => {
            "the twin's hysteresis is that of the scene, not of the robot; record slow motions that turn back, under more and less pull"
        }
        _ => return None,
    };
    Some(consequence)
}

#[cfg(test)]
mod tests {
    use hysteron_twin::fit::QUANTITIES;

    use super::*;

    #[test]
    fn every_quantity_that_stays_unknown_has_a_remedy() {
        let remedies = ["record ", "release ", "keep "];
        for quantity in &QUANTITIES {
            let words = consequence(quantity.name).unwrap_or_default();
            assert!(remedies.iter().any(|remedy| words.contains(remedy)), "{}: {words}", quantity.name);
        }
    }
}
