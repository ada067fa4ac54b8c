//! Arms at rest: who holds what.

use nalgebra::Vector3;
use rand::RngExt;

use super::arm;
use crate::virtual_arm::stiction::{N_SPEEDS, StictionProblem};
use crate::virtual_arm::{ArmWorld, N_JOINTS};

const WARM: [f64; 5] = [25.0; 5];
const STRETCHED: [f64; 4] = [0.3, 0.5, 0.1, -0.2];

fn held(payload: f64) -> ArmWorld {
    let arm = arm();
    let mut world = ArmWorld::new(&arm, STRETCHED, 0.01, WARM);
    if payload > 0.0 {
        world = world.with_payload(payload, 0.02);
    }
    let jaws = arm.gripper.angle(0.01);
    world.goals = [STRETCHED[0], STRETCHED[1], STRETCHED[2], STRETCHED[3], jaws].map(Some);
    while world.time() < 3.0 {
        world.step();
    }
    world
}

#[test]
fn an_arm_that_friction_holds_stands_still_exactly() {
    let mut world = held(0.3);
    let (q, angles) = (world.q, world.servos.map(|servo| servo.angle));
    for _ in 0..2000 {
        world.step();
        assert_eq!(world.dq, [0.0; N_JOINTS]);
        assert_eq!(world.servos.map(|servo| servo.speed), [0.0; 5]);
    }
    assert_eq!(world.q, q);
    assert_eq!(world.servos.map(|servo| servo.angle), angles);
}

#[test]
fn motors_and_friction_carry_the_weight() {
    for payload in [0.0, 0.2, 0.5] {
        let world = held(payload);
        let q = world.q;
        // Plane trigonometry of the shoulder: weights times their horizontal distances.
        let forward = |angle: f64, x: f64, z: f64| x * angle.cos() + z * angle.sin();
        let links = &world.arm().chain.links;
        let angles = [q[1], q[1] + q[2], q[1] + q[2] + q[3]];
        let mut joint = 0.0;
        let mut moment = 0.0;
        for (k, angle) in angles.into_iter().enumerate() {
            let body = &links[k + 1].body;
            moment += body.mass * (joint + forward(angle, body.centre.x, body.centre.z));
            let next = links.get(k + 2).map_or(world.arm().chain.tip, |link| link.origin);
            joint += forward(angle, next.x, next.z);
        }
        moment += payload * joint;
        let carried = world.acted.motor[1] - world.acted.friction[1];
        // At rest to the last bit: what is left is rounding of torques below 10 N m.
        assert!((carried + 9.81 * moment).abs() < 1e-9, "{payload} kg: {carried} {moment}");
    }
}

#[test]
fn friction_at_the_gear_holds_a_push_up_to_its_bound() {
    let mut world = held(0.0);
    let before = world.q;
    world.push = Vector3::new(0.0, 0.2, 0.0);
    (0..2000).for_each(|_| world.step());
    // 0.2 N at 0.3 m is less than what the gear of joint 1 holds, so only the teeth give: backlash and elasticity.
    assert!((world.q[0] - before[0]).abs() < 0.25_f64.to_radians() + 0.1 / 400.0 + 1e-9);
    world.push = Vector3::new(0.0, 4.0, 0.0);
    (0..2000).for_each(|_| world.step());
    assert!(world.q[0] - before[0] > 0.01, "{}", world.q[0] - before[0]);
}

#[test]
fn who_sticks_and_slides_minimises_the_energy_of_the_step() {
    let mut stream = hysteron_base::rng(3, "test/stiction");
    let mut n_sticking = 0;
    for _ in 0..2000 {
        let mut draw = |least: f64, greatest: f64| stream.random_range(least..greatest);
        let coupling: [f64; N_JOINTS] = std::array::from_fn(|_| draw(0.0, 30.0));
        let root: [[f64; N_JOINTS]; N_JOINTS] =
            std::array::from_fn(|_| std::array::from_fn(|_| draw(-2.0, 2.0)));
        let mut links = [[0.0; N_JOINTS]; N_JOINTS];
        for i in 0..N_JOINTS {
            for j in 0..N_JOINTS {
                links[i][j] = (0..N_JOINTS).map(|k| root[i][k] * root[j][k]).sum::<f64>();
            }
            links[i][i] += coupling[i] + 0.01;
        }
        let balance = StictionProblem {
            rotors: std::array::from_fn(|k| coupling[k] + draw(0.1, 30.0)),
            coupling,
            links,
            push: std::array::from_fn(|_| draw(-3.0, 3.0)),
            dry: std::array::from_fn(|_| draw(0.0, 2.0)),
        };
        let mut statuses = [0.0; N_SPEEDS];
        let speeds = balance.solve(&mut statuses);
        // Optimality, coordinate by coordinate: friction balances the rest, opposes motion, and holds within its bound.
        for i in 0..N_SPEEDS {
            let k = i % N_JOINTS;
            let rest: f64 = if i < N_JOINTS {
                balance.push[i] + coupling[k] * speeds[N_JOINTS + k] - balance.rotors[k] * speeds[k]
            } else {
                let row: f64 = (0..N_JOINTS).map(|j| links[k][j] * speeds[N_JOINTS + j]).sum();
                balance.push[i] + coupling[k] * speeds[k] - row
            };
            if speeds[i] == 0.0 {
                n_sticking += 1;
                assert!(rest.abs() <= balance.dry[i] * (1.0 + 1e-9) + 1e-9, "{rest} {}", balance.dry[i]);
            } else {
                let friction = balance.dry[i].copysign(speeds[i]);
                // Rounding of a well scaled system of eight.
                assert!((rest - friction).abs() < 1e-7, "{rest} {friction}");
            }
        }
    }
    assert!(n_sticking > 1000, "{n_sticking}");
}
