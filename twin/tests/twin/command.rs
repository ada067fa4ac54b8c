//! A recording as a command, followed sample by sample.

use std::path::Path;

use hysteron_base::{Channel, Metadata, Recording};
use hysteron_twin::Error;
use hysteron_twin::command::{Command, CommandRollout, Goals};

use super::{Robot, distance, scenes, strokes};

/// Pulls of the first tendon [m]; the others are slack.
fn rows(n: usize, longest: f64) -> Vec<[f64; 4]> {
    (1..=n).map(|i| [longest * i as f64 / n as f64, -5e-3, -5e-3, -5e-3]).collect()
}

fn recording(rows: &[[f64; 4]], tips: Option<&[[f64; 3]]>) -> Recording {
    let channel = |name: String, value: &dyn Fn(usize) -> f64| {
        Channel::new(name, (0..rows.len()).map(value).collect::<Vec<_>>())
    };
    let mut channels: Vec<Channel> =
        (0..4).map(|k| channel(format!("stroke_{}_m", k + 1), &|i| rows[i][k])).collect();
    for (c, axis) in ["x", "y", "z"].into_iter().enumerate() {
        channels.extend(tips.map(|tips| channel(format!("tip_{axis}_m"), &|i| tips[i][c])));
    }
    let time = (0..rows.len()).map(|i| 0.01 * i as f64).collect();
    Recording::new(time, channels, Vec::new(), Metadata::default()).expect("a recording")
}

#[test]
fn a_command_is_followed_as_its_targets_are_stepped() {
    let rows = rows(6, 2e-3);
    let recording = recording(&rows, None);
    let mut robot = Robot::new(&scenes::robot());
    let twin = robot.twin.clone();
    let command = Command::new(&twin, &recording, Path::new("rec.csv")).unwrap();
    let mut rollout = CommandRollout::new(&twin, &command, None, (&twin.rest(), 0)).unwrap();
    assert_eq!(rollout.farthest().0, 0);
    for (i, row) in rows.iter().enumerate() {
        let step = rollout.step(i).unwrap();
        let report = robot.go(&strokes(row));
        assert_eq!((step.tip, step.report, step.rounds), (robot.tip(), report, 0));
        assert_eq!(rollout.state(), &robot.state);
        assert_eq!(rollout.farthest(), (i, &robot.state), "bent further with every row");
    }
    assert!(rollout.network_strokes().is_none());
}

#[test]
fn goals_are_reached_by_strokes_of_the_twins_choice() {
    let rows = rows(3, 2e-3);
    let mut maker = Robot::new(&scenes::robot());
    let tip_at = |row: &[f64; 4]| {
        maker.go(&strokes(row));
        maker.tip()
    };
    let tips: Vec<[f64; 3]> = rows.iter().map(tip_at).collect();
    let recording = recording(&rows, Some(&tips));
    let twin = Robot::new(&scenes::robot()).twin;
    let goals = Goals::new(&recording, Path::new("rec.csv"), 1e-6).unwrap();
    let command = Command::with_free_strokes(&twin, &recording, Path::new("rec.csv"), goals).unwrap();
    let mut rollout = CommandRollout::new(&twin, &command, None, (&twin.rest(), 0)).unwrap();
    for (i, goal) in tips.iter().enumerate() {
        let step = rollout.step(i).unwrap();
        assert!(step.rounds > 0 && distance(step.tip, *goal) <= 1e-6, "{step:?}");
    }
}

#[test]
fn a_stroke_beyond_the_largest_tension_ends_at_the_sample_before() {
    let rows = rows(10, 4e-3);
    let recording = recording(&rows, None);
    let mut robot = Robot::new(&scenes::robot());
    // The tension of the fifth row, which the sixth exceeds.
    rows[..5].iter().for_each(|row| {
        robot.go(&strokes(row));
    });
    let (mut scene, mesh) = scenes::robot();
    scene.tendons[0].tension.max = 1.01 * robot.state.tensions[0];
    let twin = hysteron_twin::Twin::new(&scene, &mesh).unwrap();
    let command = Command::new(&twin, &recording, Path::new("rec.csv")).unwrap();
    let mut rollout = CommandRollout::new(&twin, &command, None, (&twin.rest(), 0)).unwrap();
    let mut before = twin.rest();
    for i in 0..5 {
        rollout.step(i).unwrap();
        before.clone_from(rollout.state());
    }
    let error = rollout.step(5).unwrap_err();
    assert!(
        matches!(&error, Error::Overloaded { tendon, .. } if *tendon == scene.tendons[0].name),
        "{error}"
    );
    assert_eq!(rollout.state(), &before);
}
