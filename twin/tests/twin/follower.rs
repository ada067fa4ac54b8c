//! Steering a twin along a path, and doing it again with the strokes alone.

use hysteron_twin::residual::{FollowLimits, PathFollower};
use hysteron_twin::{PhysicsTwin, Plant, relax_to_equilibrium};

use super::{distance, scenes};

const LIMITS: FollowLimits = FollowLimits { stroke: 2e-3, rate: 5e-3 };

fn coordinates([a, b]: [f64; 2], strokes: &mut [f64]) {
    strokes.copy_from_slice(&[a, b, -a, -b]);
}

#[test]
fn a_goal_that_stands_is_reached_and_its_strokes_lead_there_again() {
    let (scene, mesh) = scenes::robot();
    let twin = hysteron_twin::Twin::new(&scene, &mesh).unwrap();
    let mut follower =
        PathFollower::new(&twin, Box::new(PhysicsTwin::new(&twin)), &coordinates, LIMITS, 0.01).unwrap();
    let (goal, mut done) = ([1.5e-3, -1e-3], Vec::new());
    for _ in 0..150 {
        let step = follower.step(goal).unwrap();
        done.push((follower.strokes().to_vec(), step.tip));
    }
    let tip = done[149].1;
    // What is missing shrinks by a factor each sample: nothing but the accuracy of a step is left, some 1e-8 m.
    assert!((tip[0] - goal[0]).hypot(tip[1] - goal[1]) < 1e-7, "{tip:?}");
    let mut again = PhysicsTwin::new(&twin);
    let mut before = vec![0.0; 4];
    for (strokes, tip) in &done {
        let found = again.step(strokes).unwrap().tip;
        assert!((0..3).all(|c| (found[c] - tip[c]).abs() < 1e-7), "{found:?} {tip:?}");
        let moved = (strokes[0] - before[0]).hypot(strokes[1] - before[1]);
        assert!(moved <= LIMITS.rate * 0.01 * (1.0 + 1e-12), "{moved}");
        before.clone_from(strokes);
    }
}

#[test]
fn limits_hold_and_the_way_home_ends_without_strokes() {
    let (scene, mesh) = scenes::robot();
    let twin = hysteron_twin::Twin::new(&scene, &mesh).unwrap();
    let mut follower =
        PathFollower::new(&twin, Box::new(PhysicsTwin::new(&twin)), &coordinates, LIMITS, 0.01).unwrap();
    // Ten times the length of the robot cannot be reached.
    let steps: Vec<_> = (0..100).map(|_| follower.step([1.0, 0.0]).unwrap()).collect();
    // The first sample gives the beginning of the path, and leaves the strokes at rest.
    assert!(!steps[0].is_limited && steps[1..].iter().all(|step| step.is_limited));
    let reached = follower.strokes()[0].hypot(follower.strokes()[1]);
    assert!((reached - LIMITS.stroke).abs() < 1e-12, "{reached}");
    let mut n = 0;
    while !follower.is_home() {
        follower.step_home().unwrap();
        n += 1;
    }
    // 2 mm at 5 mm/s in steps of 0.05 mm, one more for rounding.
    assert!((40..=41).contains(&n), "{n}");
    assert_eq!(follower.strokes(), [0.0; 4]);
    for (wrong, place) in [
        (FollowLimits { stroke: 0.0, ..LIMITS }, "largest stroke: "),
        (FollowLimits { rate: f64::NAN, ..LIMITS }, "largest rate: expected above 0"),
    ] {
        let plant = Box::new(PhysicsTwin::new(&twin));
        let error = PathFollower::new(&twin, plant, &coordinates, wrong, 0.01).err().unwrap().to_string();
        assert!(error.starts_with(place), "{error}");
    }
}

#[test]
fn a_robot_that_rests_aside_is_led_onto_its_path_at_the_allowed_rate() {
    let (mut scene, mesh) = scenes::robot();
    scene.tendons[0].zero = 1e-3;
    let twin = hysteron_twin::Twin::new(&scene, &mesh).unwrap();
    let rest = relax_to_equilibrium(&twin, &mut PhysicsTwin::new(&twin), &[0.0; 4]).unwrap().tip;
    assert!(rest[0].abs() > 1e-3, "a rest that tests nothing: {rest:?}");
    let follow = |goal: [f64; 2]| {
        let mut follower =
            PathFollower::new(&twin, Box::new(PhysicsTwin::new(&twin)), &coordinates, LIMITS, 0.01).unwrap();
        let first = follower.step(goal).unwrap().tip;
        let (moved, mut last) = (follower.strokes().to_vec(), first);
        (0..100).for_each(|_| last = follower.step(goal).unwrap().tip);
        (moved, first, last)
    };
    // Where it rests, nothing is commanded: it does not move before it has to.
    let (moved, first, _) = follow([rest[0], rest[1]]);
    assert!(moved.iter().all(|stroke| stroke.abs() < 1e-7) && distance(first, rest) < 1e-6, "{moved:?}");
    let (moved, first, last) = follow([0.0, 0.0]);
    assert!(distance(first, rest) < distance(rest, [0.0, 0.0, rest[2]]), "a jump: {first:?}");
    assert!(moved[0].hypot(moved[1]) <= LIMITS.rate * 0.01 * (1.0 + 1e-12), "{moved:?}");
    // Every sample removes a quarter of the remaining error, less where the bent robot moves less than M predicts.
    assert!(last[0].hypot(last[1]) < 0.01 * rest[0].abs(), "{last:?}");
}
