//! Plans: what to command, in tendon space, before anything moves.
//!
//! A plan knows tendons by their angles alone, no robot. What a person typed (`typed.rs`) and what is valid (here)
//! are two types with one conversion between (`convert.rs`). Two coordinates (a, b) move every tendon, as a robot of
//! one segment bends in two directions: s_k = a cos φ_k + b sin φ_k.

mod convert;
mod draw;
mod envelope;
mod lazy;
mod limits;
mod motion;
mod schema;
mod trajectory;

use crate::{Error, Result};
use hysteron_base::{BadInput, file};
use std::path::Path;

pub use envelope::Envelope;
pub(crate) use envelope::rise;
pub use lazy::LazyPlan;
pub use limits::StrokeLimits;
pub use motion::{CurveMotion, Direction, Family};
pub use trajectory::{Space, TendonMapping, Trajectory, TrajectoryRole};

/// Plans that are part of the program, by name: `paper` is the data set of the CoReAct paper, `quick` a minute of
/// it, `synthetic` the twin's data set in the CoReAct paper, `roses` additional rose curves for the twin.
const BUILT_IN: [(&str, &str); 4] = [
    ("paper", include_str!("../../plans/paper.toml")),
    ("quick", include_str!("../../plans/quick.toml")),
    ("roses", include_str!("../../plans/roses.toml")),
    ("synthetic", include_str!("../../plans/synthetic.toml")),
];

/// Trajectories to command one after the other, valid and in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionPlan {
    /// Name of the plan.
    pub name: String,
    /// Seed of its variations.
    pub seed: u64,
    /// SHA-256 of the bytes of the plan file, 64 hexadecimal digits.
    pub hash: String,
    /// Its own limits, within which it is.
    pub limits: StrokeLimits,
    trajectories: Vec<Trajectory>,
}

impl MotionPlan {
    /// Reads and validates a plan file.
    ///
    /// # Errors
    /// `BadInput` naming the key; `Stroke` and `StrokeRate` where the plan passes its own limits; `File` if the
    /// file cannot be read.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Self::from_toml(&file::read_text(path)?, &path.display().to_string())
    }

    /// The plan in the text of a plan file; `place` names the file in messages.
    ///
    /// # Errors
    /// As [`MotionPlan::read`].
    pub fn from_toml(text: &str, place: &str) -> Result<Self> {
        Self::checked(text).map_err(|error| error.within(place))
    }

    fn checked(text: &str) -> Result<Self> {
        let typed: schema::PlanFile = hysteron_base::schema::parse(text)?;
        let plan = convert::plan(&typed, file::sha256_hex(text.as_bytes()))?;
        // Strokes for a way of the tip are held within the limits when they are found.
        if plan.space() == Space::Tendons {
            plan.check(&plan.limits)?;
        }
        Ok(plan)
    }

    /// The file of a plan that is part of the program; `None` for another name.
    pub fn text(name: &str) -> Option<&'static str> {
        BUILT_IN.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
    }

    /// A plan that is part of the program.
    ///
    /// # Errors
    /// `BadInput` listing their names.
    pub fn named(name: &str) -> Result<Self> {
        let Some(text) = Self::text(name) else {
            let known: Vec<&str> = Self::names().collect();
            return Err(Error::BadInput(
                BadInput::new("plan", format!("one of {}", known.join(", ")), format!("\"{name}\""))
                    .hint("or the path of a plan file, ending in .toml"),
            ));
        };
        Self::from_toml(text, &format!("plan {name}"))
    }

    /// Names of the plans that are part of the program.
    pub fn names() -> impl Iterator<Item = &'static str> {
        BUILT_IN.iter().map(|(name, _)| *name)
    }

    /// Its trajectories, in the order of the file; at least one.
    pub fn trajectories(&self) -> &[Trajectory] {
        &self.trajectories
    }

    /// Space of its curves.
    pub fn space(&self) -> Space {
        self.trajectories[0].space
    }

    /// Time of all trajectories together [s].
    pub fn duration(&self) -> f64 {
        self.trajectories.iter().map(Trajectory::duration).sum()
    }
}

#[cfg(test)]
mod tests;
