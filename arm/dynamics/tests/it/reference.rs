//! Every quantity compared with Pinocchio's.

use hysteron_arm_dynamics::*;

use hysteron_arm_fixtures::robots::{assert_close, each};

/// Relative to the greatest number of a quantity: what the task asks for.
const TOLERANCE: f64 = 1e-9;

/// Quantities that vanish (the Coriolis torque of a plane pendulum at zero) are compared on this scale [N m].
fn close(what: &str, got: &[f64], expected: &[f64]) {
    let vanishes = expected.iter().all(|x| x.abs() < 1e-12);
    if vanishes {
        assert!(got.iter().all(|x| x.abs() < 1e-12), "{what}: {got:?}");
    } else {
        assert_close(what, got, expected, TOLERANCE);
    }
}

#[test]
fn torques_accelerations_and_masses() {
    each(|name, model, _, s| {
        let n = model.n_joints();
        let mut data = Data::new(model, 0.0);
        let mut out = vec![0.0; n];
        inverse_dynamics(model, &mut data, [&s.q, &s.v, &s.a], &[], &mut out);
        close(&format!("{name}: inverse dynamics"), &out, &s.inverse_dynamics);
        forward_dynamics(model, &mut data, [&s.q, &s.v, &s.tau], &[], &mut out);
        close(&format!("{name}: forward dynamics"), &out, &s.forward_dynamics);
        coriolis_torque(model, &mut data, [&s.q, &s.v], &mut out);
        close(&format!("{name}: Coriolis torque"), &out, &s.coriolis_times_v);
        gravity_torque(model, &mut data, &s.q, &mut out);
        close(&format!("{name}: gravity"), &out, &s.gravity);
        let mut mass = vec![0.0; n * n];
        mass_matrix(model, &mut data, &s.q, &mut mass);
        close(&format!("{name}: mass matrix"), &mass, &s.mass_matrix.concat());
        let mut coriolis = vec![0.0; n * n];
        coriolis_matrix(model, &mut data, [&s.q, &s.v], &mut coriolis);
        let torque: Vec<f64> =
            coriolis.chunks(n).map(|row| row.iter().zip(&s.v).map(|(c, v)| c * v).sum()).collect();
        close(&format!("{name}: Coriolis matrix times speed"), &torque, &s.coriolis_times_v);
        let kinetic = kinetic_energy(model, &mut data, &s.q, &s.v);
        close(&format!("{name}: kinetic energy"), &[kinetic], &[s.kinetic_energy]);
        let potential = potential_energy(model, &mut data, &s.q);
        close(&format!("{name}: potential energy"), &[potential], &[s.potential_energy]);
    });
}

#[test]
fn derivatives_of_inverse_and_forward_dynamics() {
    each(|name, model, _, s| {
        let n = model.n_joints();
        let mut data = Data::new(model, 0.0);
        let [mut a, mut b, mut c] = [0; 3].map(|_| vec![0.0; n * n]);
        // The files hold ∂τ/∂q at the accelerations of forward dynamics, which were computed last, into the same memory.
        // At other accelerations `derivatives` compares with a complex step.
        let at = [&s.q[..], &s.v, &s.forward_dynamics];
        inverse_dynamics_derivatives(model, &mut data, at, &[], [&mut a, &mut b, &mut c]);
        close(&format!("{name}: ∂τ/∂q"), &a, &s.d_id_dq.concat());
        close(&format!("{name}: ∂τ/∂q̇"), &b, &s.d_id_dv.concat());
        close(&format!("{name}: ∂τ/∂q̈"), &c, &s.d_id_da.concat());
        let mut ddq = vec![0.0; n];
        let by = [&mut a[..], &mut b, &mut c];
        forward_dynamics_derivatives(model, &mut data, [&s.q, &s.v, &s.tau], &[], &mut ddq, by);
        close(&format!("{name}: ∂q̈/∂q"), &a, &s.d_fd_dq.concat());
        close(&format!("{name}: ∂q̈/∂q̇"), &b, &s.d_fd_dv.concat());
        close(&format!("{name}: ∂q̈/∂τ"), &c, &s.d_fd_dtau.concat());
    });
}

#[test]
fn pose_and_jacobian_of_the_tip() {
    each(|name, model, reference, s| {
        let frame = model.frame(&reference.tip_frame).unwrap();
        let mut data = Data::new(model, 0.0);
        forward_kinematics(model, &mut data, &s.q);
        let pose = frame_pose(model, &data, frame);
        for row in 0..3 {
            close(&format!("{name}: rotation"), &pose.rotation[row], &s.tip_in_world[row][..3]);
        }
        let position: Vec<f64> = s.tip_in_world[..3].iter().map(|row| row[3]).collect();
        close(&format!("{name}: position"), &pose.position, &position);
        let mut jacobian = vec![0.0; 6 * model.n_joints()];
        frame_jacobian(model, &data, frame, &mut jacobian);
        close(&format!("{name}: Jacobian"), &jacobian, &s.tip_jacobian_world_aligned.concat());
    });
}
