//! Supply and heat within which servos are used.

use super::model::ServoModel;
use super::xl430;

/// Bounds within which servos are used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoBounds {
    /// Smallest supply voltage [V].
    pub voltage_min: f64,
    /// Largest supply voltage [V].
    pub voltage_max: f64,
    /// Largest temperature [°C].
    pub temperature_max: f64,
}

impl ServoBounds {
    /// As such a servo has them from the factory.
    pub fn of(model: &ServoModel) -> Self {
        let [voltage_min, voltage_max] = model.voltage.map(|units| xl430::VOLTAGE_UNIT * f64::from(units));
        Self { voltage_min, voltage_max, temperature_max: f64::from(model.temperature) }
    }

    /// Violated bound, as expected and found; `None` if voltage [V] and temperature [°C] are within.
    pub fn violation(&self, voltage: f64, temperature: f64) -> Option<String> {
        if temperature > self.temperature_max {
            let most = self.temperature_max;
            return Some(format!("temperature: expected at most {most} degrees C, got {temperature}"));
        }
        let is_supplied = (self.voltage_min..=self.voltage_max).contains(&voltage);
        let (least, most) = (self.voltage_min, self.voltage_max);
        (!is_supplied).then(|| format!("supply: expected {least} to {most} V, got {voltage:.1} V"))
    }
}
