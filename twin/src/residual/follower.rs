//! From a path to strokes through the calibrated twin: the twin's tip is steered along the path in closed
//! loop, and the resulting strokes are the commands of a robot without a tip sensor.
//!
//! Sample by sample u ← u + M (Δy* + κ (y* - y)): how far the goal goes in this sample, and a part of what was
//! missed in the one before; M is the inverse of what a command does to the tip. M is wrong where the robot is bent,
//! slack or sticking; the next samples see what was missed, so hysteresis, which the twin remembers, is led around
//! rather than modelled backwards. κ is well below one: where the tip moves more than M predicts, the loop must not
//! swing.

use hysteron_base::BadInput;
use nalgebra::{Matrix2, Vector2};

use crate::Result;
use crate::model::Twin;
use crate::plant::{PhysicsTwin, Plant, PlantStep, relax_to_equilibrium};

/// From two coordinates (a, b) [m] to the strokes of all primary tendons [m].
pub type Coordinates<'a> = &'a (dyn Fn([f64; 2], &mut [f64]) + Sync);

/// Limits of a command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FollowLimits {
    /// Largest |(a, b)| [m].
    pub stroke: f64,
    /// Fastest change of (a, b) [m/s].
    pub rate: f64,
}

/// One sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FollowStep {
    /// Tip of the twin [m].
    pub tip: [f64; 3],
    /// True where a limit kept the command from what it should have been.
    pub is_limited: bool,
    /// True where an input of the network was outside its training range.
    pub is_extrapolating: bool,
    /// Radius of the band about the tip [m]; none without a network that has one.
    pub tip_band: Option<f64>,
}

/// Finds the strokes of a tip that is steered.
pub struct PathController<'a> {
    coordinates: Coordinates<'a>,
    limits: FollowLimits,
    /// M, (a, b) per tip in x and y [-].
    inverse: Matrix2<f64>,
    /// Duration of a sample [s].
    duration: f64,
    command: Vector2<f64>,
    /// Where the tip was to go in the sample before, in x and y [m].
    goal: Vector2<f64>,
}

/// A twin whose tip is steered.
pub struct PathFollower<'a> {
    controller: PathController<'a>,
    plant: Box<dyn Plant + 'a>,
    /// Where it is [m]; none before the first sample.
    tip: Option<[f64; 3]>,
    strokes: Vec<f64>,
}

/// κ: part of the error of a sample that the next one makes up for [-].
const FEEDBACK: f64 = 0.25;
/// Part of the largest command at which its effect on the tip is measured: past slack, before large bends.
const PROBED: f64 = 0.5;
/// Most samples of the way from the largest command to none.
const MAX_HOME: f64 = 1e6;
/// Steps of the probe: small enough for the fast iteration.
const PROBE_STEPS: usize = 50;

impl<'a> PathController<'a> {
    /// Steers `twin`, sample by sample of `duration` [s], from where it rests without strokes.
    ///
    /// # Errors
    /// Limits that are not positive; commands that do not move the tip in x and y; those of [`Plant::step`].
    pub fn new(
        twin: &Twin,
        coordinates: Coordinates<'a>,
        limits: FollowLimits,
        duration: f64,
    ) -> Result<Self> {
        for (name, value) in [("largest stroke", limits.stroke), ("largest rate", limits.rate)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(BadInput::new(name, "above 0", value.to_string()).into());
            }
        }
        // The way home goes at the largest rate.
        let n_home = limits.stroke / (limits.rate * duration);
        if n_home > MAX_HOME {
            let least = limits.stroke / (MAX_HOME * duration);
            let found = format!("{:e} mm/s", 1e3 * limits.rate);
            return Err(
                BadInput::new("largest rate", format!("at least {:.1e} mm/s", 1e3 * least), found).into()
            );
        }
        let effect = effect_of(twin, coordinates, PROBED * limits.stroke)?;
        let inverse = effect.try_inverse().filter(|m| m.iter().all(|value| value.is_finite()));
        let inverse = inverse.ok_or_else(|| {
            BadInput::new("tendons", "that move the tip in x and y", format!("{effect:.3} m/m"))
        })?;
        let [command, goal] = [Vector2::zeros(); 2];
        Ok(Self { coordinates, limits, inverse, duration, command, goal })
    }

    /// The strokes (n_primary) [m] of the next sample, towards `goal` in x and y [m]; `tip` is where the last one
    /// has led
    /// [m], none before the first. True where a limit kept them from what they should have been.
    pub fn step(&mut self, goal: [f64; 2], tip: Option<[f64; 3]>, strokes: &mut [f64]) -> bool {
        let goal = Vector2::from(goal);
        let before = std::mem::replace(&mut self.goal, goal);
        // The robot need not rest where the path begins: strokes begin at rest, and what is missing is made up for from
        // the second sample on like any other error.
        let change = tip.map_or(Vector2::zeros(), |tip| {
            let missed = before - Vector2::new(tip[0], tip[1]);
            self.inverse * (goal - before + FEEDBACK * missed)
        });
        let allowed = change.cap_magnitude(self.limits.rate * self.duration);
        let command = (self.command + allowed).cap_magnitude(self.limits.stroke);
        let is_limited = command != self.command + change;
        self.go_to(command, strokes);
        is_limited
    }

    /// The strokes (n_primary) [m] of the next sample, towards none at all as fast as the limits allow: the way
    /// home, at the end.
    pub fn return_home(&mut self, strokes: &mut [f64]) {
        let way = self.command.norm();
        let left = f64::max(way - self.limits.rate * self.duration, 0.0);
        self.go_to(self.command.cap_magnitude(left), strokes);
    }

    /// True where all strokes are zero.
    pub fn is_home(&self) -> bool {
        self.command == Vector2::zeros()
    }

    fn go_to(&mut self, command: Vector2<f64>, strokes: &mut [f64]) {
        self.command = command;
        (self.coordinates)([command.x, command.y], strokes);
    }
}

impl<'a> PathFollower<'a> {
    /// Steers `plant`, a simulation with `twin` that has just been made, from where it rests, with samples of
    /// `duration` [s].
    ///
    /// # Errors
    /// Those of [`PathController::new`].
    pub fn new(
        twin: &Twin,
        mut plant: Box<dyn Plant + 'a>,
        coordinates: Coordinates<'a>,
        limits: FollowLimits,
        duration: f64,
    ) -> Result<Self> {
        let controller = PathController::new(twin, coordinates, limits, duration)?;
        let mut strokes = vec![0.0; twin.n_primary];
        coordinates([0.0; 2], &mut strokes);
        relax_to_equilibrium(twin, &mut *plant, &strokes)?;
        Ok(Self { controller, plant, tip: None, strokes })
    }

    /// Strokes now (n_primary) [m].
    pub fn strokes(&self) -> &[f64] {
        &self.strokes
    }

    /// Goes on by one sample, towards `goal` in x and y [m].
    ///
    /// # Errors
    /// Those of [`Plant::step`].
    pub fn step(&mut self, goal: [f64; 2]) -> Result<FollowStep> {
        let is_limited = self.controller.step(goal, self.tip, &mut self.strokes);
        self.advance(is_limited)
    }

    /// Goes on by one sample, towards no strokes at all, as fast as the limits allow: the way home, at the end.
    ///
    /// # Errors
    /// Those of [`Plant::step`].
    pub fn step_home(&mut self) -> Result<FollowStep> {
        self.controller.return_home(&mut self.strokes);
        self.advance(false)
    }

    /// True where all strokes are zero.
    pub fn is_home(&self) -> bool {
        self.controller.is_home()
    }

    fn advance(&mut self, is_limited: bool) -> Result<FollowStep> {
        let step = self.plant.step(&self.strokes)?;
        self.tip = Some(step.tip);
        let PlantStep { tip, is_extrapolating, tip_band, .. } = step;
        Ok(FollowStep { tip, is_limited, is_extrapolating, tip_band })
    }
}

/// Response of x and y of the tip to (a, b) [-]: secants of the uncorrected twin, from -`amplitude` to `amplitude`.
fn effect_of(twin: &Twin, coordinates: Coordinates, amplitude: f64) -> Result<Matrix2<f64>> {
    let mut effect = Matrix2::zeros();
    let mut strokes = vec![0.0; twin.n_primary];
    for direction in 0..2 {
        for sign in [-1.0, 1.0] {
            let mut uncorrected = PhysicsTwin::new(twin);
            for i in 1..=PROBE_STEPS {
                let mut point = [0.0; 2];
                point[direction] = sign * amplitude * i as f64 / PROBE_STEPS as f64;
                coordinates(point, &mut strokes);
                uncorrected.step(&strokes)?;
            }
            let tip = twin.tip_of(uncorrected.state());
            for axis in 0..2 {
                effect[(axis, direction)] += 0.5 * sign * tip[axis] / amplitude;
            }
        }
    }
    Ok(effect)
}
