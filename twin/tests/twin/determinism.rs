//! Same scene and commands, same bytes: again, in any company, on any number of threads.

use hysteron_twin::{Rollout, Twin, TwinState, rollout as rollout_of, rollouts};
use rand::RngExt;

use super::{Robot, rng, scenes, strokes};

fn commands(run: usize) -> Vec<Vec<f64>> {
    let mut rng = rng(&format!("determinism/{run}"));
    let mut command = vec![0.0; 4];
    let mut next = || {
        for stroke in &mut command {
            *stroke = f64::clamp(*stroke + rng.random_range(-3e-4..3e-4), -1.5e-3, 1.5e-3);
        }
        command.clone()
    };
    (0..25).map(|_| next()).collect()
}

fn run_through(robot: &mut Robot, run: usize) -> Vec<TwinState> {
    robot.state = robot.twin.rest();
    let commands = commands(run);
    commands
        .iter()
        .map(|command| {
            robot.go(&strokes(command));
            robot.state.clone()
        })
        .collect()
}

const RUNS: usize = 8;

#[test]
fn repeated_run_gives_the_same_bytes() {
    let scene = scenes::robot();
    let first = run_through(&mut Robot::new(&scene), 0);
    assert_eq!(first, run_through(&mut Robot::new(&scene), 0));
    assert_ne!(first, run_through(&mut Robot::new(&scene), 1));
}

#[test]
fn stepper_from_another_run_gives_the_same_bytes() {
    // A pool hands steppers from one trajectory to the next: nothing of the first may show in the second.
    let scene = scenes::robot();
    let mut used = Robot::new(&scene);
    for run in 0..4 {
        let fresh = run_through(&mut Robot::new(&scene), run);
        assert_eq!(run_through(&mut used, run), fresh, "run {run}");
    }
}

#[test]
fn number_of_threads_does_not_show() {
    let (scene, mesh) = scenes::robot();
    let twin = Twin::new(&scene, &mesh).unwrap();
    let sequences: Vec<Vec<_>> =
        (0..RUNS).map(|run| commands(run).iter().map(|command| strokes(command)).collect()).collect();
    let on_threads = |n: usize| -> Vec<Rollout> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let results = pool.install(|| rollouts(&twin, &twin.rest(), &sequences));
        results.into_iter().map(|result| result.expect("an equilibrium")).collect()
    };
    let one = on_threads(1);
    for n in [2, 4] {
        assert_eq!(on_threads(n), one, "{n} threads");
    }
    for (run, rollout) in one.iter().enumerate() {
        let states = run_through(&mut Robot::new(&(scene.clone(), mesh.clone())), run);
        let tensions: Vec<Vec<f64>> = states.iter().map(|state| state.tensions.clone()).collect();
        assert_eq!(rollout.tensions, tensions, "run {run} alone");
        assert_eq!(*rollout, rollout_of(&twin, &twin.rest(), &sequences[run]).unwrap(), "run {run}");
        assert_eq!((rollout.tips.len(), rollout.reports.len()), (25, 25));
    }
}

#[test]
fn rollout_ends_at_the_first_sample_that_fails() {
    let (scene, mesh) = scenes::robot();
    let twin = Twin::new(&scene, &mesh).unwrap();
    let good = vec![strokes(&[1e-3, 0.0, -2e-3, 0.0])];
    let bad = vec![strokes(&[1e-3, 0.0, -2e-3, 0.0]), strokes(&[f64::NAN; 4])];
    let results = rollouts(&twin, &twin.rest(), &[good, bad, Vec::new()]);
    assert!(results[0].is_ok());
    assert!(results[1].as_ref().is_err_and(|error| error.bad_input().is_some()));
    assert!(results[2].as_ref().is_ok_and(|rollout| rollout.tips.is_empty()));
}
