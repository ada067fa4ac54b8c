//! Decomposition of torques: inertia, Coriolis and centrifugal forces, gravity, and the rest.

use nalgebra::{DMatrix, DVector};

use super::ArmSamples;
use super::network::{Evaluator, NetworkShape, TermKind};
use super::objective::motion;

/// Parts of the torques of samples, [sample][joint] [N m or N].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Decomposition {
    /// All of it.
    pub torque: Vec<f64>,
    /// H q̈.
    pub inertial: Vec<f64>,
    /// c(q, q̇).
    pub coriolis: Vec<f64>,
    /// g(q).
    pub gravity: Vec<f64>,
    /// Friction, or what the network of (8) adds.
    pub other: Vec<f64>,
}

/// The parts of a model's torques.
///
/// Of a model of velocities: gravity is its torque at rest, the inertial part is what q̈ adds at rest, and Coriolis torques are
/// what q̇ adds without q̈; for a structured Lagrangian these are the terms of (4) exactly. Of a Hamiltonian: H is the inverse of
/// ∂q̇/∂p, gravity its torque at p = 0, and Coriolis torques are what is left.
pub fn decompose(shape: &NetworkShape, parameters: &[f64], samples: &ArmSamples) -> Decomposition {
    let all = || 0..samples.len();
    let zeros = vec![0.0; samples.q.len()];
    let mut evaluator = Evaluator::new(shape);
    evaluator.evaluate(parameters, motion(samples, shape.variant), all());
    if shape.variant.is_hamiltonian() {
        return of_hamiltonian(shape, parameters, samples, evaluator);
    }
    let torque = evaluator.outputs.clone();
    let is_mixed = evaluator.kinds().count() > 1;
    let other = if is_mixed { evaluator.parts[1].clone() } else { zeros.clone() };
    debug_assert!(!is_mixed || evaluator.kinds().next() == Some(TermKind::StructuredLagrangian));
    let mut at = |v: &[f64], a: &[f64]| {
        evaluator.evaluate(parameters, [&samples.q, v, a], all());
        evaluator.parts[0].clone()
    };
    let gravity = at(&zeros, &zeros);
    let less = |values: Vec<f64>| values.iter().zip(&gravity).map(|(v, g)| v - g).collect::<Vec<f64>>();
    let inertial = less(at(&zeros, &samples.ddq));
    let coriolis = less(at(&samples.dq, &zeros));
    Decomposition { torque, inertial, coriolis, gravity, other }
}

fn of_hamiltonian(
    shape: &NetworkShape,
    parameters: &[f64],
    samples: &ArmSamples,
    mut evaluator: Evaluator<f64>,
) -> Decomposition {
    let n = shape.n_joints();
    let torques =
        |outputs: &[f64]| outputs.chunks_exact(2 * n).flat_map(|y| y[..n].to_vec()).collect::<Vec<_>>();
    let torque = torques(&evaluator.outputs);
    let zeros = vec![0.0; samples.q.len()];
    evaluator.evaluate(parameters, [&samples.q[..], &zeros, &zeros], 0..samples.len());
    let gravity = torques(&evaluator.outputs);
    // A_j = ∂q̇/∂p_j by central differences: exact where ℋ is quadratic in p.
    let columns: Vec<Vec<f64>> = (0..n)
        .map(|j| {
            let h = 1e-4 * shape.scales.speeds[j];
            let mut at = |h: f64| {
                let mut p = samples.momenta[0].clone();
                p.iter_mut().skip(j).step_by(n).for_each(|p| *p += h);
                evaluator.evaluate(parameters, [&samples.q[..], &p, &zeros], 0..samples.len());
                evaluator.outputs.clone()
            };
            at(h).iter().zip(at(-h)).map(|(a, b)| (a - b) / (2.0 * h)).collect()
        })
        .collect();
    let inverse_mass = |row: usize| DMatrix::from_fn(n, n, |i, j| columns[j][row * 2 * n + n + i]);
    let inertial: Vec<f64> = samples
        .ddq
        .chunks_exact(n)
        .enumerate()
        .flat_map(|(row, ddq)| {
            // Nothing keeps the network of a black box from a singular matrix: then there is no such torque.
            let found = inverse_mass(row).lu().solve(&DVector::from_column_slice(ddq));
            found.map_or_else(|| vec![f64::NAN; n], |x| x.as_slice().to_vec())
        })
        .collect();
    let parts = torque.iter().zip(&inertial).zip(&gravity);
    let coriolis = parts.map(|((t, i), g)| t - i - g).collect();
    Decomposition { torque, inertial, coriolis, gravity, other: zeros }
}
