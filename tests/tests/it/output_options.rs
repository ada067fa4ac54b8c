//! Every option of every verb that names an output: what cannot be written there, and what must not be replaced there, is
//! refused before the work, with the exit code of bad input, and every file stays as it was.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use hysteron_tests::{Workplace, names_in, root};

/// Kind of output that an option names.
#[derive(Clone, Copy, PartialEq)]
enum Names {
    /// A file with one of these endings.
    File(&'static [&'static str]),
    /// A folder.
    Folder,
}

use Names::{File, Folder};

const RECORDING: Names = File(&["csv", "parquet"]);
const CHECKPOINT: Names = File(&["safetensors"]);

const MESH: Names = File(&["msh"]);
const URDF: Names = File(&["urdf"]);

/// Verbs with what they read, and of their options the one that is tried; the others name outputs that are right.
const OPTIONS: [(&str, &str, Names); 45] = [
    ("simulate scene.toml --strokes strokes.csv", "--out", RECORDING),
    ("simulate scene.toml --strokes strokes.csv --out new.csv", "--figures", Folder),
    ("simulate scene.toml --strokes strokes.csv --out new.csv", "--vtu", Folder),
    ("simulate scene.toml --strokes strokes.csv --out new.csv", "--save-state", File(&[])),
    ("reach scene.toml --goals rec.csv", "--out", RECORDING),
    ("reach scene.toml --goals rec.csv --out new.csv", "--figures", Folder),
    ("reach scene.toml --goals rec.csv --out new.csv", "--vtu", Folder),
    ("reach scene.toml --goals rec.csv --out new.csv", "--save-state", File(&[])),
    ("mesh --length-mm 80 --outer-diameter-mm 12 --layers 8", "--out", MESH),
    ("mesh --length-mm 80 --outer-diameter-mm 12 --layers 8 --out new.msh", "--vtu", File(&[])),
    ("reduce scene.toml --count 1", "--out", File(&[])),
    ("record --rig virtual:typical --plan quick --only circle", "--out", Folder),
    ("record --rig virtual:typical --strokes strokes.csv --out new.csv", "--figures", Folder),
    ("fit-material scene.toml rec.csv", "--out", File(&[])),
    ("fit-material scene.toml rec.csv --out new.toml", "--figures", Folder),
    ("identify scene-coreact.toml rec.csv", "--out", Folder),
    ("fit-residual identified --epochs 1", "--out", CHECKPOINT),
    ("fit-residual identified --epochs 1 --out new.safetensors", "--figures", Folder),
    ("adapt r.safetensors rec.csv --scene scene-coreact.toml", "--out", CHECKPOINT),
    ("adapt r.safetensors rec.csv --scene scene-coreact.toml --out new.safetensors", "--figures", Folder),
    ("generate scene.toml --plan quick", "--out", Folder),
    ("target circle:20", "--out", RECORDING),
    ("target circle:20 --out new.csv", "--figures", Folder),
    ("evaluate --target circle:20 rec.csv", "--out", Folder),
    ("train rec.csv", "--out", CHECKPOINT),
    ("train rec.csv --out new.safetensors", "--figures", Folder),
    ("command --scene scene.toml --target circle:20", "--out", RECORDING),
    ("command --scene scene.toml --target circle:20 --out new.csv", "--figures", Folder),
    ("track --rig virtual:typical --scene scene.toml --nominal --target circle:20", "--out", Folder),
    ("fit-sensor scene.toml rec.csv", "--out", File(&[])),
    ("study run study.toml", "--out", Folder),
    ("demo", "--out", Folder),
    ("import rec.csv", "--out", RECORDING),
    ("import rec.csv --out new.csv", "--figures", Folder),
    ("man", "--out", Folder),
    ("rig calibrate --rig virtual:typical", "--out", File(&[])),
    ("arm dynamics three-link --states motion.csv", "--out", RECORDING),
    ("arm simulate three-link --torques torques.csv", "--out", RECORDING),
    ("arm simulate three-link --torques torques.csv --out new.csv", "--figures", Folder),
    ("arm excite panda --generations 1", "--out", RECORDING),
    ("arm excite panda --generations 1 --out new.csv", "--figures", Folder),
    ("arm export panda", "--out", URDF),
    ("arm fit delan motion.csv --epochs 1", "--out", CHECKPOINT),
    ("study wrist --seeds 1", "--out", Folder),
    ("study sofa", "--out", Folder),
];

/// Options that name outputs, by the end of their names in a manual page.
const OUTPUTS: [&str; 6] = ["--out", "--figures", "--vtu", "--save-state", "--dir", "--drive-out"];
/// Verbs whose outputs other tests try: they need hardware, an emulator, or a network that takes long to train.
const ELSEWHERE: [&str; 15] = [
    "sense",
    "shards-merge",
    "identify-servo",
    "rig-emulate",
    "rig-recover",
    "arm-adapt",
    "arm-emulate",
    "arm-estimate",
    "arm-evaluate",
    "arm-fit-neural",
    "arm-generate",
    "arm-identify-friction",
    "arm-identify-inertia",
    "arm-identify-payload",
    "arm-identify-servo",
];

/// Name of a verb and text of its page, without the marks of the page's language.
fn pages() -> Vec<(String, String)> {
    let place = tempfile::tempdir().unwrap();
    hysteron_tests::run(place.path(), &["man", "--out", "."]).succeeded();
    let page = |name: &String| {
        let text = std::fs::read_to_string(place.path().join(name)).unwrap();
        let text = text.replace("\\fB", "").replace("\\fR", "").replace("\\fI", "").replace("\\-", "-");
        Some((name.strip_prefix("hysteron-")?.strip_suffix(".1")?.to_owned(), text))
    };
    names_in(place.path()).iter().filter_map(page).collect()
}

#[test]
fn every_output_option_is_tried() {
    for (verb, page) in pages().iter().filter(|(verb, _)| !ELSEWHERE.contains(&verb.as_str())) {
        for option in OUTPUTS.iter().filter(|option| page.lines().any(|line| line.starts_with(*option))) {
            let words = verb.replace('-', " ");
            let is_it = |(line, tried, _): &(&str, &str, Names)| {
                let line = line.replace('-', " ");
                (line == words || line.starts_with(&format!("{words} "))) && tried == option
            };
            // A recording by the arms, which needs them; studies have one runner for arms and one for tendon robots.
            let is_elsewhere = verb == "arm-record" || verb.starts_with("study-");
            assert!(OPTIONS.iter().any(is_it) || is_elsewhere, "{verb} {option} is not tried");
        }
    }
}

#[test]
fn every_verb_lists_its_exit_codes_and_they_are_those_of_the_table() {
    let readme = std::fs::read_to_string(root().join("app/cli/README.md")).unwrap();
    let code = |line: &str| line.strip_prefix("| ")?.split(' ').next()?.parse::<u32>().ok();
    let table: BTreeSet<u32> = readme.lines().filter_map(code).collect();
    assert_eq!(table, BTreeSet::from([0, 1, 2, 141]));
    let mut n_pages = 0;
    for (verb, page) in pages() {
        let Some((_, codes)) = page.split_once("Exit codes: ") else { continue };
        // `0 done, 1 failed, 2 bad input`: a code begins each part.
        let line = codes.lines().next().unwrap_or_default();
        let codes: BTreeSet<u32> =
            line.split(", ").filter_map(|part| part.split(' ').next()?.parse().ok()).collect();
        assert!(codes.contains(&0) && codes.is_subset(&table), "{verb}: {line}");
        n_pages += 1;
    }
    assert!(n_pages > 30, "{n_pages} verbs say their exit codes");
}

/// All files of a folder and of those in it, by path.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for name in names_in(folder) {
        let path = folder.join(&name);
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
            found.insert(format!("{name}/"), Vec::new());
        } else {
            found.insert(name, std::fs::read(path).unwrap());
        }
    }
    found
}

/// Paths that cannot be an output, and why.
fn wrong(names: Names) -> Vec<(String, &'static str)> {
    let long = "n".repeat(245);
    let mut all = vec![
        ("scene.toml/new/x.csv".to_owned(), "in a file"),
        ("/proc/none/x.csv".to_owned(), "where nothing can be written"),
    ];
    match names {
        Folder => all.push(("foreign.txt".to_owned(), "a file")),
        File(endings) => {
            let ending = endings.first().map_or(String::new(), |ending| format!(".{ending}"));
            all.push((format!("{long}{ending}"), "a name without room for those that are made from it"));
            all.push((format!("there{ending}/"), "a folder"));
            all.push((format!("there{ending}"), "a folder"));
            all.push((format!("foreign{ending}"), "another's file"));
            if !endings.is_empty() {
                all.push(("x.xyz".to_owned(), "a file of another kind"));
            }
        }
    }
    all
}

fn place() -> Workplace {
    let place = Workplace::new();
    place.write_circle("more.csv", 160);
    place.simulate("more.csv", "rec2.csv").succeeded();
    place.write_circle("strokes.csv", 120);
    place.simulate("strokes.csv", "rec.csv").succeeded();
    let torques = std::fs::read(root().join("arm/dynamics/tests/data/torques.csv")).unwrap();
    place.write("torques.csv", torques);
    let run = |line: &str| {
        place.run(&line.split_whitespace().collect::<Vec<_>>()).succeeded();
    };
    run("arm simulate three-link --torques torques.csv --out motion.csv");
    run("identify scene-coreact.toml rec.csv rec2.csv --rounds 1 --out identified");
    run("fit-residual identified --out r.safetensors --epochs 1 --members 1");
    let study = std::fs::read(root().join("app/cli/studies/paper.toml")).unwrap();
    place.write("study.toml", study);
    place.write("foreign.txt", "of another");
    place.write("foreign", "of another");
    std::fs::create_dir(place.path().join("there")).unwrap();
    for ending in ["csv", "safetensors", "json", "toml", "msh", "urdf"] {
        std::fs::create_dir(place.path().join(format!("there.{ending}"))).unwrap();
        place.write(&format!("foreign.{ending}"), "of another");
    }
    place
}

#[test]
fn no_output_option_of_any_verb_does_harm() {
    let place = place();
    let before = files(place.path());
    let mut faults = Vec::new();
    for (line, option, names) in OPTIONS {
        for (output, why) in wrong(names) {
            let typed: Vec<&str> = line.split_whitespace().chain([option, &output]).collect();
            let outcome = place.run(&typed);
            let errors: Vec<&str> =
                outcome.stderr.lines().filter(|line| line.starts_with("error: ")).collect();
            // The system's refusals are failures, all others are bad input.
            let is_code = match outcome.code {
                Some(2) => true,
                Some(1) => output.starts_with("/proc"),
                _ => false,
            };
            if !is_code || errors.len() != 1 {
                faults.push(format!("{line} {option} {output} ({why}): {:?}, {errors:?}", outcome.code));
            }
            let after = files(place.path());
            if after != before {
                let names = |all: &BTreeMap<String, Vec<u8>>| all.keys().cloned().collect::<BTreeSet<_>>();
                let changed: Vec<String> =
                    names(&after).symmetric_difference(&names(&before)).cloned().collect();
                panic!("{line} {option} {output} ({why}) changed files: {changed:?}");
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
