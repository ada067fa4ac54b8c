//! Tendons pull only: complementarity, slackness, and no memory.

use hysteron_base::PointForce;
use hysteron_twin::Target;
use rand::RngExt;

use super::{Robot, assert_close, distance, rng, scenes, strokes, tolerance};

/// Two equilibria of the same commands differ by the residual times the compliance: 1e-8 of 5 N on a body
/// that 5 N bend by 20 mm.
const SAME_TIP: f64 = 1e-8;

/// T >= lowest, s >= u, and one of them an equality; in between s = u.
fn check_complementarity(robot: &Robot, commanded: &[f64]) {
    let strokes = robot.strokes();
    for j in 0..commanded.len() {
        let (tension, bounds) = (robot.state.tensions[j], robot.twin.tendons[j].tension);
        let slack = strokes[j] - commanded[j];
        let tol = robot.twin.accuracy.stroke;
        assert!(bounds.contains(tension), "tendon {j}: {tension} N");
        if tension == bounds.min {
            assert!(slack >= -tol, "tendon {j} is slack but too long by {slack} m");
        } else if tension == bounds.max {
            assert!(slack <= tol, "tendon {j} slips but is too short by {slack} m");
        } else {
            assert!(slack.abs() <= tol, "tendon {j} pulls {tension} N but is {slack} m off");
        }
    }
}

#[test]
fn tensions_and_slack_are_complementary() {
    let mut rng = rng("complementarity");
    let mut robot = Robot::new(&scenes::robot());
    let mut command = [0.0; 4];
    let mut n_slack = [0; 5];
    for _ in 0..150 {
        for stroke in &mut command {
            *stroke = f64::clamp(*stroke + rng.random_range(-6e-4..6e-4), -6e-4, 2e-3);
        }
        robot.go(&strokes(&command));
        check_complementarity(&robot, &command);
        n_slack[robot.state.tensions.iter().filter(|t| **t == 0.0).count()] += 1;
    }
    println!("steps with 0 to 4 tendons exactly slack: {n_slack:?}");
    assert!(
        n_slack[0] > 0 && n_slack[1..4].iter().all(|n| *n >= 5),
        "the drive must meet all cases: {n_slack:?}"
    );
}

#[test]
fn saturated_tendon_slips_at_its_bound() {
    let (mut scene, mesh) = scenes::robot();
    for tendon in &mut scene.tendons {
        tendon.tension.max = 2.0;
    }
    let mut robot = Robot::new(&(scene, mesh));
    let mut n_saturated = 0;
    for command in [[5e-3, 0.0, -5e-3, 0.0], [1e-3, 4e-3, -1e-3, -4e-3], [3e-3, 3e-3, 3e-3, 3e-3]] {
        robot.go(&strokes(&command));
        check_complementarity(&robot, &command);
        n_saturated += robot.state.tensions.iter().filter(|t| **t == 2.0).count();
    }
    assert!(n_saturated >= 4, "{n_saturated}");
    // The same shape as under the bound as a prescribed tension.
    robot.go(&strokes(&[5e-3, -1e-2, -1e-2, -1e-2]));
    let mut driven = Robot::new(&scenes::robot());
    driven.go(&super::tensions(&[2.0, 0.0, 0.0, 0.0]));
    assert!(distance(robot.tip(), driven.tip()) < tolerance(SAME_TIP));
}

#[test]
fn tendon_may_be_given_a_least_tension() {
    // 20 N on each compress the body by 16 %.
    for least in [4.0, 20.0] {
        let (mut scene, mesh) = scenes::robot();
        for tendon in &mut scene.tendons {
            tendon.tension.min = least;
        }
        let mut robot = Robot::new(&(scene, mesh));
        let command = [1e-3, 0.0, -1e-2, 0.0];
        robot.go(&strokes(&command));
        check_complementarity(&robot, &command);
        assert_eq!(robot.state.tensions[2], least);
    }
}

#[test]
fn released_tendon_has_no_effect() {
    let mut robot = Robot::new(&scenes::robot());
    robot.go(&strokes(&[2e-3, 0.0, -5e-3, 0.0]));
    assert_eq!(robot.state.tensions[2], 0.0);
    let before = robot.state.clone();
    for release in [-6e-3, -9e-3, -5e-3] {
        robot.go(&strokes(&[2e-3, 0.0, release, 0.0]));
        assert_eq!(robot.state.tensions[2], 0.0);
        assert!(distance(robot.tip(), robot.twin.tip_of(&before)) < tolerance(SAME_TIP));
        assert_close("tension of the pulled tendon", robot.state.tensions[0], before.tensions[0], 1e-6);
    }
}

#[test]
fn tendon_tightens_at_the_stroke_where_it_went_slack() {
    // Slacken tendon 1 of a bent body, step by step, and pull it again: its tension is the same
    // function of its stroke both ways, and zero below the body's own stroke.
    let mut robot = Robot::new(&scenes::robot());
    let at = |k: i32| strokes(&[1e-4 * f64::from(k), 1.5e-3, -5e-3, -5e-3]);
    robot.go(&[Target::Tension(0.0), Target::Stroke(1.5e-3), Target::Free, Target::Free]);
    let natural = robot.strokes()[0];
    let mut down = Vec::new();
    for k in (-10..=10).rev() {
        robot.go(&at(k));
        down.push(robot.state.tensions[0]);
    }
    for k in -10..=10 {
        robot.go(&at(k));
        let before = down.pop().unwrap();
        assert_close("tension on the way back", robot.state.tensions[0], before, 1e-6);
        assert_eq!(robot.state.tensions[0] == 0.0, 1e-4 * f64::from(k) < natural, "step {k}, {natural}");
    }
    assert!(natural > -1e-3 && natural < 1e-3, "the drive must cross {natural}");
}

#[test]
fn shape_does_not_depend_on_the_path() {
    let (mut scene, mesh) = scenes::robot();
    scene.gravity = [0.0, -9.81, 0.0];
    scene.point_forces.push(PointForce { at: [0.0, 0.0045, scenes::LENGTH], force: [0.1, 0.0, 0.0] });
    let scene = (scene, mesh);
    let goal = strokes(&[1.2e-3, 0.9e-3, -2e-3, -1e-3]);
    let mut direct = Robot::new(&scene);
    direct.go(&goal);

    let mut rng = rng("paths");
    let mut wandering = Robot::new(&scene);
    for _ in 0..30 {
        let command: Vec<f64> = (0..4).map(|_| rng.random_range(-1.5e-3..1.5e-3)).collect();
        wandering.go(&strokes(&command));
    }
    wandering.go(&goal);

    let mut slow = Robot::new(&scene);
    for k in 1..=25 {
        let part = f64::from(k) / 25.0;
        slow.go(&strokes(&[1.2e-3 * part, 0.9e-3 * part, -2e-3 * part, -1e-3 * part]));
    }
    for other in [&wandering, &slow] {
        let error = distance(direct.tip(), other.tip());
        println!("tips of two paths to the same strokes: {error:.1e} m apart");
        assert!(error < tolerance(SAME_TIP), "{error}");
        for j in 0..4 {
            assert_close("tension", other.state.tensions[j], direct.state.tensions[j], 1e-5);
        }
    }
}

#[test]
fn closed_loop_returns_to_its_start() {
    let mut robot = Robot::new(&scenes::robot());
    let at = |angle: f64| {
        let (x, y) = (2e-3 * angle.cos(), 2e-3 * angle.sin());
        strokes(&[x, y, -x - 1e-4, -y - 1e-4])
    };
    robot.go(&at(0.0));
    let start = robot.tip();
    let mut n_changes = 0;
    let mut farthest = 0.0f64;
    let mut slack: Vec<bool> = robot.state.tensions.iter().map(|t| *t == 0.0).collect();
    for k in 1..=60 {
        robot.go(&at(std::f64::consts::TAU * f64::from(k) / 60.0));
        let now: Vec<bool> = robot.state.tensions.iter().map(|t| *t == 0.0).collect();
        n_changes += usize::from(now != slack);
        slack = now;
        farthest = farthest.max(distance(start, robot.tip()));
    }
    assert!(n_changes >= 4, "every tendon goes slack and taut: {n_changes}");
    assert!(farthest > 5e-3, "{farthest}");
    let error = distance(start, robot.tip());
    println!("tip after a closed loop: {error:.1e} m off");
    assert!(error < tolerance(SAME_TIP), "{error}");
}

#[test]
fn tension_drive_and_stroke_drive_agree() {
    let mut by_stroke = Robot::new(&scenes::robot());
    by_stroke.go(&strokes(&[2e-3, 1e-3, -1e-2, -1e-2]));
    let mut by_tension = Robot::new(&scenes::robot());
    by_tension.go(&super::tensions(&by_stroke.state.tensions));
    assert!(distance(by_stroke.tip(), by_tension.tip()) < tolerance(SAME_TIP));
    for (a, b) in by_stroke.strokes().iter().zip(by_tension.strokes()) {
        assert_close("stroke", b, *a, SAME_TIP);
    }
}

#[test]
fn free_tendon_takes_the_least_tension_allowed() {
    let (mut scene, mesh) = scenes::robot();
    scene.tendons[1].tension.min = 0.25;
    scene.tendons[3].tension.min = -1.0;
    let mut robot = Robot::new(&(scene, mesh));
    robot.go(&[Target::Stroke(1e-3), Target::Free, Target::Free, Target::Free]);
    assert_eq!(robot.state.tensions[1..], [0.25, 0.0, 0.0]);
}
