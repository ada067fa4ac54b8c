//! Limit points: where a tendon's tension has its maximum the body wrinkles, snaps and finds a new
//! equilibrium with less tension at the same stroke.

use hysteron_base::MaterialLaw;
use hysteron_fem::{Layers, Order, Tube};
use hysteron_twin::{Target, Twin};

use super::{Robot, scenes};

const LENGTH: f64 = 0.08;

/// A tube of ten-node tetrahedra whose tendons hold on to points: where one pulls hard, elements wrinkle.
fn robot() -> Robot {
    let mut scene = scenes::scene("wrinkles", MaterialLaw::Corotational);
    scene.material.youngs_modulus = 20e6;
    scene.material.poisson_ratio = 0.45;
    scene.tendons = (0..4).map(|k| scenes::tendon(k, LENGTH, 0.0045, 10)).collect();
    for tendon in &mut scene.tendons {
        tendon.attach_within = 1e-3;
    }
    let tube = Tube {
        profile: vec![[0.0, 0.006], [LENGTH, 0.006]],
        bore_radius: 0.003,
        channels: Vec::new(),
        outer_divisions: 12,
        bore_divisions: 8,
        channel_divisions: 4,
        layers: Layers::Count(15),
        order: Order::Quadratic,
    };
    Robot::of(Twin::new(&scene, &tube.mesh().unwrap()).unwrap())
}

#[test]
fn body_snaps_to_a_stable_equilibrium_when_the_tension_has_passed_its_maximum() {
    let mut robot = robot();
    let mut tensions = Vec::new();
    let mut compliances = Vec::new();
    let strokes = (1..=8).map(|k| 1e-3 * f64::from(k)).chain((1..=6).map(|k| 8e-3 + 2e-4 * f64::from(k)));
    for stroke in strokes {
        let mut targets = vec![Target::Tension(0.0); 4];
        targets[0] = Target::Stroke(stroke);
        robot.go(&targets);
        tensions.push(robot.state.tensions[0]);
        // Fails where the exact tangent is singular; every equilibrium here is on one side or the other.
        compliances.push(robot.stepper.delassus(&robot.twin).unwrap()[0]);
    }
    let snap = tensions.windows(2).position(|pair| pair[1] < pair[0]).expect("the tension falls");
    assert!(
        compliances[snap] > 1.5 * compliances[0],
        "softer and softer towards the maximum: {compliances:?}"
    );
    assert!(tensions[snap + 1] < 0.95 * tensions[snap], "a jump, not a slide: {tensions:?}");
    assert!(compliances[snap + 1] > 0.0, "stable again: {compliances:?}");
    assert!(tensions.last() > tensions.get(snap + 1), "and it carries more again: {tensions:?}");
}
