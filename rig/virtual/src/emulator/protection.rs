//! When a servo finds itself overloaded, too hot, or badly supplied.

use super::table::ControlTable;
use hysteron_rig::bus::xl430::{self, error_bit};

/// Load that a servo cannot bear for long, as part of its stall torque [-].
const HIGH_LOAD: f64 = 0.9;
/// How long it bears that [s]. The manual gives neither number; both are of the order that servos show.
const BEARABLE_TIME: f64 = 1.5;

/// Inputs of a servo's protection.
#[derive(Debug, Clone, Copy)]
pub(super) struct Readings {
    /// Now [s].
    pub time: f64,
    /// Part of the stall torque, -1 to 1 [-].
    pub load: f64,
    /// Of the motor [°C].
    pub temperature: f64,
    /// Of the supply [V].
    pub voltage: f64,
}

/// State of a servo's protection since power-on.
#[derive(Debug, Clone, Default)]
pub(super) struct Protection {
    /// Since when the load has been high [s].
    strained_since: Option<f64>,
    /// Errors that a fault put here; reported once.
    forced: u8,
    /// Heat that a fault adds [°C], and until when [s].
    heat: Option<(f64, f64)>,
}

impl Protection {
    /// Errors present now, as bits of the register.
    pub fn errors(&mut self, readings: &Readings, table: &ControlTable) -> u8 {
        let limit = |register| f64::from(table.unsigned(register));
        let mut errors = std::mem::take(&mut self.forced);
        let volts = readings.voltage / xl430::VOLTAGE_UNIT;
        if volts < limit(xl430::MIN_VOLTAGE) - 0.5 || volts > limit(xl430::MAX_VOLTAGE) + 0.5 {
            errors |= error_bit::INPUT_VOLTAGE;
        }
        if readings.temperature > limit(xl430::TEMPERATURE_LIMIT) {
            errors |= error_bit::OVERHEATING;
        }
        if readings.load.abs() < HIGH_LOAD {
            self.strained_since = None;
        } else if readings.time - *self.strained_since.get_or_insert(readings.time) > BEARABLE_TIME {
            errors |= error_bit::OVERLOAD;
        }
        errors
    }

    /// Restarts with the load.
    pub fn rest(&mut self) {
        self.strained_since = None;
    }

    /// Reports these errors at the next look.
    pub fn force(&mut self, bits: u8) {
        self.forced |= bits;
    }

    /// Adds heat [°C] until that time [s].
    pub fn warm(&mut self, by: f64, until: f64) {
        self.heat = Some((by, until));
    }

    /// A temperature [°C] with the heat that a fault adds.
    pub fn warmed(&self, temperature: f64, time: f64) -> f64 {
        temperature + self.heat.filter(|(_, until)| time < *until).map_or(0.0, |(by, _)| by)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_rig::bus::model::XL430_W250;

    const FINE: Readings = Readings { time: 0.0, load: 0.0, temperature: 30.0, voltage: 12.0 };

    #[test]
    fn only_a_lasting_load_is_too_much() {
        let (table, mut protection) = (ControlTable::new(&XL430_W250, true), Protection::default());
        let mut at = |time, load| protection.errors(&Readings { time, load, ..FINE }, &table);
        assert_eq!(at(0.0, 1.0), 0);
        assert_eq!(at(1.4, -1.0), 0);
        assert_eq!(at(1.45, 0.5), 0);
        assert_eq!(at(1.5, 1.0), 0);
        assert_eq!(at(2.9, 1.0), 0);
        assert_eq!(at(3.1, 0.95), error_bit::OVERLOAD);
    }

    #[test]
    fn heat_and_voltage_are_watched_by_the_limits_in_the_table() {
        let (mut table, mut protection) = (ControlTable::new(&XL430_W250, true), Protection::default());
        assert_eq!(protection.errors(&FINE, &table), 0);
        let hot = Readings { temperature: 73.0, ..FINE };
        assert_eq!(protection.errors(&hot, &table), error_bit::OVERHEATING);
        for voltage in [5.0, 14.2] {
            let readings = Readings { voltage, ..FINE };
            assert_eq!(protection.errors(&readings, &table), error_bit::INPUT_VOLTAGE);
        }
        table.set(xl430::MIN_VOLTAGE, 125);
        assert_eq!(protection.errors(&FINE, &table), error_bit::INPUT_VOLTAGE);
    }
}
