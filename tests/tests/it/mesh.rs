//! The mesher, and the checker's report on its meshes.

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

/// A rod of 60 mm with the tendons of a student's first scene: a material that hardly changes its volume.
fn rod(place: &Workplace) {
    std::fs::copy(root().join("fem/tests/data/rod-41.msh"), place.path().join("rod.msh")).unwrap();
    let points =
        |x: f64| (0..=10).map(|k| format!("[{x:.1}, 0.0, {}.0]", 6 * k)).collect::<Vec<_>>().join(", ");
    let tendon = |name: &str, x: f64| {
        format!(
            "[[tendon]]\nname = \"{name}\"\npoints_mm = [{}]\ndrive = \"stroke\"\ntension_min_n = 0.0\n\
             tension_max_n = 50.0\nstroke_min_mm = -20.0\nstroke_max_mm = 20.0\nattach_within_mm = 1.0\n",
            points(x),
        )
    };
    place.write(
        "rod.toml",
        format!(
            "format = \"hysteron-scene\"\nversion = 1\nname = \"rod\"\nseed = 1\n[mesh]\nfile = \"rod.msh\"\nunit = \"mm\"\n\
             [clamp]\ngroup = \"base\"\n[material]\nlaw = \"corotational\"\nyoungs_modulus_mpa = 1.0\n\
             poisson_ratio = 0.499\ndensity_kg_m3 = 1000.0\n[gravity]\nacceleration_m_s2 = [0, 0, 0]\n[tip]\n\
             group = \"tip\"\n{}{}",
            tendon("t1", 3.0),
            tendon("t2", -3.0),
        ),
    );
    let rows: String = (0..6).map(|k| format!("0.{k},{:.1},-20\n", 0.5 * f64::from(k))).collect();
    place.write("pull.csv", format!("time_s,stroke_1_mm,stroke_2_mm\n{rows}"));
}

#[test]
fn locking_of_linear_tetrahedra_is_reported_before_and_after_a_run() {
    let place = Workplace::new();
    rod(&place);
    let check = place.run(&["check", "rod.toml", "--json"]).succeeded();
    for part in ["linear tetrahedra make this body", "times as stiff as ten-node tetrahedra: pulling t"] {
        assert!(check.stderr.contains(part), "{}", check.stderr);
    }
    let value: serde_json::Value = serde_json::from_str(&check.stdout).unwrap();
    let loss = value["locking"]["estimated"][0]["loss"].as_f64().unwrap();
    assert!((0.5..0.75).contains(&loss), "{loss}");
    let simulate =
        place.run(&["simulate", "rod.toml", "--strokes", "pull.csv", "--out", "o.csv", "--json"]).succeeded();
    let before = simulate.stderr.find("this recording moves the tip").unwrap_or(usize::MAX);
    let after = simulate.stderr.find("with ten-node tetrahedra it would have gone about").unwrap_or(0);
    assert!(before < after, "{}", simulate.stderr);
    let value: serde_json::Value = serde_json::from_str(&simulate.stdout).unwrap();
    let [tip, ten_node] =
        ["tip_m", "tip_ten_node_m"].map(|key| value["run"]["locking"][key].as_f64().unwrap());
    // The tip goes 3.5 mm across and 2.1 mm down with this mesh; 10.8 mm with ten-node tetrahedra: `twin/tests/twin/locking.rs`.
    assert!((3.9e-3..4.3e-3).contains(&tip) && (10.3e-3..11.3e-3).contains(&ten_node), "{tip} {ten_node}");
}

#[test]
fn older_and_partitioned_meshes_are_the_same_mesh() {
    let place = Workplace::new();
    rod(&place);
    let volume = |file: &str| {
        std::fs::copy(root().join("fem/tests/data").join(file), place.path().join("rod.msh")).unwrap();
        let check = place.run(&["check", "rod.toml", "--json"]).succeeded();
        let value: serde_json::Value = serde_json::from_str(&check.stdout).unwrap();
        (value["mesh"]["nodes"].clone(), value["mesh"]["groups"].clone(), value["unknowns"].clone())
    };
    let expected = volume("rod-41.msh");
    for file in
        ["rod-22.msh", "rod-40.msh", "rod-41-bom.msh", "rod-41-comments.msh", "rod-41-partitioned.msh"]
    {
        assert_eq!(volume(file), expected, "{file}");
    }
}
