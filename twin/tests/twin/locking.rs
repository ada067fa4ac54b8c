//! Locking of linear tetrahedra, estimated at rest and found by running both.

use hysteron_base::{LengthUnit, MaterialLaw, PrescribedQuantity, Scene};
use hysteron_fem::{Mesh, Order, read_mesh};
use hysteron_twin::{Locking, Stepper, Target, Twin};

use super::{distance, scenes};

/// Distance of the tip from rest [m] after the first tendon is pulled by `stroke` [m], the others slack.
fn pulled(scene: &Scene, mesh: &Mesh, stroke: f64) -> f64 {
    let twin = Twin::new(scene, mesh).expect("a good scene");
    let mut stepper = Stepper::new(&twin);
    for part in 1..=5 {
        let mut targets = vec![Target::Stroke(-0.02); scene.tendons.len()];
        targets[0] = Target::Stroke(stroke * f64::from(part) / 5.0);
        stepper.step(&twin, &targets).expect("an equilibrium");
    }
    distance(twin.tip_of(stepper.state()), twin.tip_of(&twin.rest()))
}

#[test]
fn the_estimate_is_what_both_meshes_do() {
    for (layers, ratio) in [(6, 0.3), (12, 0.3), (6, 0.45), (12, 0.49), (6, 0.499)] {
        let (mut scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, layers);
        scene.material.poisson_ratio = ratio;
        let locking = Locking::new(&scene, &mesh).expect("a good scene").expect("a linear mesh");
        let quadratic = mesh.to_quadratic();
        let errors = [0.3e-3, 0.075e-3].map(|stroke| {
            let mut targets = [Target::Stroke(-0.02); 4];
            targets[0] = Target::Stroke(stroke);
            let predicted = locking.moved(&targets, 1.0).expect("an estimate");
            // Under a stroke the tip may go as far, as ten-node tetrahedra sink in more around the tendon: they pull less.
            assert!(predicted.tension > 1.1 * predicted.tension_quadratic, "{predicted:?}");
            let found = [pulled(&scene, &mesh, stroke), pulled(&scene, &quadratic, stroke)];
            println!("{layers} layers, ν = {ratio}, {stroke} m: {predicted:?}, found {found:?}");
            let errors =
                [predicted.tip / found[0] - 1.0, predicted.tip_quadratic / found[1] - 1.0].map(f64::abs);
            // First order: the neglected part is at most the bend s/r of the motion, and goes to zero with
            // it.
            assert!(errors.iter().all(|error| *error < stroke / scenes::TENDON_RADIUS), "{errors:?}");
            errors
        });
        for (large, small) in errors[0].into_iter().zip(errors[1]) {
            assert!(small < 0.5 * large, "{layers}, ν = {ratio}: {errors:?}");
        }
    }
}

#[test]
fn finer_meshes_lose_less_and_ten_node_ones_are_not_estimated() {
    let loss = |layers| {
        let (scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, layers);
        let locking = Locking::new(&scene, &mesh).expect("a good scene").expect("a linear mesh");
        let mut targets = [Target::Free; 4];
        targets[0] = Target::Tension(1.0);
        locking.moved(&targets, 0.0).expect("an estimate").loss()
    };
    let losses = [4, 8, 16].map(loss);
    assert!(losses[0] > losses[1] && losses[1] > losses[2] && losses[2] > 0.0, "{losses:?}");
    let (scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Quadratic, 4);
    assert!(Locking::new(&scene, &mesh).expect("a good scene").is_none());
}

#[test]
fn a_rod_at_0_499_loses_six_tenths_of_its_motion() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../fem/tests/data/rod-41.msh");
    let mesh = read_mesh(file.as_ref(), LengthUnit::Millimetre.to_m()).expect("a sample");
    let mut scene = scenes::scene("rod", MaterialLaw::Corotational);
    scene.material.youngs_modulus = 1e6;
    scene.material.poisson_ratio = 0.499;
    scene.solver = Default::default();
    for x in [3e-3, -3e-3] {
        let mut tendon = scenes::tendon(0, 0.06, x, 10);
        tendon.name = format!("at {x}");
        tendon.attach_within = 1e-3;
        tendon.drive = PrescribedQuantity::Stroke;
        scene.tendons.push(tendon);
    }
    let stroke = 2.5e-3;
    let found = [pulled(&scene, &mesh, stroke), pulled(&scene, &mesh.to_quadratic(), stroke)];
    let locking = Locking::new(&scene, &mesh).expect("a good scene").expect("a linear mesh");
    let predicted =
        locking.moved(&[Target::Stroke(stroke), Target::Stroke(-0.02)], 1.0).expect("an estimate");
    println!("{predicted:?}, found {found:?}");
    // 3.5 mm across and 2.1 mm down with the mesh as it is.
    assert!((3.9e-3..4.3e-3).contains(&found[0]) && (10.3e-3..11.3e-3).contains(&found[1]), "{found:?}");
    // Each mesh adds a second order of its own, its bend of some 0.2 rad squared.
    let ratio = (found[1] / found[0]) / predicted.gain();
    assert!((ratio - 1.0).abs() < 0.04, "{ratio}");
}
