//! Parameters of a fit: bounds, scale and prior.

use hysteron_base::{BadInput, Bounds};

/// How a parameter is spread between its bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParameterScale {
    /// Evenly.
    Linear,
    /// Evenly in its logarithm; both bounds are positive.
    Logarithmic,
}

/// Prior of a parameter: a normal distribution on the parameter's scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    /// Its middle [SI].
    pub center: f64,
    /// Its standard deviation, above 0 [SI]; on a logarithmic scale a factor above 1.
    pub width: f64,
}

/// A number to fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name in reports.
    pub name: String,
    /// Where the search begins, within the bounds [SI].
    pub start: f64,
    /// Where it may go [SI].
    pub bounds: Bounds,
    /// How it is spread between them.
    pub scale: ParameterScale,
    /// Its prior, if any.
    pub prior: Option<Prior>,
}

impl Parameter {
    /// Checks that the start lies within the bounds and that the scale can be taken.
    ///
    /// # Errors
    /// `BadInput` naming the parameter.
    pub fn check(&self) -> Result<(), BadInput> {
        let Bounds { min, max } = self.bounds;
        let is_interval = min.is_finite() && max.is_finite() && min < max;
        if !is_interval || (self.scale == ParameterScale::Logarithmic && min <= 0.0) {
            let expected = match self.scale {
                ParameterScale::Linear => "two finite numbers, the first smaller",
                ParameterScale::Logarithmic => "two finite positive numbers, the first smaller",
            };
            let place = format!("bounds of {}", self.name);
            return Err(BadInput::new(place, expected, format!("{min} to {max}")));
        }
        if !self.bounds.contains(self.start) {
            let place = format!("start of {}", self.name);
            return Err(BadInput::new(place, format!("{min} to {max}"), self.start.to_string())
                .hint("widen the bounds, or start elsewhere"));
        }
        Ok(())
    }

    /// Place to which it returns if the data does not determine it.
    pub fn home(&self) -> f64 {
        self.prior.map_or(self.start, |prior| prior.center)
    }

    /// Place between the bounds, 0 to 1.
    pub fn place(&self, value: f64) -> f64 {
        let (low, high) = (self.along(self.bounds.min), self.along(self.bounds.max));
        (self.along(value) - low) / (high - low)
    }

    /// Standard deviation of the prior, in places.
    pub fn prior_width(&self) -> Option<f64> {
        let range = self.along(self.bounds.max) - self.along(self.bounds.min);
        self.prior.map(|prior| self.along(prior.width) / range)
    }

    fn along(&self, value: f64) -> f64 {
        match self.scale {
            ParameterScale::Linear => value,
            ParameterScale::Logarithmic => value.ln(),
        }
    }

    /// The inverse of [`Self::place`]; the bounds themselves, without rounding, at 0 and 1.
    pub fn value(&self, place: f64) -> f64 {
        let Bounds { min, max } = self.bounds;
        match place {
            place if place <= 0.0 => return min,
            place if place >= 1.0 => return max,
            _ => {}
        }
        let value = match self.scale {
            ParameterScale::Linear => min + place * (max - min),
            ParameterScale::Logarithmic => (min.ln() + place * (max / min).ln()).exp(),
        };
        self.bounds.clamp(value)
    }

    /// Change of the value with its place.
    pub(crate) fn slope(&self, value: f64) -> f64 {
        match self.scale {
            ParameterScale::Linear => self.bounds.max - self.bounds.min,
            ParameterScale::Logarithmic => value * (self.bounds.max / self.bounds.min).ln(),
        }
    }
}
