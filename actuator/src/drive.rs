//! A geared DC motor on a supply: voltage, current, heat, friction that depends on the load.
//!
//! The speed is found implicitly in every step, so that back EMF never makes a step unstable and friction holds exactly.

use crate::law::{JointFriction, Law, Sliding};

/// A DC motor, seen from the output of its gear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motor {
    /// Torque per current k_t, which is also back EMF per speed, at the reference temperature [N m/A].
    pub torque_constant: f64,
    /// Resistance of winding and bridge R, at the reference temperature [ohm].
    pub resistance: f64,
    /// Largest current that the drive allows; infinite where it limits none [A].
    pub current_limit: f64,
}

/// A voltage behind a resistance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Supply {
    /// Voltage without current [V].
    pub voltage: f64,
    /// Resistance of battery and cables [ohm].
    pub resistance: f64,
}

/// Heat: a winding in a case in air. A hot winding has more resistance, a hot magnet less torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Winding {
    /// Heat that warms the winding by one kelvin [J/K]; infinite where it stays as it is.
    pub heat_capacity: f64,
    /// Temperature difference of winding and case per heat flow [K/W].
    pub to_case: f64,
    /// Heat that warms the case by one kelvin [J/K].
    pub case_heat_capacity: f64,
    /// Temperature difference of case and air per heat flow [K/W].
    pub to_air: f64,
    /// Relative change of resistance per kelvin: 0.00393 for copper [1/K].
    pub resistance_slope: f64,
    /// Relative loss of torque constant per kelvin [1/K].
    pub magnet_slope: f64,
    /// Temperature at which resistance and torque constant are as stated [°C].
    pub reference: f64,
    /// Temperature of the air [°C].
    pub air: f64,
}

impl Winding {
    /// One that never warms.
    pub const COLD: Self = Self {
        heat_capacity: f64::INFINITY,
        to_case: 1.0,
        case_heat_capacity: f64::INFINITY,
        to_air: 1.0,
        resistance_slope: 0.00393,
        magnet_slope: 0.0,
        reference: 25.0,
        air: 25.0,
    };
}

/// A gear train.
#[derive(Debug, Clone, PartialEq)]
pub struct Gear {
    /// Inertia of rotor and gears at the output [kg m²].
    pub armature: f64,
    /// Law of its friction.
    pub law: Law,
    /// The parameters of that law.
    pub friction: Vec<f64>,
}

/// A motor with all that lies between supply and output.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// Its motor.
    pub motor: Motor,
    /// What feeds it.
    pub supply: Supply,
    /// Its heat.
    pub winding: Winding,
    /// Its gear.
    pub gear: Gear,
}

/// What moves with the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Inertia beyond the gear's own [kg m²].
    pub inertia: f64,
    /// Torque on the output, positive towards positive angles [N m].
    pub torque: f64,
}

/// What a drive does.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DriveState {
    /// Angle of the output [rad].
    pub angle: f64,
    /// Its speed [rad/s].
    pub velocity: f64,
    /// Current of the motor [A].
    pub current: f64,
    /// Temperature of the winding [°C].
    pub winding_temperature: f64,
    /// Temperature of the case [°C].
    pub case_temperature: f64,
}

impl DriveState {
    /// At rest at `angle` [rad], all as warm as `temperature` [°C].
    pub fn resting(angle: f64, temperature: f64) -> Self {
        Self { angle, winding_temperature: temperature, case_temperature: temperature, ..Self::default() }
    }
}

impl Drive {
    /// Torque constant [N m/A] and resistance [ohm] at the temperature of the winding.
    pub fn warm(&self, temperature: f64) -> (f64, f64) {
        let above = temperature - self.winding.reference;
        let torque_constant = self.motor.torque_constant * (1.0 - self.winding.magnet_slope * above).max(0.0);
        (torque_constant, self.motor.resistance * (1.0 + self.winding.resistance_slope * above).max(0.1))
    }

    /// Lets `h` [s] pass with `duty`, -1 to 1, of the supply's voltage on the motor.
    ///
    /// The current is (d V - k ω)/(R + d² R_s): the supply gives d times the motor's current, and loses that much voltage.
    pub fn step(&self, state: &mut DriveState, duty: f64, load: Load, h: f64) {
        let (k, winding) = self.warm(state.winding_temperature);
        let resistance = winding + duty * duty * self.supply.resistance;
        let limit = self.motor.current_limit;
        let stalled = duty * self.supply.voltage / resistance;
        let current_at = |velocity: f64| (stalled - k / resistance * velocity).clamp(-limit, limit);
        let friction = self.gear.law.budget(
            &self.gear.friction,
            &Sliding {
                velocity: state.velocity,
                motor_torque: k * current_at(state.velocity),
                load_torque: load.torque,
            },
        );
        let slope = (self.gear.armature + load.inertia) / h;
        let others = slope * state.velocity + load.torque;
        let mut velocity = friction.velocity_after(others + k * stalled, slope + k * k / resistance);
        let mut current = stalled - k / resistance * velocity;
        if current.abs() > limit {
            current = limit.copysign(current);
            velocity = friction.velocity_after(others + k * current, slope);
        }
        state.velocity = velocity;
        state.angle += velocity * h;
        state.current = current;
        let heat = &self.winding;
        let out = (state.winding_temperature - state.case_temperature) / heat.to_case;
        let lost = (state.case_temperature - heat.air) / heat.to_air;
        state.winding_temperature += h * (winding * current * current - out) / heat.heat_capacity;
        state.case_temperature += h * (out - lost) / heat.case_heat_capacity;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::CoulombViscous;

    fn drive() -> Drive {
        Drive {
            motor: Motor { torque_constant: 0.4, resistance: 3.0, current_limit: f64::INFINITY },
            supply: Supply { voltage: 7.0, resistance: 0.0 },
            winding: Winding::COLD,
            gear: Gear {
                armature: 2e-3,
                law: Law::CoulombViscous(CoulombViscous),
                friction: vec![0.02, 0.005],
            },
        }
    }

    const FREE: Load = Load { inertia: 0.0, torque: 0.0 };

    #[test]
    fn free_speed_balances_back_emf_and_friction() {
        let (drive, mut state) = (drive(), DriveState::resting(0.0, 25.0));
        for _ in 0..3000 {
            drive.step(&mut state, 1.0, FREE, 1e-3);
        }
        // k (V - k ω)/R = f_c + f_v ω.
        let exact = (0.4 * 7.0 / 3.0 - 0.02) / (0.4 * 0.4 / 3.0 + 0.005);
        assert!((state.velocity - exact).abs() < 1e-9, "{} {exact}", state.velocity);
    }

    #[test]
    fn motion_converges_to_the_exponential_with_the_first_order() {
        let drive = drive();
        let error = |h: f64| {
            let mut state = DriveState::resting(0.0, 25.0);
            for _ in 0..(0.02 / h).round() as usize {
                drive.step(&mut state, 1.0, FREE, h);
            }
            let slope: f64 = 0.4 * 0.4 / 3.0 + 0.005;
            let exact = (0.4 * 7.0 / 3.0 - 0.02) / slope * (1.0 - (-slope * 0.02 / 2e-3).exp());
            (state.velocity - exact).abs()
        };
        let ratio = error(1e-4) / error(5e-5);
        assert!((ratio - 2.0).abs() < 0.05, "{ratio}");
    }

    #[test]
    fn current_is_limited_and_the_supply_sags() {
        let mut drive = drive();
        let stalled = |drive: &Drive| {
            let mut state = DriveState::resting(0.0, 25.0);
            drive.step(&mut state, 0.5, Load { inertia: 1e9, torque: 0.0 }, 1e-3);
            state.current
        };
        assert!((stalled(&drive) - 3.5 / 3.0).abs() < 1e-9);
        drive.supply.resistance = 2.0;
        // The bus carries half the current: V = 7 - 2 · 0.5 i, and 0.5 V = 3 i.
        assert!((stalled(&drive) - 1.0).abs() < 1e-9);
        drive.motor.current_limit = 0.6;
        assert_eq!(stalled(&drive), 0.6);
    }

    #[test]
    fn winding_warms_to_the_balance_of_losses_and_flow() {
        let mut drive = drive();
        drive.winding = Winding { heat_capacity: 2.0, to_case: 5.0, magnet_slope: 1e-3, ..Winding::COLD };
        drive.motor.current_limit = 0.8;
        let mut state = DriveState::resting(0.0, 25.0);
        for _ in 0..200_000 {
            drive.step(&mut state, 0.7, Load { inertia: 1e9, torque: 0.0 }, 1e-3);
        }
        // T = 25 + 5 R(T) i², R linear in T; the case never warms.
        let heat = 5.0 * 3.0 * 0.64;
        let exact = heat / (1.0 - heat * 0.00393);
        assert!((state.winding_temperature - 25.0 - exact).abs() < 1e-6, "{}", state.winding_temperature);
        let (torque_constant, resistance) = drive.warm(25.0 + exact);
        assert!((torque_constant - 0.4 * (1.0 - 1e-3 * exact)).abs() < 1e-12);
        assert!((resistance - 3.0 * (1.0 + 0.00393 * exact)).abs() < 1e-12);
    }
}
