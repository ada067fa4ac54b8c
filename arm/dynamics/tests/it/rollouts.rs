//! Gradients of whole rollouts compared with dual numbers, through 500 steps.

use hysteron_arm_dynamics::*;
use hysteron_base::lanes::Isa;

use crate::motion::gripper;
use hysteron_arm_fixtures::numbers::Dual;
use hysteron_arm_fixtures::robots::{assert_close, model};

const STEPS: usize = 500;
/// Required accuracy [-].
const TOLERANCE: f64 = 1e-9;

/// A torque that brings every joint into motion and none out of reach, in parts of its size.
fn torque(step: usize, joint: usize) -> f64 {
    (0.02 * step as f64 + 1.3 * joint as f64).sin()
}

/// Weight of component `i` of a state in the loss [-]: a thousandth for all states but the last.
fn weight(step: usize, i: usize) -> f64 {
    (0.3 + 0.1 * i as f64) * if step == STEPS { 1.0 } else { 1e-3 }
}

struct Case {
    model: Model,
    integrator: Integrator,
    substeps: usize,
    frame: usize,
    start: fn(usize) -> f64,
    dry_friction: f64,
    /// Its growth per torque through the gear.
    load_friction: f64,
    /// Size of the torques [N m].
    torque: f64,
}

/// Everything that a rollout depends on.
struct Parameters<T> {
    state: Vec<T>,
    inertias: Vec<spatial::Inertia<T>>,
    armature: Vec<T>,
    damping: Vec<T>,
    dry_friction: Vec<T>,
    load_friction: Vec<T>,
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
        let start = |i| 0.2 - 0.1 * i as f64;
        Self {
            model,
            integrator,
            substeps: 2,
            frame,
            start,
            dry_friction: 0.0,
            load_friction: 0.0,
            torque: 0.05,
        }
    }

    /// A gripper one finger of which follows the other; it sticks, slides, and reaches the end of its range.
    fn with_friction(load_friction: f64) -> Self {
        let model = gripper(0.0);
        let frame = model.frame("right").unwrap();
        let start = |i| [0.7, 0.01, 0.3, 1.5, -0.2, 0.7][i];
        let integrator = Integrator::WithFriction(EndStops::Rigid);
        Self { model, integrator, substeps: 2, frame, start, dry_friction: 0.4, load_friction, torque: 3.0 }
    }

    fn parameters<T: Scalar>(&self, like: T) -> Parameters<T> {
        let data = Data::new(&self.model, like);
        let damping = self.model.joints().iter().map(|joint| like.splat(joint.drive.damping));
        let n = self.model.n_joints();
        Parameters {
            state: (0..2 * n).map(|i| like.splat((self.start)(i))).collect(),
            inertias: data.inertias,
            armature: vec![like.splat(0.01); n],
            damping: damping.collect(),
            dry_friction: vec![like.splat(self.dry_friction); n],
            load_friction: vec![like.splat(self.load_friction); if self.load_friction > 0.0 { n } else { 0 }],
            torque: vec![like.splat(0.0); n],
            force: [0.3, -0.2, 0.4, 0.01, 0.02, -0.01].map(|x| like.splat(x)),
        }
    }

    fn stepper<T: Scalar>(&self, p: &Parameters<T>) -> ArmStepper<T> {
        let mut stepper = ArmStepper::new(&self.model, self.integrator, (0.01, self.substeps), 1, p.state[0]);
        stepper.set_parameters(&p.inertias, &p.armature, [&p.damping, &p.dry_friction]);
        stepper.set_friction([&p.dry_friction, &p.load_friction]);
        stepper
    }

    fn external<T: Copy>(&self, f: &[T; 6]) -> [ExternalForce<T>; 1] {
        [ExternalForce { frame: self.frame, force: [f[0], f[1], f[2]], torque: [f[3], f[4], f[5]] }]
    }

    fn torques<T: Scalar>(&self, p: &Parameters<T>, step: usize) -> Vec<T> {
        p.torque
            .iter()
            .enumerate()
            .map(|(j, offset)| *offset + offset.splat(self.torque * torque(step, j)))
            .collect()
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

fn check(case: &Case) {
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
        assert_close(&format!("{:?}: {what}", case.integrator), got, expected, TOLERANCE);
    };
    let all = |f: &dyn Fn(usize) -> f64| (0..n).map(f).collect::<Vec<f64>>();
    close("q", &q, &all(&|i| dual(&|p| &mut p.state[i])));
    close("q̇", &dq, &all(&|i| dual(&|p| &mut p.state[n + i])));
    close("torques", &by_torque, &all(&|i| dual(&|p| &mut p.torque[i])));
    close("armature", &gradient.armature, &all(&|i| dual(&|p| &mut p.armature[i])));
    close("damping", &gradient.damping, &all(&|i| dual(&|p| &mut p.damping[i])));
    if case.dry_friction > 0.0 {
        close("friction", &gradient.dry_friction, &all(&|i| dual(&|p| &mut p.dry_friction[i])));
    }
    if case.load_friction > 0.0 {
        close("load friction", &gradient.load_friction, &all(&|i| dual(&|p| &mut p.load_friction[i])));
    }
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
    check(&Case::new(Integrator::SemiImplicitEuler));
}

#[test]
fn adjoint_of_runge_kutta_is_the_derivative() {
    check(&Case::new(Integrator::RungeKutta4));
}

#[test]
fn adjoint_with_friction_stops_and_followers_is_the_derivative() {
    check(&Case::with_friction(0.1));
    let case = Case::with_friction(0.0);
    check(&case);
    // State of the finger before a substep: moving, at rest, at rest at an end of its range.
    let contacts = |tape: &[f64]| -> Vec<u8> {
        let ends = [-0.05, 0.0125];
        let of_state = |state: &[f64]| {
            let at_end = ends.iter().any(|end| (state[1] - end).abs() < 1e-12);
            [state[4] == 0.0, at_end].map(u8::from)
        };
        tape.chunks(6).flat_map(of_state).collect()
    };
    let p = case.parameters(0.0);
    let (loss, tape) = case.run(&p);
    let found = contacts(&tape);
    for k in 0..2 {
        let times = found.chunks(2).filter(|contact| contact[k] == 1).count();
        assert!(times > 20 && times < found.len() / 2 - 20, "{k}: {times}");
    }
    // Differences, where no contact changes; their error is that of the second derivative and of rounding.
    let step = 1e-7;
    let zero = Dual { x: 0.0, dx: 0.0 };
    for which in 0..4 {
        let set = [0, 1, 3, 4][which];
        let moved = [step, -step].map(|step| {
            let mut p = case.parameters(0.0);
            p.state[set] += step;
            case.run(&p)
        });
        assert!(moved.iter().all(|(_, tape)| contacts(tape) == found), "a contact changes");
        let mut p = case.parameters(zero);
        p.state[set].dx = 1.0;
        let (exact, slope) = (case.run(&p).0.dx, (moved[0].0 - moved[1].0) / (2.0 * step));
        assert!((slope - exact).abs() < 1e-5 * (1.0 + loss.abs() + exact.abs()), "{slope} {exact}");
    }
}

/// Rollouts of nineteen arms: two registers that are full and one that is not. Without friction the gripper is locked.
fn many(integrator: Integrator) -> (Model, usize, [Vec<f64>; 6]) {
    const ARMS: usize = 19;
    let model = match integrator {
        Integrator::WithFriction(_) => Model::builtin("open-manipulator-x").unwrap(),
        _ => model("open_manipulator_x")
            .with_locked(&[("gripper_left_joint", 0.01), ("gripper_right_joint", 0.01)])
            .unwrap(),
    };
    let (n, frame) = (model.n_joints(), model.frame("end_effector_link").unwrap());
    let series = |n: usize, size: f64, rate: f64| (0..n).map(|i| size * (rate * i as f64).sin()).collect();
    let [initial, tau, forces] =
        [(2 * n, 0.4, 1.7), (n * MANY_STEPS, 0.1, 0.37), (6 * MANY_STEPS, 0.2, 0.91)]
            .map(|(width, size, rate)| series(ARMS * width, size, rate));
    let [states, weights] =
        [vec![0.0; ARMS * 2 * n * MANY_STEPS], series(ARMS * 2 * n * MANY_STEPS, 1.0, 0.13)];
    let friction = series(ARMS * 2 * n * MANY_STEPS, 0.15, 0.53);
    let friction = friction.into_iter().map(f64::abs).collect();
    (model, frame, [initial, tau, forces, friction, states, weights])
}

const MANY_STEPS: usize = 20;

fn rollouts(model: &Model, frame: usize, isa: Isa, integrator: Integrator) -> ArmRollouts<'_> {
    ArmRollouts { model, integrator, period: (0.01, 4), n_steps: MANY_STEPS, frames: vec![frame], isa }
}

#[test]
fn rollouts_in_lanes_are_those_of_one_arm_after_the_other() {
    let with_friction = Integrator::WithFriction(EndStops::Rigid);
    let smooth = [Integrator::SemiImplicitEuler, Integrator::RungeKutta4].into_iter().cycle();
    let cases =
        Isa::all().into_iter().zip(smooth).chain(Isa::all().into_iter().map(|isa| (isa, with_friction)));
    let cases = cases.flat_map(|(isa, integrator)| [false, true].map(|varies| (isa, integrator, varies)));
    for (isa, integrator, varies) in cases {
        let (model, frame, [initial, tau, forces, mut friction, mut states, weights]) = many(integrator);
        if !varies {
            friction.clear();
        }
        let n = model.n_joints();
        let inputs = RolloutInputs { initial: &initial, tau: &tau, forces: &forces, friction: &friction };
        let rollouts = rollouts(&model, frame, isa, integrator);
        rollouts.run(&inputs, &mut states);
        let gradient = rollouts.pull_back(&inputs, &states, &weights);
        let mut sum = StepGradient::new(&model, 1, 0.0);
        for arm in 0..initial.len() / (2 * n) {
            let mut stepper = ArmStepper::new(&model, integrator, (0.01, 4), 1, 0.0);
            let of_step = |rows: &[f64], width: usize, step: usize| -> Vec<f64> {
                rows[width * (MANY_STEPS * arm + step)..][..width].to_vec()
            };
            let external = |step: usize| {
                let f = of_step(&forces, 6, step);
                [ExternalForce { frame, force: [f[0], f[1], f[2]], torque: [f[3], f[4], f[5]] }]
            };
            let rub = |stepper: &mut ArmStepper<f64>, step: usize| {
                if varies {
                    let own = of_step(&friction, 2 * n, step);
                    stepper.set_friction([&own[..n], &own[n..]]);
                }
            };
            let mut state = initial[2 * n * arm..][..2 * n].to_vec();
            let mut tape = Vec::new();
            for step in 0..MANY_STEPS {
                let (q, dq) = state.split_at_mut(n);
                rub(&mut stepper, step);
                stepper.step(&model, [q, dq], &of_step(&tau, n, step), &external(step), &mut tape);
                assert_close("states", &of_step(&states, 2 * n, step), &state, TOLERANCE);
            }
            let mut by_state = vec![0.0; 2 * n];
            for step in (0..MANY_STEPS).rev() {
                by_state.iter_mut().zip(of_step(&weights, 2 * n, step)).for_each(|(sum, part)| *sum += part);
                let (q, dq) = by_state.split_at_mut(n);
                rub(&mut stepper, step);
                stepper.step_back(
                    &model,
                    &mut tape,
                    &of_step(&tau, n, step),
                    &external(step),
                    [q, dq],
                    &mut sum,
                );
                if varies {
                    let own = [&mut sum.dry_friction, &mut sum.load_friction].map(std::mem::take).concat();
                    assert_close("friction", &of_step(&gradient.friction, 2 * n, step), &own, TOLERANCE);
                    [sum.dry_friction, sum.load_friction] = [(); 2].map(|()| vec![0.0; n]);
                }
                assert_close("torques", &of_step(&gradient.tau, n, step), &sum.tau, TOLERANCE);
                let by_force: Vec<f64> = sum.external.iter().flatten().flatten().copied().collect();
                assert_close("forces", &of_step(&gradient.forces, 6, step), &by_force, TOLERANCE);
            }
            assert_close("initial", &gradient.initial[2 * n * arm..][..2 * n], &by_state, TOLERANCE);
        }
        let flat = |bodies: &[[f64; 10]]| bodies.iter().flatten().copied().collect::<Vec<f64>>();
        assert_close("inertias", &flat(&gradient.inertias), &flat(&sum.inertias), TOLERANCE);
        assert_close("armature", &gradient.armature, &sum.armature, TOLERANCE);
        assert_close("damping", &gradient.damping, &sum.damping, TOLERANCE);
        assert_close("friction", &gradient.dry_friction, &sum.dry_friction, TOLERANCE);
        let moves = gradient.friction.iter().any(|x| *x != 0.0);
        assert_eq!(moves, varies && integrator == with_friction, "{integrator:?}");
    }
}

#[test]
fn rollouts_are_the_same_bytes_on_any_number_of_threads() {
    for integrator in [Integrator::SemiImplicitEuler, Integrator::WithFriction(EndStops::Rigid)] {
        are_the_same_bytes_on_any_number_of_threads(integrator);
    }
}

fn are_the_same_bytes_on_any_number_of_threads(integrator: Integrator) {
    let (model, frame, [initial, tau, forces, friction, states, weights]) = many(integrator);
    let inputs = RolloutInputs { initial: &initial, tau: &tau, forces: &forces, friction: &friction };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let rollouts = rollouts(&model, frame, Isa::detect(), integrator);
            let mut states = states.clone();
            rollouts.run(&inputs, &mut states);
            let gradient = rollouts.pull_back(&inputs, &states, &weights);
            (states, gradient)
        })
    };
    let one = on(1);
    assert!(one.0.iter().any(|x| *x != 0.0) && one.1.tau.iter().any(|x| *x != 0.0));
    assert!(one == on(2) && one == on(4));
}
