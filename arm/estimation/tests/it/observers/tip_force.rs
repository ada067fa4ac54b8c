//! Forces at a frame from torques of joints.

use hysteron_arm_dynamics::*;
use hysteron_arm_estimation::observer::{ContactPrior, TipForceEstimator};
use nalgebra::DMatrix;

use super::motion::panda;

fn torques_of(model: &Model, q: &[f64], force: [f64; 3], frame: usize) -> Vec<f64> {
    // What the joints must hold less with the force than without.
    let n = q.len();
    let (mut with, mut without) = (vec![0.0; n], vec![0.0; n]);
    let zero = vec![0.0; n];
    let mut data = Data::new(model, 0.0);
    let external = [ExternalForce { frame, force, torque: [0.0; 3] }];
    inverse_dynamics(model, &mut data, [q, &zero, &zero], &external, &mut with);
    inverse_dynamics(model, &mut data, [q, &zero, &zero], &[], &mut without);
    without.iter().zip(&with).map(|(a, b)| a - b).collect()
}

#[test]
fn force_comes_back_where_the_arm_can_feel_it() {
    let model = panda();
    let frame = model.frames().len() - 1;
    let q = [0.2, -0.5, 0.3, -1.9, 0.4, 1.6, 0.5];
    let force = [4.0, -7.0, 11.0];
    let torque = torques_of(&model, &q, force, frame);
    let mut tip = TipForceEstimator::new(&model, frame, &[1e-3; 7], ContactPrior::Force(1e3));
    tip.update(&q, &torque);
    for (a, b) in tip.force.iter().zip(force) {
        assert!((a - b).abs() < 1e-6, "{:?}", tip.force);
    }
    let mut tip =
        TipForceEstimator::new(&model, frame, &[1e-3; 7], ContactPrior::Wrench { force: 1e3, torque: 1e3 });
    tip.update(&q, &torque);
    for (a, b) in tip.force.iter().zip([4.0, -7.0, 11.0, 0.0, 0.0, 0.0]) {
        assert!((a - b).abs() < 1e-5, "{:?}", tip.force);
    }
}

#[test]
fn a_singular_arm_has_a_large_variance() {
    // The SCARA stretched out feels nothing along itself, nor out of its plane.
    let model = Model::builtin("scara").unwrap();
    let frame = model.frame("tip").unwrap();
    let mut tip = TipForceEstimator::new(&model, frame, &[0.1, 0.1], ContactPrior::Force(50.0));
    let torque = torques_of(&model, &[0.0, 0.0], [30.0, 5.0, 8.0], frame);
    tip.update(&[0.0, 0.0], &torque);
    assert!(tip.force[0].abs() < 1e-9 && tip.force[2].abs() < 1e-9, "{:?}", tip.force);
    assert!((tip.force[1] - 5.0).abs() < 0.01, "{:?}", tip.force);
    let deviation = |k: usize| tip.covariance[4 * k].sqrt();
    assert!((deviation(0) - 50.0).abs() < 1e-6 && (deviation(2) - 50.0).abs() < 1e-6);
    assert!(deviation(1) < 0.5);
    // Close by, no jump.
    tip.update(&[0.0, 1e-6], &torque);
    assert!(tip.force[0].abs() < 1.0, "{:?}", tip.force);
}

#[test]
fn stated_covariance_is_that_of_the_errors() {
    let model = panda();
    let frame = model.frames().len() - 1;
    let q = [0.2, -0.5, 0.3, -1.9, 0.4, 1.6, 0.5];
    let (torque_deviation, force_deviation) = (0.3, 5.0);
    let mut tip =
        TipForceEstimator::new(&model, frame, &[torque_deviation; 7], ContactPrior::Force(force_deviation));
    let mut random = hysteron_base::rng(3, "tip");
    let mut normal = || hysteron_base::normal(&mut random);
    let (mut sum, n) = (0.0, 4000);
    for _ in 0..n {
        let force = [0; 3].map(|_| force_deviation * normal());
        let mut torque = torques_of(&model, &q, force, frame);
        torque.iter_mut().for_each(|t| *t += torque_deviation * normal());
        tip.update(&q, &torque);
        let error = DMatrix::from_fn(3, 1, |i, _| tip.force[i] - force[i]);
        let covariance = DMatrix::from_row_slice(3, 3, &tip.covariance);
        sum += (error.transpose() * covariance.try_inverse().unwrap() * &error)[0];
    }
    // Mean of chi squared with 3 degrees of freedom; its standard deviation here is √(6/n) = 0.04.
    let mean = sum / f64::from(n);
    assert!((mean - 3.0).abs() < 0.16, "{mean}");
}
