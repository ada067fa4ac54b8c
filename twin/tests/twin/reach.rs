//! From a tip goal to strokes.

use hysteron_base::Bounds;
use hysteron_twin::{Target, TipGoal};
use rand::RngExt;

use super::{Robot, check_report, distance, rng, scenes, strokes, tolerance};

fn goal(position: [f64; 3]) -> TipGoal {
    TipGoal { position: position.map(Some), tolerance: 1e-6, regularisation: 1e-6, least_gain: 0.0 }
}

#[test]
fn reached_goal_is_the_forward_answer_to_its_strokes() {
    let mut rng = rng("reach");
    let mut robot = Robot::new(&scenes::robot());
    let mut rounds = Vec::new();
    for _ in 0..15 {
        // A goal that some pair of tendons can reach: made by the forward problem.
        let mut command = [-1e-2; 4];
        let (k, pull) = (rng.random_range(0..4), rng.random_range(0.2e-3..3e-3));
        command[k] = pull;
        command[(k + 1) % 4] = rng.random_range(0.2e-3..3e-3);
        let mut maker = Robot::new(&scenes::robot());
        maker.go(&strokes(&command));
        let position = maker.tip();
        let targets = [Target::Free; 4];
        let report = robot.reach(&goal(position), &targets).expect("an answer");
        assert!(report.is_reached && report.tip_error <= 1e-6, "{report:?} for {command:?}");
        assert!((distance(robot.tip(), position) - report.tip_error).abs() < 1e-12);
        check_report(&robot.twin, &report.step);
        assert_eq!(report.strokes, robot.strokes());
        rounds.push(report.rounds);
        // The report promises that its strokes give the same equilibrium.
        let mut again = Robot::new(&scenes::robot());
        again.go(&strokes(&report.strokes));
        assert!(distance(again.tip(), robot.tip()) < tolerance(1e-7));
    }
    println!("rounds to reach random goals: {rounds:?}");
}

#[test]
fn a_coordinate_that_is_left_free_takes_what_the_others_need() {
    let mut robot = Robot::new(&scenes::robot());
    let mut maker = Robot::new(&scenes::robot());
    maker.go(&strokes(&[2e-3, 1e-3, -1e-2, -1e-2]));
    let [x, y, z] = maker.tip();
    let free = TipGoal { position: [Some(x), Some(y), None], ..goal([x, y, z]) };
    let report = robot.reach(&free, &[Target::Free; 4]).expect("an answer");
    let tip = robot.tip();
    assert!(report.is_reached, "{report:?}");
    assert!(((tip[0] - x).hypot(tip[1] - y) - report.tip_error).abs() < 1e-12);
    // Bent as far, with tensions of its own choice: lower or higher by no more than a pull of all shortens it.
    assert!((tip[2] - z).abs() < 1e-3 && tip[2] != z, "{tip:?} {z}");
}

#[test]
fn bounds_are_kept_and_far_goals_approached() {
    let (mut scene, mesh) = scenes::robot();
    for tendon in &mut scene.tendons {
        tendon.stroke = Bounds { min: -0.01, max: 2e-3 };
        tendon.tension = Bounds { min: 0.0, max: 3.0 };
    }
    let mut robot = Robot::new(&(scene, mesh));
    let start = robot.twin.tip_of(&robot.state);
    let place = [0.03, 0.0, 0.02];
    let goal = goal(place);
    let report = robot.reach(&goal, &[Target::Free; 4]).expect("an answer");
    assert!(!report.is_reached && report.tip_error > 1e-3, "{report:?}");
    assert!(report.tip_error < distance(start, place) - 1e-3, "{report:?}");
    for (tension, stroke) in robot.state.tensions.iter().zip(&report.strokes) {
        assert!((0.0..=3.0).contains(tension), "{report:?}");
        assert!(*stroke <= 2e-3 + 1e-9 && *stroke >= -0.01 - 1e-9, "{report:?}");
    }
    // One of the bounds is what stops it.
    let at_bound =
        robot.state.tensions.iter().any(|t| *t > 2.9) || report.strokes.iter().any(|s| *s > 1.9e-3);
    assert!(at_bound, "{report:?}");
}

#[test]
fn held_tendons_keep_their_targets() {
    // Taut at the goal, and gone slack on the path: the free ones have to pass that change of the active set.
    for (pull, stays_taut) in [(-1.5e-3, true), (1.5e-3, false)] {
        let mut robot = Robot::new(&scenes::robot());
        let targets = [Target::Free, Target::Stroke(4e-4), Target::Free, Target::Tension(0.7)];
        let mut maker = Robot::new(&scenes::robot());
        let third = if stays_taut { Target::Stroke(1e-4) } else { Target::Tension(0.0) };
        maker.go(&[Target::Stroke(pull), targets[1], third, targets[3]]);
        assert_eq!(maker.state.tensions[1] > 0.0, stays_taut);
        let goal = TipGoal { tolerance: 1e-5, ..goal(maker.tip()) };
        let report = robot.reach(&goal, &targets).expect("an answer");
        assert!(report.is_reached, "{report:?}");
        assert_eq!(robot.state.tensions[1] > 0.0, stays_taut);
        let slack = report.strokes[1] - 4e-4;
        assert!(if stays_taut { slack.abs() < 1e-9 } else { slack > -1e-9 }, "{slack}");
        assert_eq!(robot.state.tensions[3], 0.7);
    }
}

#[test]
fn without_free_tendon_there_is_nothing_to_choose() {
    let mut robot = Robot::new(&scenes::robot());
    let goal = goal([0.0, 0.0, 0.03]);
    let result = robot.reach(&goal, &strokes(&[0.0; 4]));
    assert!(result.is_err_and(|error| error.bad_input().is_some_and(|bad| bad.place == "targets")));
}

#[test]
fn bad_goal_or_targets_are_refused() {
    let mut robot = Robot::new(&scenes::robot());
    for position in [[f64::NAN, 0.0, 0.0], [0.0, f64::INFINITY, 0.0]] {
        let result = robot.reach(&goal(position), &[Target::Free; 4]);
        assert!(result.is_err_and(|error| error.bad_input().is_some_and(|bad| bad.place == "goal")));
    }
    for n in [1, 5] {
        let targets = vec![Target::Free; n];
        let result = robot.reach(&goal([0.0; 3]), &targets);
        assert!(
            result.is_err_and(|error| error.bad_input().is_some_and(|bad| bad.place == "targets")),
            "{n}"
        );
    }
}
