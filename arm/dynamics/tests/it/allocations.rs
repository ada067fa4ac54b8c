//! Nothing is allocated after set-up.

use hysteron_arm_dynamics::*;

use hysteron_arm_fixtures::robots::model;

/// Fails where `call` allocates; it has been called once before, so that what grows has grown.
fn allocates_nothing(what: &str, mut call: impl FnMut()) {
    call();
    let found = allocation_counter::measure(call);
    assert_eq!(found.count_total, 0, "{what}");
}

#[test]
fn single_calls_allocate_nothing() {
    for name in ["panda", "so101"] {
        let model = model(name);
        let n = model.n_joints();
        let mut data = Data::new(&model, 0.0);
        let [q, dq, given] = [0.3, -0.2, 0.5].map(|x| vec![x; n]);
        let (mut out, mut cotangent) = (vec![0.0; n], Cotangent::new(&model, 1, 0.0));
        let [mut a, mut b, mut c] = [0; 3].map(|_| vec![0.0; n * n]);
        let (mut jacobian, mut wide) = (vec![0.0; 6 * n], vec![0.0; 10 * n * n]);
        let external = [ExternalForce { frame: model.frames().len() - 1, force: [1.0; 3], torque: [0.0; 3] }];
        let state = [&q[..], &dq, &given];
        allocates_nothing("inverse dynamics", || {
            inverse_dynamics(&model, &mut data, state, &external, &mut out)
        });
        allocates_nothing("forward dynamics and its adjoint", || {
            forward_dynamics(&model, &mut data, state, &external, &mut out);
            forward_dynamics_adjoint(&model, &mut data, &external, &given, &mut cotangent);
            parameter_adjoint(&data, &out, &mut cotangent);
        });
        allocates_nothing("mass matrix", || mass_matrix(&model, &mut data, &q, &mut a));
        allocates_nothing("Coriolis matrix", || coriolis_matrix(&model, &mut data, [&q, &dq], &mut a));
        allocates_nothing("gravity, Coriolis torque", || {
            gravity_torque(&model, &mut data, &q, &mut out);
            coriolis_torque(&model, &mut data, [&q, &dq], &mut out);
        });
        allocates_nothing("derivatives", || {
            inverse_dynamics_derivatives(&model, &mut data, state, &external, [&mut a, &mut b, &mut c]);
            forward_dynamics_derivatives(
                &model,
                &mut data,
                state,
                &external,
                &mut out,
                [&mut a, &mut b, &mut c],
            );
        });
        allocates_nothing("regressor", || regressor(&model, &mut data, state, &mut wide));
        allocates_nothing("energies", || {
            kinetic_energy(&model, &mut data, &q, &dq);
            potential_energy(&model, &mut data, &q);
        });
        allocates_nothing("Jacobian", || {
            forward_kinematics(&model, &mut data, &q);
            frame_jacobian(&model, &data, model.frames().len() - 1, &mut jacobian);
        });
    }
}

#[test]
fn steps_and_their_gradients_allocate_nothing() {
    let model = model("panda");
    let n = model.n_joints();
    let with_friction = Integrator::WithFriction(EndStops::Rigid);
    for integrator in [Integrator::SemiImplicitEuler, Integrator::RungeKutta4, with_friction] {
        let mut stepper = ArmStepper::new(&model, integrator, (1e-3, 4), 0, 0.0);
        let mut gradient = StepGradient::new(&model, 0, 0.0);
        let (tau, mut tape) = (vec![0.1; n], Vec::new());
        let [mut q, mut dq, mut by_q, mut by_dq] = [0.1, 0.0, 1.0, 0.5].map(|x| vec![x; n]);
        allocates_nothing("a step and its way back", || {
            stepper.step(&model, [&mut q, &mut dq], &tau, &[], &mut tape);
            stepper.step_back(&model, &mut tape, &tau, &[], [&mut by_q, &mut by_dq], &mut gradient);
        });
    }
    let rubbing = Model::builtin("open-manipulator-x").unwrap();
    let mut simulator = Simulator::new(&rubbing, 1e-3, 4, EndStops::Rigid);
    let n = rubbing.n_joints();
    let (mut q, mut dq, tau) = (vec![0.01; n], vec![0.0; n], vec![0.5; n]);
    for _ in 0..500 {
        allocates_nothing("a step with friction and stops", || simulator.step([&mut q, &mut dq], &tau, &[]));
    }
}
