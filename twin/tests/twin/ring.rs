//! Tendon points carried by a ring of body points.

use hysteron_fem::{Layers, Order};
use hysteron_twin::{Stepper, Target, Twin};

use super::scenes;

/// Radius of the ring, three quarters of the wall around the tendon [m].
const RING: f64 = 0.0009;

fn twin(sides: u32, ring: f64) -> Twin {
    let (mut scene, _) = scenes::robot();
    for tendon in &mut scene.tendons {
        tendon.ring = ring;
    }
    let tube = scenes::tube_of(sides, Layers::Count(2 * sides), Order::Linear);
    Twin::new(&scene, &tube.mesh().unwrap()).unwrap()
}

/// Stroke of the first tendon per tension in all four [m/N]: the body shortens without bending, which
/// every mesh of a tube does alike, and the tendons' ends sink in.
fn compliance(sides: u32, ring: f64) -> f64 {
    let twin = twin(sides, ring);
    let delassus = Stepper::new(&twin).delassus(&twin).unwrap();
    delassus[..4].iter().sum()
}

#[test]
fn ring_mean_is_the_point_and_moves_with_the_body() {
    let twin = twin(8, RING);
    let (scene, _) = scenes::robot();
    // Round-off of sixteen weighted positions of 0.04 m.
    let tol = 1e-15;
    for (j, tendon) in scene.tendons.iter().enumerate() {
        for (carried, point) in twin.cables.polyline(j, &twin.body.rest).iter().zip(&tendon.points) {
            for c in 0..3 {
                assert!((carried[c] - point[c]).abs() < tol, "{carried:?} instead of {point:?}");
            }
        }
    }
    let shifted: Vec<[f64; 4]> =
        twin.body.rest.iter().map(|[x, y, z, _]| [x + 0.01, *y, z - 0.02, 0.0]).collect();
    let (before, after) = (twin.cables.polyline(0, &twin.body.rest), twin.cables.polyline(0, &shifted));
    assert!((after[3][0] - before[3][0] - 0.01).abs() < tol);
    assert!((after[3][2] - before[3][2] + 0.02).abs() < tol);
}

#[test]
fn ring_keeps_the_compliance_from_growing_with_refinement() {
    // A point sinks in by 1/(E h): from 12 sides to 24 that part doubles. A ring's part is finite.
    let growth = |ring: f64| compliance(24, ring) / compliance(12, ring) - 1.0;
    let (point, ring) = (growth(0.0), growth(RING));
    assert!(point > 0.05, "a point must show the effect: {point}");
    assert!(ring < 0.5 * point, "grows by {ring} with the ring, {point} without");
}

#[test]
fn ring_tendons_bend_the_robot_within_the_accuracy() {
    let twin = twin(8, RING);
    let mut stepper = Stepper::new(&twin);
    let targets = [0.002, 0.0, -0.002, 0.0].map(Target::Stroke);
    let report = stepper.step(&twin, &targets).unwrap();
    let state = stepper.state();
    assert!(report.relative_residual <= twin.accuracy.relative_residual);
    assert!(state.tensions[0] > 1.0, "{:?}", state.tensions);
    assert!(twin.tip_of(state)[0] > 0.05 * scenes::LENGTH, "{:?}", twin.tip_of(state));
}
