//! Friction that gives way before it slides: LuGre's bristles, of which Dahl's are a special case.
//!
//! # Reference
//! Canudas de Wit, Olsson, Åström, Lischinsky (1995), A new model for control of systems with friction, eqs. 1 to 3; Dahl (1968).

use super::{JointFriction, Sliding};

/// Bristles over a law that gives their largest friction in steady motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Bristles<L> {
    /// Steady friction: its dry part is g(v), its viscous part f_v. Constant g with `damping` 0 is Dahl's model.
    pub law: L,
    /// Parameters of the law.
    pub parameters: Vec<f64>,
    /// Stiffness σ₀ [N m/rad].
    pub stiffness: f64,
    /// Damping of their deflection σ₁ [N m s/rad].
    pub damping: f64,
    /// Deflection z, their memory [rad].
    pub deflection: f64,
}

impl<L: JointFriction> Bristles<L> {
    /// Lets `h` [s] pass at constant speed, exactly: ż = v - σ₀ |v| z / g(v). Returns the torque against motion in its mean
    /// over the step, σ₀ z + σ₁ ż + f_v v [N m].
    pub fn step(&mut self, at: &Sliding, h: f64) -> f64 {
        let budget = self.law.budget(&self.parameters, at);
        let v = at.velocity;
        let before = self.deflection;
        let rate = if budget.dry > 0.0 { self.stiffness * v.abs() / budget.dry } else { f64::INFINITY };
        let steady = budget.dry / self.stiffness * v.signum();
        // exp(-x) - 1 without loss for slow motion, and the mean of exp(-x s) over the step.
        let x = rate * h;
        let (after, mean) = if v == 0.0 {
            (before, before)
        } else if x.is_finite() {
            let decay = (-x).exp_m1();
            (before - decay * (steady - before), steady + (before - steady) * (-decay / x))
        } else {
            (0.0, 0.0)
        };
        self.deflection = after;
        self.stiffness * mean + self.damping * (after - before) / h + budget.viscous * v
    }
}
