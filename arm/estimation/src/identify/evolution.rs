//! Bodies and joint terms by differential evolution, as papers do it: the baseline of the convex fit.
//!
//! # Reference
//! Saadatzi, Long, Celik (2019), eq. 6: DE/best/1/bin, joint 2 weighed six-fold. Differs from it by refusing bodies that cannot exist and by
//! bounds as wide as the body rather than as its nominal numbers.

use hysteron_base::{BadInput, Bounds};
use hysteron_fit::{GlobalOptions, Parameter, ParameterScale, search_globally};
use nalgebra::DVector;

use super::bodies::BodyOptions;
use super::motion::JointMotion;
use super::normal::{JointNormal, JointTerm, RegressionColumns};
use super::pseudo_inertia::{InertialParameters, matrix, nearest_consistent};
use hysteron_arm_dynamics::Model;
use hysteron_arm_dynamics::spatial::Inertia;

/// The outcome.
#[derive(Debug, Clone, PartialEq)]
pub struct EvolutionFit {
    /// Ten numbers of every body, then the terms of every joint.
    pub parameters: Vec<f64>,
    /// Root mean square of what is left of every joint's torque [N m].
    pub rms: Vec<f64>,
    /// Least eigenvalue of the pseudo-inertia of every body: above 0 where it can exist.
    pub least_pseudo_inertias: Vec<f64>,
    /// Generations passed.
    pub generations: usize,
    /// Evaluations of the cost.
    pub evaluations: usize,
    /// True if the costs of the population came together.
    pub is_converged: bool,
}

/// Factors of a nominal mass, and of its largest moment, within which the body is looked for.
const MASSES: [f64; 2] = [0.5, 1.5];
const MAX_MOMENT: f64 = 3.0;
/// Distance of a centre from the joint's frame, in lengths of the nominal one and of the body's radius of gyration.
const FARTHEST: f64 = 2.0;

/// Finds bodies of `model`, which is also the prior, and joint terms from `motion`, by the global search that is
/// given; the sum of squares has these weights of the joints [-].
///
/// # Errors
/// `BadInput` for a motion of another arm, or weights that are not one above 0 for each joint.
pub fn evolve_bodies(
    model: &Model,
    motion: &JointMotion,
    options: &BodyOptions,
    weights: &[f64],
    search: &GlobalOptions,
) -> Result<EvolutionFit, BadInput> {
    let n = model.n_joints();
    if motion.n_joints != n || motion.n_samples() == 0 {
        return Err(BadInput::new("motion", format!("samples of {n} joints"), motion.n_joints.to_string()));
    }
    if weights.len() != n || !weights.iter().all(|w| w.is_finite() && *w > 0.0) {
        let expected = format!("{n} numbers above 0");
        return Err(BadInput::new("weights", expected, format!("{:?}", weights)));
    }
    let columns = RegressionColumns { model, terms: options.terms, width: options.width };
    columns.check()?;
    let normals = columns.normals(motion);
    let rows = motion.n_samples() as f64;
    let variances: Vec<f64> = weights.iter().map(|w| rows / w).collect();
    let sum = super::bodies::weighed(&normals, &variances);
    let genes = genes(model, options.terms, &normals);
    let cost = |values: &[f64]| -> Result<f64, BadInput> {
        let parameters = parameters(values, n);
        let can_exist = (0..n).all(|k| matrix(&body(&parameters, k)).cholesky().is_some());
        Ok(if can_exist { sum.error(&parameters).max(0.0).sqrt() } else { f64::INFINITY })
    };
    let found = search_globally(&genes, search, cost)?;
    let parameters = parameters(&found.values, n);
    let least = |k: usize| matrix(&body(&parameters, k)).symmetric_eigenvalues().min();
    Ok(EvolutionFit {
        rms: normals.iter().map(|normal| (normal.error(&parameters) / rows).max(0.0).sqrt()).collect(),
        least_pseudo_inertias: (0..n).map(least).collect(),
        parameters: parameters.as_slice().to_vec(),
        generations: found.generations,
        evaluations: found.evaluations,
        is_converged: found.is_converged,
    })
}

/// Mass, centre and moments about it of every body, then the terms of every joint.
fn genes(model: &Model, terms: &[JointTerm], normals: &[JointNormal]) -> Vec<Parameter> {
    let gene = |name: String, bounds: [f64; 2]| {
        let [min, max] = bounds;
        Parameter {
            name,
            start: 0.5 * (min + max),
            bounds: Bounds { min, max },
            scale: ParameterScale::Linear,
            prior: None,
        }
    };
    let mut genes = Vec::new();
    for joint in model.joints() {
        let body = nearest_consistent(&joint.inertia);
        let name = |what: &str| format!("{}: {what}", joint.name);
        genes.push(gene(name("mass"), MASSES.map(|factor| factor * body.mass)));
        let second = body.second_about_centre();
        let largest = second[0].max(second[2]).max(second[5]);
        let far = FARTHEST
            * (body.centre().iter().map(|c| c * c).sum::<f64>().sqrt() + (largest / body.mass).sqrt());
        for axis in ["x", "y", "z"] {
            genes.push(gene(name(axis), [-far, far]));
        }
        for (k, axes) in ["xx", "xy", "yy", "xz", "yz", "zz"].iter().enumerate() {
            let is_moment = matches!(k, 0 | 2 | 5);
            let least = if is_moment { 0.0 } else { -MAX_MOMENT * largest };
            genes.push(gene(name(axes), [least, MAX_MOMENT * largest]));
        }
    }
    for (j, normal) in normals.iter().enumerate() {
        for (t, term) in terms.iter().enumerate() {
            // Alone against the whole torque: as much as the largest part that it could have.
            let at = 10 * model.n_joints() + j * terms.len() + t;
            let most = (normal.square / normal.matrix[(at, at)].max(f64::MIN_POSITIVE)).sqrt();
            let least = if term.is_never_negative() { 0.0 } else { -most };
            genes.push(gene(term.name(j), [least, most]));
        }
    }
    genes
}

/// Parameters that the torques are linear in, from the genes of a candidate.
fn parameters(genes: &[f64], n_joints: usize) -> DVector<f64> {
    let mut parameters = DVector::from_column_slice(genes);
    for k in 0..n_joints {
        let [m, x, y, z, second @ ..] = &genes[10 * k..10 * (k + 1)] else { continue };
        let second = std::array::from_fn(|i| second[i]);
        let body = Inertia::about_centre(*m, [*x, *y, *z], second);
        parameters.rows_mut(10 * k, 10).copy_from_slice(&body.parameters());
    }
    parameters
}

fn body(parameters: &DVector<f64>, k: usize) -> InertialParameters {
    parameters.fixed_rows::<10>(10 * k).into_owned()
}
