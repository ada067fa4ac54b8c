//! Properties of any rigid body: skew symmetry, linearity in the parameters, power.

use hysteron_arm_dynamics::*;

use hysteron_arm_fixtures::numbers::{Complex, STEP};
use hysteron_arm_fixtures::robots::{assert_close, each};

/// Rounding of sums of a hundred terms.
const TOLERANCE: f64 = 1e-12;

fn moving(q: &[f64], v: &[f64]) -> Vec<Complex> {
    q.iter().zip(v).map(|(x, v)| Complex { x: *x, y: STEP * v }).collect()
}

#[test]
fn rate_of_the_mass_matrix_less_twice_coriolis_is_skew() {
    each(|name, model, _, s| {
        let n = model.n_joints();
        let zero = Complex { x: 0.0, y: 0.0 };
        let (mut data, mut mass) = (Data::new(model, zero), vec![zero; n * n]);
        mass_matrix(model, &mut data, &moving(&s.q, &s.v), &mut mass);
        let (mut data, mut c) = (Data::new(model, 0.0), vec![0.0; n * n]);
        coriolis_matrix(model, &mut data, [&s.q, &s.v], &mut c);
        let scale = c.iter().fold(1e-12_f64, |m, x| m.max(x.abs()));
        for i in 0..n {
            for j in 0..n {
                let symmetric = mass[n * i + j].y / STEP - c[n * i + j] - c[n * j + i];
                assert!(symmetric.abs() <= TOLERANCE * scale, "{name}: {i}, {j}: {symmetric:e}");
            }
        }
    });
}

#[test]
fn regressor_times_parameters_is_the_torque() {
    each(|name, model, _, s| {
        let n = model.n_joints();
        let (mut data, mut tau, mut y) = (Data::new(model, 0.0), vec![0.0; n], vec![0.0; 10 * n * n]);
        inverse_dynamics(model, &mut data, [&s.q, &s.v, &s.a], &[], &mut tau);
        regressor(model, &mut data, [&s.q, &s.v, &s.a], &mut y);
        let parameters: Vec<f64> = data.inertias.iter().flat_map(|i| i.parameters()).collect();
        let product: Vec<f64> =
            y.chunks(10 * n).map(|row| row.iter().zip(&parameters).map(|(a, b)| a * b).sum()).collect();
        assert_close(&format!("{name}: Y π"), &product, &tau, 1e-11);
    });
}

#[test]
fn power_of_the_torques_is_the_rate_of_energy() {
    each(|name, model, _, s| {
        let n = model.n_joints();
        let zero = Complex { x: 0.0, y: 0.0 };
        let (q, v) = (moving(&s.q, &s.v), moving(&s.v, &s.a));
        let mut data = Data::new(model, zero);
        let energy = kinetic_energy(model, &mut data, &q, &v) + potential_energy(model, &mut data, &q);
        let (mut data, mut tau) = (Data::new(model, 0.0), vec![0.0; n]);
        inverse_dynamics(model, &mut data, [&s.q, &s.v, &s.a], &[], &mut tau);
        let power: f64 = tau.iter().zip(&s.v).map(|(t, v)| t * v).sum();
        let scale: f64 = tau.iter().zip(&s.v).map(|(t, v)| (t * v).abs()).sum();
        assert!((energy.y / STEP - power).abs() <= 1e-11 * scale, "{name}: {} W, {power} W", energy.y / STEP);
    });
}

#[test]
fn force_at_the_base_is_the_rate_of_momentum() {
    each(|name, model, _, s| {
        let zero = Complex { x: 0.0, y: 0.0 };
        let mut data = Data::new(model, zero);
        let momentum = momentum(model, &mut data, &moving(&s.q, &s.v), &moving(&s.v, &s.a));
        // The joint at the base feels of the rate of momentum, weight taken off, what is along its axis: only a sum over
        // all joints of a chain is compared, by the power of a virtual motion of the first joint.
        let (mut data, mut tau, mut weight) =
            (Data::new(model, 0.0), vec![0.0; s.q.len()], vec![0.0; s.q.len()]);
        inverse_dynamics(model, &mut data, [&s.q, &s.v, &s.a], &[], &mut tau);
        gravity_torque(model, &mut data, &s.q, &mut weight);
        forward_kinematics(model, &mut data, &s.q);
        let (mut jacobian, frame) = (vec![0.0; 6 * s.q.len()], model.frame(&model.joints()[0].name.clone()));
        assert_eq!(frame.unwrap_err().place, "frame", "frames are named after links");
        let first = model.frames().iter().position(|frame| frame.joint == Some(0)).unwrap();
        frame_jacobian(model, &data, first, &mut jacobian);
        let n = s.q.len();
        let column: Vec<f64> = (0..6).map(|row| jacobian[n * row]).collect();
        let point = frame_pose(model, &data, first).position;
        let [force, moment] = [momentum.force, momentum.moment].map(|p| p.map(|c| c.y / STEP));
        // Power of the rate of momentum in that motion, taken about the frame's origin.
        let about = [
            moment[0] - (point[1] * force[2] - point[2] * force[1]),
            moment[1] - (point[2] * force[0] - point[0] * force[2]),
            moment[2] - (point[0] * force[1] - point[1] * force[0]),
        ];
        let power: f64 = (0..3).map(|c| column[c] * force[c] + column[3 + c] * about[c]).sum();
        let expected = tau[0] - weight[0];
        let scale = tau[0].abs().max(weight[0].abs()).max(expected.abs());
        assert!((power - expected).abs() <= 1e-11 * scale, "{name}: {power}, {expected}");
    });
}
