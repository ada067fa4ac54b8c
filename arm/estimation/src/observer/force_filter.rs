//! `ForceFilter`: a time-varying force, of which joints carry much information while they move and little at rest.
//!
//! Components of f are Ornstein-Uhlenbeck processes of deviation σ and time T; the external torque of joint k is Jₖᵀ f + noise, of a variance
//! that the caller gives: small for a joint in motion, that of its dry friction for one at rest. The Kalman filter of both, joint by joint.

use hysteron_arm_dynamics::spatial::{Vec3, dot3};

/// Follows a force at a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceFilter {
    /// T [s].
    time: f64,
    /// σ² [N²].
    variance: f64,
    /// f [N].
    pub force: Vec3<f64>,
    /// P [N²].
    pub covariance: [Vec3<f64>; 3],
}

impl ForceFilter {
    /// Of a force with this time [s] and deviation [N]; nothing is known of it yet.
    pub fn new(time: f64, deviation: f64) -> Self {
        assert!(time > 0.0 && deviation > 0.0, "{time} s, {deviation} N");
        let variance = deviation * deviation;
        let covariance = [0, 1, 2].map(|i| std::array::from_fn(|k| if i == k { variance } else { 0.0 }));
        Self { time, variance, force: [0.0; 3], covariance }
    }

    /// `period` [s] goes by.
    pub fn advance(&mut self, period: f64) {
        let left = (-period / self.time).exp();
        for (i, (force, row)) in self.force.iter_mut().zip(&mut self.covariance).enumerate() {
            *force *= left;
            row.iter_mut().for_each(|p| *p *= left * left);
            row[i] += (1.0 - left * left) * self.variance;
        }
    }

    /// Takes a joint's external torque [N m] of this variance [N² m²]; `lever` is the torque of a unit force along each axis [m].
    pub fn update(&mut self, lever: Vec3<f64>, torque: f64, variance: f64) {
        let gain = self.covariance.map(|row| dot3(row, lever));
        let total = dot3(gain, lever) + variance;
        let error = (torque - dot3(self.force, lever)) / total;
        for (i, row) in self.covariance.iter_mut().enumerate() {
            self.force[i] += gain[i] * error;
            row.iter_mut().zip(gain).for_each(|(p, other)| *p -= gain[i] * other / total);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// E[f | y] = kᵀ S⁻¹ y with the covariances k of f and S of two torques, written out.
    #[test]
    fn two_torques_say_what_gaussian_variables_say() {
        let (time, deviation, period) = (0.4_f64, 3.0, 0.25);
        let (levers, torques, noises) = ([0.3, -0.2], [0.7, 0.1], [0.02, 0.5]);
        let mut filter = ForceFilter::new(time, deviation);
        filter.update([0.0, levers[0], 0.0], torques[0], noises[0]);
        filter.advance(period);
        filter.update([0.0, levers[1], 0.0], torques[1], noises[1]);
        let (variance, left) = (deviation * deviation, (-period / time).exp());
        let own = [0, 1].map(|i| levers[i] * levers[i] * variance + noises[i]);
        let both = levers[0] * levers[1] * left * variance;
        let k = [left * levers[0] * variance, levers[1] * variance];
        let det = own[0] * own[1] - both * both;
        let inverse = [[own[1] / det, -both / det], [-both / det, own[0] / det]];
        let gain = [0, 1].map(|j| k[0] * inverse[0][j] + k[1] * inverse[1][j]);
        let expected = gain[0] * torques[0] + gain[1] * torques[1];
        let spread = variance - gain[0] * k[0] - gain[1] * k[1];
        assert!((filter.force[1] - expected).abs() < 1e-12, "{} {expected}", filter.force[1]);
        assert!((filter.covariance[1][1] - spread).abs() < 1e-12, "{:?} {spread}", filter.covariance);
        // The other axes had no measurement.
        assert_eq!([filter.force[0], filter.force[2]], [0.0; 2]);
        assert!((filter.covariance[0][0] - variance).abs() < 1e-12 * variance);
    }

    #[test]
    fn a_joint_at_rest_keeps_the_estimate_from_moving_ones() {
        let (lever, force, period) = ([0.1, 0.0, 0.3], 2.0, 0.01);
        let mut filter = ForceFilter::new(1.0, 5.0);
        for _ in 0..100 {
            filter.advance(period);
            filter.update(lever, 0.3 * force, 1e-6);
        }
        let felt = dot3(filter.force, lever);
        assert!((felt - 0.3 * force).abs() < 1e-3, "{felt}");
        // At rest it reads nothing, with all the friction that there may be: after a tenth of T, e^(-0.1) of it is left.
        for _ in 0..10 {
            filter.advance(period);
            filter.update(lever, 0.0, 1e6);
        }
        let kept = dot3(filter.force, lever) / felt;
        assert!((kept - (-0.1_f64).exp()).abs() < 1e-4, "{kept}");
    }
}
