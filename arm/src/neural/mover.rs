//! What moves the motors of the simulated arm beside the network, and how warm it gets.

use hysteron_actuator::Drive;
use hysteron_actuator::number::Dual;

use super::data::Trajectory;
use super::features::Features;
use super::segment::Segment;
use super::servo::{FRICTION_WIDTH, ServoModel};
use super::simulation::{Asked, SimulationOptions};

/// What moves every motor beside the network.
#[derive(Debug, Clone, Copy)]
pub(super) enum Mover<'a> {
    /// Stiffness, friction and damping.
    Servo(&'a ServoModel),
    /// A motor on its supply, with heat and limits of current.
    Drive(&'a Drive),
}

impl SimulationOptions {
    /// What moves the motors beside the network.
    pub(super) fn mover(&self) -> Option<Mover<'_>> {
        let drive = self.drive.as_ref().map(|one| Mover::Drive(&one.drive));
        self.servo.as_ref().map(Mover::Servo).or(drive)
    }

    /// Gain of the position loops that gains are told over; none where they are not known.
    pub(super) fn position_gain(&self) -> Option<f64> {
        match self.mover()? {
            Mover::Servo(servo) => servo.position_gain,
            Mover::Drive(_) => Some(1.0),
        }
    }
}

impl Mover<'_> {
    /// Torque of motor `k` towards `goal` at this position and speed [N m], and its derivatives by these two; without friction that holds,
    /// which is the integrator's. `gain` is over [`SimulationOptions::position_gain`], `winding` the temperature of a drive's [°C].
    pub fn torque(
        &self,
        k: usize,
        (goal, gain): (f64, f64),
        [position, speed]: [f64; 2],
        winding: f64,
    ) -> (f64, [f64; 2]) {
        match self {
            Self::Servo(servo) => servo.torque(k, (goal, gain), [position, speed]),
            Self::Drive(drive) => {
                let at = |error, speed| drive.follow(gain, [error, speed], winding)[0];
                let by_error = at(Dual::variable(goal - position), Dual::from(speed));
                let by_speed = at(Dual::from(goal - position), Dual::variable(speed));
                (by_error.value, [-by_error.slope, by_speed.slope])
            }
        }
    }

    /// Friction of motor `k` that the integrator has to hold [N m] and its growth per torque through the gear, each with its derivative by
    /// the speed.
    pub fn friction(&self, k: usize, speed: f64) -> [Dual; 2] {
        match self {
            Self::Servo(servo) => servo.held(k).map(Dual::from),
            Self::Drive(drive) => drive.load_friction(Dual::variable(speed)),
        }
    }

    /// What friction leaves of motor `k`'s torque at a speed where inertia takes nothing: b of τ − b = s (F + μ |τ + b|) [N m].
    pub fn left_by_friction(&self, k: usize, torque: f64, speed: f64) -> f64 {
        if matches!(self, Self::Servo(servo) if !servo.holds) {
            return torque;
        }
        let [friction, share] = self.friction(k, speed).map(|one| one.value);
        let against = (speed / FRICTION_WIDTH).tanh();
        let grows = against * share * torque.signum();
        (torque * (1.0 - grows) - against * friction) / (1.0 + grows)
    }

    /// Whether [`Self::friction`] is more than a number for each motor.
    pub fn friction_varies(&self) -> bool {
        match self {
            Self::Servo(servo) => !servo.load_friction.is_empty(),
            Self::Drive(_) => true,
        }
    }
}

/// Temperatures of drives along rollouts. Torques follow from them, and gradients take them as given: windings warm in seconds.
#[derive(Debug, Clone)]
pub(super) struct Heat<'a> {
    drive: Option<&'a Drive>,
    motors: usize,
    period: f64,
    /// Windings and cases at the beginning (trajectories × m) [°C], and now.
    start: Vec<[f64; 2]>,
    now: Vec<[f64; 2]>,
    /// Windings at every step so far (steps × trajectories × m) [°C].
    windings: Vec<f64>,
}

impl<'a> Heat<'a> {
    /// Of rollouts along these segments: drives were as warm as recorded at the beginning of a recording, and warmed from there on.
    pub fn new(options: &'a SimulationOptions, features: &Features, segments: &[Segment<'_>]) -> Self {
        let Some(Mover::Drive(drive)) = options.mover() else {
            let [start, now] = [(); 2].map(|()| Vec::new());
            return Self { drive: None, motors: 0, period: options.period, start, now, windings: Vec::new() };
        };
        let m = features.motors();
        let of = |one: &Segment<'_>| warmed(drive, (features, options.period), one.trajectory, one.start);
        let start: Vec<[f64; 2]> = segments.iter().flat_map(of).collect();
        let now = start.clone();
        Self { drive: Some(drive), motors: m, period: options.period, start, now, windings: Vec::new() }
    }

    /// Windings at a step (trajectories × m) [°C]; empty without drives.
    pub fn at(&self, step: usize) -> &[f64] {
        let width = self.start.len();
        &self.windings[step * width..(step + 1) * width]
    }

    /// Keeps the windings of a step; the first begins anew.
    pub fn begin(&mut self, step: usize) {
        if step == 0 {
            self.windings.clear();
            self.now.clone_from(&self.start);
        }
        self.windings.extend(self.now.iter().map(|[winding, _]| winding));
    }

    /// Lets a step from `states` pass.
    pub fn pass(&mut self, states: &[f64], asked: Asked<'_>) {
        let (Some(drive), m) = (self.drive, self.motors) else { return };
        for (at, now) in self.now.iter_mut().enumerate() {
            let (row, k) = (at / m, at % m);
            let state = &states[row * 2 * m..][..2 * m];
            let [_, current] =
                drive.follow(asked.gains[row], [asked.goals[at] - state[k], state[m + k]], now[0]);
            *now = drive.warmed(*now, current, self.period);
        }
    }
}

/// Winding and case of every motor at a row of a recording.
fn warmed(
    drive: &Drive,
    (features, period): (&Features, f64),
    trajectory: &Trajectory,
    row: usize,
) -> Vec<[f64; 2]> {
    let m = features.motors();
    let gain = trajectory.position_gain.unwrap_or(0.0);
    let of = |k: usize| {
        let first = trajectory.inputs_at(0)[features.temperatures() + k];
        (0..row).fold([first; 2], |now, row| {
            let (state, goal) = (trajectory.state_at(row), trajectory.inputs_at(row as isize)[k]);
            let [_, current] = drive.follow(gain, [goal - state[k], state[m + k]], now[0]);
            drive.warmed(now, current, period)
        })
    };
    (0..m).map(of).collect()
}
