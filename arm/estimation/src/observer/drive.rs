//! Torque of a motor from what its drive reports.

/// How the torque of a joint's motor is found, at the joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MotorTorque {
    /// τ = k_t i + b: ID-Linear and GMO-linear of Dou et al. (NeuralActuator), calibrated on free motion.
    Current {
        /// k_t, gear included [N m/A].
        torque_constant: f64,
        /// b [N m].
        offset: f64,
    },
    /// τ = k_t (V · pwm − k_t q̇)/R: the torque of a servo whose PWM is known, without a current sensor.
    Pwm {
        /// k_t, gear included; back EMF per speed too [N m/A], [V s/rad].
        torque_constant: f64,
        /// R [Ω].
        resistance: f64,
    },
}

/// Readings of one joint's drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveReading {
    /// [A].
    pub current: f64,
    /// Of the supply [V].
    pub voltage: f64,
    /// Duty, −1 to 1 [-].
    pub pwm: f64,
    /// Speed of the joint [rad/s].
    pub velocity: f64,
}

impl MotorTorque {
    /// Torque at the joint [N m].
    pub fn at(&self, reading: &DriveReading) -> f64 {
        match *self {
            Self::Current { torque_constant, offset } => torque_constant * reading.current + offset,
            Self::Pwm { torque_constant, resistance } => {
                torque_constant * (reading.voltage * reading.pwm - torque_constant * reading.velocity)
                    / resistance
            }
        }
    }
}
