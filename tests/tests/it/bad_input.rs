//! Everything that can be wrong with the input: one clear error, exit code 2, nothing under the final name.

use hysteron_tests::{Workplace, names_in};

/// Simulates after `spoil`, expects an error with these parts and no new file.
fn refused(spoil: impl FnOnce(&Workplace), parts: &[&str]) {
    let place = Workplace::new();
    place.write_circle("strokes.csv", 5);
    spoil(&place);
    let before = names_in(place.path());
    let outcome = place.run(&[
        "simulate",
        "scene.toml",
        "--strokes",
        "strokes.csv",
        "--out",
        "out/tip.csv",
        "--figures",
        "figures",
        "--vtu",
        "vtu",
    ]);
    let error = outcome.error(2);
    for part in parts {
        assert!(error.contains(part), "{part:?} in {error:?}");
    }
    assert_eq!(outcome.stdout, "");
    assert_eq!(names_in(place.path()), before);
}

const HEADER: &str = "time_s,stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm\n";

/// Text of a mesh of two tetrahedra with the group `base`; `top` and `second` are points, in mm.
fn small_mesh(top: &str, second: &str) -> String {
    format!(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n\
         $PhysicalNames\n1\n3 1 \"base\"\n$EndPhysicalNames\n\
         $Entities\n0 0 0 1\n1 0 0 0 1 1 1 1 1 0\n$EndEntities\n\
         $Nodes\n1 5 1 5\n3 1 0 5\n1\n2\n3\n4\n5\n0 0 0\n1 0 0\n0 1 0\n{top}\n{second}\n$EndNodes\n\
         $Elements\n1 2 1 2\n3 1 4 2\n1 1 2 3 4\n2 2 3 4 5\n$EndElements\n"
    )
}

#[test]
fn mesh_files_that_cannot_be_used() {
    refused(
        |place| std::fs::remove_file(place.path().join("tpu80.msh")).unwrap(),
        &["tpu80.msh", "nothing there"],
    );
    refused(
        |place| {
            std::fs::remove_file(place.path().join("tpu80.msh")).unwrap();
            std::fs::create_dir(place.path().join("tpu80.msh")).unwrap();
        },
        &["tpu80.msh: expected a file, got a folder"],
    );
    refused(
        |place| {
            let bytes = place.read("tpu80.msh");
            place.write("tpu80.msh", &bytes[..bytes.len() / 2]);
        },
        &["tpu80.msh"],
    );
    refused(
        |place| {
            // Element type 2 is a triangle, 3 a quadrangle of the surface, 5 a hexahedron.
            let hexahedron = small_mesh("0 0 1", "1 1 1")
                .replace("3 1 4 2\n1 1 2 3 4\n2 2 3 4 5\n", "3 1 5 1\n1 1 2 3 4 5 1 2 3\n");
            place.write("tpu80.msh", hexahedron.replace("1 2 1 2\n", "1 1 1 1\n"));
        },
        &["tpu80.msh", "tetrahedra"],
    );
    refused(|place| place.write("tpu80.msh", "solid cube\n"), &["tpu80.msh"]);
}

#[test]
fn elements_that_cannot_be_used_are_named() {
    // A good second tetrahedron lies on the far side of the face 2 3 4.
    refused(
        |place| place.write("tpu80.msh", small_mesh("0 0 1", "0.1 0.1 0.1")),
        &["tetrahedron 1", "inside out"],
    );
    refused(
        |place| place.write("tpu80.msh", small_mesh("0 0 1", "0.25 0.25 0.5")),
        &["tetrahedron 1", "one plane"],
    );
}

#[test]
fn scenes_that_cannot_be_used() {
    let scene =
        |from: &'static str, to: &'static str| move |place: &Workplace| place.replace("scene.toml", from, to);
    refused(scene("group = \"base\"", "group = \"foot\""), &["clamp.group", "foot", "base"]);
    refused(
        scene("group = \"base\"", "box_min_mm = [0.0, 0.0, -9.0]\nbox_max_mm = [1.0, 1.0, -8.0]"),
        &["clamp", "nodes"],
    );
    refused(scene("[clamp]\ngroup = \"base\"\n", ""), &["clamp"]);
    refused(
        scene("[4.5, 0.0, 16.0]", "[9.5, 0.0, 16.0]"),
        &["tendon.p1.points_mm[2]", "outside", "(9.500, 0.000, 16.000) mm"],
    );
    refused(
        scene("poisson_ratio = 0.45", "poisson_ratio = 0.5"),
        &["material.poisson_ratio", "nu < 0.5", "got 0.5"],
    );
    refused(scene("poisson_ratio = 0.45", "poisson_ratio = 0.7"), &["material.poisson_ratio"]);
    refused(scene("[gravity]", "colour = 3\n[gravity]"), &["scene.toml", "colour"]);
    refused(scene("version = 1", "version = 2"), &["version", "got 2"]);
    refused(
        |place| std::fs::remove_file(place.path().join("scene.toml")).unwrap(),
        &["scene.toml", "nothing there"],
    );
}

#[test]
fn strokes_that_cannot_be_used() {
    let strokes =
        |rows: &'static str| move |place: &Workplace| place.write("strokes.csv", format!("{HEADER}{rows}"));
    refused(strokes("0,0,0,0,0\n0.01,0,NaN,0,0\n"), &["strokes.csv: line 3: stroke_2_mm", "finite"]);
    refused(strokes("0,0,0,0,0\n0.02,0,0,0,0\n0.01,0,0,0,0\n"), &["line 4: time_s", "after 0.02 s"]);
    refused(strokes("0,0,0,0,0\n0,0,0,0,0\n"), &["line 3: time_s"]);
    refused(strokes("0,0,0,0\n"), &["strokes.csv: line 2", "5 cells"]);
    refused(strokes("0,0,x,0,0\n"), &["line 2: stroke_2_mm", "a number"]);
    refused(strokes(""), &["strokes.csv", "at least one row"]);
    // The tendons are 80 mm long.
    refused(
        strokes("0,0,0,0,0\n0.01,0,0,80.5,0\n"),
        &["row 2 (t = 0.01 s)", "tendon p3", "80.500 mm", "80.000 mm"],
    );
    let header = |text: &'static str| move |place: &Workplace| place.write("strokes.csv", text);
    refused(
        header("time_s,stroke_1_mm,stroke_2_mm\n0,0,0\n"),
        &["stroke columns", "expected 4 (p1, p2, p3, p4), got 2"],
    );
    refused(header("time_s,pull_1\n0,0\n"), &["strokes.csv", "pull_1"]);
    refused(header("time_s,stroke_1_mm,stroke_3_mm\n0,0,0\n"), &["number 2 next"]);
    refused(header("stroke_1_mm\n0\n"), &["time_s"]);
    refused(
        |place| std::fs::remove_file(place.path().join("strokes.csv")).unwrap(),
        &["strokes.csv", "nothing there"],
    );
}

#[test]
fn tendons_driven_by_tension_follow_tensions_within_their_bounds() {
    let by_tension = |place: &Workplace| {
        let text = String::from_utf8(place.read("scene.toml")).unwrap();
        place.write("scene.toml", text.replace("drive = \"stroke\"", "drive = \"tension\""));
    };
    refused(by_tension, &["tension_1_n", "drive = \"stroke\""]);
    refused(
        |place| {
            by_tension(place);
            place
                .write("strokes.csv", "time_s,tension_1_n,tension_2_n,tension_3_n,tension_4_n\n0,0,0,-1,0\n");
        },
        &["row 1", "tension_3_n", "0 to 200 N", "-1 N"],
    );
}

#[test]
fn names_that_cannot_be_written() {
    let place = Workplace::new();
    place.write_circle("strokes.csv", 5);
    assert!(place.simulate("strokes.csv", "tip.xlsx").error(2).contains("--out"));
    std::fs::create_dir(place.path().join("folder.csv")).unwrap();
    assert!(place.simulate("strokes.csv", "folder.csv").error(2).contains("folder"));
    let outcome = place.run(&["simulate", "scene.toml", "--strokes", "strokes.csv"]);
    assert_eq!(outcome.code, Some(2), "clap refuses a missing option");
    assert_eq!(place.run(&["dance"]).code, Some(2));
}

#[test]
#[cfg(unix)]
fn devices_and_pipes_are_no_files() {
    let place = Workplace::new();
    place.write_circle("strokes.csv", 5);
    // Reading a pipe waits for its other end, and /dev/zero has none.
    for ending in ["toml", "msh", "csv", "parquet", "svg", "safetensors", "state"] {
        let pipe = place.path().join(format!("pipe.{ending}"));
        assert!(std::process::Command::new("mkfifo").arg(pipe).status().unwrap().success());
        let zero = place.path().join(format!("zero.{ending}"));
        std::os::unix::fs::symlink("/dev/zero", zero).unwrap();
    }
    for file in ["pipe", "zero"] {
        place.write("meshed.toml", place.read("scene.toml"));
        place.replace("meshed.toml", "tpu80.msh", &format!("{file}.msh"));
        for arguments in [
            &["check", "FILE.toml"][..],
            &["check", "meshed.toml"],
            &["simulate", "scene.toml", "--strokes", "FILE.csv", "--out", "tip.csv"],
            &["simulate", "scene.toml", "--strokes", "FILE.parquet", "--out", "tip.csv"],
            &[
                "simulate",
                "scene.toml",
                "--strokes",
                "strokes.csv",
                "--from",
                "FILE.state",
                "--out",
                "tip.csv",
            ],
            &[
                "simulate",
                "scene-coreact.toml",
                "--strokes",
                "strokes.csv",
                "--residual",
                "FILE.safetensors",
                "--out",
                "a.csv",
            ],
            &["simulate", "scene.toml", "--strokes", "strokes.csv", "--out", "FILE.csv"],
            &[
                "simulate",
                "scene.toml",
                "--strokes",
                "strokes.csv",
                "--save-state",
                "FILE.state",
                "--out",
                "a.csv",
            ],
            &["generate", "scene.toml", "--plan", "FILE.toml", "--out", "data"],
            &["target", "FILE.toml", "--out", "a.csv"],
            &["target", "FILE.svg", "--out", "a.csv"],
            &["target", "FILE.csv", "--out", "a.csv"],
            &["evaluate", "--target", "circle:20", "FILE.parquet"],
            &["command", "FILE.safetensors", "--target", "circle:20", "--out", "a.csv"],
            &["identify", "scene-coreact.toml", "FILE.csv", "--out", "data"],
            &["train", "FILE.parquet", "--out", "a.safetensors"],
            &["fit-residual", "FILE.parquet", "--out", "a.safetensors"],
            &["fit-material", "scene.toml", "strokes.csv", "--fit-file", "FILE.toml", "--out", "a.toml"],
            &["record", "--rig", "FILE.toml", "--plan", "quick", "--out", "data"],
            &["run", "FILE.toml"],
        ] {
            let arguments: Vec<String> = arguments.iter().map(|word| word.replace("FILE", file)).collect();
            let outcome = place.run(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
            assert!(
                outcome.error(2).contains("device or pipe")
                    || outcome.error(2).contains("a device or a pipe"),
                "{arguments:?}: {}",
                outcome.stderr
            );
        }
    }
}

#[test]
fn names_cannot_forge_lines_or_move_the_cursor() {
    let place = Workplace::new();
    place.write_circle("strokes.csv", 5);
    let name = "no\nerror: all is well\u{1b}[2J\r.csv";
    for arguments in [
        &["simulate", "scene.toml", "--strokes", name, "--out", "tip.csv"][..],
        &["check", name],
        &["dance", name],
        &["simulate", name],
        &["evaluate", "--target", "circle:20", name],
        &["command", "--scene", "scene.toml", "--target", name, "--out", "tip.csv"],
    ] {
        let outcome = place.run(arguments);
        assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
        assert!(!outcome.stderr.contains(['\u{1b}', '\r']), "{:?}", outcome.stderr);
        assert_eq!(
            outcome.stderr.lines().filter(|line| line.starts_with("error: ")).count(),
            1,
            "{}",
            outcome.stderr
        );
    }
    // On the way of what goes well, too.
    #[cfg(unix)]
    {
        let outcome = place.simulate("strokes.csv", name).succeeded();
        assert_eq!(outcome.stdout, "no\\nerror: all is well\\u{1b}[2J\\r.csv\n");
        assert!(
            !outcome.stderr.contains(['\u{1b}', '\r']) && !outcome.stderr.contains("\nerror: "),
            "{:?}",
            outcome.stderr
        );
    }
}

#[test]
#[cfg(unix)]
fn words_that_are_no_unicode_are_shown_and_not_fatal() {
    use std::os::unix::ffi::OsStrExt;
    let place = Workplace::new();
    let name = std::ffi::OsStr::from_bytes(b"stro\xffkes.csv");
    std::fs::write(
        place.path().join(name),
        "time_s,stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm\n0,0,0,0,0\n",
    )
    .unwrap();
    let mut command = std::process::Command::new(hysteron_tests::program());
    command
        .args(["simulate", "scene.toml", "--out", "tip.csv", "--strokes"])
        .arg(name)
        .current_dir(place.path());
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
