//! Computed-torque control: an arm follows a motion by the torques that its dynamics, from a file or learned, ask for.

use crate::observer::Dynamics;

/// τ = M(q) (q̈_d + K_d (q̇_d − q̇) + K_p (q_d − q)) + c(q, q̇) + g(q): with the right dynamics the error of every joint obeys
/// ë + K_d ė + K_p e = 0.
///
/// Feed-forward alone is [`Dynamics::inverse`] of the motion that is desired.
///
/// # Reference
/// Siciliano et al. (2009), Robotics: modelling, planning and control, section 8.5.2.
#[derive(Debug, Clone)]
pub struct ComputedTorque<D> {
    dynamics: D,
    /// ω of every joint [rad/s].
    bandwidths: Vec<f64>,
    accelerations: Vec<f64>,
}

impl<D: Dynamics> ComputedTorque<D> {
    /// Critically damped errors, K_p = ω² and K_d = 2 ω, with `bandwidths` ω of every joint [rad/s], all above 0.
    pub fn new(dynamics: D, bandwidths: &[f64]) -> Self {
        assert_eq!(dynamics.n_joints(), bandwidths.len());
        assert!(bandwidths.iter().all(|w| *w > 0.0 && w.is_finite()), "bandwidths {bandwidths:?}");
        Self { dynamics, bandwidths: bandwidths.to_vec(), accelerations: vec![0.0; bandwidths.len()] }
    }

    /// Writes the torques at (q, q̇) for the motion (q_d, q̇_d, q̈_d), n numbers each [N m] or [N]. Allocates nothing.
    pub fn torque(&mut self, [q, dq]: [&[f64]; 2], desired: [&[f64]; 3], torque: &mut [f64]) {
        for (j, acceleration) in self.accelerations.iter_mut().enumerate() {
            let w = self.bandwidths[j];
            *acceleration =
                desired[2][j] + 2.0 * w * (desired[1][j] - dq[j]) + w * w * (desired[0][j] - q[j]);
        }
        self.dynamics.inverse(q, dq, &self.accelerations, torque);
    }
}
