//! Calibration: from ticks to strokes and from the tracker's frame to the robot's, dated, and bound to its servos.
//!
//! CoReAct paper, section III: an affine map per channel. Its slope is the pulley (2 pi r per turn, with the direction
//! that winds); its zero is where the tendon carries its pretension at rest. A servo counts its turns only while it
//! has power, so a calibration knows the zero within its turn, and [`RigCalibration::unwrapped`] finds the turn again.

mod file;
mod procedure;

use crate::bus::model::XL430_W250;
use crate::bus::registers::StoredRegisters;
use crate::bus::{RegisterBaseline, ServoReport, differences, xl430};
use crate::config::{RigConfig, WindingDirection};
use crate::tracker::Registration;
use crate::{Error, Result};
pub use procedure::calibrate;
use std::f64::consts::TAU;

/// Result of a calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct RigCalibration {
    /// When, as RFC 3339 in UTC.
    pub date: String,
    /// Name of the rig.
    pub rig: String,
    /// One per tendon, in the order of strokes.
    pub channels: Vec<ChannelMap>,
    /// From the tracker's frame to the robot's, if there is a tracker.
    pub registration: Option<Registration>,
    /// RMS angle that the registration leaves [rad].
    pub registration_residual: f64,
    /// Stored register values of each servo, in the order of the channels; empty for a calibration without
    /// registers: one from before they were stored, or of a simulated rig, which has none.
    pub registers: Vec<StoredRegisters>,
}

/// From the ticks of one servo to the stroke of its tendon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelMap {
    /// Id of the servo.
    pub servo_id: u8,
    /// Its model number.
    pub model: u16,
    /// Ticks of a turn.
    pub ticks_per_turn: i32,
    /// Radius at which the tendon lies on its pulley [m].
    pub pulley_radius: f64,
    /// Which way it winds.
    pub winds: WindingDirection,
    /// Where the stroke is zero [ticks].
    pub zero: i32,
    /// Stroke at which the tendon goes slack [m]; below zero where there is pretension.
    pub slack_end: f64,
}

impl ChannelMap {
    /// Stroke of a tick, signed [m]: how much tendon a tick winds up.
    pub fn stroke_per_tick(&self) -> f64 {
        self.winds.sign() * TAU * self.pulley_radius / f64::from(self.ticks_per_turn)
    }

    /// Stroke at a position [m].
    pub fn stroke(&self, ticks: i32) -> f64 {
        (f64::from(ticks) - f64::from(self.zero)) * self.stroke_per_tick()
    }

    /// Position nearest to a stroke [ticks].
    pub fn ticks(&self, stroke: f64) -> i32 {
        self.zero.saturating_add((stroke / self.stroke_per_tick()).round() as i32)
    }
}

impl RigCalibration {
    /// Refuses servos and tendons that are not those that were calibrated.
    ///
    /// # Errors
    /// `Bus` naming everything that differs.
    pub fn check(&self, rig: &RigConfig, servos: &[ServoReport]) -> Result<()> {
        let mut wrong = Vec::new();
        let ids: Vec<u8> = self.channels.iter().map(|channel| channel.servo_id).collect();
        if ids != rig.ids() {
            wrong.push(format!("expected servos {ids:?}, got {:?} in the rig file", rig.ids()));
        }
        for (k, (channel, tendon)) in self.channels.iter().zip(&rig.tendons).enumerate() {
            if channel.pulley_radius != tendon.pulley_radius || channel.winds != tendon.winds {
                wrong.push(format!("tendon {}: its pulley or direction is another in the rig file", k + 1));
            }
        }
        for channel in &self.channels {
            match servos.iter().find(|servo| servo.id == channel.servo_id) {
                None => wrong.push(format!("servo {} is not on the bus", channel.servo_id)),
                Some(servo) if servo.model != channel.model => wrong.push(format!(
                    "servo {}: expected model {}, got {}",
                    servo.id, channel.model, servo.model
                )),
                Some(_) => {}
            }
        }
        for (channel, known) in self.channels.iter().zip(&self.registers) {
            let there = servos.iter().find(|servo| servo.id == channel.servo_id);
            if let Some(servo) = there.filter(|servo| !servo.registers.is_empty()) {
                let different = differences(servo.id, &XL430_W250, &servo.registers, Some(known));
                wrong.extend(different.iter().map(ToString::to_string));
            }
        }
        if wrong.is_empty() {
            return Ok(());
        }
        Err(Error::Bus(format!(
            "the calibration of {} is not for this rig:\n  {} (hint: run `hysteron rig calibrate`)",
            self.date,
            wrong.join("\n  ")
        )))
    }

    /// Reference with which the servos' registers are compared before they are driven with this calibration:
    /// the stored values, or the factory's values if it has none.
    pub fn register_baseline(&self) -> RegisterBaseline {
        if self.registers.is_empty() {
            return RegisterBaseline::Factory;
        }
        let of = format!("as the calibration of {} stored them", self.date);
        RegisterBaseline::Known { of, servos: self.registers.clone() }
    }

    /// The same calibration with every zero moved by whole turns to where it is nearest to `positions` [ticks].
    ///
    /// A servo that lost power counts from the turn it woke up in. The strokes of a run stay within half a turn of
    /// rest, where this is unambiguous.
    pub fn unwrapped(&self, positions: &[i32]) -> Self {
        let mut moved = self.clone();
        for (channel, position) in moved.channels.iter_mut().zip(positions) {
            let away = f64::from(*position) - f64::from(channel.zero);
            let turns = (away / f64::from(channel.ticks_per_turn)).round() as i64;
            let moved = i64::from(channel.zero) + turns * i64::from(channel.ticks_per_turn);
            // A servo at the end of all numbers has its last zero within them.
            channel.zero = i32::try_from(moved).unwrap_or(channel.zero);
        }
        moved
    }

    /// Strokes at these positions [m].
    pub fn strokes_into(&self, positions: &[i32], strokes: &mut [f64]) {
        for ((channel, position), stroke) in self.channels.iter().zip(positions).zip(strokes) {
            *stroke = channel.stroke(*position);
        }
    }
}

/// A provisional calibration: zero where the servos are. For the search of the true one.
pub(crate) fn provisional(rig: &RigConfig, positions: &[i32]) -> RigCalibration {
    let channels = rig.tendons.iter().zip(positions).map(|(tendon, position)| ChannelMap {
        servo_id: tendon.servo_id,
        model: XL430_W250.number,
        ticks_per_turn: xl430::TICKS_PER_TURN,
        pulley_radius: tendon.pulley_radius,
        winds: tendon.winds,
        zero: *position,
        slack_end: 0.0,
    });
    RigCalibration {
        date: String::new(),
        rig: rig.name.clone(),
        channels: channels.collect(),
        registration: None,
        registration_residual: 0.0,
        registers: Vec::new(),
    }
}

#[cfg(test)]
mod tests;
