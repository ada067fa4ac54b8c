//! Tendons that stretch, and that are pulled before the first stroke.

use hysteron_base::Scene;
use hysteron_fem::Mesh;
use hysteron_twin::{Stepper, Target, TipGoal};

use super::{Robot, assert_close, distance, scenes, strokes, tolerance};

/// Of the order of the body's own compliance along a tendon.
const COMPLIANCE: f64 = 2e-4;
/// Equilibria of the same commands differ by a residual of 1e-8 of 5 N on a body that 5 N bend by 20 mm.
const SAME_TIP: f64 = 1e-8;

fn stretching(compliance: f64) -> (Scene, Mesh) {
    let (mut scene, mesh) = scenes::robot();
    for tendon in &mut scene.tendons {
        tendon.compliance = compliance;
    }
    (scene, mesh)
}

#[test]
fn zero_is_a_shift_of_the_commanded_stroke() {
    let zeros = [1e-3, -5e-4, 0.0, 3e-4];
    let (mut scene, mesh) = scenes::robot();
    for (tendon, zero) in scene.tendons.iter_mut().zip(zeros) {
        tendon.zero = zero;
    }
    let mut offset = Robot::new(&(scene, mesh));
    let mut plain = Robot::new(&scenes::robot());
    for k in 0..10 {
        let command = [2e-4 * f64::from(k), 1e-4, -1e-4 * f64::from(k), 2e-4];
        let shifted: Vec<f64> = command.iter().zip(zeros).map(|(stroke, zero)| stroke + zero).collect();
        offset.go(&strokes(&command));
        plain.go(&strokes(&shifted));
        assert_eq!(offset.state, plain.state, "to the last bit, step {k}");
    }
    let (shown, geometric) = (offset.twin.commands_of(&offset.state), offset.strokes());
    for j in 0..4 {
        assert_close("zero", geometric[j] - shown[j], zeros[j], 1e-17);
    }
}

#[test]
fn stretched_tendon_pulls_the_body_as_a_stiff_one_by_the_rest_of_the_stroke() {
    let mut robot = Robot::new(&stretching(COMPLIANCE));
    let mut stiff = Robot::new(&scenes::robot());
    for command in [[2e-3, 0.0, -2e-3, 0.0], [1e-3, 2e-3, -1e-3, -4e-3], [5e-4, 5e-4, 5e-4, 5e-4]] {
        robot.go(&strokes(&command));
        stiff.go(&strokes(&robot.strokes()));
        assert!(distance(robot.tip(), stiff.tip()) < tolerance(SAME_TIP));
        for j in 0..4 {
            let (tension, stroke) = (robot.state.tensions[j], robot.strokes()[j]);
            let missing = command[j] - stroke - COMPLIANCE * tension;
            assert!(if tension > 0.0 { missing.abs() <= 1e-10 } else { missing <= 1e-10 }, "{j}: {missing}");
            assert_close("tension", stiff.state.tensions[j], tension, 1e-5);
        }
        assert!(COMPLIANCE * robot.state.tensions[1].max(robot.state.tensions[0]) > 1e-4, "it stretches");
    }
}

#[test]
fn tendon_and_body_are_springs_in_series() {
    // A pull so small that the body is linear: T = u / (W + c). Terms of second order are u over the body's
    // length, 1 µm / 40 mm.
    let pull = 1e-6;
    let tension = |compliance: f64| {
        let mut robot = Robot::new(&stretching(compliance));
        robot.go(&[Target::Stroke(pull), Target::Free, Target::Free, Target::Free]);
        robot.state.tensions[0]
    };
    let body = pull / tension(0.0);
    for compliance in [0.1 * body, body, 10.0 * body] {
        let expected = pull / (body + compliance);
        assert_close("tension", tension(compliance) / expected, 1.0, 1e-3);
    }
}

#[test]
fn delassus_operator_has_the_tendons_own_compliance_on_its_diagonal() {
    let (stiff, soft) = (Robot::new(&scenes::robot()), Robot::new(&stretching(COMPLIANCE)));
    let operator = |robot: &Robot| Stepper::new(&robot.twin).delassus(&robot.twin).unwrap();
    let (stiff, soft) = (operator(&stiff), operator(&soft));
    for k in 0..16 {
        let own = if k % 5 == 0 { COMPLIANCE } else { 0.0 };
        // One addition, rounded.
        assert_close("entry", soft[k], stiff[k] + own, 1e-18);
    }
}

#[test]
fn work_at_the_pulled_end_is_energy_of_body_and_tendons() {
    let error = |steps: u32| {
        let mut robot = Robot::new(&stretching(COMPLIANCE));
        let at = |s: f64| strokes(&[s, 0.0, -3e-3, 1e-4]);
        let stored = |robot: &Robot| {
            let stretch: f64 = robot.state.tensions.iter().map(|t| 0.5 * COMPLIANCE * t * t).sum();
            robot.twin.body.energy(&robot.state.positions) + stretch
        };
        robot.go(&at(1e-4));
        let (start, mut work) = (stored(&robot), 0.0);
        for k in 1..=steps {
            let before = (robot.twin.commands_of(&robot.state), robot.state.tensions.clone());
            robot.go(&at(1e-4 + 2e-3 * f64::from(k) / f64::from(steps)));
            let now = robot.twin.commands_of(&robot.state);
            for j in 0..4 {
                work += 0.5 * (before.1[j] + robot.state.tensions[j]) * (now[j] - before.0[j]);
            }
        }
        (work - (stored(&robot) - start)) / stored(&robot)
    };
    let (coarse, fine) = (error(8), error(16));
    let order = (coarse / fine).log2();
    // The trapezoid rule, up to terms of higher order.
    assert!((order - 2.0).abs() < tolerance(0.2), "{coarse} {fine}");
    assert!(fine.abs() < tolerance(1e-3), "{fine}");
}

#[test]
fn strokes_that_reach_a_goal_count_stretch_and_zero() {
    let (mut scene, mesh) = stretching(COMPLIANCE);
    scene.tendons[0].zero = 4e-4;
    scene.tendons[1].zero = -3e-4;
    let scene = (scene, mesh);
    let mut maker = Robot::new(&scene);
    maker.go(&strokes(&[1e-3, 1.2e-3, -5e-3, -5e-3]));
    let goal =
        TipGoal { position: maker.tip().map(Some), tolerance: 1e-7, regularisation: 1e-6, least_gain: 0.0 };
    let mut robot = Robot::new(&scene);
    robot.go(&[Target::Free; 4]);
    let report = robot.reach(&goal, &[Target::Free; 4]).unwrap();
    assert!(report.is_reached, "{report:?}");
    let mut follower = Robot::new(&scene);
    follower.go(&strokes(&report.strokes));
    assert!(distance(follower.tip(), maker.tip()) < tolerance(1.1e-7));
}
