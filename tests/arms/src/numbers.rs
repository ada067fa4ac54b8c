//! Dual and complex numbers: derivatives to the last digits, to compare with.

use std::ops::{Add, Mul, Neg, Sub};

use hysteron_arm_dynamics::Scalar;
use hysteron_base::lanes::LANES;

/// x + ε dx, ε² = 0.
#[derive(Debug, Clone, Copy)]
pub struct Dual {
    /// Value.
    pub x: f64,
    /// Derivative.
    pub dx: f64,
}

/// x + i y.
#[derive(Debug, Clone, Copy)]
pub struct Complex {
    /// Real part.
    pub x: f64,
    /// Imaginary part.
    pub y: f64,
}

macro_rules! linear {
    ($number:ident, $a:ident, $b:ident) => {
        impl Add for $number {
            type Output = Self;
            fn add(self, other: Self) -> Self {
                Self { $a: self.$a + other.$a, $b: self.$b + other.$b }
            }
        }
        impl Sub for $number {
            type Output = Self;
            fn sub(self, other: Self) -> Self {
                Self { $a: self.$a - other.$a, $b: self.$b - other.$b }
            }
        }
        impl Neg for $number {
            type Output = Self;
            fn neg(self) -> Self {
                Self { $a: -self.$a, $b: -self.$b }
            }
        }
    };
}

linear!(Dual, x, dx);
linear!(Complex, x, y);

impl Mul for Dual {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self { x: self.x * other.x, dx: self.x * other.dx + self.dx * other.x }
    }
}

impl Mul for Complex {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self { x: self.x * other.x - self.y * other.y, y: self.x * other.y + self.y * other.x }
    }
}

impl Scalar for Dual {
    fn values(self) -> [f64; LANES] {
        [self.x; LANES]
    }
    fn splat(self, value: f64) -> Self {
        Self { x: value, dx: 0.0 }
    }
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.x.sin_cos();
        (Self { x: sin, dx: cos * self.dx }, Self { x: cos, dx: -sin * self.dx })
    }
    fn recip(self) -> Self {
        let x = 1.0 / self.x;
        Self { x, dx: -x * x * self.dx }
    }
}

impl Scalar for Complex {
    fn values(self) -> [f64; LANES] {
        [self.x; LANES]
    }
    fn splat(self, value: f64) -> Self {
        Self { x: value, y: 0.0 }
    }
    fn sin_cos(self) -> (Self, Self) {
        let ((sin, cos), (sinh, cosh)) = (self.x.sin_cos(), (self.y.sinh(), self.y.cosh()));
        (Self { x: sin * cosh, y: cos * sinh }, Self { x: cos * cosh, y: -sin * sinh })
    }
    fn recip(self) -> Self {
        let square = self.x * self.x + self.y * self.y;
        Self { x: self.x / square, y: -self.y / square }
    }
}

/// Imaginary step: so small that its square vanishes compared with 1.
pub const STEP: f64 = 1e-40;

/// `values` with the imaginary step added to one of them.
pub fn stepped(values: &[f64], which: Option<usize>) -> Vec<Complex> {
    let step = |i| if Some(i) == which { STEP } else { 0.0 };
    values.iter().enumerate().map(|(i, x)| Complex { x: *x, y: step(i) }).collect()
}
