//! Verdicts: whether a result can be used, in one sentence, from numbers with stated limits.
//!
//! All limits are in one table, [`RULES`], each with its reason: a verb reports its measurements, the table
//! decides. The worst of its reasons decides a verdict.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Whether a result can be used, from best to worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Usability {
    /// No number speaks against it.
    Usable,
    /// It can be used where the reasons do not matter.
    UsableWithCare,
    /// It gives no information beyond what was known before.
    NotUsable,
}

impl Usability {
    /// As sentences begin with it.
    pub fn words(self) -> &'static str {
        match self {
            Self::Usable => "Usable",
            Self::UsableWithCare => "Usable with care",
            Self::NotUsable => "Not usable",
        }
    }

    /// In a column of a table.
    pub fn mark(self) -> &'static str {
        match self {
            Self::Usable => "ok",
            Self::UsableWithCare => "care",
            Self::NotUsable => "no",
        }
    }
}

/// Criterion that a result is measured by. Larger is worse for all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Criterion {
    /// Root mean square error over the standard deviation of what was measured [-].
    ErrorOverSpread,
    /// Error over that of the simplest baseline [-].
    ErrorOverBaseline,
    /// Error on what was not fitted over that on what was [-].
    HeldOutOverFitted,
    /// Error over the size of the target [-].
    ErrorOverTarget,
    /// Relative standard error of a number that is used as it is [-].
    RelativeStandardError,
    /// Share of the parameters that ended on a bound [-].
    ParametersOnBound,
    /// Share of the parameters that the data do not determine, or hardly [-].
    ParametersUndetermined,
    /// Condition number of the Jacobian, its columns of length one [-].
    ConditionNumber,
    /// Fitted parameters over independent residuals [-].
    ParametersOverResiduals,
    /// 1 where a search ended without a minimum, 0 else.
    NotConverged,
    /// Share of the solves without a solution [-].
    SolverFailures,
    /// Share of the samples outside the range of a training or a validation [-].
    OutsideTraining,
    /// Share of the samples at a limit of what drives or auxiliary tendons may do [-].
    AtLimit,
    /// 1 over the number of independent repeats: seeds, robots or recordings [-].
    SingleRepeat,
    /// Share of what was to be measured that is missing [-].
    Missing,
}

/// From where on a criterion speaks against a result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rule {
    /// Criterion of the rule.
    pub criterion: Criterion,
    /// Above this a result is usable with care.
    pub care_above: f64,
    /// Above this it is not usable; `None` where the criterion alone does not go so far.
    pub not_usable_above: Option<f64>,
    /// Why these limits.
    pub why: &'static str,
}

const fn rule(
    criterion: Criterion,
    care_above: f64,
    not_usable_above: Option<f64>,
    why: &'static str,
) -> Rule {
    Rule { criterion, care_above, not_usable_above, why }
}

/// All limits.
pub const RULES: [Rule; 15] = [
    rule(
        Criterion::ErrorOverSpread,
        0.5,
        Some(0.9),
        "the mean of the measurements has 100 %; at 50 % a quarter of the variance is unexplained, at 90 % four fifths",
    ),
    rule(
        Criterion::ErrorOverBaseline,
        0.95,
        Some(1.0),
        "at 100 % the simplest baseline does as well; less than 5 % is what another seed changes",
    ),
    rule(
        Criterion::HeldOutOverFitted,
        2.0,
        Some(10.0),
        "at twice the error three quarters of the residual variance were not in the fit; at ten times the fit is to \
         its own recordings alone",
    ),
    rule(
        Criterion::ErrorOverTarget,
        0.05,
        Some(0.25),
        "the CoReAct paper tracks within 2 to 5 % of the target's size; at 25 % the path is not recognisable",
    ),
    rule(
        Criterion::RelativeStandardError,
        0.5,
        None,
        "at two standard errors from zero (95 %) the sign of a number is just known",
    ),
    rule(
        Criterion::ParametersOnBound,
        0.0,
        Some(0.99),
        "a bound decided, not the data; with all parameters on bounds nothing was fitted",
    ),
    rule(
        Criterion::ParametersUndetermined,
        0.0,
        Some(0.99),
        "such a parameter is an assumption; with all of them nothing was fitted",
    ),
    rule(
        Criterion::ConditionNumber,
        30.0,
        None,
        "from 30 on some parameters can hardly be distinguished (Belsley, Kuh, Welsch, 1980)",
    ),
    rule(
        Criterion::ParametersOverResiduals,
        0.1,
        None,
        "ten independent residuals for a parameter; with fewer a fit follows the noise",
    ),
    rule(Criterion::NotConverged, 0.0, None, "the search may have ended anywhere"),
    rule(
        Criterion::SolverFailures,
        0.0,
        Some(0.05),
        "the unsolved samples are the hardest ones; 5 % are no exception",
    ),
    rule(
        Criterion::OutsideTraining,
        0.05,
        Some(0.5),
        "5 % are the tails of the training data; with half of the samples outside, the network extrapolates",
    ),
    rule(
        Criterion::AtLimit,
        0.05,
        Some(0.5),
        "a limit decided, not the command; with half of the samples at it, the limit is the result",
    ),
    rule(Criterion::SingleRepeat, 0.5, None, "one repeat does not show the scatter"),
    rule(Criterion::Missing, 0.0, Some(0.5), "a comparison of the remaining ones is not the requested one"),
];

impl Criterion {
    /// Its limits.
    pub fn rule(self) -> Rule {
        // A test holds the table complete.
        RULES.into_iter().find(|rule| rule.criterion == self).unwrap_or(RULES[0])
    }

    /// A value of it, for people.
    fn shown(self, value: f64) -> String {
        match self {
            Self::NotConverged => if value > 0.0 { "yes" } else { "no" }.to_owned(),
            Self::ConditionNumber => format!("{value:.0}"),
            Self::HeldOutOverFitted => format!("{value:.2}"),
            _ if value.abs() < 0.0995 && value != 0.0 => format!("{:.1} %", 100.0 * value),
            _ => format!("{:.0} %", 100.0 * value),
        }
    }
}

/// A number that was compared with its limits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Reason {
    /// Criterion of the number.
    pub criterion: Criterion,
    /// Statement of the number, as part of a sentence.
    pub statement: String,
    /// The number; none where it is not finite.
    pub value: Option<f64>,
    /// Above this a result is usable with care.
    pub care_above: f64,
    /// Above this it is not usable.
    pub not_usable_above: Option<f64>,
    /// Usability by this number alone.
    pub usability: Usability,
}

impl Reason {
    /// Value and limits, for people.
    pub fn cells(&self) -> [String; 5] {
        let shown = |value: Option<f64>| value.map_or("-".to_owned(), |value| self.criterion.shown(value));
        [
            self.usability.mark().to_owned(),
            self.statement.clone(),
            self.value.map_or("not finite".to_owned(), |value| self.criterion.shown(value)),
            shown(Some(self.care_above)),
            shown(self.not_usable_above),
        ]
    }
}

/// Whether a result can be used.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Verdict {
    /// That of the worst reason.
    pub usability: Usability,
    /// The verdict in one sentence.
    pub sentence: String,
    /// Reasons, the worst first.
    pub reasons: Vec<Reason>,
}

/// Reasons that a sentence names at most.
const MAX_NAMED: usize = 3;

impl Verdict {
    /// Collects reasons for a verdict on a result, whose `claim` is true if it can be used: "the scene follows
    /// the robot within 0.4 mm".
    pub fn on(claim: impl Into<String>) -> VerdictBuilder {
        VerdictBuilder { claim: claim.into(), reasons: Vec::new() }
    }

    /// Headings of a table of reasons, whose rows are [`Reason::cells`].
    pub const HEADINGS: [&'static str; 5] =
        ["", "What was found", "Value", "With care above", "Not usable above"];
}

/// Reasons from which a verdict is built.
#[derive(Debug, Clone)]
pub struct VerdictBuilder {
    claim: String,
    reasons: Vec<Reason>,
}

impl VerdictBuilder {
    /// Adds a number, and its meaning as part of a sentence: "the tip is off by 97 % of its spread". What is not finite is not
    /// usable.
    #[must_use]
    pub fn because(mut self, criterion: Criterion, value: f64, statement: impl Into<String>) -> Self {
        let Rule { care_above, not_usable_above, .. } = criterion.rule();
        let usability = match value {
            value if !value.is_finite() => Usability::NotUsable,
            value if not_usable_above.is_some_and(|limit| value > limit) => Usability::NotUsable,
            value if value > care_above => Usability::UsableWithCare,
            _ => Usability::Usable,
        };
        self.reasons.push(Reason {
            criterion,
            statement: statement.into(),
            value: value.is_finite().then_some(value),
            care_above,
            not_usable_above,
            usability,
        });
        self
    }

    /// [`Self::because`], where there is a number.
    #[must_use]
    pub fn because_of(
        self,
        criterion: Criterion,
        value: Option<f64>,
        statement: impl FnOnce(f64) -> String,
    ) -> Self {
        match value {
            Some(value) => self.because(criterion, value, statement(value)),
            None => self,
        }
    }

    /// The verdict. Without any reason a result can be used with care.
    pub fn verdict(mut self) -> Verdict {
        self.reasons.sort_by_key(|reason| std::cmp::Reverse(reason.usability));
        let worst = self.reasons.first().map_or(Usability::UsableWithCare, |reason| reason.usability);
        let speaking = self.reasons.iter().filter(|reason| reason.usability == worst);
        let named: Vec<&str> = speaking.clone().map(|reason| reason.statement.as_str()).collect();
        let reasons = match named.get(MAX_NAMED..) {
            Some(more) if !more.is_empty() => {
                format!("{}; and {} more", named[..MAX_NAMED].join("; "), more.len())
            }
            _ => named.join("; "),
        };
        let (words, claim) = (worst.words(), &self.claim);
        let sentence = match worst {
            Usability::Usable => format!("{words}: {claim}."),
            Usability::UsableWithCare if reasons.is_empty() => {
                format!("{words}: {claim}, but its accuracy was not measured.")
            }
            Usability::UsableWithCare => format!("{words}: {claim}, but {reasons}."),
            Usability::NotUsable => format!("{words}: {reasons}."),
        };
        Verdict { usability: worst, sentence, reasons: self.reasons }
    }
}

#[cfg(test)]
mod tests {
    use hysteron_base::json;

    use super::*;

    #[test]
    fn every_criterion_has_one_rule_and_its_limits_are_in_order() {
        for rule in RULES {
            assert_eq!(rule.criterion.rule(), rule, "one rule each");
            assert!(rule.not_usable_above.is_none_or(|limit| limit > rule.care_above), "{rule:?}");
            assert!(!rule.why.is_empty());
        }
        // The last variant: an enum without data counts from zero.
        assert_eq!(Criterion::Missing as usize + 1, RULES.len());
    }

    #[test]
    fn the_worst_reason_decides_and_the_sentence_names_it() {
        let assessment = |error: f64, bound: f64| {
            Verdict::on("it works")
                .because(Criterion::ErrorOverSpread, error, format!("error {error}"))
                .because(Criterion::ParametersOnBound, bound, format!("bound {bound}"))
                .verdict()
        };
        assert_eq!(assessment(0.1, 0.0).sentence, "Usable: it works.");
        let care = assessment(0.1, 0.5);
        assert_eq!(care.sentence, "Usable with care: it works, but bound 0.5.");
        assert_eq!(care.reasons[0].criterion, Criterion::ParametersOnBound);
        let hopeless = assessment(0.97, 0.5);
        assert_eq!(
            (hopeless.usability, &hopeless.sentence[..]),
            (Usability::NotUsable, "Not usable: error 0.97.")
        );
        // Limits are allowed, above them is not.
        assert_eq!(assessment(0.5, 0.0).usability, Usability::Usable);
        assert_eq!(assessment(0.9, 0.0).usability, Usability::UsableWithCare);
    }

    #[test]
    fn what_is_not_finite_is_not_usable_and_survives_json() -> anyhow::Result<()> {
        for value in [f64::NAN, f64::INFINITY] {
            let verdict =
                Verdict::on("it works").because(Criterion::ErrorOverBaseline, value, "no error").verdict();
            assert_eq!(verdict.usability, Usability::NotUsable);
            let read: Verdict = json::from_text(json::to_line(&verdict)?)?;
            assert_eq!(read, verdict);
        }
        Ok(())
    }

    #[test]
    fn nothing_measured_is_no_praise() {
        let verdict = Verdict::on("it works").verdict();
        assert_eq!(verdict.usability, Usability::UsableWithCare);
    }

    #[test]
    fn many_reasons_are_counted() {
        let assessment = (0..5).fold(Verdict::on("it works"), |assessment, k| {
            assessment.because(Criterion::NotConverged, 1.0, format!("r{k}"))
        });
        assert_eq!(assessment.verdict().sentence, "Usable with care: it works, but r0; r1; r2; and 2 more.");
    }
}
