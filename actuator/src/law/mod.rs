//! Laws of joint friction: the friction torque of a joint in steady motion, and its dependence on named
//! parameters.
//!
//! Each law is one formula over [`Real`], so its derivatives by speed and by every parameter are those of the formula itself.
//! A law splits friction into a dry part, a bound at standstill, and a viscous coefficient: a stepper needs both
//! ([`Budget::velocity_after`]), a regression their sum.

mod backdrive;
mod bristle;
mod capstan;
mod learned;
mod load;
mod steady;

use std::borrow::Cow;

use hysteron_base::BadInput;

use crate::number::{Dual, Real};

pub use backdrive::{HoldingRange, holding_range};
pub use bristle::Bristles;
pub use capstan::Capstan;
pub use learned::{LearnedMap, Monotonicity};
pub use load::LoadDependent;
pub use steady::{CoulombViscous, DirectedStribeck, PiecewiseLinear, SymmetricStribeck};

/// A joint in motion, input of a law of friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sliding<T = f64> {
    /// Speed [rad/s].
    pub velocity: T,
    /// Torque of the motor at the output of the gear, positive towards positive angles [N m].
    pub motor_torque: T,
    /// Torque that load and weight exert on the output, in the same sense [N m].
    pub load_torque: T,
}

impl Sliding {
    /// Without torques: for laws that know the speed alone.
    pub fn at(velocity: f64) -> Self {
        Self { velocity, motor_torque: 0.0, load_torque: 0.0 }
    }

    fn lift<T: Real>(self) -> Sliding<T> {
        let [velocity, motor_torque, load_torque] =
            [self.velocity, self.motor_torque, self.load_torque].map(T::from);
        Sliding { velocity, motor_torque, load_torque }
    }
}

/// Friction of a joint, split as a stepper needs it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget<T = f64> {
    /// Size of the part that does not vanish at standstill: against motion, or a bound at standstill [N m].
    pub dry: T,
    /// Viscous coefficient [N m s/rad].
    pub viscous: T,
}

impl Budget {
    /// Torque against motion at `velocity` [N m]; 0 at standstill.
    pub fn torque(&self, velocity: f64) -> f64 {
        let sign = if velocity == 0.0 { 0.0 } else { velocity.signum() };
        self.dry * sign + self.viscous * velocity
    }

    /// Speed after a step, implicitly: exactly zero where friction can hold the joint [rad/s].
    ///
    /// `slope` is inertia over step plus other damping [N m s/rad]; `drive` is momentum over step plus the torques that do
    /// not depend on the new speed [N m].
    pub fn velocity_after(&self, drive: f64, slope: f64) -> f64 {
        ((drive.abs() - self.dry).max(0.0) / (slope + self.viscous)).copysign(drive)
    }
}

/// A parameter of a law.
#[derive(Debug, Clone, PartialEq)]
pub struct LawParameter {
    /// Name with its unit, as in files.
    pub name: Cow<'static, str>,
    /// Least and greatest value that makes sense for a joint whose friction is of the order of 1 N m [SI].
    pub bounds: [f64; 2],
    /// Quantity that its bounds scale with.
    pub scales_with: ScalesWith,
}

/// Quantity that the bounds of a parameter are relative to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScalesWith {
    /// The torques of the joint: 1 is the largest.
    Torque,
    /// Its speeds: 1 is the largest.
    Speed,
    /// The largest torque over the largest speed.
    TorquePerSpeed,
    /// Nothing.
    Nothing,
}

const fn torque(name: &'static str) -> LawParameter {
    LawParameter { name: Cow::Borrowed(name), bounds: [0.0, 2.0], scales_with: ScalesWith::Torque }
}

const fn damping(name: &'static str) -> LawParameter {
    LawParameter { name: Cow::Borrowed(name), bounds: [0.0, 2.0], scales_with: ScalesWith::TorquePerSpeed }
}

const fn number(name: &'static str, min: f64, max: f64) -> LawParameter {
    LawParameter { name: Cow::Borrowed(name), bounds: [min, max], scales_with: ScalesWith::Nothing }
}

const fn speed(name: &'static str) -> LawParameter {
    LawParameter { name: Cow::Borrowed(name), bounds: [1e-3, 1.0], scales_with: ScalesWith::Speed }
}

/// A law of friction.
pub trait JointFriction {
    /// Its parameters, in the order of the values that it is given.
    fn parameters(&self) -> Vec<LawParameter>;

    /// Dry and viscous friction with the parameters `p`.
    fn budget<T: Real>(&self, p: &[T], at: &Sliding<T>) -> Budget<T>;

    /// Torque against motion [N m]; 0 at standstill.
    fn torque(&self, p: &[f64], at: &Sliding) -> f64 {
        self.budget(p, at).torque(at.velocity)
    }

    /// Derivative of the torque by the speed, off standstill [N m s/rad].
    fn by_velocity(&self, p: &[f64], at: &Sliding) -> f64 {
        let p: Vec<Dual> = p.iter().map(|p| Dual::from(*p)).collect();
        let velocity = Dual::variable(at.velocity);
        let budget = self.budget(&p, &Sliding { velocity, ..at.lift() });
        (budget.dry * Dual::from(at.velocity.signum()) + budget.viscous * velocity).slope
    }

    /// Derivatives of the torque by the parameters, into `gradient` (one each) [N m per unit of the parameter].
    fn by_parameters(&self, p: &[f64], at: &Sliding, gradient: &mut [f64]) {
        let mut dual: Vec<Dual> = p.iter().map(|p| Dual::from(*p)).collect();
        let sign = if at.velocity == 0.0 { 0.0 } else { at.velocity.signum() };
        for k in 0..p.len() {
            dual[k].slope = 1.0;
            let budget = self.budget(&dual, &at.lift());
            gradient[k] = budget.dry.slope * sign + budget.viscous.slope * at.velocity;
            dual[k].slope = 0.0;
        }
    }
}

/// Every law, chosen by name.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// f_c, f_v.
    CoulombViscous(CoulombViscous),
    /// f_c, f_s, v_s, f_v, the same in both directions.
    Stribeck(SymmetricStribeck),
    /// The same with each direction's own numbers.
    DirectedStribeck(DirectedStribeck),
    /// A curve through knots of speed.
    PiecewiseLinear(PiecewiseLinear),
    /// bam's m1 to m6.
    LoadDependent(LoadDependent),
    /// A rope around a guide.
    Capstan(Capstan),
    /// A map of speed and load, fitted to data.
    LearnedMap(LearnedMap),
}

/// Names of the laws that [`Law::named`] knows.
pub const LAW_NAMES: [&str; 9] =
    ["coulomb-viscous", "stribeck", "directed-stribeck", "m1", "m2", "m3", "m4", "m5", "m6"];

/// Name of a [`LearnedMap`] of the speed, whose knots come from data ([`Law::for_speeds`]).
pub const LEARNED_MAP: &str = "learned-map";
/// Name of one that does not fall with the speed.
pub const RISING_MAP: &str = "rising-map";

impl Law {
    /// The law of that name, for motion at `velocity` [rad/s]: as [`Law::named`], or a fitted map with knots
    /// there.
    ///
    /// # Errors
    /// `BadInput` with the names there are; speeds that do not differ.
    pub fn for_speeds(name: &str, velocity: &[f64]) -> Result<Self, BadInput> {
        match name {
            LEARNED_MAP => LearnedMap::of_speeds(velocity).map(Self::LearnedMap),
            RISING_MAP => {
                let map = LearnedMap::of_speeds(velocity)?;
                Ok(Self::LearnedMap(map.monotone(Monotonicity::WithSpeed)))
            }
            _ => Self::named(name),
        }
    }

    /// The law of that name.
    ///
    /// # Errors
    /// `BadInput` with the names there are.
    pub fn named(name: &str) -> Result<Self, BadInput> {
        Ok(match name {
            "coulomb-viscous" => Self::CoulombViscous(CoulombViscous),
            "stribeck" => Self::Stribeck(SymmetricStribeck),
            "directed-stribeck" => Self::DirectedStribeck(DirectedStribeck),
            _ => Self::LoadDependent(LoadDependent::named(name).ok_or_else(|| {
                BadInput::new(
                    "law of friction",
                    format!("one of {}", LAW_NAMES.join(", ")),
                    format!("{name:?}"),
                )
            })?),
        })
    }

    /// Its name, as [`Law::for_speeds`] takes it where it knows the law.
    pub fn name(&self) -> &'static str {
        match self {
            Self::LoadDependent(law) => law.name(),
            Self::CoulombViscous(_) => "coulomb-viscous",
            Self::Stribeck(_) => "stribeck",
            Self::DirectedStribeck(_) => "directed-stribeck",
            Self::PiecewiseLinear(_) => "piecewise-linear",
            Self::Capstan(_) => "capstan",
            Self::LearnedMap(_) => LEARNED_MAP,
        }
    }
}

impl JointFriction for Law {
    fn parameters(&self) -> Vec<LawParameter> {
        match self {
            Self::CoulombViscous(law) => law.parameters(),
            Self::Stribeck(law) => law.parameters(),
            Self::DirectedStribeck(law) => law.parameters(),
            Self::PiecewiseLinear(law) => law.parameters(),
            Self::LoadDependent(law) => law.parameters(),
            Self::Capstan(law) => law.parameters(),
            Self::LearnedMap(law) => law.parameters(),
        }
    }

    fn budget<T: Real>(&self, p: &[T], at: &Sliding<T>) -> Budget<T> {
        match self {
            Self::CoulombViscous(law) => law.budget(p, at),
            Self::Stribeck(law) => law.budget(p, at),
            Self::DirectedStribeck(law) => law.budget(p, at),
            Self::PiecewiseLinear(law) => law.budget(p, at),
            Self::LoadDependent(law) => law.budget(p, at),
            Self::Capstan(law) => law.budget(p, at),
            Self::LearnedMap(law) => law.budget(p, at),
        }
    }
}

#[cfg(test)]
mod tests;
