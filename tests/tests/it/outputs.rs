//! Overwriting: a command writes over nothing that it reads, nothing that was measured, nothing that another
//! has made.

use std::collections::BTreeMap;
use std::path::Path;

use hysteron_base::Lock;
use hysteron_tests::{Workplace, names_in};

const STROKES: &str =
    "time_s,stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm\n0,0,0,0,0\n0.01,0.2,0,-0.2,0\n";
const RECORD: [&str; 9] =
    ["record", "--rig", "virtual:typical", "--plan", "quick", "--only", "circle", "--out", "data"];

/// All files of a folder and of those in it, by path.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for name in names_in(folder) {
        let path = folder.join(&name);
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            found.insert(name, std::fs::read(path).unwrap());
        }
    }
    found
}

/// Refused as bad input, with these words, and every file is as it was.
#[track_caller]
fn refused(place: &Workplace, arguments: &[&str], parts: &[&str]) {
    let before = files(place.path());
    let outcome = place.run(arguments);
    let error = outcome.error(2);
    for part in parts {
        assert!(error.contains(part), "{part:?} in {error:?}");
    }
    let after = files(place.path());
    assert_eq!(before.keys().collect::<Vec<_>>(), after.keys().collect::<Vec<_>>(), "{arguments:?}");
    assert!(before == after, "{arguments:?} changed a file");
}

#[test]
fn no_verb_writes_over_its_inputs() {
    let place = Workplace::new();
    place.write("strokes.csv", STROKES);
    std::fs::hard_link(place.path().join("strokes.csv"), place.path().join("hard.csv")).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink("strokes.csv", place.path().join("soft.csv")).unwrap();
    let simulate = ["simulate", "scene.toml", "--strokes", "strokes.csv", "--out"];
    let with = |more: &[&'static str]| [&simulate[..], more].concat();
    let names: &[&'static str] =
        if cfg!(unix) { &["./strokes.csv", "hard.csv", "soft.csv"] } else { &["./strokes.csv", "hard.csv"] };
    for name in names {
        refused(&place, &with(&[name]), &["--out: expected another file than the input strokes.csv"]);
    }
    for input in ["scene.toml", "tpu80.msh", "strokes.csv"] {
        refused(
            &place,
            &with(&["tip.csv", "--save-state", input]),
            &["--save-state: expected another file than"],
        );
    }
    refused(&place, &with(&["tip.csv", "--save-state", "tip.csv"]), &["--save-state", "than --out names"]);
    place.run(&with(&["tip.csv", "--save-state", "end.state"])).succeeded();
    std::fs::copy(place.path().join("end.state"), place.path().join("on.state")).unwrap();
    refused(&place, &with(&["on.csv", "--from", "on.state"]), &["--out", "than the input on.state"]);
    refused(
        &place,
        &["reach", "scene.toml", "--goals", "tip.csv", "--out", "tip.csv"],
        &["the input tip.csv"],
    );

    std::fs::create_dir(place.path().join("drawing")).unwrap();
    place.write(
        "drawing/target.svg",
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"20mm\" height=\"20mm\" viewBox=\"0 0 20 20\">\
         <circle cx=\"0\" cy=\"0\" r=\"10\"/></svg>",
    );
    let target = ["target", "drawing/target.svg", "--out", "target.csv", "--figures", "drawing"];
    refused(
        &place,
        &target,
        &["--figures: expected another folder than that of the input drawing/target.svg"],
    );
    place.run(&target[..4]).succeeded();
    let command = ["command", "--scene", "scene.toml", "--target", "target.csv", "--out", "target.csv"];
    refused(&place, &command, &["--out: expected another file than the input target.csv"]);
    let fit = ["fit-material", "scene.toml", "tip.csv", "--out", "scene.toml"];
    refused(&place, &fit, &["--out: expected another file than the input scene.toml"]);
    let mesh =
        ["mesh", "--length-mm", "80", "--outer-diameter-mm", "12", "--layers", "8", "--out", "tpu80.msh"];
    refused(&place, &mesh, &["--out: expected a new file", "tpu80.msh, which these measures do not give"]);
}

#[test]
fn what_was_measured_is_never_replaced() {
    let place = Workplace::new();
    place.run(&RECORD).succeeded();
    let strokes = "data/circle.parquet";
    let simulate = ["simulate", "scene.toml", "--strokes", strokes, "--out", "tip.csv"];
    for more in [&[][..], &["--overwrite"]] {
        let run = |arguments: &[&str], parts: &[&str]| refused(&place, &[arguments, more].concat(), parts);
        run(&["identify", "scene-coreact.toml", "data", "--out", "data"], &["the input data/circle.parquet"]);
        run(
            &["generate", "scene.toml", "--plan", "quick", "--out", "data"],
            &["--out", "data/", "choose another --out"],
        );
        place.write("strokes.csv", STROKES);
        run(
            &["simulate", "scene.toml", "--strokes", "strokes.csv", "--out", strokes],
            &["data/circle.parquet, which was measured", "never overwritten: choose another --out"],
        );
        run(
            &["command", "--scene", "scene.toml", "--target", "circle:20", "--out", strokes],
            &["data/circle.parquet, which was measured"],
        );
        run(
            &[&simulate[..], &["--save-state", strokes]].concat(),
            &["--save-state: expected another file than"],
        );
    }
}

#[test]
fn results_are_replaced_by_the_same_command_and_by_others_only_where_that_is_asked() {
    let place = Workplace::new();
    place.write("strokes.csv", STROKES);
    place.write("others.csv", STROKES.replace("0.2", "0.3"));
    let simulate = |strokes: &'static str, more: &[&'static str]| {
        [&["simulate", "scene.toml", "--strokes", strokes, "--out", "tip.csv"][..], more].concat()
    };
    place.write("tip.csv", "time_s,mine_mm\n0,0\n");
    refused(&place, &simulate("strokes.csv", &[]), &["tip.csv, which hysteron has not made", "move it away"]);
    refused(&place, &simulate("strokes.csv", &["--overwrite"]), &["tip.csv, which hysteron has not made"]);
    std::fs::remove_file(place.path().join("tip.csv")).unwrap();
    place.run(&simulate("strokes.csv", &[])).succeeded();
    // Where something goes is not what it is.
    place.run(&simulate("strokes.csv", &["--figures", "figures", "--png", "--vtu", "vtu"])).succeeded();
    place.run(&simulate("strokes.csv", &["--figures", "figures", "--png", "--vtu", "vtu"])).succeeded();
    let parts = ["made by `hysteron simulate scene.toml --strokes strokes.csv", "or add --overwrite"];
    refused(&place, &simulate("others.csv", &[]), &parts);
    refused(&place, &simulate("others.csv", &["--figures", "figures"]), &parts);
    place.run(&simulate("others.csv", &["--figures", "figures", "--overwrite"])).succeeded();

    place.write("figures/report.html", "<html>mine</html>");
    let error = ["figures/report.html, which hysteron has not made"];
    refused(&place, &simulate("others.csv", &["--figures", "figures"]), &error);
    refused(
        &place,
        &simulate("others.csv", &["--figures", "strokes.csv"]),
        &["--figures: expected a folder"],
    );
    refused(&place, &simulate("others.csv", &["--vtu", "strokes.csv"]), &["--vtu: expected a folder"]);
    refused(&place, &simulate("others.csv", &["--save-state", "figures"]), &["the folder figures"]);
    std::fs::create_dir(place.path().join("mine")).unwrap();
    place.write("mine/target.svg", "<svg>mine</svg>");
    let target = ["target", "circle:20", "--out", "target.csv", "--figures", "mine"];
    assert!(place.run(&target).error(2).contains("mine/target.svg"));
    assert_eq!(place.read("mine/target.svg"), b"<svg>mine</svg>");
}

#[test]
fn a_folder_that_another_command_writes_is_refused() {
    let place = Workplace::new();
    place.write("strokes.csv", STROKES);
    // This process has them.
    let locks = [
        Lock::folder(&place.path().join("data")).unwrap(),
        Lock::file(&place.path().join("tip.csv")).unwrap(),
    ];
    let outcome = place.run(&["generate", "scene.toml", "--plan", "quick", "--out", "data"]);
    assert!(outcome.error(2).contains(&format!("process {}", std::process::id())), "{}", outcome.stderr);
    assert!(place.simulate("strokes.csv", "tip.csv").error(2).contains("process"));
    drop(locks);
    place.simulate("strokes.csv", "tip.csv").succeeded();
}

#[test]
fn what_a_killed_command_was_writing_is_cleared_by_the_next() {
    let place = Workplace::new();
    place.write("strokes.csv", STROKES);
    std::fs::create_dir(place.path().join("out")).unwrap();
    place.write("out/.hysteron-a1b2c3.tmp", "half");
    place.write("out/.tip.csv.lock", "1");
    place.simulate("strokes.csv", "out/tip.csv").succeeded();
    assert_eq!(names_in(&place.path().join("out")), ["tip.csv"]);
    place.write("out/.hysteron-a1b2c3.tmp", "half");
    let record = ["record", "--rig", "virtual:typical", "--plan", "quick", "--only", "circle", "--out"];
    place.run(&[&record[..], &["out/circle.parquet"]].concat()).succeeded();
    assert_eq!(names_in(&place.path().join("out")), ["circle.events.jsonl", "circle.parquet", "tip.csv"]);
}

#[test]
fn an_edited_mesh_is_another_scene() {
    let place = Workplace::new();
    place.write("strokes.csv", STROKES);
    let simulate = ["simulate", "scene.toml", "--strokes", "strokes.csv", "--out"];
    place.run(&[&simulate[..], &["a.csv", "--save-state", "a.state"]].concat()).succeeded();
    place.run(&[&simulate[..], &["b.csv", "--from", "a.state"]].concat()).succeeded();
    // A comment of the scene changes nothing, a node of its mesh does.
    place.replace("scene.toml", "[gravity]", "# downwards\n[gravity]");
    place.run(&[&simulate[..], &["b.csv", "--from", "a.state"]].concat()).succeeded();
    let mesh = String::from_utf8(place.read("tpu80.msh")).unwrap();
    place.write("tpu80.msh", format!("{mesh}\n"));
    let from = [&simulate[..], &["b.csv", "--from", "a.state"]].concat();
    refused(&place, &from, &["a.state: scene_hash", "scene and mesh"]);
}

#[test]
fn recordings_are_added_to_a_folder_of_identifications() {
    let place = Workplace::new();
    for (k, name) in ["a.csv", "b.csv"].into_iter().enumerate() {
        place.write_circle("strokes.csv", 120 + 20 * k);
        place
            .run(&["simulate", "scene.toml", "--strokes", "strokes.csv", "--out", name, "--overwrite"])
            .succeeded();
    }
    let identify = |more: &[&str]| {
        place.run(&[&["identify", "scene-coreact.toml"], more, &["--rounds", "1", "--out", "found"]].concat())
    };
    identify(&["a.csv"]).succeeded();
    let first = place.read("found/a.parquet");
    let both = identify(&["a.csv", "b.csv"]).succeeded();
    assert!(both.stdout.contains("a: tip off") && both.stdout.contains("b: tip off"), "{}", both.stdout);
    assert!(first == place.read("found/a.parquet"), "what was there is kept");
    identify(&["b.csv"]).succeeded();
    // With other options the results are others.
    let other = place.run(&["identify", "scene-coreact.toml", "a.csv", "--rounds", "2", "--out", "found"]);
    assert!(other.error(2).contains("found/a.parquet, made by"), "{}", other.error(2));
}
