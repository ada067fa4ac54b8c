//! The numbers that laws are written on: `f64`, and [`Dual`] for exact derivatives of the same formula.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number, or one with its derivative.
pub trait Real:
    Copy
    + std::fmt::Debug
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The number without its derivative.
    fn value(self) -> f64;
    /// A function of the number, from its value and its derivative there.
    fn map(self, value: f64, slope: f64) -> Self;

    /// |x|, whose derivative at zero counts as that from above.
    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }

    /// The nearest number from `least` to `most`, constant beyond them.
    fn clamp(self, least: f64, most: f64) -> Self {
        match self.value() {
            x if x < least => Self::from(least),
            x if x > most => Self::from(most),
            _ => self,
        }
    }

    /// eˣ.
    fn exp(self) -> Self {
        let exp = self.value().exp();
        self.map(exp, exp)
    }

    /// ln x.
    fn ln(self) -> Self {
        self.map(self.value().ln(), self.value().recip())
    }

    /// tanh x.
    fn tanh(self) -> Self {
        let tanh = self.value().tanh();
        self.map(tanh, 1.0 - tanh * tanh)
    }

    /// x to the power `exponent`, for x >= 0; zero at zero, with derivative zero.
    fn powf(self, exponent: Self) -> Self {
        if self.value() <= 0.0 { Self::from(0.0) } else { (self.ln() * exponent).exp() }
    }
}

impl Real for f64 {
    fn value(self) -> f64 {
        self
    }

    fn map(self, value: f64, _: f64) -> Self {
        value
    }
}

/// A number and its derivative by one variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual {
    /// The number.
    pub value: f64,
    /// Its derivative.
    pub slope: f64,
}

impl Dual {
    /// The variable itself.
    pub fn variable(value: f64) -> Self {
        Self { value, slope: 1.0 }
    }
}

impl From<f64> for Dual {
    fn from(value: f64) -> Self {
        Self { value, slope: 0.0 }
    }
}

impl Real for Dual {
    fn value(self) -> f64 {
        self.value
    }

    fn map(self, value: f64, slope: f64) -> Self {
        Self { value, slope: slope * self.slope }
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, slope: self.slope + other.slope }
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { value: self.value - other.value, slope: self.slope - other.slope }
    }
}

impl Mul for Dual {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self { value: self.value * other.value, slope: self.slope * other.value + self.value * other.slope }
    }
}

impl Div for Dual {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self { value, slope: (self.slope - value * other.slope) / other.value }
    }
}

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, slope: -self.slope }
    }
}
