//! Assessment of a fit's estimates for and against its use; the limits are in `hysteron_report::verdict`.

pub use hysteron_base::number::digits;
use hysteron_fit::{Identifiability, IdentifiedParameter};
use hysteron_report::verdict::{Criterion, Reason, Verdict, VerdictBuilder};

/// A parameter after a fit, as a verdict asks for it.
pub struct AssessedParameter<'a> {
    /// Name, for people.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its standard error, where it has one.
    pub standard_error: Option<f64>,
    /// Identifiability of the parameter.
    pub identifiability: &'a Identifiability,
    /// Kind of number; the standard error of a size is compared with the size.
    pub kind: Kind,
    /// Consequence where the data do not determine it.
    pub consequence: Option<&'static str>,
}

/// Whether a number is a size above zero, or one whose zero means nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// As a modulus.
    Size,
    /// As the zero of a tendon.
    Place,
}

impl<'a> AssessedParameter<'a> {
    /// An estimate of a fit.
    pub fn new(
        name: String,
        estimate: &'a IdentifiedParameter,
        kind: Kind,
        consequence: Option<&'static str>,
    ) -> Self {
        let IdentifiedParameter { value, standard_error, ref identifiability, .. } = *estimate;
        Self { name, value, standard_error, identifiability, kind, consequence }
    }

    fn is_open(&self) -> bool {
        matches!(self.identifiability, Identifiability::Undetermined(_) | Identifiability::Vague)
    }
}

/// Adds the reasons from the parameters of a fit.
pub fn parameters(assessment: VerdictBuilder, assessed: &[AssessedParameter]) -> VerdictBuilder {
    if assessed.is_empty() {
        return assessment;
    }
    let share = |names: &[&str]| names.len() as f64 / assessed.len() as f64;
    let on_bound: Vec<&str> =
        (assessed.iter().filter(|assessed| *assessed.identifiability == Identifiability::AtBound))
            .map(|assessed| &assessed.name[..])
            .collect();
    let assessment = assessment.because(
        Criterion::ParametersOnBound,
        share(&on_bound),
        match &on_bound[..] {
            [] => "no parameter ended on a bound".to_owned(),
            names => format!("{} ended on a bound, which the data did not choose", names.join(", ")),
        },
    );
    let open: Vec<&AssessedParameter> = assessed.iter().filter(|assessed| assessed.is_open()).collect();
    let names: Vec<&str> = open.iter().map(|assessed| &assessed.name[..]).collect();
    let mut consequences: Vec<&str> = open.iter().filter_map(|assessed| assessed.consequence).collect();
    consequences.dedup();
    let assessment = assessment.because(
        Criterion::ParametersUndetermined,
        share(&names),
        match &names[..] {
            [] => "the data determine every parameter".to_owned(),
            names => {
                let colon = if consequences.is_empty() { "" } else { ": " };
                let consequences = consequences.join("; ");
                format!("the data do not determine {}{colon}{consequences}", names.join(", "))
            }
        },
    );
    let relative = |assessed: &AssessedParameter| {
        let error = assessed.standard_error.filter(|_| assessed.kind == Kind::Size && !assessed.is_open())?;
        Some((error / assessed.value.abs(), assessed.name.clone()))
    };
    let worst = assessed.iter().filter_map(relative).max_by(|a, b| a.0.total_cmp(&b.0));
    match worst {
        Some((error, name)) => assessment.because(
            Criterion::RelativeStandardError,
            error,
            format!("{name} has a standard error of {:.0} % of its value", 100.0 * error),
        ),
        None => assessment,
    }
}

/// An error over that of a baseline; 1 where both are alike, zeros too.
pub fn ratio(error: f64, baseline: f64) -> f64 {
    if error == baseline { 1.0 } else { error / baseline }
}

/// Adds how the best of several methods compares with the `baseline` among them; `what` is measured, in `unit`.
pub fn compared(
    assessment: VerdictBuilder,
    (what, unit): (&str, &str),
    methods: &[(String, f64)],
    baseline: &str,
) -> VerdictBuilder {
    let simple = methods.iter().find(|(name, _)| name == baseline);
    let others = methods.iter().filter(|(name, error)| name != baseline && !error.is_nan());
    let best = others.min_by(|a, b| a.1.total_cmp(&b.1));
    match (simple, best) {
        (Some((_, simple)), Some((name, best))) => assessment.because(
            Criterion::ErrorOverBaseline,
            ratio(*best, *simple),
            format!("{what}: {name} {} {unit}, {baseline} {} {unit}", digits(*best), digits(*simple)),
        ),
        _ => assessment,
    }
}

/// Adds how often a result was repeated with another seed, robot or recording: `what`, counted.
pub fn repeated(assessment: VerdictBuilder, repeats: usize, what: &str) -> VerdictBuilder {
    let statement = match repeats {
        1 => format!("a single {what} does not show the scatter"),
        n => format!("number of repeats, each another {what}: {n}"),
    };
    assessment.because(Criterion::SingleRepeat, 1.0 / repeats.max(1) as f64, statement)
}

/// A verdict as lines for people: its sentence, then its reasons with their limits.
pub fn lines(verdict: &Verdict) -> Vec<String> {
    let reason = |reason: &Reason| {
        let [mark, statement, value, care, not_usable] = reason.cells();
        let limits = match reason.not_usable_above {
            Some(_) => format!("care above {care}, not usable above {not_usable}"),
            None => format!("care above {care}"),
        };
        format!("  {mark:<5}{value:>8}  {statement} ({limits})")
    };
    std::iter::once(format!("verdict: {}", verdict.sentence))
        .chain(verdict.reasons.iter().map(reason))
        .collect()
}

#[cfg(test)]
mod tests {
    use hysteron_report::verdict::Usability;

    use super::*;

    fn estimate(
        name: &str,
        value: f64,
        standard_error: Option<f64>,
        identifiability: Identifiability,
    ) -> IdentifiedParameter {
        IdentifiedParameter { name: name.into(), start: 1.0, value, standard_error, identifiability }
    }

    fn verdict_of(estimates: &[IdentifiedParameter], consequence: Option<&'static str>) -> Verdict {
        let assessed: Vec<AssessedParameter> = estimates
            .iter()
            .map(|estimate| AssessedParameter::new(estimate.name.clone(), estimate, Kind::Size, consequence))
            .collect();
        parameters(Verdict::on("it holds"), &assessed).verdict()
    }

    #[test]
    fn a_bound_an_open_parameter_and_a_large_error_are_each_named() {
        let good = estimate("modulus", 2.0, Some(0.1), Identifiability::Fitted);
        assert_eq!(verdict_of(std::slice::from_ref(&good), None).sentence, "Usable: it holds.");
        let bound = estimate("compliance", 0.0, None, Identifiability::AtBound);
        let verdict = verdict_of(&[good.clone(), bound.clone()], None);
        assert_eq!(verdict.usability, Usability::UsableWithCare);
        assert!(verdict.sentence.contains("compliance ended on a bound"), "{}", verdict.sentence);
        assert_eq!(verdict_of(&[bound], None).usability, Usability::NotUsable);
        let open = estimate("friction", 0.3, None, Identifiability::Undetermined(vec![]));
        let verdict = verdict_of(&[good.clone(), open], Some("its hysteresis is assumed"));
        assert!(verdict.sentence.contains("do not determine friction: its hysteresis is assumed"));
        let wide = estimate("damping", 1.0, Some(0.8), Identifiability::Fitted);
        let verdict = verdict_of(&[good, wide], None);
        assert!(verdict.sentence.contains("damping has a standard error of 80 %"), "{}", verdict.sentence);
    }

    #[test]
    fn a_comparison_is_with_the_baseline_and_reports_a_single_seed() {
        let methods = |best: f64| [("mean".to_owned(), 2.0), ("network".to_owned(), best)];
        let verdict_of = |best: f64, seeds: usize| {
            let assessed = compared(Verdict::on("it holds"), ("error", "N"), &methods(best), "mean");
            repeated(assessed, seeds, "seed").verdict()
        };
        assert_eq!(verdict_of(1.0, 3).usability, Usability::Usable);
        assert_eq!(verdict_of(1.0, 1).usability, Usability::UsableWithCare);
        let lost = verdict_of(2.1, 3);
        assert_eq!(lost.sentence, "Not usable: error: network 2.10 N, mean 2.00 N.");
    }

    #[test]
    fn lines_are_the_sentence_then_the_reasons_with_their_limits() {
        let verdict = repeated(Verdict::on("it holds"), 1, "seed").verdict();
        let lines = lines(&verdict);
        assert_eq!(lines.len(), 2);
        assert!(lines[0].starts_with("verdict: Usable with care: it holds, but"), "{lines:?}");
        assert!(
            lines[1].starts_with("  care    100 %  ") && lines[1].ends_with("(care above 50 %)"),
            "{lines:?}"
        );
    }
}
