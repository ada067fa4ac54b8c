//! Strokes of a way of the tip: those that bring the twin's tip along it, found as it goes.

use hysteron_control::{StrokeLimits, Trajectory};
use hysteron_twin::residual::{Coordinates, FollowLimits, PathController};
use hysteron_twin::synthetic::StrokeSource;
use hysteron_twin::{Result, Twin};

/// A tip that is steered along a trajectory, and then home.
pub struct Steered<'a> {
    trajectory: &'a Trajectory,
    controller: PathController<'a>,
}

impl<'a> Steered<'a> {
    /// Steers `twin`; `coordinates` are those of the trajectory's tendons.
    ///
    /// # Errors
    /// Those of [`PathController::new`].
    pub fn new(
        twin: &Twin,
        trajectory: &'a Trajectory,
        coordinates: Coordinates<'a>,
        limits: StrokeLimits,
    ) -> Result<Self> {
        let limits = FollowLimits { stroke: limits.stroke.max, rate: limits.stroke_rate };
        let controller = PathController::new(twin, coordinates, limits, trajectory.rate_hz.recip())?;
        Ok(Self { trajectory, controller })
    }
}

impl StrokeSource for Steered<'_> {
    fn time(&self, i: usize) -> f64 {
        self.trajectory.time(i)
    }

    fn strokes(&mut self, i: usize, tip: Option<[f64; 3]>, strokes: &mut [f64]) -> bool {
        if i < self.trajectory.n_samples() {
            self.controller.step(self.trajectory.position_at(self.trajectory.time(i)), tip, strokes);
            return true;
        }
        let is_home = self.controller.is_home();
        self.controller.return_home(strokes);
        !is_home
    }
}
