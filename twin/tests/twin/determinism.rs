//! Same scene and commands, same bytes: again, in any company, on any number of threads.

use hysteron_twin::TwinState;
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
    let scene = scenes::robot();
    let mut results = Vec::new();
    for n_threads in [1, 2, 4] {
        let mut all: Vec<Vec<TwinState>> = vec![Vec::new(); RUNS];
        std::thread::scope(|scope| {
            for (first, chunk) in all.chunks_mut(RUNS / n_threads).enumerate() {
                let scene = &scene;
                scope.spawn(move || {
                    let mut robot = Robot::new(scene);
                    for (k, result) in chunk.iter_mut().enumerate() {
                        *result = run_through(&mut robot, first * RUNS / n_threads + k);
                    }
                });
            }
        });
        results.push(all);
    }
    assert_eq!(results[0], results[1]);
    assert_eq!(results[0], results[2]);
}
