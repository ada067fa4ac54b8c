//! The page on a robot of one's own: its files and its commands, as written there.

use hysteron_base::Recording;
use hysteron_tests::{root, run};

#[test]
fn the_robot_of_the_page_is_meshed_checked_and_moved() {
    let page = std::fs::read_to_string(root().join("docs/your-robot.md")).unwrap();
    let block = |begins: &str| page.split_once(begins).unwrap().1.split_once("```").unwrap().0;
    let place = tempfile::tempdir().unwrap();
    let robot = place.path().join("out/my-robot");
    std::fs::create_dir_all(&robot).unwrap();
    std::fs::write(robot.join("scene.toml"), block("```toml\n")).unwrap();
    std::fs::write(robot.join("strokes.csv"), block("```csv\n")).unwrap();
    // The recordings of the last step come from a robot.
    let commands = page.lines().filter_map(|line| line.strip_prefix("    hysteron "));
    let commands: Vec<&str> = commands.filter(|line| !line.contains("out/my-robot/recordings")).collect();
    assert_eq!(commands.len(), 3);
    for line in commands {
        run(place.path(), &line.split_whitespace().collect::<Vec<_>>()).succeeded();
    }
    let recording = Recording::read(robot.join("tip.parquet")).unwrap();
    let [x, y, z] = recording.tip().unwrap();
    // The third row pulls the tendon at x > 0 by 2 mm: the tip bends towards x, and down.
    assert!(x[2] > 10e-3 && y[2].abs() < 2e-3 && z[2] < 0.119, "{} {} {}", x[2], y[2], z[2]);
}
