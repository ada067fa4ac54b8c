//! Weighted least squares of bodies and joint terms, with bodies that can exist.
//!
//! The sum of squares is convex in the parameters, and so is the divergence of every body from its nominal one, which is
//! infinite where a body cannot exist: one problem for consistency, for what the data does not determine, and for what is
//! the prior. Newton's method solves it. No semidefinite solver is needed.

use hysteron_base::BadInput;
use hysteron_fit::ResidualVariance;
use nalgebra::{DMatrix, DVector, Matrix4};

use super::motion::{JointMotion, rms_left};
use super::normal::{JointNormal, JointTerm, RegressionColumns};
use super::pseudo_inertia::{InertialParameters, divergence, matrix, nearest_consistent};
use hysteron_arm_dynamics::Model;
use hysteron_arm_dynamics::spatial::Inertia;

/// How bodies are identified.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyOptions<'a> {
    /// Terms of every joint in addition to its body.
    pub terms: &'a [JointTerm],
    /// Speed over which Coulomb friction changes its sign [rad/s].
    pub width: f64,
    /// Weight of the nominal bodies, in independent samples of one joint [-]; above 0.
    pub prior: f64,
}

/// Identifiability of a parameter from the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Determined {
    /// By the data.
    Alone,
    /// Only in sums with others; the nominal bodies decide the rest.
    Together,
}

/// A number of the fit.
#[derive(Debug, Clone, PartialEq)]
pub struct TermEstimate {
    /// Name with its unit.
    pub name: String,
    /// Value [SI].
    pub value: f64,
    /// Standard error, with the prior of the bodies [SI].
    pub standard_error: f64,
    /// Whether the data determines it.
    pub determined: Determined,
}

/// The outcome.
#[derive(Debug, Clone)]
pub struct BodyFit {
    /// The arm with its bodies, armature, damping and dry friction.
    pub model: Model,
    /// Bodies (ten numbers each), then the terms of every joint.
    pub estimates: Vec<TermEstimate>,
    /// Root mean square of what is left of every joint's torque on the samples of the fit [N m].
    pub rms: Vec<f64>,
    /// Combinations of parameters that the motion determines.
    pub n_determined: usize,
    /// Ratio of the best to the worst determined of them, columns scaled [-].
    pub condition: f64,
    /// Pairs of joint terms that the motion can hardly distinguish, in words.
    pub warnings: Vec<String>,
    parameters: DVector<f64>,
    terms: Vec<JointTerm>,
    width: f64,
}

/// Names of the ten parameters of a body.
const BODY: [&str; 10] = [
    "mass_kg",
    "mx_kg_m",
    "my_kg_m",
    "mz_kg_m",
    "jxx_kg_m2",
    "jxy_kg_m2",
    "jyy_kg_m2",
    "jxz_kg_m2",
    "jyz_kg_m2",
    "jzz_kg_m2",
];
/// Correlation from which on two terms of a joint are named together.
const ALIKE: f64 = 0.95;
/// Singular value, relative to the largest with columns scaled, below which a direction counts as not moved at all.
const UNMOVED: f64 = 1e-7;
/// Share of an unmoved direction from which on a parameter is determined only together with others.
const SHARE: f64 = 1e-3;
/// Lower bound on the variance of a joint's torque residual: rounding of simulated data [N² m²].
const SMALLEST_VARIANCE: f64 = 1e-12;
/// Times that the weights of the joints are taken from what is left.
const ROUNDS: usize = 3;

/// Identifies the bodies of `model`, which is also the prior, from `motion`. A body of the model that cannot exist, or has no
/// width, is replaced in the prior by the nearest one that can.
///
/// # Errors
/// `BadInput` for a motion of another number of joints, fewer samples than parameters, a prior that is not above 0, a body
/// whose numbers are not finite, or a model with springs or gravity compensation.
pub fn identify_bodies(
    model: &Model,
    motion: &JointMotion,
    options: &BodyOptions,
) -> Result<BodyFit, BadInput> {
    let n = model.n_joints();
    let columns = RegressionColumns { model, terms: options.terms, width: options.width };
    columns.check()?;
    if motion.n_joints != n {
        return Err(BadInput::new("motion", format!("{n} joints"), motion.n_joints.to_string()));
    }
    if motion.n_samples() < columns.n() {
        let expected = format!("at least {} samples, one for each parameter", columns.n());
        return Err(BadInput::new("motion", expected, motion.n_samples().to_string()));
    }
    if !(options.prior > 0.0 && options.prior.is_finite() && options.width > 0.0) {
        let found = format!("{} and {}", options.prior, options.width);
        return Err(BadInput::new(
            "weight of the prior, width of Coulomb friction",
            "numbers above 0",
            found,
        ));
    }
    let prior = BodyPrior::new(model, options)?;
    let normals = columns.normals(motion);
    let rows = motion.n_samples() as f64;
    let mut variances: Vec<f64> =
        normals.iter().map(|normal| (normal.square / rows).max(SMALLEST_VARIANCE)).collect();
    let mut parameters = prior.start();
    for _ in 0..ROUNDS {
        let sum = weighed(&normals, &variances);
        parameters = prior.minimum(&sum, parameters);
        let error = |normal: &JointNormal| (normal.error(&parameters) / rows).max(SMALLEST_VARIANCE);
        variances = normals.iter().map(error).collect();
    }
    let sum = weighed(&normals, &variances);
    parameters = prior.minimum(&sum, parameters);
    let rms = normals.iter().map(|normal| (normal.error(&parameters) / rows).max(0.0).sqrt()).collect();
    // Neighbouring residuals are correlated: their effective number decides the standard errors, not the weights.
    let curvature = prior.hessian(&weighed(&normals, &spreads(&columns, motion, &parameters)), &parameters);
    let covariance =
        curvature.cholesky().map_or_else(|| DMatrix::zeros(columns.n(), columns.n()), |c| c.inverse());
    let (n_determined, condition, together) = determined(&sum.matrix);
    let estimate = |k: usize| TermEstimate {
        name: name(model, options.terms, k),
        value: parameters[k],
        standard_error: covariance[(k, k)].max(0.0).sqrt(),
        determined: if together[k] { Determined::Together } else { Determined::Alone },
    };
    Ok(BodyFit {
        model: prior.arm(&parameters),
        estimates: (0..columns.n()).map(estimate).collect(),
        rms,
        n_determined,
        condition,
        warnings: warnings(&columns, &covariance),
        parameters,
        terms: options.terms.to_vec(),
        width: options.width,
    })
}

impl BodyFit {
    /// The torques that the fit gives for a motion, row by row [N m].
    pub fn torques(&self, motion: &JointMotion) -> Vec<f64> {
        let columns = RegressionColumns { model: &self.model, terms: &self.terms, width: self.width };
        columns.torques(motion, &self.parameters)
    }

    /// Root mean square of what is left of every joint's torque on another motion [N m].
    pub fn rms_on(&self, motion: &JointMotion) -> Vec<f64> {
        rms_left([motion], motion.n_joints, |motion| self.torques(motion))
    }

    /// Least eigenvalue of the pseudo-inertia of every body: above 0 where it can exist.
    pub fn least_pseudo_inertias(&self) -> Vec<f64> {
        let least = |k: usize| matrix(&body(&self.parameters, k)).symmetric_eigenvalues().min();
        (0..self.model.n_joints()).map(least).collect()
    }
}

impl JointNormal {
    /// Sum of squared errors.
    pub(super) fn error(&self, parameters: &DVector<f64>) -> f64 {
        (parameters.transpose() * &self.matrix * parameters)[0] - 2.0 * self.right.dot(parameters)
            + self.square
    }
}

/// The joints' sums over their variances.
pub(super) fn weighed(normals: &[JointNormal], variances: &[f64]) -> JointNormal {
    let mut sum = normals[0].clone();
    sum.matrix /= variances[0];
    sum.right /= variances[0];
    sum.square /= variances[0];
    for (normal, variance) in normals.iter().zip(variances).skip(1) {
        sum.matrix += &normal.matrix / *variance;
        sum.right += &normal.right / *variance;
        sum.square += normal.square / variance;
    }
    sum
}

/// Residual variance of each joint, increased for the correlation of neighbouring errors.
fn spreads(columns: &RegressionColumns, motion: &JointMotion, parameters: &DVector<f64>) -> Vec<f64> {
    let n = motion.n_joints;
    let torques = columns.torques(motion, parameters);
    let of = |j: usize| {
        let errors =
            (0..motion.n_samples()).map(|s| torques[s * n + j] - motion.tau[s * n + j]).collect::<Vec<f64>>();
        ResidualVariance::new(&[errors], columns.terms.len()).variance.max(SMALLEST_VARIANCE)
    };
    (0..n).map(of).collect()
}

fn body(parameters: &DVector<f64>, k: usize) -> InertialParameters {
    parameters.fixed_rows::<10>(10 * k).into_owned()
}

/// Prior of the parameters: nominal bodies and joint terms.
struct BodyPrior<'a> {
    model: &'a Model,
    terms: &'a [JointTerm],
    prior: f64,
    bodies: Vec<InertialParameters>,
    inverses: Vec<Matrix4<f64>>,
}

impl<'a> BodyPrior<'a> {
    fn new(model: &'a Model, options: &BodyOptions<'a>) -> Result<Self, BadInput> {
        let bodies: Vec<InertialParameters> = model
            .joints()
            .iter()
            .map(|joint| InertialParameters::from(nearest_consistent(&joint.inertia).parameters()))
            .collect();
        let inverse = |(body, joint): (&InertialParameters, &hysteron_arm_dynamics::Joint)| {
            matrix(body).cholesky().map(|cholesky| cholesky.inverse()).ok_or_else(|| {
                let place = format!("{}: {}", model.name(), joint.name);
                let mass = joint.inertia.mass;
                BadInput::new(place, "a body of finite mass and size", format!("one of {mass} kg"))
            })
        };
        let inverses = bodies.iter().zip(model.joints()).map(inverse).collect::<Result<_, _>>()?;
        Ok(Self { model, terms: options.terms, prior: options.prior, bodies, inverses })
    }

    /// The nominal bodies, and small terms.
    fn start(&self) -> DVector<f64> {
        let n = self.model.n_joints();
        let bodies = self.bodies.iter().flat_map(|body| body.iter().copied());
        let terms = (0..n * self.terms.len()).map(|_| 0.01);
        DVector::from_iterator((10 + self.terms.len()) * n, bodies.chain(terms))
    }

    /// Half the sum of squares, the divergence of the bodies, and a barrier for terms that are never negative; `None` outside.
    fn cost(&self, sum: &JointNormal, x: &DVector<f64>) -> Option<f64> {
        let mut cost = 0.5 * sum.error(x);
        for (k, inverse) in self.inverses.iter().enumerate() {
            cost += self.prior * divergence(&body(x, k), inverse)?.0;
        }
        for (at, _) in self.never_negative() {
            if x[at] <= 0.0 {
                return None;
            }
            cost -= BARRIER * x[at].ln();
        }
        cost.is_finite().then_some(cost)
    }

    fn never_negative(&self) -> impl Iterator<Item = (usize, JointTerm)> {
        let n = self.model.n_joints();
        let all = (0..n).flat_map(move |_| self.terms.iter().copied());
        all.enumerate().map(move |(k, term)| (10 * n + k, term)).filter(|(_, term)| term.is_never_negative())
    }

    fn hessian(&self, sum: &JointNormal, x: &DVector<f64>) -> DMatrix<f64> {
        let mut hessian = sum.matrix.clone();
        for (k, inverse) in self.inverses.iter().enumerate() {
            if let Some((_, _, more)) = divergence(&body(x, k), inverse) {
                let mut block = hessian.fixed_view_mut::<10, 10>(10 * k, 10 * k);
                block += self.prior * more;
            }
        }
        for (at, _) in self.never_negative() {
            hessian[(at, at)] += BARRIER / (x[at] * x[at]);
        }
        // Offsets and springs that nothing determines stay where they are.
        for k in 10 * self.model.n_joints()..x.len() {
            hessian[(k, k)] += 1e-9;
        }
        hessian
    }

    /// The minimum from `start`, along smaller and smaller weights of the prior: Newton's method does not see the walls of a
    /// thin one from afar.
    fn minimum(&self, sum: &JointNormal, start: DVector<f64>) -> DVector<f64> {
        let (mut x, mut weight) = (start, self.prior.max(1.0));
        loop {
            x = Self { prior: weight, bodies: vec![], inverses: self.inverses.clone(), ..*self }
                .newton(sum, x);
            if weight <= self.prior {
                return x;
            }
            weight = (weight * THINNER).max(self.prior);
        }
    }

    /// Newton's method with halved steps, which stay where bodies exist.
    fn newton(&self, sum: &JointNormal, start: DVector<f64>) -> DVector<f64> {
        let mut x = start;
        for _ in 0..MAX_STEPS {
            let mut gradient = &sum.matrix * &x - &sum.right;
            for (k, inverse) in self.inverses.iter().enumerate() {
                if let Some((_, more, _)) = divergence(&body(&x, k), inverse) {
                    let mut part = gradient.fixed_rows_mut::<10>(10 * k);
                    part += self.prior * more;
                }
            }
            for (at, _) in self.never_negative() {
                gradient[at] -= BARRIER / x[at];
            }
            let Some(cholesky) = self.hessian(sum, &x).cholesky() else { break };
            let step = -cholesky.solve(&gradient);
            let slope = gradient.dot(&step);
            let Some(before) = self.cost(sum, &x) else { break };
            let mut part = 1.0;
            while part > 1e-12 {
                let next = &x + part * &step;
                if self.cost(sum, &next).is_some_and(|cost| cost <= before + 1e-4 * part * slope) {
                    x = next;
                    break;
                }
                part *= 0.5;
            }
            if -slope < DECREMENT || part <= 1e-12 {
                break;
            }
        }
        x
    }

    /// The arm with these bodies and terms.
    fn arm(&self, x: &DVector<f64>) -> Model {
        let n = self.model.n_joints();
        self.model.with_bodies_and_drives(|k, inertia, drive| {
            *inertia = Inertia::from_parameters(body(x, k).data.0[0]);
            for (t, term) in self.terms.iter().enumerate() {
                let value = x[10 * n + k * self.terms.len() + t];
                match term {
                    JointTerm::Armature => drive.armature = value,
                    JointTerm::Coulomb => drive.dry_friction = value,
                    JointTerm::Viscous => drive.damping = value,
                    JointTerm::Offset | JointTerm::Spring => {}
                }
            }
        })
    }
}

/// Weight of the barrier of terms that are never negative, against half of a squared standard deviation.
const BARRIER: f64 = 1e-3;
/// Ratio of one weight of the prior to the one before.
const THINNER: f64 = 0.1;
const MAX_STEPS: usize = 60;
/// Decrease of the cost that another step would bring, below which the minimum is found.
const DECREMENT: f64 = 1e-8;

fn name(model: &Model, terms: &[JointTerm], k: usize) -> String {
    let n = model.n_joints();
    match k < 10 * n {
        true => format!("{}: {}", model.joints()[k / 10].name, BODY[k % 10]),
        false => {
            let k = k - 10 * n;
            terms[k % terms.len()].name(k / terms.len())
        }
    }
}

/// How many directions the data moves, how unlike, and which parameters have a part in those that it does not.
fn determined(matrix: &DMatrix<f64>) -> (usize, f64, Vec<bool>) {
    let p = matrix.nrows();
    let scale: Vec<f64> = (0..p).map(|k| matrix[(k, k)].max(1e-300).sqrt()).collect();
    let is_seen: Vec<bool> = (0..p).map(|k| matrix[(k, k)] > 1e-20).collect();
    let scaled = DMatrix::from_fn(p, p, |a, b| match is_seen[a] && is_seen[b] {
        true => matrix[(a, b)] / (scale[a] * scale[b]),
        false => 0.0,
    });
    let eigen = scaled.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    // Eigenvalues are squares of singular values.
    let moved = |k: usize| eigen.eigenvalues[k] > largest * UNMOVED * UNMOVED.sqrt();
    let least = (0..p).filter(|k| moved(*k)).map(|k| eigen.eigenvalues[k]).fold(largest, f64::min);
    let together = |a: usize| (0..p).any(|k| !moved(k) && eigen.eigenvectors[(a, k)].abs() > SHARE);
    ((0..p).filter(|k| moved(*k)).count(), (largest / least).sqrt(), (0..p).map(together).collect())
}

/// Terms of one joint whose estimates move together.
fn warnings(columns: &RegressionColumns, covariance: &DMatrix<f64>) -> Vec<String> {
    let mut warnings = Vec::new();
    for j in 0..columns.model.n_joints() {
        for a in 0..columns.terms.len() {
            for b in 0..a {
                let (x, y) = (columns.position(j, a), columns.position(j, b));
                let correlation = covariance[(x, y)] / (covariance[(x, x)] * covariance[(y, y)]).sqrt();
                if correlation.abs() > ALIKE {
                    let [first, second] = [b, a].map(|t| columns.terms[t].name(j));
                    warnings.push(format!(
                        "{first} and {second} can hardly be distinguished (correlation {correlation:.3}): record joint {} at more \
                         speeds, in both directions",
                        j + 1
                    ));
                }
            }
        }
    }
    warnings
}
