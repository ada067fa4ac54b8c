//! Work done by cables and loads is energy stored in the body.

use hysteron_base::PointForce;
use hysteron_twin::Target;

use super::{Robot, scenes};

/// Work of cables and loads along a pull of tendon 1 by `stroke` in `steps`, and the energy stored.
fn work_and_energy(steps: usize, stroke: f64) -> (f64, f64) {
    let (mut scene, mesh) = scenes::robot();
    scene.solver.relative_residual = 1e-10;
    scene.solver.stroke_tolerance = 1e-12;
    scene
        .point_forces
        .push(PointForce { at: [0.0, scenes::TENDON_RADIUS, scenes::LENGTH], force: [0.0, -0.3, 0.2] });
    let mut robot = Robot::new(&(scene, mesh));
    // Tendon 1 pulls; 2 keeps its tension; 3 follows the bending without tension; 4 holds its length.
    let targets =
        |s: f64| [Target::Stroke(s), Target::Tension(0.8), Target::Tension(0.0), Target::Stroke(3e-5)];
    robot.go(&targets(1e-4));
    let energy = robot.twin.body.energy(&robot.state.positions);
    let (mut before, mut tensions) = (robot.strokes(), robot.state.tensions.clone());
    let mut positions = robot.state.positions.clone();
    let mut work = 0.0;
    for k in 1..=steps {
        robot.go(&targets(1e-4 + stroke * k as f64 / steps as f64));
        let strokes = robot.strokes();
        for j in 0..4 {
            work += 0.5 * (tensions[j] + robot.state.tensions[j]) * (strokes[j] - before[j]);
        }
        for ((load, now), then) in robot.twin.loads.iter().zip(&robot.state.positions).zip(&positions) {
            work += (0..3).map(|c| load[c] * (now[c] - then[c])).sum::<f64>();
        }
        before = strokes;
        tensions.clone_from(&robot.state.tensions);
        positions.clone_from(&robot.state.positions);
    }
    assert!(robot.state.tensions[0] > 1.0, "the pulled tendon works: {:?}", robot.state.tensions);
    (work, robot.twin.body.energy(&robot.state.positions) - energy)
}

#[test]
fn work_of_tendons_and_loads_is_stored_energy_to_second_order() {
    let errors: Vec<f64> = [4, 8, 16, 32]
        .into_iter()
        .map(|steps| {
            let (work, energy) = work_and_energy(steps, 2.5e-3);
            assert!(energy > 0.0);
            (work - energy) / energy
        })
        .collect();
    println!("work balance, 4 to 32 trapezoids: relative errors {errors:?}");
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        println!("work balance: order {order:.3}");
        // Two for the trapezoid rule, up to terms of higher order on the coarsest steps.
        assert!((order - 2.0).abs() < super::tolerance(0.2), "order {order}, {errors:?}");
    }
    assert!(errors[3].abs() < super::tolerance(1e-4), "{errors:?}");
}

#[test]
fn closed_loop_of_commands_does_no_work() {
    // A loop of strokes, with a tendon slack for part of it: the energy returns to where it was.
    let (scene, mesh) = scenes::robot();
    let mut robot = Robot::new(&(scene, mesh));
    let at = |angle: f64| {
        let (x, y) = (1.5e-3 * angle.cos(), 1.5e-3 * angle.sin());
        super::strokes(&[x, y, -x, -y])
    };
    robot.go(&at(0.0));
    let energy = robot.twin.body.energy(&robot.state.positions);
    let mut largest = 0.0f64;
    for k in 1..=40 {
        robot.go(&at(std::f64::consts::TAU * f64::from(k) / 40.0));
        largest = largest.max((robot.twin.body.energy(&robot.state.positions) - energy).abs());
    }
    let error = (robot.twin.body.energy(&robot.state.positions) - energy).abs() / energy;
    println!("energy after a closed loop: relative error {error:.1e}");
    // An error of 1e-10 m in a stroke of 1.5 mm, and of 1e-8 in the forces.
    assert!(error < super::tolerance(1e-6), "{error}");
    assert!(largest > 1e-3 * energy, "a loop that changes nothing");
}
