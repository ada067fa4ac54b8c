//! The motor of a gear: a DC motor on a supply, its winding warm or cold, through a bridge that is driven or
//! open.

use crate::number::Real;

/// A DC motor, at the output of its gear, by its stall values at one voltage: so data sheets state it, and
/// the rest is proportional.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motor {
    /// Voltage that stall torque and stall current hold for [V].
    pub rated_voltage: f64,
    /// Torque of the stalled motor, of which friction takes its part, at the reference temperature [N m].
    pub stall_torque: f64,
    /// Current of the stalled motor [A].
    pub stall_current: f64,
    /// Torque that back EMF takes per speed while the voltage stays [N m s/rad].
    pub back_emf_damping: f64,
    /// Largest current that the drive allows; infinite where it limits none [A].
    pub current_limit: f64,
}

impl Motor {
    /// A motor whose torque per current k_t [N m/A] is its back EMF per speed too, with `resistance` R of winding and bridge [ohm], and
    /// without a limit of the current.
    pub fn new(torque_constant: f64, resistance: f64, rated_voltage: f64) -> Self {
        let stall_current = rated_voltage / resistance;
        Self {
            rated_voltage,
            stall_torque: torque_constant * stall_current,
            stall_current,
            back_emf_damping: torque_constant * torque_constant / resistance,
            current_limit: f64::INFINITY,
        }
    }

    /// Torque per current k_t at the reference temperature [N m/A].
    pub fn torque_constant(&self) -> f64 {
        self.stall_torque / self.stall_current
    }

    /// Resistance of winding and bridge R at the reference temperature [ohm].
    pub fn resistance(&self) -> f64 {
        self.rated_voltage / self.stall_current
    }

    /// The same with other constants, as [`Motor::new`] takes them.
    pub fn with_constants(self, torque_constant: f64, resistance: f64) -> Self {
        Self {
            current_limit: self.current_limit,
            ..Self::new(torque_constant, resistance, self.rated_voltage)
        }
    }
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

/// Least that temperature leaves of torque constant and resistance: the lines are not meant for what is beyond [-].
const MIN_FACTOR: f64 = 0.1;

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

    /// Torque constant and resistance at `temperature` [°C] over those at the reference [-].
    pub fn factors(&self, temperature: f64) -> (f64, f64) {
        let above = temperature - self.reference;
        (
            (1.0 - self.magnet_slope * above).max(MIN_FACTOR),
            (1.0 + self.resistance_slope * above).max(MIN_FACTOR),
        )
    }
}

/// Connection of motor and supply.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bridge {
    /// A duty, -1 to 1, of the supply's voltage; at zero the motor is shorted, and brakes.
    Driven(f64),
    /// Nothing: no current flows, as with the torque of a servo switched off.
    Open,
}

/// Torque of a motor over the speed of the output, in one step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MotorLine<T = f64> {
    /// Torque at standstill, before any limit [N m].
    pub stalled: T,
    /// By how much it falls with the speed [N m s/rad].
    pub slope: T,
    /// Largest torque that the current's limit allows [N m].
    pub limit: f64,
    /// Current per torque is `stall_current / stall_torque`, both at the winding's temperature [A, N m].
    per_torque: [f64; 2],
}

impl MotorLine {
    pub(crate) fn new(motor: &Motor, supply: &Supply, factors: (f64, f64), bridge: Bridge) -> Self {
        match bridge {
            Bridge::Driven(duty) => Self::driven(motor, supply, factors, duty),
            Bridge::Open => Self { stalled: 0.0, slope: 0.0, ..Self::driven(motor, supply, factors, 0.0) },
        }
    }
}

impl<T: Real> MotorLine<T> {
    /// Of a bridge with this duty, at the winding's factors of torque constant and resistance.
    pub(crate) fn driven(motor: &Motor, supply: &Supply, (magnet, ohmic): (f64, f64), duty: T) -> Self {
        let stall_torque = motor.stall_torque * magnet;
        // The supply gives d times the motor's current, and loses that much voltage: i = (d V - k ω)/(R + d² R_s).
        let lost = duty * duty * T::from(supply.resistance) / T::from(motor.resistance());
        let ohmic = T::from(ohmic) + lost;
        let share = duty * T::from(supply.voltage) / T::from(motor.rated_voltage);
        Self {
            stalled: share * T::from(stall_torque) / ohmic,
            slope: T::from(motor.back_emf_damping * magnet * magnet) / ohmic,
            limit: motor.current_limit * stall_torque / motor.stall_current,
            per_torque: [motor.stall_current, stall_torque],
        }
    }

    /// Torque at a speed [N m].
    pub(crate) fn torque(&self, velocity: T) -> T {
        (self.stalled - self.slope * velocity).clamp(-self.limit, self.limit)
    }

    /// Current at a speed [A].
    pub(crate) fn current(&self, velocity: T) -> T {
        let [stall_current, stall_torque] = self.per_torque;
        self.torque(velocity) / T::from(stall_torque) * T::from(stall_current)
    }
}
