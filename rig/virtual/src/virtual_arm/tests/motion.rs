//! Arms that move: energy, momentum, pendulums.

use super::{endless, ideal};
use crate::virtual_arm::{ArmWorld, N_JOINTS, VirtualArm};

const WARM: [f64; 5] = [25.0; 5];
/// Where the arm is released [rad].
const HANGING: [f64; 4] = [0.2, 0.5, 0.3, 0.2];

/// Gravity down the arm: an upright arm swings like a hanging one.
fn hung(mut arm: VirtualArm) -> VirtualArm {
    arm.chain.gravity = -arm.chain.gravity;
    arm
}

fn total(world: &ArmWorld) -> f64 {
    world.energies().iter().sum()
}

/// Largest relative change of energy, heat of friction included, over a second of free motion.
fn imbalance(mut arm: VirtualArm, step: f64) -> f64 {
    arm.step = step;
    let mut world = ArmWorld::new(&arm, HANGING, 0.01, WARM);
    let (start, mut heat, mut worst) = (total(&world), 0.0, 0.0_f64);
    let mut swing = 0.0_f64;
    while world.time() < 1.0 {
        world.step();
        for k in 0..N_JOINTS {
            // Each friction with its own speed: gear with the rotor's, bearing with the link's, teeth with both.
            heat += step * world.lost[k];
        }
        swing = swing.max(world.energies()[0]);
        worst = worst.max((total(&world) + heat - start).abs());
    }
    worst / swing
}

#[test]
fn energy_without_friction_is_kept_with_the_first_order() {
    let arm = hung(ideal());
    let [coarse, fine] = [4e-4, 2e-4].map(|h| imbalance(arm.clone(), h));
    assert!(coarse < 0.2, "{coarse}");
    // Implicit Euler: the error is proportional to the step, a tenth left for its second order.
    assert!((coarse / fine - 2.0).abs() < 0.4, "{coarse} {fine}");
}

#[test]
fn what_friction_takes_is_what_energy_loses() {
    let arm = hung(endless());
    let [coarse, fine] = [4e-4, 1e-4].map(|h| imbalance(arm.clone(), h));
    assert!(fine < 0.02 && fine < 0.5 * coarse, "{coarse} {fine}");
}

#[test]
fn friction_never_gives_energy() {
    let mut arm = hung(endless());
    arm.step = 2e-4;
    let mut world = ArmWorld::new(&arm, HANGING, 0.01, WARM);
    let mut before = total(&world);
    while world.time() < 2.0 {
        world.step();
        let now = total(&world);
        assert!(now <= before + 1e-9, "{} s: {before} to {now}", world.time());
        before = now;
    }
}

#[test]
fn momentum_about_the_vertical_is_kept_under_gravity() {
    let mut arm = hung(ideal());
    arm.step = 1e-4;
    let mut world = ArmWorld::new(&arm, HANGING, 0.01, WARM);
    let spin = 2.0;
    world.dq[0] = spin;
    world.servos[0].speed = spin;
    let about_the_vertical = |world: &ArmWorld| {
        let mass = world.arm().chain.at(&world.q, &world.dq).mass;
        let links: f64 = (0..N_JOINTS).map(|j| mass[0][j] * world.dq[j]).sum();
        links + world.arm().servos[0].armature * world.servos[0].speed
    };
    let start = about_the_vertical(&world);
    let mut most = 0.0_f64;
    while world.time() < 0.5 {
        world.step();
        most = most.max((about_the_vertical(&world) / start - 1.0).abs());
    }
    // M changes by a part of h q̇ in a step, up to 10 rad/s, and the errors of one way add up to no more than that over the swing.
    assert!(most < 1e-4 * 10.0 * 5.0, "{most}");
    assert!((world.q[1] - HANGING[1]).abs() > 0.3, "it swings: {:?}", world.q);
}

/// A quarter of a period of a pendulum over π/2 √(I/(m g l)), for this amplitude: by the arithmetic-geometric mean.
fn period_factor(amplitude: f64) -> f64 {
    let (mut a, mut b) = (1.0, (0.5 * amplitude).cos());
    for _ in 0..6 {
        (a, b) = (0.5 * (a + b), f64::sqrt(a * b));
    }
    1.0 / a
}

#[test]
fn shoulder_swings_as_a_pendulum() {
    let mut arm = hung(ideal());
    // The other joints stick under any load; the shoulder has no mass but a ball at the wrist.
    for k in [0, 2, 3] {
        arm.servos[k].friction.base = 1e6;
        arm.servos[k].bearing = 1e6;
    }
    for link in &mut arm.chain.links {
        link.body.mass = 1e-9;
        link.body.inertia *= 1e-9;
    }
    let ball = 0.3;
    arm.chain.links[3].body.mass = ball;
    arm.chain.links[3].body.centre.fill(0.0);
    // Straight up: upper arm and forearm in one line with the joint.
    let q = [0.0, 0.4, 0.0, 0.0];
    let wrist = arm.chain.links[2].origin + arm.chain.links[3].origin;
    let length = wrist.x.hypot(wrist.z);
    let rest = -wrist.x.atan2(wrist.z);
    let amplitude = q[1] - rest;
    let stiff = 5e4;
    arm.servos[1].stiffness = stiff;
    let inertia = ball * length * length + arm.servos[1].armature;
    let pull = ball * 9.81 * length;
    let period = std::f64::consts::TAU * (inertia / pull).sqrt() * period_factor(amplitude);
    let measured = |step: f64| {
        let mut arm = arm.clone();
        arm.step = step;
        let mut world = ArmWorld::new(&arm, q, 0.01, WARM);
        let mut crossings = Vec::new();
        while crossings.len() < 3 {
            let before = world.q[1] - rest;
            world.step();
            let now = world.q[1] - rest;
            if before * now < 0.0 {
                crossings.push(world.time() - step * now / (now - before));
            }
        }
        assert_eq!([world.q[0], world.q[2], world.q[3]], [0.0; 3], "the others stick");
        crossings[2] - crossings[0]
    };
    // Semi-implicit steps shorten the swing by their damping; two steps extrapolate to none.
    let [coarse, fine] = [2e-4, 1e-4].map(measured);
    let extrapolated = 2.0 * fine - coarse;
    // The gear gives by m g l/k, 1e-5 of the angle; what is left is of second order in the step.
    assert!((extrapolated / period - 1.0).abs() < 2e-4, "{extrapolated} {period}");
}
