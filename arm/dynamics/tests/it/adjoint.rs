//! The adjoint of forward dynamics compared with dual numbers, and with the full matrices.

use hysteron_arm_dynamics::*;

use hysteron_arm_fixtures::numbers::Dual;
use hysteron_arm_fixtures::robots::{assert_close, each};

const TOLERANCE: f64 = 1e-10;

/// Cotangent of the accelerations.
fn weights(n: usize) -> Vec<f64> {
    (0..n).map(|i| 1.0 - 0.3 * i as f64).collect()
}

/// Everything that accelerations depend on, in one row of numbers.
struct Inputs {
    model: Model,
    numbers: Vec<f64>,
    frame: usize,
}

impl Inputs {
    /// Derivative of w·q̈ by every number, by dual numbers.
    fn gradient(&self) -> Vec<f64> {
        (0..self.numbers.len())
            .map(|which| {
                let n = self.model.n_joints();
                let dual: Vec<Dual> = self
                    .numbers
                    .iter()
                    .enumerate()
                    .map(|(i, x)| Dual { x: *x, dx: if i == which { 1.0 } else { 0.0 } })
                    .collect();
                let zero = Dual { x: 0.0, dx: 0.0 };
                let (mut data, mut ddq) = (Data::new(&self.model, zero), vec![zero; n]);
                let (parts, rest) = dual.split_at(3 * n);
                let (armature, rest) = rest.split_at(n);
                data.armature.copy_from_slice(armature);
                let (inertias, force) = rest.split_at(10 * n);
                for (inertia, numbers) in data.inertias.iter_mut().zip(inertias.chunks(10)) {
                    *inertia = spatial::Inertia::from_parameters(numbers.try_into().unwrap());
                }
                let external = [self.external(force)];
                let q: Vec<&[Dual]> = parts.chunks(n).collect();
                forward_dynamics(&self.model, &mut data, [q[0], q[1], q[2]], &external, &mut ddq);
                weights(n).iter().zip(&ddq).map(|(w, a)| w * a.dx).sum()
            })
            .collect()
    }

    fn external<T: Copy>(&self, f: &[T]) -> ExternalForce<T> {
        ExternalForce { frame: self.frame, force: [f[0], f[1], f[2]], torque: [f[3], f[4], f[5]] }
    }
}

#[test]
fn is_the_gradient_by_dual_numbers() {
    each(|name, model, reference, s| {
        let n = model.n_joints();
        let push = [2.0, -1.0, 3.0, 0.2, 0.1, -0.3];
        let mut data = Data::new(model, 0.0);
        data.armature.iter_mut().enumerate().for_each(|(i, a)| *a = 0.01 + 1e-3 * i as f64);
        let numbers: Vec<f64> = [&s.q, &s.v, &s.tau, &data.armature]
            .into_iter()
            .flatten()
            .copied()
            .chain(data.inertias.iter().flat_map(|i| i.parameters()))
            .chain(push)
            .collect();
        let inputs =
            Inputs { model: model.clone(), numbers, frame: model.frame(&reference.tip_frame).unwrap() };
        let external = [inputs.external(&push)];
        let mut ddq = vec![0.0; n];
        let mut adjoint = Cotangent::new(model, 1, 0.0);
        forward_dynamics(model, &mut data, [&s.q, &s.v, &s.tau], &external, &mut ddq);
        // Twice: nothing that it needs is spoiled.
        for _ in 0..2 {
            forward_dynamics_adjoint(model, &mut data, &external, &weights(n), &mut adjoint);
            parameter_adjoint(&data, &ddq, &mut adjoint);
        }
        let expected = inputs.gradient();
        let parts = [
            ("q", adjoint.q.clone()),
            ("q̇", adjoint.dq.clone()),
            ("τ", adjoint.tau.clone()),
            ("armature", adjoint.armature.clone()),
            ("inertias", adjoint.inertias.concat()),
            ("force", adjoint.external.concat().concat()),
        ];
        let mut from = 0;
        for (what, got) in parts {
            assert_close(&format!("{name}: {what}"), &got, &expected[from..from + got.len()], TOLERANCE);
            from += got.len();
        }
        assert_eq!(from, expected.len());
    });
}
