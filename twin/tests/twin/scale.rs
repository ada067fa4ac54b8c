//! One robot at two scales of length and force gives the same dimensionless answers.

use hysteron_fem::Order;

use super::{Robot, assert_close, scenes, strokes};

/// The robot `length` times as large, of a material that gives `force` times the forces.
fn robot(length: f64, force: f64) -> Robot {
    let mesh =
        scenes::tube(length * scenes::LENGTH, length * scenes::OUTER, length * 0.0025, 12, Order::Linear);
    let (mut scene, _) = scenes::robot();
    scene.material.youngs_modulus *= force / length.powi(2);
    for tendon in &mut scene.tendons {
        for point in &mut tendon.points {
            *point = point.map(|c| length * c);
        }
        tendon.tension.min *= force;
        tendon.tension.max *= force;
        tendon.attach_within *= length;
    }
    scene.solver.stroke_tolerance *= length;
    Robot::new(&(scene, mesh))
}

#[test]
fn answers_do_not_depend_on_scale() {
    // Ten times larger of a material a hundred times softer: the same forces. And a robot of 4 km.
    for (length, force) in [(10.0, 1.0), (1e5, 1e7), (1e-3, 1e-9)] {
        let (mut unit, mut scaled) = (robot(1.0, 1.0), robot(length, force));
        for command in [[0.0; 4], [2e-3, 0.0, -4e-3, 0.0], [1e-3, 1.5e-3, -3e-3, -3e-3], [3e-4; 4]] {
            let a = unit.go(&strokes(&command));
            let b = scaled.go(&strokes(&command.map(|s| length * s)));
            assert_eq!(a.newton_iterations > 0, b.newton_iterations > 0, "the same path: {a:?} and {b:?}");
            let (tip, scaled_tip) = (unit.tip(), scaled.tip());
            for c in 0..3 {
                // Both are within 1e-8 of balance.
                assert_close("tip", scaled_tip[c] / length, tip[c], 1e-8);
            }
            for j in 0..4 {
                assert_close("tension", scaled.state.tensions[j] / force, unit.state.tensions[j], 1e-5);
            }
        }
    }
}
