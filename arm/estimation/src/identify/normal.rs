//! The normal equations of the regression, joint by joint: made once, weighed later.

use hysteron_base::{BadInput, parallel};
use nalgebra::{DMatrix, DVector};

use super::motion::JointMotion;
use hysteron_arm_dynamics::{Data, Model, regressor};

/// Term of a joint's torque beyond rigid bodies, linear in one coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointTerm {
    /// Inertia of rotor and gear times acceleration; >= 0.
    Armature,
    /// Coulomb friction, tanh(v/w) times its size; >= 0.
    Coulomb,
    /// Viscous friction; >= 0.
    Viscous,
    /// A constant: offset of the torque sensor.
    Offset,
    /// A spring about coordinate zero.
    Spring,
}

impl JointTerm {
    /// Name with the joint's number put in and its unit.
    pub fn name(self, joint: usize) -> String {
        let k = joint + 1;
        match self {
            Self::Armature => format!("armature_{k}_kg_m2"),
            Self::Coulomb => format!("coulomb_{k}_n_m"),
            Self::Viscous => format!("viscous_{k}_n_m_s_per_rad"),
            Self::Offset => format!("offset_{k}_n_m"),
            Self::Spring => format!("spring_{k}_n_m_per_rad"),
        }
    }

    /// True where a negative value cannot be.
    pub fn is_never_negative(self) -> bool {
        matches!(self, Self::Armature | Self::Coulomb | Self::Viscous)
    }

    fn column(self, [q, dq, ddq]: [f64; 3], width: f64) -> f64 {
        match self {
            Self::Armature => ddq,
            Self::Coulomb => (dq / width).tanh(),
            Self::Viscous => dq,
            Self::Offset => 1.0,
            Self::Spring => q,
        }
    }
}

/// Σ aᵀa, Σ aᵀτ, Σ τ² over the rows of one joint.
#[derive(Clone)]
pub struct JointNormal {
    pub matrix: DMatrix<f64>,
    pub right: DVector<f64>,
    pub square: f64,
}

/// The columns of a regression: ten of every body, then the terms of every joint.
pub struct RegressionColumns<'a> {
    pub model: &'a Model,
    pub terms: &'a [JointTerm],
    /// Speed over which Coulomb friction changes its sign [rad/s].
    pub width: f64,
}

/// Samples of one product of matrices.
const CHUNK: usize = 256;

impl RegressionColumns<'_> {
    /// Number of columns.
    pub fn n(&self) -> usize {
        (10 + self.terms.len()) * self.model.n_joints()
    }

    /// Refuses robots whose torques have parts that are no column: springs, and bodies whose weight is carried.
    ///
    /// # Errors
    /// `BadInput` naming the joint.
    pub fn check(&self) -> Result<(), BadInput> {
        for joint in self.model.joints() {
            let place = format!("joint[{}]", joint.name);
            if joint.drive.stiffness != 0.0 {
                let found = format!("stiffness {}", joint.drive.stiffness);
                return Err(BadInput::new(place, "a joint without spring, where bodies are identified", found)
                    .hint("remove stiffness and springdamper in a copy of the robot file; the identification has its own spring term"));
            }
            if joint.weightless.mass != 0.0 {
                let found = format!("{} kg without weight (gravcomp)", joint.weightless.mass);
                return Err(BadInput::new(
                    place,
                    "bodies with their whole weight, where bodies are identified",
                    found,
                )
                .hint("remove gravcomp in a copy of the robot file"));
            }
        }
        Ok(())
    }

    /// Column of term number `term` of a joint.
    pub fn position(&self, joint: usize, term: usize) -> usize {
        10 * self.model.n_joints() + joint * self.terms.len() + term
    }

    /// One per joint. The sums are taken chunk by chunk in one order, for any number of threads.
    pub fn normals(&self, motion: &JointMotion) -> Vec<JointNormal> {
        let n = self.model.n_joints();
        let width = CHUNK * n;
        let samples = motion.q.len().div_ceil(width);
        let parts: Vec<Vec<JointNormal>> = parallel::map_indices(samples, |part| {
            let range = part * width..((part + 1) * width).min(motion.q.len());
            let of = |rows| -> &[f64] { &Vec::as_slice(rows)[range.clone()] };
            self.chunk([of(&motion.q), of(&motion.dq), of(&motion.ddq)], of(&motion.tau))
        });
        let empty = JointNormal {
            matrix: DMatrix::zeros(self.n(), self.n()),
            right: DVector::zeros(self.n()),
            square: 0.0,
        };
        let mut sums = vec![empty; n];
        for part in &parts {
            for (sum, more) in sums.iter_mut().zip(part) {
                sum.matrix += &more.matrix;
                sum.right += &more.right;
                sum.square += more.square;
            }
        }
        sums
    }

    fn chunk(&self, [q, dq, ddq]: [&[f64]; 3], tau: &[f64]) -> Vec<JointNormal> {
        let n = self.model.n_joints();
        let (rows, p) = (q.len() / n, self.n());
        let mut data = Data::new(self.model, 0.0);
        let mut of_bodies = vec![0.0; 10 * n * n];
        let mut columns = vec![DMatrix::zeros(p, rows); n];
        for s in 0..rows {
            let at = s * n..(s + 1) * n;
            let state = [&q[at.clone()], &dq[at.clone()], &ddq[at]];
            regressor(self.model, &mut data, state, &mut of_bodies);
            for (j, matrix) in columns.iter_mut().enumerate() {
                let mut row = matrix.column_mut(s);
                row.rows_mut(0, 10 * n).copy_from_slice(&of_bodies[10 * n * j..10 * n * (j + 1)]);
                for (t, term) in self.terms.iter().enumerate() {
                    row[self.position(j, t)] =
                        term.column([state[0][j], state[1][j], state[2][j]], self.width);
                }
            }
        }
        let normal = |(j, a): (usize, &DMatrix<f64>)| {
            let tau = DVector::from_fn(rows, |s, _| tau[s * n + j]);
            JointNormal { matrix: a * a.transpose(), right: a * &tau, square: tau.norm_squared() }
        };
        columns.iter().enumerate().map(normal).collect()
    }

    /// The torque that `parameters` give, row by row.
    pub fn torques(&self, motion: &JointMotion, parameters: &DVector<f64>) -> Vec<f64> {
        let n = self.model.n_joints();
        let mut data = Data::new(self.model, 0.0);
        let mut of_bodies = vec![0.0; 10 * n * n];
        let mut torques = Vec::with_capacity(motion.q.len());
        let bodies = &parameters.as_slice()[..10 * n];
        for s in 0..motion.n_samples() {
            let at = s * n..(s + 1) * n;
            let state = [&motion.q[at.clone()], &motion.dq[at.clone()], &motion.ddq[at]];
            regressor(self.model, &mut data, state, &mut of_bodies);
            for j in 0..n {
                let rigid: f64 =
                    of_bodies[10 * n * j..10 * n * (j + 1)].iter().zip(bodies).map(|(a, b)| a * b).sum();
                let more = self.terms.iter().enumerate().map(|(t, term)| {
                    parameters[self.position(j, t)]
                        * term.column([state[0][j], state[1][j], state[2][j]], self.width)
                });
                torques.push(rigid + more.sum::<f64>());
            }
        }
        torques
    }
}
