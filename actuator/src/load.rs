//! Tension of a tendon from the load of the servo that pulls it.
//!
//! While the pulley turns steadily one way, T = (τ - τ_f(ω))/r, with the torque τ that the servo gives its motor and τ_f all that
//! works against motion, the motor's own back EMF included. At rest the servo's friction acts up to its
//! breakaway either way: a load then carries next to no information on a tension.

use hysteron_base::BadInput;

use crate::friction::Stribeck;
use crate::identify::identify_friction;
use crate::law::{Law, SymmetricStribeck};

/// Slowest steady motion [rad/s]: half a tick of an XL430 in a sample of 10 ms.
const SLOWEST: f64 = 0.03;
/// Fewest samples of motion that friction is identified from.
const MIN_SAMPLES: usize = 200;

/// Tension on a pulley from the load of its servo: torque, radius and friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadModel {
    /// Torque of a load of 1 [N m].
    pub stall_torque: f64,
    /// Radius at which the tendon lies on the pulley [m].
    pub radius: f64,
    /// Against motion of the output, back EMF included.
    pub friction: Stribeck,
}

impl LoadModel {
    /// Tension under `load` [-], positive where the servo pulls, of a pulley that turns at `velocity` [rad/s], positive where it
    /// pulls [N].
    pub fn tension(&self, load: f64, velocity: f64) -> f64 {
        (self.stall_torque * load - self.friction.torque(velocity)) / self.radius
    }

    /// Finds the friction from samples of steady motion on a slack tendon: speeds [rad/s] and loads [-].
    ///
    /// # Errors
    /// `BadInput` where there are too few, or none in one direction; those of the fit.
    pub fn identify(
        stall_torque: f64,
        radius: f64,
        velocity: &[f64],
        load: &[f64],
    ) -> Result<Self, BadInput> {
        for (direction, n) in [
            ("pulling", velocity.iter().filter(|v| **v > 0.0).count()),
            ("releasing", velocity.iter().filter(|v| **v < 0.0).count()),
        ] {
            if n < MIN_SAMPLES {
                let expected = format!(
                    "at least {MIN_SAMPLES} samples of steady motion, {direction}, on a slack tendon"
                );
                return Err(BadInput::new("friction of the servos", expected, n.to_string())
                    .hint("record a plan in which every tendon goes slack, such as `quick`"));
            }
        }
        let torque: Vec<f64> = load.iter().map(|load| stall_torque * load).collect();
        let found = identify_friction(&Law::Stribeck(SymmetricStribeck), velocity, &torque, None)?;
        let [coulomb, excess, stribeck_velocity, viscous] = found.parameters[..] else {
            return Err(BadInput::new(
                "friction of the servos",
                "four numbers",
                found.parameters.len().to_string(),
            ));
        };
        let friction = Stribeck::new(coulomb, coulomb + excess, stribeck_velocity, viscous)?;
        Ok(Self { stall_torque, radius, friction })
    }
}

/// A pulley in steady motion, on the average over the last [`SteadyMotion::SPAN`] samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteadyLoad {
    /// Speed [rad/s].
    pub velocity: f64,
    /// Load of its servo [-].
    pub load: f64,
}

/// Finds steady motion of a pulley, sample by sample; allocates nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyMotion {
    /// Duration of a sample [s].
    period: f64,
    /// Angles [rad] and loads [-] of the last samples, the newest first.
    angles: [f64; Self::SPAN + 1],
    loads: [f64; Self::SPAN],
    n_seen: usize,
    /// For how many samples the speed has had its sign.
    n_steady: usize,
    velocity: f64,
}

impl SteadyMotion {
    /// Samples that are averaged over: a tick more or less in ten samples of 10 ms is 0.3 N of an XL430's viscous friction.
    pub const SPAN: usize = 10;

    /// For samples of `period` [s].
    pub fn new(period: f64) -> Self {
        let (angles, loads) = ([0.0; Self::SPAN + 1], [0.0; Self::SPAN]);
        Self { period, angles, loads, n_seen: 0, n_steady: 0, velocity: 0.0 }
    }

    /// Speed and load where the motion has been steady and not slow; `angle` [rad] and `load` [-] are those of this sample.
    pub fn step(&mut self, angle: f64, load: f64) -> Option<SteadyLoad> {
        self.angles.rotate_right(1);
        self.loads.rotate_right(1);
        (self.angles[0], self.loads[0]) = (angle, load);
        self.n_seen += 1;
        if self.n_seen <= Self::SPAN {
            return None;
        }
        let velocity = (self.angles[0] - self.angles[Self::SPAN]) / (Self::SPAN as f64 * self.period);
        let is_same_direction = velocity * self.velocity > 0.0;
        self.n_steady = if is_same_direction { self.n_steady + 1 } else { 0 };
        self.velocity = velocity;
        let load = self.loads.iter().sum::<f64>() / Self::SPAN as f64;
        (self.n_steady >= Self::SPAN && velocity.abs() > SLOWEST).then_some(SteadyLoad { velocity, load })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::servo::{ServoSimulation, ServoSpec};
    use crate::{DriveLoad, Gains, ServoCommand};
    use std::f64::consts::TAU;

    const RADIUS: f64 = 0.01;
    const PERIOD: f64 = 0.01;

    fn spec() -> ServoSpec {
        ServoSpec {
            stall_torque: 1.4,
            no_load_speed: 5.97,
            stall_current: 1.3,
            inertia: 0.003,
            friction: Stribeck { coulomb: 0.045, breakaway: 0.065, stribeck_velocity: 0.1, viscous: 0.01 },
            dead_band: 0.0,
            heat_capacity: 50.0,
            thermal_resistance: 8.0,
            ambient_temperature: 24.0,
        }
    }

    /// A servo that goes to and fro under a tension: angle and load, sample by sample.
    fn recorded(tension: impl Fn(f64) -> f64) -> Vec<(f64, f64, f64)> {
        let mut servo = ServoSimulation::new(spec().drive(), 3.0);
        servo.drive.supply.voltage = 12.0;
        let mut command = ServoCommand { torque_on: true, gains: Gains::XL430, ..ServoCommand::POWER_ON };
        let mut rows = Vec::new();
        for sample in 0..4000 {
            let time = sample as f64 * PERIOD;
            command.goal = ((3.0 + 0.5 * (0.2 * TAU * time).sin() + 0.1 * (0.05 * TAU * time).sin()) * 4096.0
                / TAU) as i32;
            for tick in 0..10 {
                let torque = -RADIUS * tension(time + 1e-3 * f64::from(tick));
                servo.step(&command, DriveLoad::torque(torque), 1e-3);
            }
            rows.push((f64::from(servo.ticks()) * TAU / 4096.0, servo.load(), tension(time)));
        }
        rows
    }

    fn steady(rows: &[(f64, f64, f64)]) -> Vec<(f64, f64, f64)> {
        let mut motion = SteadyMotion::new(PERIOD);
        // The load lags by 20 ms, so does the mean of the tension that belongs to it.
        let span = |i: usize| i.saturating_sub(SteadyMotion::SPAN + 1)..i.saturating_sub(1);
        let tension =
            |i: usize| rows[span(i)].iter().map(|row| row.2).sum::<f64>() / SteadyMotion::SPAN as f64;
        let found = rows.iter().enumerate().filter_map(|(i, (angle, load, _))| {
            let steady = motion.step(*angle, *load)?;
            Some((steady.velocity, steady.load, tension(i)))
        });
        found.collect()
    }

    #[test]
    fn friction_of_a_slack_tendon_gives_the_tension_of_a_taut_one() {
        let slack = steady(&recorded(|_| 0.0));
        let (velocity, load): (Vec<f64>, Vec<f64>) = slack.iter().map(|(v, load, _)| (*v, *load)).unzip();
        let model = LoadModel::identify(1.4, RADIUS, &velocity, &load).expect("motion both ways");
        let taut = steady(&recorded(|time| 15.0 + 10.0 * (0.1 * TAU * time).sin()));
        let square = |f: &dyn Fn(&(f64, f64, f64)) -> f64| {
            taut.iter().map(|row| f(row).powi(2)).sum::<f64>() / taut.len() as f64
        };
        let error = square(&|(velocity, load, tension)| model.tension(*load, *velocity) - tension).sqrt();
        let naive = square(&|(_, load, tension)| 1.4 * load / RADIUS - tension).sqrt();
        // The position loop knows its error to a tick, which at these gains is 1.07 N of tension: loads cannot be better than that
        // by much, and must not be worse.
        assert!(error < 1.07, "{error} N");
        assert!(naive > 4.0, "{naive} N without friction: no test");
    }

    #[test]
    fn a_reversal_is_no_steady_motion() {
        let mut motion = SteadyMotion::new(PERIOD);
        let angle = |i: i32| 0.01 * f64::from(if i < 30 { i } else { 60 - i });
        let found: Vec<Option<SteadyLoad>> = (0..70).map(|i| motion.step(angle(i), f64::from(i))).collect();
        let span = SteadyMotion::SPAN;
        assert!(found[..2 * span].iter().all(Option::is_none));
        let before = found[25].expect("steady");
        assert!((before.velocity - 1.0).abs() < 1e-12 && before.load == 20.5, "{before:?}");
        // The speed over the span changes its sign half a span after the motion has.
        assert!(found[30 + span / 2..30 + span / 2 + span].iter().all(Option::is_none));
        assert!((found[69].expect("steady").velocity + 1.0).abs() < 1e-12);
    }

    #[test]
    fn motion_one_way_is_not_enough() {
        let refused =
            LoadModel::identify(1.4, RADIUS, &[0.5; 1000], &[0.1; 1000]).expect_err("one way alone");
        assert!(refused.to_string().contains("releasing"), "{refused}");
    }
}
