//! Torques against dual-number-free references: closed forms of a network's own energy by differences, and gradients.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

use hysteron_learn::{Activation, LeastSquares, Objective};

use super::network::Evaluator;
use super::objective::motion;
use super::{ArmSamples, InputForm, JointWeights, NetworkShape, Scales, TorqueObjective, Variant};

const N: usize = 3;

fn shape(variant: Variant) -> NetworkShape {
    let scales = Scales {
        speeds: vec![1.5, 0.8, 2.0],
        accelerations: vec![3.0, 2.0, 1.0],
        torques: vec![4.0, 2.0, 1.0],
        factor: vec![1.3, 0.9, 0.5],
        energy: 3.0,
    };
    NetworkShape {
        variant,
        hidden: vec![6, 5],
        activation: Activation::Softplus,
        epsilon: 1e-2,
        scales,
        lengths: vec![None, None, Some(0.5)],
        inputs: InputForm::SinesAndCosines,
        squares: 0,
    }
}

fn parameters(shape: &NetworkShape) -> Vec<f64> {
    let begin = shape.initial_parameters(3);
    begin.iter().enumerate().map(|(i, p)| p + 0.2 * (1.3 * i as f64).sin()).collect()
}

fn samples(n: usize) -> ArmSamples {
    let numbers = |seed: f64| (0..n * N).map(|i| (1.1 * i as f64 + seed).sin()).collect::<Vec<_>>();
    let mut samples = ArmSamples::new(N);
    let [q, dq, ddq, tau, p, dp] = [0.0, 0.4, 0.9, 1.7, 2.2, 2.9].map(numbers);
    samples.push([&q, &dq, &ddq, &tau], [&p, &dp]).unwrap();
    samples
}

/// Outputs of one sample for (q, v, a).
fn outputs(shape: &NetworkShape, p: &[f64], [q, v, a]: [&[f64]; 3]) -> Vec<f64> {
    let mut evaluator = Evaluator::new(shape);
    evaluator.evaluate(p, [q, v, a], 0..1);
    evaluator.outputs
}

fn moved(x: &[f64], j: usize, h: f64) -> Vec<f64> {
    x.iter().enumerate().map(|(i, x)| x + if i == j { h } else { 0.0 }).collect()
}

/// The mass matrix, column by column, of a model that is linear in q̈.
fn mass(shape: &NetworkShape, p: &[f64], q: &[f64], v: &[f64]) -> Vec<Vec<f64>> {
    let zero = outputs(shape, p, [q, v, &[0.0; N]]);
    let column = |j: usize| {
        let tau = outputs(shape, p, [q, v, &moved(&[0.0; N], j, 1.0)]);
        tau.iter().zip(&zero).map(|(a, b)| a - b).collect()
    };
    (0..N).map(column).collect()
}

#[test]
fn torques_of_a_structured_lagrangian_follow_from_its_own_mass_matrix() {
    // τ = H q̈ + Ḣ q̇ − ½ ∂_q q̇ᵀ H q̇ + g with H and g read off at rest and differentiated by central differences.
    for squares in [0, 3] {
        follow_from_the_mass_matrix(&NetworkShape { squares, ..shape(Variant::StructuredLagrangian) });
    }
}

fn follow_from_the_mass_matrix(shape: &NetworkShape) {
    let p = parameters(shape);
    let (q, dq, ddq) = ([0.3, -0.8, 0.5], [0.7, 1.1, -0.6], [0.4, -1.2, 0.9]);
    let tau = outputs(shape, &p, [&q, &dq, &ddq]);
    let gravity = outputs(shape, &p, [&q, &[0.0; N], &[0.0; N]]);
    let (h, tol) = (1e-5, 1e-8);
    let mass_at = |q: &[f64]| mass(shape, &p, q, &[0.0; N]);
    let here = mass_at(&q);
    let slopes: Vec<Vec<Vec<f64>>> = (0..N)
        .map(|k| {
            let (after, before) = (mass_at(&moved(&q, k, h)), mass_at(&moved(&q, k, -h)));
            (0..N).map(|i| (0..N).map(|j| (after[i][j] - before[i][j]) / (2.0 * h)).collect()).collect()
        })
        .collect();
    for i in 0..N {
        let mut expected = gravity[i];
        for j in 0..N {
            assert!((here[i][j] - here[j][i]).abs() < 1e-12, "symmetric");
            expected += here[j][i] * ddq[j];
            for k in 0..N {
                expected += slopes[k][i][j] * dq[k] * dq[j] - 0.5 * slopes[i][j][k] * dq[j] * dq[k];
            }
        }
        assert!((tau[i] - expected).abs() < tol, "joint {i}: {} {expected}", tau[i]);
    }
    // Energy is not created: a potential's torque does no work around a loop. Here: its curl vanishes.
    let g = |q: &[f64]| outputs(shape, &p, [q, &[0.0; N], &[0.0; N]]);
    for i in 0..N {
        for j in 0..i {
            let slope = |a: usize, b: usize| (g(&moved(&q, b, h))[a] - g(&moved(&q, b, -h))[a]) / (2.0 * h);
            assert!((slope(i, j) - slope(j, i)).abs() < tol);
        }
    }
}

#[test]
fn a_black_box_lagrangian_obeys_the_power_balance() {
    // With E = q̇ᵀ ∂ℒ/∂q̇ − ℒ: Ė = q̇ᵀ τ along any motion. p = ∂ℒ/∂q̇ follows from ∂τ/∂q̈ being its slope; both are found
    // by integrating the torque along a short motion instead: ∮ over a closed motion in (q, q̇) of q̇ᵀ τ dt is zero.
    let shape = shape(Variant::BlackBoxLagrangian);
    let p = parameters(&shape);
    let steps = 400;
    let mut work = 0.0;
    let mut size = 0.0;
    for s in 0..steps {
        let t = std::f64::consts::TAU * f64::from(s) / f64::from(steps);
        let q: Vec<f64> = (0..N).map(|j| 0.7 * (t + j as f64).sin() + 0.2 * (2.0 * t).cos()).collect();
        let dq: Vec<f64> = (0..N).map(|j| 0.7 * (t + j as f64).cos() - 0.4 * (2.0 * t).sin()).collect();
        let ddq: Vec<f64> = (0..N).map(|j| -0.7 * (t + j as f64).sin() - 0.8 * (2.0 * t).cos()).collect();
        let tau = outputs(&shape, &p, [&q, &dq, &ddq]);
        let power: f64 = tau.iter().zip(&dq).map(|(t, v)| t * v).sum();
        work += power;
        size += power.abs();
    }
    // The rectangle rule converges faster than any power of the step on periodic motions.
    assert!(work.abs() < 1e-10 * size && size > 1.0, "{work} of {size}");
}

#[test]
fn hamiltonians_conserve_energy_in_free_motion() {
    // τ = 0 means ṗ = −∂ℋ/∂q; then q̇ and ṗ are orthogonal to the gradient: power of q̇ᵀ τ is the rate of ℋ.
    // ∮ q̇(q, p)ᵀ (ṗ + ∂_q ℋ) dt = ∮ ℋ̇ dt = 0 needs q̇ to be that of the model: with p(t) given, take q' = dq/dt of the
    // closed curve and check ∮ (∂_q ℋ · q' + q̇ · p') dt = 0.
    let variants = [Variant::StructuredHamiltonian, Variant::BlackBoxHamiltonian];
    let forms = [InputForm::SinesAndCosines, InputForm::Products(2)];
    for (variant, inputs) in variants.into_iter().flat_map(|variant| forms.map(|form| (variant, form))) {
        let shape = NetworkShape { inputs, ..shape(variant) };
        let params = parameters(&shape);
        let steps = 400;
        let (mut sum, mut size) = (0.0, 0.0);
        for s in 0..steps {
            let t = std::f64::consts::TAU * f64::from(s) / f64::from(steps);
            let of = |f: &dyn Fn(f64) -> f64| (0..N).map(|j| f(t + 1.3 * j as f64)).collect::<Vec<f64>>();
            let (q, dq) = (of(&|a| 0.7 * a.sin()), of(&|a| 0.7 * a.cos()));
            let (p, dp) = (of(&|a| 0.9 * (2.0 * a).sin()), of(&|a| 1.8 * (2.0 * a).cos()));
            let y = outputs(&shape, &params, [&q, &p, &dp]);
            let rate: f64 = (0..N).map(|j| (y[j] - dp[j]) * dq[j] + y[N + j] * dp[j]).sum();
            sum += rate;
            size += rate.abs();
        }
        assert!(sum.abs() < 1e-10 * size && size > 1.0, "{variant:?} {inputs:?}: {sum} of {size}");
    }
}

#[test]
fn gradients_of_the_loss_are_those_of_differences() {
    let data = samples(7);
    let forms = [(InputForm::SinesAndCosines, 0), (InputForm::Products(3), 0), (InputForm::Products(2), 4)];
    for (variant, (inputs, squares)) in Variant::ALL.into_iter().flat_map(|v| forms.map(|form| (v, form))) {
        let shape = NetworkShape { inputs, squares, ..shape(variant) };
        shape.check().unwrap();
        let p = parameters(&shape);
        let mut objective = TorqueObjective::new(&shape, [&data, &data], JointWeights::InverseVariance, 0.3);
        let rows: Vec<usize> = (0..data.len()).collect();
        let mut gradient = vec![0.0; p.len()];
        let loss = objective.gradient(&p, &rows, &mut gradient);
        let mut other = vec![0.0; p.len()];
        // Along several directions: central differences of step h err by rounding 1e-16 loss/h and by h² times a third derivative, which
        // is some 10⁴ for directions as long as these.
        let (h, tol) = (1e-6, 1e-7 * loss);
        for k in 0..4 {
            let direction: Vec<f64> = (0..p.len()).map(|i| (0.7 * i as f64 + f64::from(k)).cos()).collect();
            let mut at = |t: f64| {
                let p: Vec<f64> = p.iter().zip(&direction).map(|(p, d)| p + t * d).collect();
                objective.gradient(&p, &rows, &mut other)
            };
            let slope = (at(h) - at(-h)) / (2.0 * h);
            let found: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
            assert!((found - slope).abs() < tol.max(1e-6 * slope.abs()), "{variant:?}: {found} {slope}");
            assert!(slope.abs() > 1e-3 * loss, "{variant:?}: {slope}");
        }
    }
}

#[test]
fn products_are_over_joints_that_differ_and_none_is_there_twice() {
    // Of three joints: 6 numbers, 3 pairs with 4 products each, 8 products of three.
    for (degree, expected) in [(1, 6), (2, 18), (3, 26), (4, 26)] {
        let shape = NetworkShape { inputs: InputForm::Products(degree), ..shape(Variant::FeedForward) };
        assert_eq!(shape.features().len(), expected, "{degree}");
    }
    let shape = NetworkShape { inputs: InputForm::Products(5), ..shape(Variant::FeedForward) };
    assert!(shape.check().unwrap_err().to_string().contains("products over 1 to 4 joints"));
}

#[test]
fn squares_beyond_what_is_held_are_refused() {
    let shape = NetworkShape { squares: 47, ..shape(Variant::Friction) };
    assert_eq!(
        shape.check().unwrap_err().to_string(),
        "network: squares: expected 0 to 46 squares of 3 joints, got 47"
    );
}

#[test]
fn single_precision_agrees_with_double() {
    let data = samples(200);
    for variant in Variant::ALL {
        let shape = shape(variant);
        let p = parameters(&shape);
        let single: Vec<f32> = p.iter().map(|v| *v as f32).collect();
        let mut doubles = Evaluator::<f64>::new(&shape);
        let mut singles = Evaluator::<f32>::new(&shape);
        doubles.evaluate(&p, motion(&data, variant), 0..data.len());
        singles.evaluate(&single, motion(&data, variant), 0..data.len());
        let size = doubles.outputs.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        for (a, b) in doubles.outputs.iter().zip(&singles.outputs) {
            // Some tens of roundings through three layers, their derivatives and products of matrices.
            assert!(
                (a - f64::from(*b)).abs() < 100.0 * f64::from(f32::EPSILON) * size,
                "{variant:?}: {a} {b}"
            );
        }
    }
}

#[test]
fn learned_mass_matrices_are_positive_definite_for_any_parameters() {
    for (seed, squares) in (0..20).zip([0, 3].into_iter().cycle()) {
        let shape = NetworkShape { squares, ..shape(Variant::StructuredLagrangian) };
        let p: Vec<f64> = shape.initial_parameters(seed).iter().map(|p| 5.0 * p).collect();
        let q = [0.1 * seed as f64, -0.3 * seed as f64, 0.2];
        let h = mass(&shape, &p, &q, &[0.0; N]);
        let minor2 = h[0][0] * h[1][1] - h[0][1] * h[1][0];
        let determinant = (0..N)
            .map(|i| {
                let (j, k) = ((i + 1) % N, (i + 2) % N);
                h[0][i] * (h[1][j] * h[2][k] - h[1][k] * h[2][j])
            })
            .sum::<f64>();
        assert!(h[0][0] > 0.0 && minor2 > 0.0 && determinant > 0.0, "seed {seed}: {h:?}");
    }
}

#[test]
fn samples_that_cannot_be_are_refused() {
    let mut samples = ArmSamples::new(2);
    let row = [0.0, 1.0];
    let bad = samples.push([&row, &row, &[0.0, f64::NAN], &row], [&[], &[]]).unwrap_err();
    assert_eq!(bad.to_string(), "ddq: sample 1, joint 2: expected a finite number, got NaN");
    let bad = samples.push([&row, &row, &row, &[0.0; 3]], [&[], &[]]).unwrap_err();
    assert_eq!(bad.to_string(), "tau: expected 1 samples of 2 joints, got 3 numbers");
    samples.push([&row, &row, &row, &row], [&[], &[]]).unwrap();
    samples.push([&[0.0, 2.0]; 4], [&[], &[]]).unwrap();
    let bad = samples.check_variation().unwrap_err();
    assert!(bad.to_string().starts_with("q: joint 1: expected values that change, got a constant"), "{bad}");
}

#[test]
fn the_jacobian_of_the_residuals_gives_the_gradient_of_their_squares() {
    // 2 Jᵀr over the number of samples, with r from the outputs themselves; sums of some hundred numbers of order 1 in another order.
    for variant in Variant::ALL {
        for (inputs, squares) in [(InputForm::SinesAndCosines, 0), (InputForm::Products(2), 3)] {
            let shape = NetworkShape { inputs, squares, ..shape(variant) };
            let (p, samples, penalty) = (parameters(&shape), samples(9), 0.3);
            let rows: Vec<usize> = (0..9).collect();
            let mut objective =
                TorqueObjective::<f64>::new(&shape, [&samples, &samples], JointWeights::Equal, penalty);
            let mut gradient = vec![0.0; p.len()];
            objective.gradient(&p, &rows, &mut gradient);
            let k = objective.n_residuals();
            let mut jacobian = vec![0.0; rows.len() * k * p.len()];
            objective.jacobian(&p, &rows, &mut jacobian);
            let mut evaluator = Evaluator::new(&shape);
            evaluator.evaluate(&p, motion(&samples, variant), 0..9);
            let m = shape.n_outputs();
            let target = [&samples.tau, &samples.dq];
            let residual = |row: usize, r: usize| match r.checked_sub(m) {
                Some(j) => penalty.sqrt() * evaluator.parts[1][row * N + j],
                None => evaluator.outputs[row * m + r] - target[r / N][row * N + r % N],
            };
            let mut found = vec![0.0; p.len()];
            for (at, by) in jacobian.chunks_exact(p.len()).enumerate() {
                let r = residual(at / k, at % k);
                found.iter_mut().zip(by).for_each(|(sum, by)| *sum += 2.0 * r * by / 9.0);
            }
            let size = gradient.iter().fold(1.0f64, |size, g| size.max(g.abs()));
            for (i, (found, exact)) in found.iter().zip(&gradient).enumerate() {
                assert!((found - exact).abs() < 1e-12 * size, "{variant:?} {i}: {found} {exact}");
            }
        }
    }
}

#[test]
fn a_training_is_the_same_on_any_number_of_threads() {
    let shape = NetworkShape { squares: 1, ..shape(Variant::StructuredLagrangian) };
    let (p, samples) = (parameters(&shape), samples(45));
    let rows: Vec<usize> = (0..45).collect();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut objective =
                TorqueObjective::<f64>::new(&shape, [&samples, &samples], JointWeights::Equal, 0.0);
            let mut gradient = vec![0.0; p.len()];
            let loss = objective.gradient(&p, &rows, &mut gradient);
            let mut jacobian = vec![0.0; rows.len() * objective.n_residuals() * p.len()];
            objective.jacobian(&p, &rows, &mut jacobian);
            (loss, objective.validate(&p), gradient, jacobian)
        })
    };
    let alone = on(1);
    for threads in [2, 3, 8, 20] {
        assert_eq!(on(threads), alone, "{threads} threads");
    }
}
