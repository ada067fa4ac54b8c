//! `hysteron fit-material`, from files to files.

use hysteron_base::{Recording, Scene, json};
use hysteron_tests::Workplace;

/// A place with a recording of a robot whose first tendon is pulled by 0.3 mm before it begins.
fn recorded() -> Workplace {
    let place = Workplace::new();
    place.write_circle("strokes.csv", 60);
    let nominal = place.read("scene.toml");
    place.replace("scene.toml", "drive = \"stroke\"", "drive = \"stroke\"\nzero_mm = 0.3");
    place.simulate("strokes.csv", "rec.csv").succeeded();
    place.write("scene.toml", nominal);
    place
}

const FIT: [&str; 4] = ["fit-material", "scene.toml", "rec.csv", "--out"];

#[test]
fn zeros_come_back_and_comments_stay() {
    let place = recorded();
    place.write("fit.toml", "format = \"hysteron-fit\"\nversion = 1\n[fit]\nzero_mm = [-1.0, 1.0]\n");
    let more = ["out/new.toml", "--every-mm", "0.5", "--fit-file", "fit.toml", "--figures", "out"];
    let done = place.run(&[&FIT[..], &more].concat()).succeeded();
    assert!(done.stdout.contains("zero of p1 [mm]"), "{}", done.stdout);

    let (old, new) = (place.read("scene.toml"), place.read("out/new.toml"));
    let comments = |text: &[u8]| String::from_utf8_lossy(text).lines().filter(|l| l.contains('#')).count();
    // One line more names what made it.
    assert_eq!(comments(&old) + 1, comments(&new));
    let scene = Scene::read(place.path().join("out/new.toml")).unwrap();
    assert!(scene.mesh_path.canonicalize().unwrap().ends_with("tpu80.msh"));
    for (tendon, expected) in scene.tendons.iter().zip([0.3e-3, 0.0, 0.0, 0.0]) {
        // No noise: what is left is the search's tolerance and the four decimals of the strokes.
        assert!((tendon.zero - expected).abs() < 0.01e-3, "{}: {}", tendon.name, tendon.zero);
    }

    let metrics: serde_json::Value = json::from_text(place.read("out/metrics.json")).unwrap();
    let error = |key: &str| metrics[key]["rmse_distance_m"].as_f64().unwrap();
    assert!(error("errors_after") < 0.01 * error("errors_before"), "{metrics}");
    let report = String::from_utf8(place.read("out/report.html")).unwrap();
    assert!(report.contains("<svg") && report.contains("Standard error"));
}

#[test]
fn recording_of_another_kind_is_one_clear_error() {
    let place = recorded();
    let refused = |more: &[&str]| place.run(&[&FIT[..], &["new.toml"], more].concat()).error(2).to_owned();
    assert!(refused(&["--fit", "stiffness"]).contains("youngs_modulus"));
    assert!(refused(&["--every-mm", "0"]).contains("--every-mm"));
    assert!(refused(&["--every-mm", "50"]).contains("rows"));
    assert!(refused(&["--role", "training"]).contains("--role"));
    place.write("fit.toml", "format = \"hysteron-fit\"\nversion = 1\n[fit]\nzero_mm = [1.0]\n");
    assert!(refused(&["--fit-file", "fit.toml"]).contains("fit.zero_mm"));

    // A tip that is off by 50 mm.
    let text = String::from_utf8(place.read("rec.csv")).unwrap();
    let recording = Recording::read(place.path().join("rec.csv")).unwrap();
    let [x, ..] = recording.tip().unwrap();
    let header = text.lines().find(|line| line.starts_with("time_s")).unwrap();
    let column = header.split(',').position(|name| name == "tip_x_mm").unwrap();
    let mut row = 0;
    let moved: Vec<String> = text
        .lines()
        .map(|line| {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            if cells[0].parse::<f64>().is_ok() {
                cells[column] = format!("{}", 1e3 * x[row] + 50.0);
                row += 1;
            }
            cells.join(",")
        })
        .collect();
    place.write("rec.csv", moved.join("\n") + "\n");
    assert!(refused(&["--fit", "zero"]).contains("tracker"));
    assert!(!place.path().join("new.toml").exists());
}

/// A mesh that cannot be read is found before a twin is built; the recordings are read even before.
#[test]
fn recordings_are_read_before_the_mesh() {
    let place = recorded();
    let mesh = Scene::read(place.path().join("scene.toml")).unwrap().mesh_path;
    let name = mesh.file_name().unwrap().to_str().unwrap().to_owned();
    let refused = |more: &[&str]| {
        place.run(&[&FIT[..], &["new.toml", "--fit", "zero"], more].concat()).error(2).to_owned()
    };
    std::fs::write(&mesh, "no mesh").unwrap();
    assert!(refused(&[]).contains(&name));
    assert!(refused(&["--role", "training"]).contains("--role"));
    place.write("rec.csv", "time_s,stroke_1_mm\n0,0\n0,1\n");
    assert!(refused(&[]).contains("rec.csv"));
}

#[test]
fn a_folder_stands_for_the_recordings_in_it() {
    let place = recorded();
    std::fs::create_dir(place.path().join("data")).unwrap();
    std::fs::rename(place.path().join("rec.csv"), place.path().join("data/rec.csv")).unwrap();
    place.write("data/notes.txt", "no recording");
    // Few steps: what counts is that both are the same.
    let fit = |recordings: &str, out: &str| {
        place.run(&[
            "fit-material",
            "scene.toml",
            recordings,
            "--fit",
            "zero",
            "--every-mm",
            "0.5",
            "--out",
            out,
        ])
    };
    fit("data", "by-folder.toml").succeeded();
    fit("data/rec.csv", "by-file.toml").succeeded();
    let tendons = |scene: &str| Scene::read(place.path().join(scene)).unwrap().tendons;
    assert_eq!(tendons("by-folder.toml"), tendons("by-file.toml"));
    std::fs::create_dir(place.path().join("empty")).unwrap();
    let refused = fit("empty", "new.toml");
    assert!(refused.error(2).contains("a folder with recordings"), "{}", refused.error(2));
    assert!(!place.path().join("new.toml").exists());
}
