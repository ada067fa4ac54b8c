//! Force at a frame from external joint torques.
//!
//! τ_ext = Jᵀ F + noise of covariance Σ, F before any measurement N(0, σ_F²): F̂ = P J Σ⁻¹ τ_ext with
//! P = (J Σ⁻¹ Jᵀ + σ_F⁻²)⁻¹ its covariance. Near singularities this is damped least squares: the prior replaces the missing information of
//! the joints, and P grows.

use hysteron_arm_dynamics::{Data, Model, dense, forward_kinematics, frame_jacobian};

/// Prior of a contact: standard deviations of its components.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactPrior {
    /// A force at the frame's origin [N].
    Force(f64),
    /// A force [N] and a torque [N m].
    Wrench {
        /// [N].
        force: f64,
        /// [N m].
        torque: f64,
    },
}

/// Finds the force at one frame.
#[derive(Debug, Clone)]
pub struct TipForceEstimator<'m> {
    model: &'m Model,
    data: Data<f64>,
    frame: usize,
    /// 1/σ² of every joint's external torque.
    weights: Vec<f64>,
    /// 1/σ_F² of the forces [1/N²], then of the torques [1/(N m)²].
    prior: Vec<f64>,
    jacobian: Vec<f64>,
    information: Vec<f64>,
    /// F̂ [N], [N m], in the axes of the base.
    pub force: Vec<f64>,
    /// P, row by row [N²], [N² m], [N² m²].
    pub covariance: Vec<f64>,
}

impl<'m> TipForceEstimator<'m> {
    /// At `frame`, from torques with standard deviations `torques` [N m].
    pub fn new(model: &'m Model, frame: usize, torques: &[f64], before: ContactPrior) -> Self {
        assert_eq!(model.n_joints(), torques.len());
        let positive = |x: &f64| *x > 0.0 && x.is_finite();
        assert!(torques.iter().all(positive), "standard deviations {torques:?}");
        let deviations = match before {
            ContactPrior::Force(force) => vec![force; 3],
            ContactPrior::Wrench { force, torque } => vec![force, force, force, torque, torque, torque],
        };
        assert!(deviations.iter().all(positive), "{before:?}");
        let m = deviations.len();
        let precision = |s: &f64| 1.0 / (s * s);
        Self {
            model,
            data: Data::new(model, 0.0),
            frame,
            weights: torques.iter().map(precision).collect(),
            prior: deviations.iter().map(precision).collect(),
            jacobian: vec![0.0; 6 * model.n_joints()],
            information: vec![0.0; m * m],
            force: vec![0.0; m],
            covariance: vec![0.0; m * m],
        }
    }

    /// Takes external torques at `q`; writes [`Self::force`] and [`Self::covariance`]. Allocates nothing.
    pub fn update(&mut self, q: &[f64], external: &[f64]) {
        let (n, m) = (q.len(), self.prior.len());
        forward_kinematics(self.model, &mut self.data, q);
        frame_jacobian(self.model, &self.data, self.frame, &mut self.jacobian);
        for i in 0..m {
            let row = &self.jacobian[n * i..n * (i + 1)];
            for k in 0..m {
                let other = &self.jacobian[n * k..n * (k + 1)];
                let products = row.iter().zip(other).zip(&self.weights);
                self.information[m * i + k] = products.map(|((a, b), w)| a * w * b).sum();
            }
            self.information[m * i + i] += self.prior[i];
            self.force[i] = row.iter().zip(external).zip(&self.weights).map(|((a, t), w)| a * w * t).sum();
        }
        dense::factor(m, &mut self.information);
        dense::solve_columns(m, &self.information, &mut self.force);
        dense::invert(m, &self.information, &mut self.covariance);
    }

    /// Torque of a unit force along axis `i` at a joint [m].
    pub fn lever(&self, i: usize, joint: usize) -> f64 {
        self.jacobian[self.model.n_joints() * i + joint]
    }

    /// Torque of the force at a joint, and its variance [N m], [N² m²].
    pub fn torque(&self, joint: usize) -> [f64; 2] {
        let m = self.prior.len();
        let lever = |i: usize| self.lever(i, joint);
        let mean = (0..m).map(|i| lever(i) * self.force[i]).sum();
        let row = |i: usize| (0..m).map(|k| self.covariance[m * i + k] * lever(k)).sum::<f64>();
        [mean, (0..m).map(|i| lever(i) * row(i)).sum()]
    }
}
