//! Tendon points that act on the body within a radius.

use hysteron_base::{Insert, MaterialLaw, Region, Scene};
use hysteron_fem::{Layers, Order};
use hysteron_twin::chain::{Chain, Equilibrium, ValidationOptions};
use hysteron_twin::{Stepper, Target, Twin};

use super::{scenes, tolerance};

const RADIUS: f64 = 0.0025;

fn anchored(scene: &mut Scene, radius: f64) {
    for tendon in &mut scene.tendons {
        tendon.anchor = Some(radius);
    }
    if let Some(layout) = &mut scene.auxiliary {
        layout.anchor = Some(radius);
    }
}

/// The robot of the other tests with `sides` and layers as high as they are wide, finer where the tendons end.
fn twin(sides: u32, anchor: Option<f64>) -> Twin {
    twin_of(Order::Linear, sides, anchor)
}

fn twin_of(order: Order, sides: u32, anchor: Option<f64>) -> Twin {
    let (mut scene, _) = scenes::robot();
    if let Some(radius) = anchor {
        anchored(&mut scene, radius);
    }
    let height = std::f64::consts::TAU * scenes::OUTER / f64::from(sides);
    let tube = scenes::tube_of(sides, Layers::Graded { height, end: 0.5 * height }, order);
    Twin::new(&scene, &tube.with_circle_areas().mesh().unwrap()).unwrap()
}

#[test]
fn anchors_lie_on_the_lines_of_their_tendons() {
    let twin = twin(12, Some(RADIUS));
    let (scene, _) = scenes::robot();
    for (j, tendon) in scene.tendons.iter().enumerate() {
        // Tendons run along z; round-off of a hundred weighted positions.
        for (carried, point) in twin.cables.polyline(j, &twin.body.rest).iter().zip(&tendon.points) {
            for c in 0..2 {
                assert!((carried[c] - point[c]).abs() < 1e-12 * scenes::LENGTH, "{carried:?} for {point:?}");
            }
            assert!((carried[2] - point[2]).abs() < 0.5 * RADIUS, "{carried:?} for {point:?}");
        }
    }
}

/// Stroke of the first tendon per tension in all four [m/N]: the body shortens without bending, and the ends sink in.
fn compliance(sides: u32, anchor: Option<f64>) -> f64 {
    let twin = twin_of(Order::Quadratic, sides, anchor);
    let delassus = Stepper::new(&twin).delassus(&twin).unwrap();
    delassus[..4].iter().sum()
}

#[test]
fn the_compliance_of_anchored_tendons_converges() {
    let change = |anchor: Option<f64>| {
        let [coarse, middle, fine] = [8, 12, 18].map(|sides| compliance(sides, anchor));
        (middle / coarse - 1.0, fine / middle - 1.0)
    };
    let (anchored, pointed) = (change(Some(RADIUS)), change(None));
    // Refined by 1.5 each time, an error of second order falls to a factor 1/2.25, one of first order to 1/1.5; what a
    // point adds grows by 1.5.
    assert!(anchored.1.abs() < anchored.0.abs() / 1.5, "{anchored:?}");
    assert!(pointed.1 > pointed.0 && pointed.1 > 5.0 * anchored.1.abs(), "{pointed:?}, {anchored:?}");
}

#[test]
fn anchored_tendons_are_conjugate_to_their_tensions() {
    // Reciprocity, W = Wᵀ, without the factor: differences of strokes by tensions at a bent state.
    let mut twin = twin(12, Some(RADIUS));
    twin.accuracy.relative_residual = 1e-11;
    for tendon in &mut twin.tendons {
        tendon.tension.min = -100.0;
    }
    let bent = [3.0, 1.0, 0.2, 0.5];
    let step = 1e-3;
    let strokes = |j: usize, by: f64| {
        let mut tensions = bent;
        tensions[j] += by;
        let state = super::after(&twin, &twin.rest(), &super::tensions(&tensions));
        twin.strokes_of(&state)
    };
    let by_tension: Vec<Vec<f64>> = (0..4)
        .map(|j| {
            let (ahead, behind) = (strokes(j, step), strokes(j, -step));
            (0..4).map(|i| (ahead[i] - behind[i]) / (2.0 * step)).collect()
        })
        .collect();
    let size = by_tension.iter().flatten().fold(0.0f64, |max, w| max.max(w.abs()));
    for (i, row) in by_tension.iter().enumerate() {
        for j in 0..i {
            // A residual of 1e-11 of 5 N over a step of 1e-3 N, some 5e-8.
            assert!((row[j] - by_tension[j][i]).abs() < tolerance(1e-6) * size, "{i} {j}: {by_tension:?}");
        }
    }
    assert!(by_tension[0][2] < 0.0, "pulling one side lengthens the other: {by_tension:?}");
}

#[test]
fn the_simpler_tangent_of_anchors_costs_few_iterations() {
    let iterations = |anchor: Option<f64>| {
        let twin = twin(12, anchor);
        let mut stepper = Stepper::new(&twin);
        let mut sum = 0;
        for step in 1..=10 {
            let stroke = 0.0004 * f64::from(step);
            let report = stepper.step(&twin, &[stroke, 0.0, -stroke, 0.0].map(Target::Stroke)).unwrap();
            assert!(report.relative_residual <= twin.accuracy.relative_residual);
            sum += report.iterations;
        }
        sum
    };
    let (anchored, pointed) = (iterations(Some(RADIUS)), iterations(None));
    assert!(anchored <= 2 * pointed, "{anchored} against {pointed}");
}

#[test]
fn auxiliary_tendons_are_anchored_alike() {
    let (mut scene, mesh) = scenes::actuated(4);
    anchored(&mut scene, RADIUS);
    let twin = Twin::new(&scene, &mesh).unwrap();
    let mut stepper = Stepper::new(&twin);
    let targets: Vec<Target> = (0..twin.tendons.len())
        .map(|j| if j < 4 { Target::Stroke(0.0) } else { Target::Tension(if j == 4 { 5.0 } else { 0.0 }) })
        .collect();
    let report = stepper.step(&twin, &targets).unwrap();
    assert!(report.relative_residual <= twin.accuracy.relative_residual);
    assert!(twin.tip_of(stepper.state())[0] > twin.tip_of(&twin.rest())[0] + 1e-4);
}

/// The last three millimetres of the robot as a cap that is a hundred times as stiff.
fn capped(scene: &mut Scene) {
    let (side, end) = (2.0 * scenes::OUTER, scenes::LENGTH);
    let region = Region::Box { min: [-side, -side, end - 3.4e-3], max: [side, side, end + 1e-3] };
    scene.inserts = vec![Insert { region, modulus_ratio: 100.0 }];
}

#[test]
fn tendons_hardly_sink_into_a_stiff_cap() {
    let own = |is_capped: bool| {
        let (mut scene, mesh) = scenes::robot();
        if is_capped {
            capped(&mut scene);
        }
        let twin = Twin::new(&scene, &mesh).unwrap();
        Stepper::new(&twin).delassus(&twin).unwrap()[..4].iter().sum::<f64>()
    };
    // Of a bar of 40 mm with its last layer stiff a twelfth of the stretch is gone, and what the ends sink in.
    let gain = 1.0 - own(true) / own(false);
    assert!((1.0 / 12.0..0.5).contains(&gain), "{gain}");
}

#[test]
fn a_part_without_whole_elements_is_refused() {
    let (mut scene, mesh) = scenes::robot();
    capped(&mut scene);
    scene.inserts[0].region = Region::Box { min: [-1.0, -1.0, 0.0399], max: [1.0; 3] };
    let error = Twin::new(&scene, &mesh).unwrap_err().to_string();
    assert!(error.contains("insert[1]") && error.contains("whole elements"), "{error}");
}

/// Displacement of the tip [mm], tension [N] and rotation [deg] of the finest ten-node mesh of a reference.
fn reference(name: &str) -> [f64; 3] {
    let path = format!("{}/../tests/reference/anchors/{name}.csv", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let row = text.lines().rfind(|row| row.contains(",2:")).unwrap();
    let number = |column: usize| row.split(',').nth(column).unwrap().parse().unwrap();
    [4, 5, 6].map(number)
}

#[test]
fn the_robot_with_a_chain_is_as_stiff_as_the_converged_one() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../meshes/tpu80/scene-reduced.toml");
    let mut scene = Scene::read(path).unwrap();
    (scene.auxiliary, scene.friction) = (None, None);
    for tendon in &mut scene.tendons {
        (tendon.compliance, tendon.zero) = (0.0, 0.0);
    }
    let twin = Twin::from_scene(&scene).unwrap();
    let mut stepper = Stepper::new(&twin);
    let rest = twin.tip_of(stepper.state());
    for step in 1..=4 {
        let mut targets = [Target::Tension(0.0); 4];
        targets[0] = Target::Stroke(1.25e-3 * f64::from(step));
        stepper.step(&twin, &targets).unwrap();
    }
    let state = stepper.state();
    let tip = twin.tip_of(state);
    let moved = (0..3).map(|c| (tip[c] - rest[c]).powi(2)).sum::<f64>().sqrt();
    let found = [1e3 * moved, state.tensions[0], twin.tip_rotation_of(state).angle().to_degrees()];
    for (found, expected) in found.iter().zip(reference("tpu80")) {
        // Its mesh, the first of the file, is within 0.9 % of the finest; the chain within 0.6 % of its mesh under one tendon.
        assert!((found / expected - 1.0).abs() < 0.015, "{found} for {expected}");
    }
}

#[test]
fn a_chain_has_the_stiff_parts_of_its_body() {
    let (mut scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, 24);
    capped(&mut scene);
    let twin = Twin::new(&scene, &mesh).unwrap();
    let mut chain = Chain::new(&twin).unwrap();
    let options = ValidationOptions { count: 4, stroke: 1e-3, tension: 0.0, seed: 3 };
    chain.validate(&twin, &options, &Equilibrium::all(&twin, &options).unwrap()).unwrap();
    let found = chain.validation.unwrap();
    // As without a cap: what is left out is of fourth order.
    assert_eq!((found.count, found.refused), (4, [0; 2]));
    assert!(found.tip.largest < 1e-3 && found.tensions.largest < 1e-3, "{found:?}");
}

#[test]
fn an_anchor_without_body_is_refused_with_what_to_do() {
    let (mut scene, mesh) = scenes::robot();
    scene.tendons[1].anchor = Some(1e-4);
    for point in &mut scene.tendons[1].points {
        point[1] = 0.0065;
    }
    let error = Twin::new(&scene, &mesh).unwrap_err().to_string();
    assert!(error.contains("at least 5 % of its anchor in the body"), "{error}");
    assert!(error.contains("points_mm[0]") && error.contains("anchor_radius_mm"), "{error}");
}
