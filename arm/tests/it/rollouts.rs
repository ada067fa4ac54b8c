//! Gradients of whole rollouts beside dual numbers, through 500 steps.

use hysteron_arm::*;

use crate::numbers::Dual;
use crate::robots::{assert_close, model};

const STEPS: usize = 500;
/// What the task asks for.
const TOLERANCE: f64 = 1e-9;

/// A torque that brings every joint into motion and none out of reach.
fn torque(step: usize, joint: usize) -> f64 {
    0.05 * (0.02 * step as f64 + 1.3 * joint as f64).sin()
}

/// What the loss weighs: the last state, and every state a little.
fn weight(step: usize, i: usize) -> f64 {
    (0.3 + 0.1 * i as f64) * if step == STEPS { 1.0 } else { 1e-3 }
}

struct Case {
    model: Model,
    integrator: Integrator,
    substeps: usize,
    frame: usize,
}

/// Everything that a rollout depends on.
struct Parameters<T> {
    state: Vec<T>,
    inertias: Vec<spatial::Inertia<T>>,
    armature: Vec<T>,
    damping: Vec<T>,
    /// Added to every torque of the joint.
    torque: Vec<T>,
    /// The same in every step.
    force: [T; 6],
}

impl Case {
    fn new(integrator: Integrator) -> Self {
        let model = model("open_manipulator_x")
            .with_locked(&[("gripper_left_joint", 0.01), ("gripper_right_joint", 0.01)])
            .unwrap();
        let frame = model.frame("end_effector_link").unwrap();
        Self { model, integrator, substeps: 2, frame }
    }

    fn parameters<T: Scalar>(&self, like: T) -> Parameters<T> {
        let data = Data::new(&self.model, like);
        let damping = self.model.joints().iter().map(|joint| like.splat(joint.drive.damping));
        let n = self.model.n_joints();
        Parameters {
            state: (0..2 * n).map(|i| like.splat(0.2 - 0.1 * i as f64)).collect(),
            inertias: data.inertias,
            armature: vec![like.splat(0.01); n],
            damping: damping.collect(),
            torque: vec![like.splat(0.0); n],
            force: [0.3, -0.2, 0.4, 0.01, 0.02, -0.01].map(|x| like.splat(x)),
        }
    }

    fn stepper<T: Scalar>(&self, p: &Parameters<T>) -> Stepper<T> {
        let mut stepper = Stepper::new(&self.model, self.integrator, (0.01, self.substeps), 1, p.state[0]);
        stepper.set_parameters(&p.inertias, &p.armature, &p.damping);
        stepper
    }

    fn external<T: Copy>(&self, f: &[T; 6]) -> [ExternalForce<T>; 1] {
        [ExternalForce { frame: self.frame, force: [f[0], f[1], f[2]], torque: [f[3], f[4], f[5]] }]
    }

    fn torques<T: Scalar>(&self, p: &Parameters<T>, step: usize) -> Vec<T> {
        p.torque.iter().enumerate().map(|(j, offset)| *offset + offset.splat(torque(step, j))).collect()
    }

    /// The loss, and the states that were passed.
    fn run<T: Scalar>(&self, p: &Parameters<T>) -> (T, Vec<T>) {
        let (n, mut stepper, mut tape) = (self.model.n_joints(), self.stepper(p), Vec::new());
        let (mut q, mut dq) = (p.state[..n].to_vec(), p.state[n..].to_vec());
        let mut loss = q[0].splat(0.0);
        for step in 1..=STEPS {
            let tau = self.torques(p, step);
            stepper.step(&self.model, [&mut q, &mut dq], &tau, &self.external(&p.force), &mut tape);
            for (i, x) in q.iter().chain(&dq).enumerate() {
                loss = loss + x.scale(weight(step, i));
            }
        }
        (loss, tape)
    }
}

fn check(integrator: Integrator) {
    let case = Case::new(integrator);
    let (n, p) = (case.model.n_joints(), case.parameters(0.0));
    let (_, mut tape) = case.run(&p);
    let mut stepper = case.stepper(&p);
    let mut gradient = StepGradient::new(&case.model, 1, 0.0);
    let (mut q, mut dq) = (vec![0.0; n], vec![0.0; n]);
    let (mut by_torque, mut by_force) = (vec![0.0; n], [0.0; 6]);
    for step in (1..=STEPS).rev() {
        for (i, x) in q.iter_mut().chain(&mut dq).enumerate() {
            *x += weight(step, i);
        }
        let (tau, external) = (case.torques(&p, step), case.external(&p.force));
        stepper.step_back(&case.model, &mut tape, &tau, &external, [&mut q, &mut dq], &mut gradient);
        by_torque.iter_mut().zip(&gradient.tau).for_each(|(sum, part)| *sum += part);
        by_force.iter_mut().zip(gradient.external.iter().flatten().flatten()).for_each(|(sum, x)| *sum += x);
    }
    assert!(tape.is_empty());
    // The same by one dual number at a time.
    let zero = Dual { x: 0.0, dx: 0.0 };
    let dual = |set: &dyn Fn(&mut Parameters<Dual>) -> &mut Dual| {
        let mut p = case.parameters(zero);
        set(&mut p).dx = 1.0;
        case.run(&p).0.dx
    };
    let close = |what: &str, got: &[f64], expected: &[f64]| {
        assert_close(&format!("{integrator:?}: {what}"), got, expected, TOLERANCE);
    };
    let all = |f: &dyn Fn(usize) -> f64| (0..n).map(f).collect::<Vec<f64>>();
    close("q", &q, &all(&|i| dual(&|p| &mut p.state[i])));
    close("q̇", &dq, &all(&|i| dual(&|p| &mut p.state[n + i])));
    close("torques", &by_torque, &all(&|i| dual(&|p| &mut p.torque[i])));
    close("armature", &gradient.armature, &all(&|i| dual(&|p| &mut p.armature[i])));
    close("damping", &gradient.damping, &all(&|i| dual(&|p| &mut p.damping[i])));
    let forces: Vec<f64> = (0..6).map(|i| dual(&|p| &mut p.force[i])).collect();
    close("force", &by_force, &forces);
    let masses = all(&|i| dual(&|p| &mut p.inertias[i].mass));
    close("mass", &gradient.inertias.iter().map(|p| p[0]).collect::<Vec<f64>>(), &masses);
    let centres = all(&|i| dual(&|p| &mut p.inertias[i].first[2]));
    close("first moment", &gradient.inertias.iter().map(|p| p[3]).collect::<Vec<f64>>(), &centres);
    let seconds = all(&|i| dual(&|p| &mut p.inertias[i].second[2]));
    close("second moment", &gradient.inertias.iter().map(|p| p[6]).collect::<Vec<f64>>(), &seconds);
}

#[test]
fn adjoint_of_semi_implicit_euler_is_the_derivative() {
    check(Integrator::SemiImplicitEuler);
}

#[test]
fn adjoint_of_runge_kutta_is_the_derivative() {
    check(Integrator::RungeKutta4);
}
