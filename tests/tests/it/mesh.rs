//! The mesher, and what the checker says about it.

use hysteron_tests::{Workplace, root, run};

const TPU80: [&str; 15] = [
    "mesh",
    "--length-mm",
    "80",
    "--outer-diameter-mm",
    "12",
    "--bore-diameter-mm",
    "6",
    "--channels",
    "4",
    "--channel-diameter-mm",
    "1.5",
    "--channel-radius-mm",
    "4.5",
    "--layers",
    "17",
];

#[test]
fn measures_of_the_robot_give_its_mesh() {
    let place = Workplace::new();
    let outcome =
        place.run(&[&TPU80[..], &["--out", "new/tube.msh", "--vtu", "new/tube.vtu"]].concat()).succeeded();
    assert_eq!(place.read("new/tube.msh"), place.read("tpu80.msh"));
    assert!(place.path().join("new/tube.vtu").exists());
    for part in ["864 nodes, 3264 tetrahedra", "radius ratio", "smallest angle", "#####"] {
        assert!(outcome.stdout.contains(part), "{part} in {}", outcome.stdout);
    }
}

#[test]
fn a_new_mesh_can_be_checked_and_simulated() {
    let place = Workplace::new();
    std::fs::remove_file(place.path().join("tpu80.msh")).unwrap();
    place
        .run(&[
            "mesh",
            "--profile",
            "0:12,40:12,80:11.5",
            "--edge-mm",
            "4",
            "--quadratic",
            "--binary",
            "--out",
            "tpu80.msh",
        ])
        .succeeded();
    let outcome = place.run(&["check", "scene.toml"]).succeeded();
    assert!(outcome.stdout.contains("unknowns") && outcome.stdout.contains("p4"), "{}", outcome.stdout);
    place.write_circle("strokes.csv", 3);
    place.simulate("strokes.csv", "tip.csv").succeeded();
}

#[test]
fn a_mesh_by_this_program_is_replaced_where_that_is_asked_for_and_one_by_another_never() {
    let place = Workplace::new();
    let tube = |length: &str, more: &[&str]| {
        let mut arguments = TPU80.to_vec();
        arguments[2] = length;
        place.run(&[&arguments[..], &["--out", "tube.msh"], more].concat())
    };
    tube("80", &[]).succeeded();
    let first = place.read("tube.msh");
    assert!(tube("70", &[]).error(2).contains("add --overwrite"));
    assert_eq!(place.read("tube.msh"), first);
    tube("70", &["--overwrite"]).succeeded();
    assert_ne!(place.read("tube.msh"), first);
    // The same mesh as another program spaces it.
    let spaced = String::from_utf8(first).unwrap().replace("$EndNodes", " \n$EndNodes");
    std::fs::write(place.path().join("tube.msh"), &spaced).unwrap();
    tube("70", &["--overwrite"]).error(2);
    assert_eq!(place.read("tube.msh"), spaced.into_bytes());
}

#[test]
fn measures_without_a_body_are_refused() {
    let place = Workplace::new();
    let refused = |arguments: &[&str], part: &str| {
        let outcome = place.run(&[&["mesh", "--out", "bad.msh"], arguments].concat());
        assert!(outcome.error(2).contains(part), "{part:?} in {}", outcome.stderr);
        assert!(!place.path().join("bad.msh").exists());
    };
    let tube = ["--length-mm", "80", "--outer-diameter-mm", "12", "--layers", "8"];
    refused(&[&tube[..], &["--bore-diameter-mm", "12"]].concat(), "bore_radius");
    refused(&[&tube[..], &["--channels", "4"]].concat(), "--channel-diameter-mm");
    refused(
        &[&tube[..], &["--channels", "4", "--channel-diameter-mm", "4", "--channel-radius-mm", "5"]].concat(),
        "to the surface",
    );
    refused(&["--length-mm", "-80", "--outer-diameter-mm", "12", "--layers", "8"], "profile");
    refused(&["--length-mm", "80", "--outer-diameter-mm", "12", "--edge-mm", "0"], "--edge-mm");
    refused(&["--profile", "0:12,80", "--edge-mm", "4"], "Z:D");
}

#[test]
fn every_scene_of_the_repository_is_fit() {
    for scene in [
        "tpu80/scene.toml",
        "tpu80/scene-fine.toml",
        "tpu80/scene-quadratic.toml",
        "tpu80/scene-coreact.toml",
        "tpu80/scene-friction.toml",
        "tentacle/scene.toml",
        "tentacle/scene-quadratic.toml",
    ] {
        run(root(), &["check", &format!("meshes/{scene}")]).succeeded();
    }
}
