//! The fast and the robust iteration find the same equilibrium, to the accuracy asked.

use hysteron_base::{MaterialLaw, PointForce};
use hysteron_fem::Order;
use hysteron_twin::{Accuracy, Target};

use super::{Robot, assert_close, distance, scenes, strokes, tolerance};

#[test]
fn fast_and_robust_iterations_agree() {
    let scene = scenes::robot();
    let goal = [2e-3, -1e-3, -4e-3, 1e-3];
    let mut fast = Robot::new(&scene);
    let mut newton_iterations = 0;
    fast.go(&strokes(&[0.0; 4]));
    for k in 1..=40 {
        let part = f64::from(k) / 40.0;
        newton_iterations += fast.go(&strokes(&goal.map(|s| part * s))).newton_iterations;
    }
    assert_eq!(newton_iterations, 0, "small steps are the fast iteration's");
    let mut robust = Robot::new(&scene);
    // A state without loads always takes the robust iteration first.
    let report = robust.go(&strokes(&goal));
    assert!(report.newton_iterations > 0 && report.iterations == 0, "{report:?}");
    // The residual of 1e-8 of about 5 N on a body that 5 N bend by 20 mm.
    let error = distance(fast.tip(), robust.tip());
    println!("tips of fast and robust iteration: {error:.1e} m apart");
    assert!(error < tolerance(1e-8), "{error}");
}

#[test]
fn residual_of_a_step_is_internal_minus_applied() {
    // The report's residual, computed again from public parts: energy gradient against virtual work.
    let (mut scene, mesh) = scenes::robot();
    scene.point_forces.push(PointForce { at: [0.0, 0.0045, scenes::LENGTH], force: [0.1, 0.0, 0.0] });
    let mut robot = Robot::new(&(scene, mesh));
    robot.go(&strokes(&[2e-3, 0.0, -4e-3, 1e-3]));
    let body = &robot.twin.body;
    let mut internal = vec![[0.0; 4]; body.n_nodes()];
    body.internal_force_into(&robot.state.positions, &mut internal);
    // dE - T ds - F du = 0 for any move; step of 1e-6 m for strokes of curvature 1 / 4 mm.
    const STEP: f64 = 1e-6;
    let mut moved = robot.state.clone();
    let mut back = robot.state.clone();
    let mut inner_work = 0.0;
    let mut load_work = 0.0;
    for i in 0..body.n_free {
        for c in 0..3 {
            let direction = ((7 * i + 3 * c) as f64).sin();
            moved.positions[i][c] += STEP * direction;
            back.positions[i][c] -= STEP * direction;
            inner_work += internal[i][c] * direction;
            load_work += robot.twin.loads[i][c] * direction;
        }
    }
    let (ahead, behind) = (robot.twin.strokes_of(&moved), robot.twin.strokes_of(&back));
    let cable_work: f64 =
        (0..4).map(|j| robot.state.tensions[j] * (ahead[j] - behind[j]) / (2.0 * STEP)).sum();
    assert!(cable_work.abs() > 0.1, "{cable_work}");
    assert_close("virtual work", inner_work, cable_work + load_work, 1e-5 * cable_work.abs());
}

#[test]
fn tight_accuracy_is_reached() {
    let (mut scene, mesh) = scenes::robot();
    scene.solver.relative_residual = 1e-10;
    scene.solver.stroke_tolerance = 1e-13;
    let mut robot = Robot::new(&(scene, mesh));
    for k in 0..20 {
        let angle = 0.3 * f64::from(k);
        let (x, y) = (1.5e-3 * angle.cos(), 1.5e-3 * angle.sin());
        let report = robot.go(&strokes(&[x, y, -x, -y]));
        assert!(report.relative_residual <= 1e-10 && report.stroke_error <= 1e-13, "{report:?}");
    }
}

#[test]
fn errors_shrink_with_the_accuracy_asked() {
    let scene = scenes::robot();
    let goal = strokes(&[2e-3, 1e-3, -4e-3, -4e-3]);
    let tip_at = |relative_residual: f64, stroke: f64| {
        let mut robot = Robot::new(&scene);
        robot.twin.accuracy = Accuracy { relative_residual, stroke };
        // Off the straight first step, which often does better than asked.
        for part in [0.0, 0.3, 0.7, 0.8, 0.9] {
            robot.go(&strokes(&[2e-3 * part, 1e-3 * part, -4e-3 * part, -4e-3 * part]));
        }
        robot.go(&goal);
        robot.tip()
    };
    let best = tip_at(1e-12, 1e-14);
    for exponent in [-3, -5, -7, -9] {
        let accuracy = 10f64.powi(exponent);
        let error = distance(best, tip_at(accuracy, 1e-3 * accuracy));
        println!("accuracy {accuracy:.0e}: tip {error:.1e} m off");
        // The tip moves about 20 mm; the residual counts single nodes, which bend the body less.
        assert!(error < tolerance(accuracy * 0.02), "{accuracy}: {error}");
    }
}

#[test]
fn every_law_and_order_bends() {
    let command = [1.5e-3, 0.0, -3e-3, 0.0];
    let mut angles = Vec::new();
    for (law, order) in [
        (MaterialLaw::Corotational, Order::Linear),
        (MaterialLaw::CorotationalEdges, Order::Linear),
        (MaterialLaw::NeoHookean, Order::Linear),
        (MaterialLaw::SmallStrain, Order::Linear),
        (MaterialLaw::Corotational, Order::Quadratic),
        (MaterialLaw::NeoHookean, Order::Quadratic),
    ] {
        let mut robot = Robot::new(&scenes::robot_with(law, order, 8));
        robot.go(&strokes(&[0.0; 4]));
        for k in 1..=5 {
            robot.go(&strokes(&command.map(|s| s * f64::from(k) / 5.0)));
        }
        let tip = robot.tip();
        println!("{law:?} {order:?}: tip ({:.3}, {:.3}, {:.3}) mm", 1e3 * tip[0], 1e3 * tip[1], 1e3 * tip[2]);
        angles.push(tip[0] / scenes::LENGTH);
        // A tendon at radius e pulled by s turns the end by s/e times e² / (e² + I/A) = 0.66, 0.22 rad, and
        // shortens the body by the rest: an arc with its tip at 0.11 of the length. Coarse elements, the
        // clamp and the dent at the tendon's end take from that.
        assert!(
            tip[0] > 0.05 * scenes::LENGTH && tip[0] < 0.12 * scenes::LENGTH,
            "{law:?} {order:?}: {tip:?}"
        );
        assert!(tip[1].abs() < 0.01 * scenes::LENGTH, "{tip:?}");
    }
    // Corotational and neo-Hookean agree while strains are small.
    assert_close("neo-Hookean", angles[2], angles[0], 0.01);
}

#[test]
fn small_strain_body_is_linear_under_loads() {
    let (mut scene, mesh) = scenes::robot_with(MaterialLaw::SmallStrain, Order::Linear, 8);
    scene.tendons.clear();
    let tip_under = |force: f64| {
        let mut scene = scene.clone();
        scene.point_forces.push(PointForce { at: [0.0, 0.0045, scenes::LENGTH], force: [force, 0.0, 0.0] });
        let mut robot = Robot::new(&(scene, mesh.clone()));
        robot.go(&[]);
        robot.tip()
    };
    let (once, twice) = (tip_under(0.5), tip_under(1.0));
    // The residual asked for is 1e-8.
    assert_close("twice the load", twice[0], 2.0 * once[0], 1e-7 * once[0]);
    assert!(once[0] > 1e-4, "{once:?}");
}

#[test]
fn large_jump_takes_sub_steps_or_newton_and_lands_in_the_same_place() {
    let scene = scenes::robot();
    let goal = strokes(&[5e-3, 0.0, -1e-2, 0.0]);
    let mut jump = Robot::new(&scene);
    jump.go(&strokes(&[-1e-2, 5e-3, 0.0, -1e-2]));
    let report = jump.go(&goal);
    println!("jump across the workspace: {report:?}");
    let mut slow = Robot::new(&scene);
    slow.go(&strokes(&[0.0; 4]));
    for k in 1..=50 {
        let part = f64::from(k) / 50.0;
        slow.go(&strokes(&[5e-3 * part, 0.0, -1e-2 * part, 0.0]));
    }
    slow.go(&goal);
    assert!(distance(jump.tip(), slow.tip()) < tolerance(1e-8));
}

#[test]
fn gravity_sags_before_the_first_pull() {
    let (mut scene, mesh) = scenes::robot();
    scene.gravity = [-9.81, 0.0, 0.0];
    let mut robot = Robot::new(&(scene, mesh));
    robot.go(&[Target::Free; 4]);
    assert_eq!(robot.state.load, 1.0);
    assert_eq!(robot.state.tensions, [0.0; 4]);
    // A cantilever under its own weight q: q L⁴ / (8 E I), stiffened by linear elements.
    let (e, rho) = (5e6, 1200.0);
    let (r, b) = (scenes::OUTER, 0.0025f64);
    let pi = std::f64::consts::PI;
    let (area, inertia) = (pi * (r * r - b * b), 0.25 * pi * (r.powi(4) - b.powi(4)));
    let sag = rho * area * 9.81 * scenes::LENGTH.powi(4) / (8.0 * e * inertia);
    let found = -robot.tip()[0];
    assert!(found > 0.4 * sag && found < 1.3 * sag, "{found} of {sag}");
}
