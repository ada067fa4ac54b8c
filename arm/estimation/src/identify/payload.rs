//! A body that an identified arm carries, from what its torques are beyond those of the bare arm.

use hysteron_base::BadInput;
use hysteron_fit::ResidualVariance;
use nalgebra::{DMatrix, DVector, SMatrix};

use super::bodies::{BodyFit, Determined, TermEstimate};
use super::motion::JointMotion;
use super::pseudo_inertia::{InertialParameters, divergence, matrix, nearest_consistent};
use hysteron_arm_dynamics::spatial::Inertia;
use hysteron_arm_dynamics::{Data, Model, regressor};

/// A payload and its uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct PayloadFit {
    /// Mass [kg], centre of mass in the frame [m], second moment about it in the frame's axes (xx, xy, yy, xz, yz, zz) [kg m²].
    pub estimates: Vec<TermEstimate>,
    /// Root mean square of every joint's torque that is left without and with the payload [N m].
    pub rms: [Vec<f64>; 2],
    /// The arm with it.
    pub model: Model,
}

/// Prior of a payload: a kilogramme within five centimetres [kg], [m].
const PRIOR_MASS: f64 = 1.0;
const PRIOR_RADIUS: f64 = 0.05;
/// Weight of that prior, in independent samples of one joint [-].
const PRIOR: f64 = 1.0;
const MAX_STEPS: usize = 100;
/// Variance that a joint's torque never falls below: rounding of simulated data [N² m²].
const SMALLEST_VARIANCE: f64 = 1e-12;

/// Identifies what the arm of `bare`, which was identified without it, carries at the frame called `frame` during `motion`.
/// The body can exist: its pseudo-inertia is positive definite.
///
/// # Errors
/// `BadInput` for a frame that is not there or is on the base, or a motion of another arm.
pub fn identify_payload(bare: &BodyFit, frame: &str, motion: &JointMotion) -> Result<PayloadFit, BadInput> {
    let model = &bare.model;
    let n = model.n_joints();
    if motion.n_joints != n {
        return Err(BadInput::new("motion", format!("{n} joints"), motion.n_joints.to_string()));
    }
    let at = &model.frames()[model.frame(frame)?];
    let Some(joint) = at.joint else {
        return Err(BadInput::new("frame", "one that moves with a joint", format!("{frame:?}, on the base")));
    };
    // Ten numbers in the frame's axes make ten in the joint's.
    let mut placed = SMatrix::<f64, 10, 10>::zeros();
    for k in 0..10 {
        let mut unit = [0.0; 10];
        unit[k] = 1.0;
        let moved = Inertia::from_parameters(unit).placed(&at.pose.rotation, at.pose.position).parameters();
        placed.set_column(k, &InertialParameters::from(moved));
    }
    let without: Vec<f64> =
        bare.torques(motion).iter().zip(&motion.tau).map(|(found, measured)| measured - found).collect();
    let columns = columns(model, motion, joint, &placed);
    let prior = prior();
    let mut variances: Vec<f64> = (0..n).map(|j| variance(&without, n, j)).collect();
    let mut found = InertialParameters::from(prior.parameters());
    for _ in 0..3 {
        found = minimum(&columns, &without, &variances, found)?.0;
        let left = left(&columns, &without, &found);
        variances = (0..n).map(|j| variance(&left, n, j)).collect();
    }
    let rest = left(&columns, &without, &found);
    // Neighbouring residuals are correlated: their effective number decides the standard errors.
    let spreads: Vec<f64> = (0..n)
        .map(|j| {
            let series = rest.iter().skip(j).step_by(n).copied().collect();
            ResidualVariance::new(&[series], 10 / n + 1).variance.max(SMALLEST_VARIANCE)
        })
        .collect();
    let (_, curvature) = minimum(&columns, &without, &spreads, found)?;
    let covariance = inverse(&curvature).unwrap_or_else(|| SMatrix::from_diagonal_element(f64::INFINITY));
    let inertia = Inertia::from_parameters(found.data.0[0]);
    let rms = |errors: &[f64]| (0..n).map(|j| variance(errors, n, j).sqrt()).collect();
    Ok(PayloadFit {
        estimates: estimates(&found, &covariance),
        rms: [rms(&without), rms(&rest)],
        model: model.with_payload(frame, inertia.mass, inertia.centre(), inertia.second_about_centre())?,
    })
}

fn prior() -> Inertia<f64> {
    // So wide in every direction, a body has twice m r² about every axis.
    let moment = 2.0 * PRIOR_MASS * PRIOR_RADIUS * PRIOR_RADIUS;
    nearest_consistent(&Inertia::about_centre(PRIOR_MASS, [0.0; 3], [moment, 0.0, moment, 0.0, 0.0, moment]))
}

/// Regressor of the payload: derivatives of every torque by its ten inertial parameters (10 × rows).
fn columns(model: &Model, motion: &JointMotion, joint: usize, placed: &SMatrix<f64, 10, 10>) -> DMatrix<f64> {
    let n = model.n_joints();
    let (mut data, mut of_bodies) = (Data::new(model, 0.0), vec![0.0; 10 * n * n]);
    let mut columns = DMatrix::zeros(10, motion.tau.len());
    for s in 0..motion.n_samples() {
        let at = s * n..(s + 1) * n;
        let state = [&motion.q[at.clone()], &motion.dq[at.clone()], &motion.ddq[at]];
        regressor(model, &mut data, state, &mut of_bodies);
        for j in 0..n {
            let from = 10 * n * j + 10 * joint;
            let own = InertialParameters::from_row_slice(&of_bodies[from..from + 10]);
            columns.set_column(s * n + j, &(placed.transpose() * own));
        }
    }
    columns
}

fn left(columns: &DMatrix<f64>, torques: &[f64], body: &InertialParameters) -> Vec<f64> {
    let body = DVector::from_column_slice(body.as_slice());
    let given = columns.tr_mul(&body);
    torques.iter().zip(given.iter()).map(|(torque, given)| torque - given).collect()
}

fn variance(errors: &[f64], n: usize, joint: usize) -> f64 {
    let squares = errors.iter().skip(joint).step_by(n).map(|e| e * e);
    (squares.sum::<f64>() * n as f64 / errors.len() as f64).max(SMALLEST_VARIANCE)
}

/// The body of least weighed squares and divergence from the prior, by Newton's method with halved steps, and the
/// curvature there.
fn minimum(
    columns: &DMatrix<f64>,
    torques: &[f64],
    variances: &[f64],
    start: InertialParameters,
) -> Result<(InertialParameters, SMatrix<f64, 10, 10>), BadInput> {
    let n = variances.len();
    let (mut square, mut side) = (SMatrix::<f64, 10, 10>::zeros(), InertialParameters::zeros());
    for (k, column) in columns.column_iter().enumerate() {
        let row = InertialParameters::from_column_slice(column.as_slice());
        square += row * row.transpose() / variances[k % n];
        side += row * (torques[k] / variances[k % n]);
    }
    let Some(prior) = matrix(&InertialParameters::from(prior().parameters())).try_inverse() else {
        return Err(BadInput::new("payload", "a body that can exist", "none"));
    };
    let cost = |x: &InertialParameters| {
        let divergence = PRIOR * divergence(x, &prior)?.0;
        Some((0.5 * (x.transpose() * square * x)[0] - side.dot(x)) + divergence)
    };
    let mut x = start;
    let mut curvature = square;
    for _ in 0..MAX_STEPS {
        let Some((_, gradient, hessian)) = divergence(&x, &prior) else { break };
        let gradient = square * x - side + PRIOR * gradient;
        curvature = square + PRIOR * hessian;
        let Some(step) = inverse(&curvature).map(|inverse| -inverse * gradient) else { break };
        let slope = gradient.dot(&step);
        let Some(before) = cost(&x) else { break };
        let mut part = 1.0;
        while part > 1e-12 && cost(&(x + part * step)).is_none_or(|c| c > before + 1e-4 * part * slope) {
            part *= 0.5;
        }
        x += part * step;
        if -slope < 1e-10 || part <= 1e-12 {
            return Ok((x, curvature));
        }
    }
    match cost(&x) {
        Some(_) => Ok((x, curvature)),
        None => Err(BadInput::new("payload", "torques of a body that can exist", "none")),
    }
}

/// Inverse of a positive definite matrix whose rows have very different units.
fn inverse(matrix: &SMatrix<f64, 10, 10>) -> Option<SMatrix<f64, 10, 10>> {
    let scale = matrix.diagonal().map(|x| x.max(f64::MIN_POSITIVE).sqrt());
    let scaled = SMatrix::<f64, 10, 10>::from_fn(|a, b| matrix[(a, b)] / (scale[a] * scale[b]));
    let inverse = scaled.cholesky()?.inverse();
    Some(SMatrix::from_fn(|a, b| inverse[(a, b)] / (scale[a] * scale[b])))
}

/// Mass, centre and moments with their standard errors: those of h/m by propagation.
fn estimates(found: &InertialParameters, covariance: &SMatrix<f64, 10, 10>) -> Vec<TermEstimate> {
    let inertia = Inertia::from_parameters(found.data.0[0]);
    let values = |p: &InertialParameters| {
        let inertia = Inertia::from_parameters(p.data.0[0]);
        let [x, y, z] = inertia.centre();
        let [xx, xy, yy, xz, yz, zz] = inertia.second_about_centre();
        InertialParameters::from([inertia.mass, x, y, z, xx, xy, yy, xz, yz, zz])
    };
    let at = values(found);
    let mut jacobian = SMatrix::<f64, 10, 10>::zeros();
    for k in 0..10 {
        // Central differences of smooth functions, at a step far above rounding and below the body's own numbers.
        let step = 1e-6 * inertia.mass;
        let moved = |sign: f64| {
            let mut p = *found;
            p[k] += sign * step;
            values(&p)
        };
        jacobian.set_column(k, &((moved(1.0) - moved(-1.0)) / (2.0 * step)));
    }
    let spread = jacobian * covariance * jacobian.transpose();
    const NAMES: [&str; 10] = [
        "mass_kg",
        "centre_x_m",
        "centre_y_m",
        "centre_z_m",
        "moment_xx_kg_m2",
        "moment_xy_kg_m2",
        "moment_yy_kg_m2",
        "moment_xz_kg_m2",
        "moment_yz_kg_m2",
        "moment_zz_kg_m2",
    ];
    let estimate = |k: usize| TermEstimate {
        name: NAMES[k].to_owned(),
        value: at[k],
        // A parameter that is not identifiable has an infinite standard error, not zero.
        standard_error: if spread[(k, k)] >= 0.0 { spread[(k, k)].sqrt() } else { f64::INFINITY },
        determined: Determined::Alone,
    };
    (0..10).map(estimate).collect()
}
