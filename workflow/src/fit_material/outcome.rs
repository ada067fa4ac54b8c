//! What a fit came to, in words.

use hysteron_base::Scene;
use hysteron_twin::Motion;
use hysteron_twin::fit::{MaterialFit, Selected, Standing};

/// Everything a report may show.
pub struct Outcome<'a> {
    /// The scene as given.
    pub scene: &'a Scene,
    /// What was compared.
    pub motions: &'a [Motion],
    /// What was fitted.
    pub selected: &'a [Selected],
    /// The outcome.
    pub found: &'a MaterialFit,
    /// Time it took [s].
    pub wall_s: f64,
    /// Recordings left out for their role.
    pub n_other_role: usize,
    /// Largest tension that each tendon can be pulled with [N].
    pub tension_max: Vec<f64>,
}

/// Part of the largest tension allowed from which on a tendon is said to need too much.
const STRAINED: f64 = 0.8;

impl Outcome<'_> {
    /// What speaks against the outcome, and what else would explain the errors that are left.
    pub fn doubts(&self) -> Vec<String> {
        let mut doubts = Vec::new();
        let at_bound = |estimate: &&hysteron_twin::fit::Estimate| estimate.standing == Standing::AtBound;
        for estimate in self.found.fit.estimates.iter().filter(at_bound) {
            doubts
                .push(format!("{} ended at a bound: an assumption of the scene may be wrong", estimate.name));
        }
        for ((tendon, tension), most) in
            self.scene.tendons.iter().zip(&self.found.tensions).zip(&self.tension_max)
        {
            if *tension > STRAINED * most {
                let name = &tendon.name;
                doubts.push(format!("{name} would need {tension:.1} N of the {most:.1} N that it can pull"));
            }
        }
        for hint in &self.found.hints {
            let [now, then] = hint.rms.map(|rms| 1e3 * rms);
            let how = if hint.fit.is_empty() { String::new() } else { format!(" (--fit {})", hint.fit) };
            let what = &hint.instead;
            doubts.push(format!(
                "another explanation of the errors: {what}, {now:.3} -> {then:.3} mm per coordinate{how}"
            ));
        }
        doubts
    }
}

/// A number of four digits.
pub fn digits(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let decimals = (3 - value.abs().log10().floor() as i32).clamp(0, 9) as usize;
    format!("{value:.decimals$}")
}

/// What became of a parameter, for a reader.
pub fn standing(standing: &Standing) -> String {
    match standing {
        Standing::Fitted => "fitted".into(),
        Standing::AtBound => "at a bound".into(),
        Standing::Vague => "vague, but the scene's value fits worse".into(),
        Standing::Undetermined(with) if with.is_empty() => "not determined by the data, held".into(),
        Standing::Undetermined(with) => format!("determined only together with {}, held", with.join(", ")),
    }
}
