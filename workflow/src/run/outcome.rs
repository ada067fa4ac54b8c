//! What a run was for and what came of it, as figures and reports show it.

use hysteron_base::{Recording, Scene};
use hysteron_twin::{Twin, TwinState};

use super::goals::Goals;
use super::summary::Summary;

/// What the robot does with the samples of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Task {
    /// It follows their strokes or tensions.
    Simulate,
    /// Its tip goes to their tip positions, within the tolerance [m].
    Reach(f64),
}

impl Task {
    /// What a reader calls the run.
    pub fn title(self) -> &'static str {
        match self {
            Self::Simulate => "simulation",
            Self::Reach(_) => "strokes to reach goals",
        }
    }

    /// What the recording that goes in is for: name of its option, and part of its key in the metadata.
    pub(super) fn input(self) -> &'static str {
        match self {
            Self::Simulate => "strokes",
            Self::Reach(_) => "goals",
        }
    }
}

/// Everything a figure or report may show.
pub struct Run<'a> {
    /// What it was for.
    pub task: Task,
    /// The robot.
    pub twin: &'a Twin,
    /// The scene it was made from.
    pub scene: &'a Scene,
    /// What was recorded.
    pub recording: &'a Recording,
    /// Where the tip was to go, if that was asked.
    pub goals: Option<&'a Goals<'a>>,
    /// Where the robot's own tip was measured under the same strokes, if it was: x, y and z (n_samples each) [m].
    pub measured: Option<[&'a [f64]; 3]>,
    /// Samples whose tip was not measured (n_samples).
    pub gap: &'a [bool],
    /// State in which the tip was farthest from rest, and its sample.
    pub farthest: (usize, &'a TwinState),
    /// Numbers of the run.
    pub summary: &'a Summary,
}
