//! Laws that know the speed alone.

use super::{Budget, JointFriction, LawParameter, ScalesWith, Sliding, damping, speed, torque};
use crate::friction::stribeck;
use crate::number::Real;

/// f_c sgn v + f_v v.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoulombViscous;

impl JointFriction for CoulombViscous {
    fn parameters(&self) -> Vec<LawParameter> {
        vec![torque("coulomb_n_m"), damping("viscous_n_m_s_per_rad")]
    }

    fn budget<T: Real>(&self, p: &[T], _: &Sliding<T>) -> Budget<T> {
        Budget { dry: p[0], viscous: p[1] }
    }
}

/// [f_c + Δ exp(-(|v|/v_s)²)] sgn v + f_v v, with f_s = f_c + Δ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SymmetricStribeck;

impl JointFriction for SymmetricStribeck {
    fn parameters(&self) -> Vec<LawParameter> {
        vec![
            torque("coulomb_n_m"),
            torque("breakaway_excess_n_m"),
            speed("stribeck_velocity_rad_s"),
            damping("viscous_n_m_s_per_rad"),
        ]
    }

    fn budget<T: Real>(&self, p: &[T], at: &Sliding<T>) -> Budget<T> {
        let dry = stribeck([p[0], p[1], p[2]], at.velocity);
        Budget { dry, viscous: p[3] }
    }
}

/// Stribeck's law with each direction's own f_c, Δ and v_s, and one viscous coefficient.
///
/// # Reference
/// Wan et al. (2026), eq. 39; there the breakaway friction itself is the parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectedStribeck;

impl JointFriction for DirectedStribeck {
    fn parameters(&self) -> Vec<LawParameter> {
        vec![
            torque("coulomb_forward_n_m"),
            torque("coulomb_reverse_n_m"),
            torque("breakaway_excess_forward_n_m"),
            torque("breakaway_excess_reverse_n_m"),
            speed("stribeck_velocity_forward_rad_s"),
            speed("stribeck_velocity_reverse_rad_s"),
            damping("viscous_n_m_s_per_rad"),
        ]
    }

    fn budget<T: Real>(&self, p: &[T], at: &Sliding<T>) -> Budget<T> {
        let k = usize::from(at.velocity.value() < 0.0);
        let dry = stribeck([p[k], p[2 + k], p[4 + k]], at.velocity);
        Budget { dry, viscous: p[6] }
    }
}

/// Friction over speed as a line through knots, each direction's own, constant beyond the last.
#[derive(Debug, Clone, PartialEq)]
pub struct PiecewiseLinear {
    /// Sizes of the speed at which the friction is a parameter, ascending from 0 [rad/s].
    pub knots: Vec<f64>,
}

impl JointFriction for PiecewiseLinear {
    fn parameters(&self) -> Vec<LawParameter> {
        let knot = |direction: &str, k: usize| LawParameter {
            name: format!("{direction}_{}_n_m", k + 1).into(),
            bounds: [0.0, 2.0],
            scales_with: ScalesWith::Torque,
        };
        ["forward", "reverse"]
            .iter()
            .flat_map(|way| (0..self.knots.len()).map(move |k| knot(way, k)))
            .collect()
    }

    fn budget<T: Real>(&self, p: &[T], at: &Sliding<T>) -> Budget<T> {
        let n = self.knots.len();
        let p = if at.velocity.value() < 0.0 { &p[n..] } else { &p[..n] };
        let speed = at.velocity.abs();
        let after = self.knots.partition_point(|knot| *knot <= speed.value());
        let dry = match after {
            0 => p[0],
            after if after == n => p[n - 1],
            after => {
                let (low, high) = (self.knots[after - 1], self.knots[after]);
                let share = (speed - T::from(low)) / T::from(high - low);
                p[after - 1] + (p[after] - p[after - 1]) * share
            }
        };
        Budget { dry, viscous: T::from(0.0) }
    }
}
