//! Registers that arms read of their servos: positions of the leader; all measurements and the torque state
//! of the follower.
//!
//! Both are contiguous in every control table, so that no indirect addresses are needed, which differ between servos.

use super::model::{EffortRegister, ServoModel};
use super::{ServoBus, xl430};
use crate::Result;

/// From the present PWM to the present temperature.
const MEASURED_BYTES: usize = 23;
/// From the torque switch to the hardware errors.
const STATUS_BYTES: usize = 7;

/// Measurements of one servo of the follower.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmServoSample {
    /// Part of the supply voltage on the motor, -1 to 1 [-].
    pub pwm: f64,
    /// Register of load or current, see [`ArmServoSample::effort`].
    effort: i16,
    /// Speed of the output [rad/s].
    pub velocity: f64,
    /// Position of the output [ticks].
    pub position: i32,
    /// Supply voltage [V].
    pub voltage: f64,
    /// Temperature [°C].
    pub temperature: f64,
}

/// Whether a servo holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ServoStatus {
    /// Whether its motor is driven.
    pub torque_on: bool,
    /// Register of hardware errors; 0 if there is none.
    pub hardware_error: u8,
}

impl ArmServoSample {
    /// Effort of the motor, by its model: current [A], or load as a fraction of the stall torque [-].
    pub fn effort(&self, model: &ServoModel) -> f64 {
        let unit = match model.effort {
            EffortRegister::Current(unit) => unit,
            EffortRegister::Load => xl430::LOAD_UNIT,
        };
        unit * f64::from(self.effort)
    }

    /// Current of the motor [A]; `None` for a model that does not measure it.
    pub fn current(&self, model: &ServoModel) -> Option<f64> {
        matches!(model.effort, EffortRegister::Current(_)).then(|| self.effort(model))
    }

    fn read(bytes: &[u8]) -> Self {
        let half = |at: usize| i16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let word = |at: usize| i32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        Self {
            pwm: f64::from(half(0)) / f64::from(xl430::PWM_MAX),
            effort: half(2),
            velocity: xl430::VELOCITY_UNIT * f64::from(word(4)),
            position: word(8),
            voltage: xl430::VOLTAGE_UNIT * f64::from(half(20)),
            temperature: f64::from(bytes[22]),
        }
    }
}

impl ServoBus {
    /// Makes the servos of a leader ready: without torque, answering at once.
    ///
    /// # Errors
    /// `Bus` naming the servo and the register.
    pub fn configure_passive(&mut self) -> Result<()> {
        for id in self.ids.clone() {
            for (register, value) in
                [(xl430::TORQUE_ENABLE, 0), (xl430::RETURN_DELAY, 0), (xl430::STATUS_RETURN, 2)]
            {
                self.write(id, register, value)?;
            }
        }
        Ok(())
    }

    /// Reads the positions of all servos [ticks]; `None` as [`ServoBus::read_servos`].
    ///
    /// # Errors
    /// As [`ServoBus::read_servos`].
    pub fn read_positions(&mut self, positions: &mut [Option<i32>]) -> Result<()> {
        self.sync_read(xl430::PRESENT_POSITION.address, 4, positions, |bytes| {
            i32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
        })
    }

    /// Reads all that the servos measure; `None` as above.
    ///
    /// # Errors
    /// As [`ServoBus::read_servos`].
    pub fn read_measured(&mut self, samples: &mut [Option<ArmServoSample>]) -> Result<()> {
        self.sync_read(xl430::PRESENT_PWM.address, MEASURED_BYTES, samples, ArmServoSample::read)
    }

    /// Reads whether the servos still hold; `None` as above.
    ///
    /// # Errors
    /// As [`ServoBus::read_servos`].
    pub fn read_status(&mut self, status: &mut [Option<ServoStatus>]) -> Result<()> {
        self.sync_read(xl430::TORQUE_ENABLE.address, STATUS_BYTES, status, |bytes| ServoStatus {
            torque_on: bytes[0] == 1,
            hardware_error: bytes[6],
        })
    }
}
