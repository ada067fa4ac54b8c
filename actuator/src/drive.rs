//! A geared DC motor: what turns its output, how warm it gets, and what the registers of its position loop mean.
//!
//! The speed is found implicitly in every step, so that back EMF never makes a step unstable and friction holds exactly.

use hysteron_base::BadInput;

use crate::law::{JointFriction, Law, LoadDependent, Sliding};
use crate::motor::{Bridge, Motor, MotorLine, Supply, Winding};
use crate::number::Real;
use crate::position_loop::LoopSpec;

/// Parameters of the largest law of [`Drive::check_load_friction`], m4.
const MAX_PARAMETERS: usize = 7;

/// A gear train.
#[derive(Debug, Clone, PartialEq)]
pub struct Gear {
    /// Inertia of rotor and gears at the output [kg m²].
    pub armature: f64,
    /// How far the output turns from one flank to the other while the rotor is at rest [rad].
    pub backlash: f64,
    /// Law of its friction.
    pub law: Law,
    /// The parameters of that law.
    pub friction: Vec<f64>,
}

/// A motor with all that lies between command and output.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// Its motor.
    pub motor: Motor,
    /// Its supply.
    pub supply: Supply,
    /// Its heat.
    pub winding: Winding,
    /// Its gear.
    pub gear: Gear,
    /// Its position loop.
    pub position_loop: LoopSpec,
}

/// Load that moves with the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveLoad {
    /// Inertia beyond the gear's own [kg m²].
    pub inertia: f64,
    /// Torque on the output, positive towards positive angles [N m].
    pub torque: f64,
}

impl DriveLoad {
    /// A torque alone [N m].
    pub fn torque(torque: f64) -> Self {
        Self { inertia: 0.0, torque }
    }
}

/// State of a drive.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DriveState {
    /// Angle of the output, where the encoder is [rad].
    pub angle: f64,
    /// Its speed [rad/s].
    pub velocity: f64,
    /// How far the output is ahead of the middle of the backlash, at most half of it either way [rad].
    pub lead: f64,
    /// Speed of the rotor, as the output has it while flanks touch [rad/s].
    pub rotor_velocity: f64,
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

/// A mass in one step: how it resists a change of speed, and the speed that it brings along.
#[derive(Clone, Copy)]
struct StepInertia {
    /// Over the step [N m s/rad].
    slope: f64,
    /// Over the step [N m].
    momentum: f64,
}

impl Drive {
    /// Stiffness of the position loop with gain `p`: torque per angle [N m/rad].
    pub fn stiffness(&self, p: u16) -> f64 {
        let duty_per_radian = self.position_loop.duty_per_radian(f64::from(p));
        duty_per_radian * self.motor.stall_torque * self.supply.voltage / self.motor.rated_voltage
    }

    /// Current of the motor where `bridge` meets `voltage` at the drive [V], i = (d V - k_t ω)/R within the drive's limit, for a speed of
    /// the output [rad/s] and a temperature of the winding [°C]; negative where it brakes [A].
    ///
    /// ```
    /// use hysteron_actuator::{Bridge, CatalogueDrive};
    ///
    /// let drive = CatalogueDrive::named("xl430-w250").unwrap().drive;
    /// let stalled = drive.current(Bridge::Driven(0.5), 12.0, (0.0, drive.winding.reference));
    /// assert!((stalled - 0.5 * 12.0 / drive.motor.resistance()).abs() < 1e-12);
    /// ```
    pub fn current(&self, bridge: Bridge, voltage: f64, (speed, temperature): (f64, f64)) -> f64 {
        // What the supply loses on its way is lost before the voltage is measured.
        let supply = Supply { voltage, resistance: 0.0 };
        MotorLine::new(&self.motor, &supply, self.winding.factors(temperature), bridge).current(speed)
    }

    /// Lets `h` [s] pass.
    ///
    /// While flanks touch, rotor and load are one mass; between them the rotor turns alone, and the load goes where it is pushed. Where
    /// they meet they go on together, and the momentum stays.
    pub fn step(&self, state: &mut DriveState, bridge: Bridge, load: DriveLoad, h: f64) {
        let factors = self.winding.factors(state.winding_temperature);
        let line = MotorLine::new(&self.motor, &self.supply, factors, bridge);
        if self.gear.backlash > 0.0 {
            self.turn_with_backlash(state, &line, load, h);
        } else {
            let slope = (self.gear.armature + load.inertia) / h;
            let together = StepInertia { slope, momentum: slope * state.velocity };
            state.velocity = self.velocity_after(&line, state.velocity, together, load.torque);
            state.rotor_velocity = state.velocity;
        }
        state.angle += state.velocity * h;
        state.current = line.current(state.rotor_velocity);
        let temperatures = [state.winding_temperature, state.case_temperature];
        [state.winding_temperature, state.case_temperature] = self.warmed(temperatures, state.current, h);
    }

    /// Temperatures of winding and case after `h` [s] in which the motor follows as [`Self::follow`] has it, from those before [°C].
    pub fn warmed_by_following(
        &self,
        p: f64,
        error_and_speed: [f64; 2],
        temperatures: [f64; 2],
        h: f64,
    ) -> [f64; 2] {
        let [_, current] = self.follow(p, error_and_speed, temperatures[0]);
        self.warmed(temperatures, current, h)
    }

    /// Temperatures of winding and case after `h` [s] with this current [A], from those before [°C].
    fn warmed(&self, [winding, case]: [f64; 2], current: f64, h: f64) -> [f64; 2] {
        let heat = &self.winding;
        let (out, lost) = ((winding - case) / heat.to_case, (case - heat.air) / heat.to_air);
        let resistance = self.motor.resistance() * heat.factors(winding).1;
        [
            winding + h * (resistance * current * current - out) / heat.heat_capacity,
            case + h * (out - lost) / heat.case_heat_capacity,
        ]
    }

    /// Torque [N m] and current [A] of the motor under a position loop with the proportional gain `p` of its register alone, at an error of
    /// position [rad], a speed [rad/s] and a temperature of the winding [°C].
    pub fn follow<T: Real>(&self, p: f64, [error, speed]: [T; 2], temperature: f64) -> [T; 2] {
        let duty = (T::from(self.position_loop.duty_per_radian(p)) * error).clamp(-1.0, 1.0);
        let factors = self.winding.factors(temperature);
        let line = MotorLine::driven(&self.motor, &self.supply, factors, duty);
        [line.torque(speed), line.current(speed)]
    }

    /// Dry friction of the unloaded gear at a speed [N m], and its growth per torque through the gear, |load − motor| [-], where the law
    /// is of that form: [`Self::check_load_friction`].
    pub fn load_friction<T: Real>(&self, speed: T) -> [T; 2] {
        let mut parameters = [T::from(0.0); MAX_PARAMETERS];
        let n = self.gear.friction.len().min(MAX_PARAMETERS);
        for (to, value) in parameters.iter_mut().zip(&self.gear.friction) {
            *to = T::from(*value);
        }
        let under = |torque: f64| {
            let [motor_torque, load_torque] = [0.0, torque].map(T::from);
            let at = Sliding { velocity: speed, motor_torque, load_torque };
            self.gear.law.budget(&parameters[..n], &at).dry
        };
        let alone = under(0.0);
        [alone, under(1.0) - alone]
    }

    /// Viscous friction of the gear [N m s/rad].
    pub fn viscous(&self) -> f64 {
        self.gear.law.budget(&self.gear.friction, &Sliding::at(0.0)).viscous
    }

    /// # Errors
    /// `BadInput` where dry friction is no function of the speed that grows with |load − motor|, or the gear has backlash.
    pub fn check_load_friction(&self) -> Result<(), BadInput> {
        use LoadDependent::{M1, M2, M3, M4};
        let is_one = match &self.gear.law {
            Law::CoulombViscous(_) | Law::Stribeck(_) => true,
            Law::LoadDependent(law) => [M1, M2, M3, M4].contains(law),
            _ => false,
        };
        if !is_one {
            let expected = "coulomb-viscous, stribeck, or m1 to m4";
            return Err(BadInput::new("gear.law", expected, "another"));
        }
        if self.gear.backlash > 0.0 {
            let found = self.gear.backlash.to_degrees().to_string();
            return Err(BadInput::new("gear.backlash_deg", "a drive without backlash", found)
                .hint("a copy of the file without it follows as if there were none"));
        }
        Ok(())
    }

    /// Speeds of rotor and output after a step, and where between the flanks they then are.
    fn turn_with_backlash(&self, state: &mut DriveState, line: &MotorLine, load: DriveLoad, h: f64) {
        let half = 0.5 * self.gear.backlash;
        let slope = self.gear.armature / h;
        let alone = StepInertia { slope, momentum: slope * state.rotor_velocity };
        let rotor = self.velocity_after(line, state.rotor_velocity, alone, 0.0);
        let output = match load.inertia > 0.0 {
            true => state.velocity + h * load.torque / load.inertia,
            // Without mass it goes to the flank that it is pushed against, and stays where nothing pushes.
            false if load.torque == 0.0 => 0.0,
            false => f64::INFINITY.copysign(load.torque),
        };
        let lead = state.lead + h * (output - rotor);
        if lead.abs() <= half {
            (state.lead, state.rotor_velocity, state.velocity) = (lead, rotor, output);
            return;
        }
        let flank = half.copysign(lead);
        let closing = (flank - state.lead) / h;
        let of_load = load.inertia / h;
        let together = StepInertia {
            slope: slope + of_load,
            momentum: slope * state.rotor_velocity + of_load * (state.velocity - closing),
        };
        let rotor = self.velocity_after(line, state.rotor_velocity, together, load.torque);
        (state.lead, state.rotor_velocity, state.velocity) = (flank, rotor, rotor + closing);
    }

    /// Speed after a step in which the rotor, with what moves with it, sticks, starts, slides or stops; `before` is its speed at the
    /// beginning [rad/s].
    ///
    /// Dry friction changes with speed, and may with the motor's torque: it is taken at the speed found with that of the beginning. From
    /// standstill, and where the direction changes, the beginning is breakaway.
    fn velocity_after(&self, line: &MotorLine, before: f64, mass: StepInertia, load_torque: f64) -> f64 {
        let push = mass.momentum + line.stalled + load_torque;
        let with_friction_at = |velocity: f64| {
            let at = Sliding { velocity, motor_torque: line.torque(velocity), load_torque };
            let friction = self.gear.law.budget(&self.gear.friction, &at);
            let free = friction.velocity_after(push, mass.slope + line.slope);
            let torque = line.stalled - line.slope * free;
            if torque.abs() <= line.limit {
                return free;
            }
            friction.velocity_after(mass.momentum + line.limit.copysign(torque) + load_torque, mass.slope)
        };
        let is_reversal = before * push < 0.0;
        let first = with_friction_at(if is_reversal { 0.0 } else { before });
        if first == 0.0 { first } else { with_friction_at(first) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Play;
    use crate::law::{CoulombViscous, SymmetricStribeck};

    fn drive() -> Drive {
        Drive {
            motor: Motor::new(0.4, 3.0, 7.0),
            supply: Supply { voltage: 7.0, resistance: 0.0 },
            winding: Winding::COLD,
            gear: Gear {
                armature: 2e-3,
                backlash: 0.0,
                law: Law::CoulombViscous(CoulombViscous),
                friction: vec![0.02, 0.005],
            },
            position_loop: LoopSpec::XL430,
        }
    }

    const FULL: Bridge = Bridge::Driven(1.0);
    const FREE: DriveLoad = DriveLoad { inertia: 0.0, torque: 0.0 };
    const HELD: DriveLoad = DriveLoad { inertia: 1e9, torque: 0.0 };

    #[test]
    fn free_speed_balances_back_emf_and_friction() {
        let (drive, mut state) = (drive(), DriveState::resting(0.0, 25.0));
        for _ in 0..3000 {
            drive.step(&mut state, FULL, FREE, 1e-3);
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
                drive.step(&mut state, FULL, FREE, h);
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
            drive.step(&mut state, Bridge::Driven(0.5), HELD, 1e-3);
            state.current
        };
        assert!((stalled(&drive) - 3.5 / 3.0).abs() < 1e-9);
        drive.supply.resistance = 2.0;
        // The bus carries half the current: V = 7 - 2 · 0.5 i, and 0.5 V = 3 i.
        assert!((stalled(&drive) - 1.0).abs() < 1e-9);
        drive.motor.current_limit = 0.6;
        assert!((stalled(&drive) - 0.6).abs() < 1e-15);
    }

    #[test]
    fn a_shorted_motor_brakes_and_an_open_one_coasts() {
        let drive = drive();
        let after = |bridge: Bridge| {
            let mut state = DriveState { velocity: 5.0, ..DriveState::resting(0.0, 25.0) };
            drive.step(&mut state, bridge, FREE, 1e-3);
            (state.velocity, state.current)
        };
        // I (ω - 5)/h = - f_c - f_v ω, and also - k²/R ω.
        assert_eq!(after(Bridge::Open), ((10.0 - 0.02) / (2.0 + 0.005), 0.0));
        let (velocity, current) = after(Bridge::Driven(0.0));
        assert!((velocity - (10.0 - 0.02) / (2.0 + 0.005 + 0.16 / 3.0)).abs() < 1e-12);
        assert!((current + 0.4 / 3.0 * velocity).abs() < 1e-12);
    }

    #[test]
    fn winding_warms_to_the_balance_of_losses_and_flow() {
        let mut drive = drive();
        drive.winding = Winding { heat_capacity: 2.0, to_case: 5.0, magnet_slope: 1e-3, ..Winding::COLD };
        drive.motor.current_limit = 0.8;
        let mut state = DriveState::resting(0.0, 25.0);
        for _ in 0..200_000 {
            drive.step(&mut state, Bridge::Driven(0.7), HELD, 1e-3);
        }
        // T = 25 + 5 R(T) i², R linear in T; the case never warms.
        let heat = 5.0 * 3.0 * 0.64;
        let exact = heat / (1.0 - heat * 0.00393);
        assert!((state.winding_temperature - 25.0 - exact).abs() < 1e-6, "{}", state.winding_temperature);
        let (magnet, ohmic) = drive.winding.factors(25.0 + exact);
        assert!((magnet - (1.0 - 1e-3 * exact)).abs() < 1e-12);
        assert!((ohmic - (1.0 + 0.00393 * exact)).abs() < 1e-12);
    }

    #[test]
    fn joint_sticks_below_breakaway_and_slides_above() {
        let mut drive = drive();
        drive.gear.law = Law::Stribeck(SymmetricStribeck);
        drive.gear.friction = vec![6.17, 11.15 - 6.17, 0.5, 12.18];
        let after = |velocity: f64, torque: f64| {
            let mut state = DriveState { velocity, ..DriveState::resting(0.0, 25.0) };
            drive.step(&mut state, Bridge::Open, DriveLoad::torque(torque), 1e-3);
            state.velocity
        };
        assert_eq!(after(0.0, 11.1), 0.0);
        assert!(after(0.0, 11.2) > 0.0);
        // In motion less is needed.
        assert!(after(-2.0, -7.1) < 0.0);
        // A step never reverses a joint by friction alone.
        assert_eq!(after(2.5, 0.0), 0.0);
    }

    fn with_backlash(backlash: f64) -> Drive {
        let mut drive = drive();
        drive.gear.backlash = backlash;
        drive
    }

    #[test]
    fn free_output_behind_backlash_is_the_operator_of_play() {
        let drive = with_backlash(0.03);
        let mut state = DriveState::resting(0.0, 25.0);
        let (mut rotor, mut play, mut lost) = (0.0, Play::new(0.03, 0.0), 0.0f64);
        for k in 0..20_000 {
            let duty = 0.3 * (3e-3 * f64::from(k)).sin() + 0.2 * (7e-3 * f64::from(k)).cos();
            drive.step(&mut state, Bridge::Driven(duty), FREE, 1e-3);
            rotor += state.rotor_velocity * 1e-3;
            assert!((state.angle - play.follow(rotor)).abs() < 1e-12, "step {k}");
            lost = lost.max((rotor - state.angle).abs());
        }
        assert!(rotor.abs() > 0.0 && (lost - 0.015).abs() < 1e-12, "{lost}");
    }

    #[test]
    fn motion_of_the_backlash_is_lost_where_the_direction_turns() {
        let drive = with_backlash(0.02);
        let mut state = DriveState::resting(0.0, 25.0);
        let run = |state: &mut DriveState, duty: f64| drive.step(state, Bridge::Driven(duty), FREE, 1e-4);
        (0..5000).for_each(|_| run(&mut state, 0.2));
        let mut rotor_back = 0.0;
        let turned = state.angle;
        while state.rotor_velocity > 0.0 {
            run(&mut state, -0.2);
        }
        let reversed = state.angle;
        assert!(reversed > turned);
        while state.angle == reversed {
            run(&mut state, -0.2);
            rotor_back += -1e-4 * state.rotor_velocity;
        }
        // The step in which the flanks meet goes on beyond the gap.
        let overshoot = 1e-4 * state.rotor_velocity.abs();
        assert!((0.02..=0.02 + overshoot).contains(&rotor_back), "{rotor_back}");
    }

    #[test]
    fn flanks_that_meet_keep_the_momentum_and_a_pushed_load_loses_no_motion() {
        let mut drive = with_backlash(0.01);
        drive.gear.friction = vec![0.0, 0.0];
        let load = DriveLoad { inertia: 6e-3, torque: 0.0 };
        let mut state = DriveState { rotor_velocity: 1.0, ..DriveState::resting(0.0, 25.0) };
        (0..3).for_each(|_| drive.step(&mut state, Bridge::Open, load, 1e-3));
        assert_eq!((state.velocity, state.rotor_velocity), (0.0, 1.0));
        (0..10).for_each(|_| drive.step(&mut state, Bridge::Open, load, 1e-3));
        // 2e-3 kg m² at 1 rad/s take 6e-3 kg m² along.
        assert!((state.velocity - 0.25).abs() < 1e-12 && state.velocity == state.rotor_velocity, "{state:?}");
        assert_eq!(state.lead, -0.005);
        // A load that pushes stays at its flank, whichever way the motor goes.
        let pushed = DriveLoad { torque: -0.3, ..load };
        for k in 0..4000 {
            drive.step(&mut state, Bridge::Driven(0.3 * (4e-3 * f64::from(k)).sin()), pushed, 1e-3);
            assert!(state.lead == -0.005 && (state.velocity - state.rotor_velocity).abs() < 1e-9, "step {k}");
        }
    }

    #[test]
    fn torque_and_friction_as_separate_outputs_are_those_of_a_step() {
        let mut drive = crate::CatalogueDrive::named("xl330-m288").expect("of the catalogue").drive;
        drive.check_load_friction().expect("m4, no backlash");
        // So heavy that a step changes no speed, and every torque is that of its beginning.
        let (inertia, h, gain) = (1e6, 1e-3, 200.0);
        for (error, speed, load) in [(0.1, 0.4, 0.1), (-0.3, -2.0, 0.05), (2.0, 0.3, -0.2), (0.2, -0.6, -0.1)]
        {
            let temperature = 60.0;
            let [torque, current] = drive.follow(gain, [error, speed], temperature);
            let [alone, share] = drive.load_friction(speed);
            let friction = (alone + share * (load - torque).abs()) * speed.signum() + drive.viscous() * speed;
            let duty = (drive.position_loop.duty_per_radian(gain) * error).clamp(-1.0, 1.0);
            let mut state = DriveState { velocity: speed, ..DriveState::resting(0.0, temperature) };
            let load = DriveLoad { inertia, torque: load };
            drive.step(&mut state, Bridge::Driven(duty), load, h);
            let whole = (state.velocity - speed) * (inertia + drive.gear.armature) / h;
            // A speed near 1 known to 1e-16 is a torque known to 1e-7.
            assert!((whole - (torque + load.torque - friction)).abs() < 1e-6, "{whole} {torque} {friction}");
            assert!((state.current - current).abs() < 1e-6, "{} {current}", state.current);
        }
        drive.gear.backlash = 0.01;
        assert_eq!(drive.check_load_friction().expect_err("backlash").place, "gear.backlash_deg");
    }
}
