//! From a recording to the target of every tendon in every sample, and a twin that follows these targets.
//!
//! The drive of a primary tendon decides which channel it follows: `stroke_k_m`, or `tension_k_n`. Auxiliary tendons
//! follow `aux_kk_m` where the recording has them, and otherwise rest: at the allowed value nearest to zero.
//! Everything is checked here, before the first step.

mod exact;
mod goals;
mod rollout;

use std::path::Path;

use hysteron_base::number::shown;
use hysteron_base::{BadInput, PrescribedQuantity, Recording};

use crate::coreact::AuxiliaryLimits;
use crate::model::{Target, Twin, TwinTendon};
use crate::{Error, TwinState};

pub use exact::{ChainError, ExactSteps};
pub use goals::Goals;
pub use rollout::{CommandRollout, CommandStep};

/// Prescribed course of one tendon.
#[derive(Debug, Clone)]
enum Course<'a> {
    Strokes(&'a [f64]),
    Tensions(&'a [f64]),
    /// Strokes of an auxiliary tendon as CoReAct means them: each is a tension, by this many newtons per metre.
    Residual(&'a [f64], f64),
    Constant(Target),
}

/// The course of every tendon, primary ones first.
#[derive(Debug, Clone)]
pub struct Command<'a> {
    courses: Vec<Course<'a>>,
    /// Number of primary tendons.
    pub n_primary: usize,
    /// Times [s].
    pub time: &'a [f64],
    /// True where the recording itself drives the auxiliary tendons.
    pub drives_auxiliary: bool,
    /// Where the tip is to go, if strokes are left open for that.
    pub goals: Option<Goals<'a>>,
}

impl<'a> Command<'a> {
    /// Takes the channels that `twin` needs out of `recording`, which was read from `path`.
    pub fn new(twin: &Twin, recording: &'a Recording, path: &Path) -> Result<Self, BadInput> {
        Self::checked(twin, recording).map_err(|bad| bad.within(path.display()))
    }

    /// Leaves the strokes of all primary tendons open for `goals`; the auxiliary ones are commanded what [`Self::new`]
    /// sets.
    pub fn with_free_strokes(
        twin: &Twin,
        recording: &'a Recording,
        path: &Path,
        goals: Goals<'a>,
    ) -> Result<Self, BadInput> {
        if twin.n_primary == 0 {
            return Err(BadInput::new("the scene", "at least one tendon", "none"));
        }
        let free = vec![Course::Constant(Target::Free); twin.n_primary];
        let command =
            Self::with_auxiliary(free, twin, recording).map_err(|bad| bad.within(path.display()))?;
        Ok(Self { goals: Some(goals), ..command })
    }

    fn checked(twin: &Twin, recording: &'a Recording) -> Result<Self, BadInput> {
        let primary = &twin.tendons[..twin.n_primary];
        let strokes = recording.strokes();
        let is_by_stroke = |tendon: &TwinTendon| tendon.drive == PrescribedQuantity::Stroke;
        if primary.iter().any(is_by_stroke) || strokes.len() > primary.len() {
            check_count("stroke", strokes.len(), primary)?;
        }
        let mut courses = Vec::new();
        for (j, tendon) in primary.iter().enumerate() {
            courses.push(match tendon.drive {
                PrescribedQuantity::Stroke => Course::Strokes(strokes[j]),
                PrescribedQuantity::Tension => Course::Tensions(tensions(recording, tendon, j + 1)?),
                PrescribedQuantity::Free => Course::Constant(Target::Free),
            });
        }
        Self::with_auxiliary(courses, twin, recording)
    }

    /// Adds the auxiliary tendons to the courses of the primary ones.
    fn with_auxiliary(
        mut courses: Vec<Course<'a>>,
        twin: &Twin,
        recording: &'a Recording,
    ) -> Result<Self, BadInput> {
        let auxiliary = &twin.tendons[twin.n_primary..];
        let aux = recording.aux();
        if !aux.is_empty() {
            check_count("aux", aux.len(), auxiliary)?;
            courses.extend(driven(twin, &aux)?);
        } else {
            courses.extend(auxiliary.iter().map(|tendon| Course::Constant(tendon.resting_target())));
        }
        let command = Self {
            courses,
            n_primary: twin.n_primary,
            time: recording.time(),
            drives_auxiliary: !aux.is_empty(),
            goals: None,
        };
        command.check_lengths(twin)?;
        Ok(command)
    }

    /// Targets of all tendons in sample `row` (n_tendons).
    pub fn targets(&self, row: usize) -> Vec<Target> {
        let target = |course: &Course| match course {
            Course::Strokes(values) => Target::Stroke(values[row]),
            Course::Tensions(values) => Target::Tension(values[row]),
            Course::Residual(values, stiffness) => Target::Tension(values[row] * stiffness),
            Course::Constant(target) => *target,
        };
        self.courses.iter().map(target).collect()
    }

    /// Strokes commanded to the primary tendons in sample `row` [m].
    pub fn primary_strokes(&self, row: usize) -> Vec<f64> {
        self.courses[..self.n_primary]
            .iter()
            .map_while(|course| match course {
                Course::Strokes(values) => Some(values[row]),
                _ => None,
            })
            .collect()
    }

    /// Stroke commanded to tendon `j` [m], if that is what it follows.
    pub fn strokes_of(&self, j: usize) -> Option<&'a [f64]> {
        match self.courses[j] {
            Course::Strokes(values) | Course::Residual(values, _) => Some(values),
            _ => None,
        }
    }

    /// The error of a stroke that is not met because the tendon has reached its largest tension.
    fn overloaded(&self, twin: &Twin, state: &TwinState) -> Option<Error> {
        twin.overloaded(state, |j| self.strokes_of(j).is_some())
    }

    /// Description of the command of the primary tendons in sample `row`, for a message.
    pub fn describe(&self, twin: &Twin, row: usize) -> String {
        let of = |j: usize| {
            let name = &twin.tendons[j].name;
            match self.courses[j] {
                Course::Strokes(values) => format!("{name} {:.3} mm", 1e3 * values[row]),
                Course::Tensions(values) => format!("{name} {:.3} N", values[row]),
                Course::Residual(values, _) => format!("{name} {:.3} mm", 1e3 * values[row]),
                Course::Constant(_) => format!("{name} free"),
            }
        };
        (0..twin.n_primary).map(of).collect::<Vec<_>>().join(", ")
    }

    /// No stroke may be as long as its tendon.
    fn check_lengths(&self, twin: &Twin) -> Result<(), BadInput> {
        for j in 0..self.courses.len() {
            let length = twin.cables.rest_lengths[j];
            let Some(strokes) = self.strokes_of(j) else { continue };
            if let Some(row) = strokes.iter().position(|stroke| *stroke >= length) {
                let name = &twin.tendons[j].name;
                return Err(BadInput::new(
                    format!("row {} (t = {} s): stroke of tendon {name}", row + 1, shown(self.time[row])),
                    format!("less than the tendon's length, {:.3} mm", 1e3 * length),
                    format!("{:.3} mm", 1e3 * strokes[row]),
                )
                .hint("is the unit of the column its ending, _mm or _m?"));
            }
            if !matches!(self.courses[j], Course::Strokes(_)) {
                continue;
            }
            for (row, stroke) in strokes.iter().enumerate() {
                twin.tendons[j].check_stroke(*stroke, || {
                    let name = &twin.tendons[j].name;
                    format!("row {} (t = {} s): stroke of tendon {name}", row + 1, shown(self.time[row]))
                })?;
            }
        }
        Ok(())
    }
}

/// The courses of auxiliary tendons that a recording drives: by stroke, or, where the scene drives them by tension, by
/// the strokes that CoReAct knows.
fn driven<'a>(twin: &Twin, aux: &[&'a [f64]]) -> Result<Vec<Course<'a>>, BadInput> {
    let tendons = &twin.tendons[twin.n_primary..];
    if tendons.iter().all(|tendon| tendon.drive != PrescribedQuantity::Tension) {
        return Ok(aux.iter().map(|values| Course::Strokes(values)).collect());
    }
    let auxiliary = AuxiliaryLimits::new(twin).map_err(|error| {
        error
            .bad_input()
            .cloned()
            .unwrap_or_else(|| BadInput::new("scene", "auxiliary tendons", error.to_string()))
    })?;
    for (k, (values, bounds)) in aux.iter().zip(&auxiliary.bounds).enumerate() {
        // Written and read again, a stroke at its bound may have lost its last digit.
        let slack = 1e-9 * (bounds.max - bounds.min);
        let outside = |value: &f64| *value < bounds.min - slack || *value > bounds.max + slack;
        if let Some(row) = values.iter().position(outside) {
            let expected = format!("{:.4} to {:.4} mm", 1e3 * bounds.min, 1e3 * bounds.max);
            let place = format!("row {}: aux_{:02}_m", row + 1, k + 1);
            return Err(BadInput::new(place, expected, format!("{:.4} mm", 1e3 * values[row]))
                .hint("bounds of stroke and tension in the scene's [auxiliary]"));
        }
    }
    let stiffness = auxiliary.compliances.iter().map(|compliance| compliance.recip());
    Ok(aux.iter().zip(stiffness).map(|(values, stiffness)| Course::Residual(values, stiffness)).collect())
}

/// As many channels of this kind as tendons.
fn check_count(stem: &str, found: usize, tendons: &[TwinTendon]) -> Result<(), BadInput> {
    if found == tendons.len() {
        return Ok(());
    }
    let names: Vec<&str> = tendons.iter().map(|tendon| tendon.name.as_str()).collect();
    let expected = match tendons.len() {
        0 => "none: the scene has no such tendons".to_owned(),
        n if n > 8 => format!("{n} ({} to {})", names[0], names[n - 1]),
        n => format!("{n} ({})", names.join(", ")),
    };
    let hint = match (tendons.len(), stem) {
        (0, _) => format!("take the {stem} columns out, or add the tendons to the scene"),
        (n, "aux") => format!("name the columns aux_01_mm to aux_{n:02}_mm, in the order of the layout"),
        (n, _) => {
            format!("name the columns {stem}_1_mm to {stem}_{n}_mm, in the order of the scene's tendons")
        }
    };
    Err(BadInput::new(format!("{stem} columns"), expected, found.to_string()).hint(hint))
}

fn tensions<'a>(recording: &'a Recording, tendon: &TwinTendon, number: usize) -> Result<&'a [f64], BadInput> {
    let name = format!("tension_{number}_n");
    let hint =
        format!("the scene drives tendon {} by tension; set drive = \"stroke\" for strokes", tendon.name);
    let values = recording.require(&name).map_err(|bad| bad.hint(hint))?;
    if let Some(row) = values.iter().position(|value| !tendon.tension.contains(*value)) {
        let bounds = tendon.tension;
        return Err(BadInput::new(
            format!("row {} (t = {} s): {name}", row + 1, shown(recording.time()[row])),
            format!("within the tendon's bounds, {} to {} N", bounds.min, bounds.max),
            format!("{} N", values[row]),
        )
        .hint("the bounds are tension_min_n and tension_max_n in the scene"));
    }
    Ok(values)
}
