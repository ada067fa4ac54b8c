//! Every command of README and docs runs as typed, or is listed below with the reason why not; then its verb and its options are at
//! least those of the help.

use std::path::Path;

use hysteron_tests::{names_in, root, run};

/// Commands that are not executed: document, how they begin (without the program's name), and why.
const NOT_RUN: [(&str, &str, &str); 32] = [
    ("README.md", "test --release", "these are the tests"),
    ("README.md", "demo", "five minutes; its stages are those of a study: study.rs"),
    ("docs/actuator.md", "arm identify servo", "recordings that are not part of the repository"),
    ("docs/actuator.md", "study identification", "recordings that are not part of the repository"),
    ("docs/arms.md", "arm emulate", "runs until it is stopped: teleoperation.rs"),
    ("docs/arms.md", "arm record", "in real time: teleoperation.rs"),
    ("docs/arms.md", "arm estimate", "in real time: estimate_live.rs"),
    ("docs/hysteron.md", "", "examples of the help: repository.rs"),
    ("docs/lagrangian.md", "arm fit delan RECORDING", "a recording of one's own"),
    ("docs/lagrangian.md", "arm dynamics model.safetensors", "a recording of one's own"),
    ("docs/lagrangian.md", "arm estimate model.safetensors", "a recording of one's own"),
    ("docs/lagrangian.md", "arm evaluate model.safetensors", "a recording of one's own"),
    ("docs/lagrangian.md", "study", "recordings that are not part of the repository"),
    ("docs/many-machines.md", "shards", "an object store; in a folder: shards.rs"),
    ("docs/observers.md", "study scara", "a quarter of an hour"),
    ("docs/observers.md", "study wrist", "a quarter of an hour"),
    ("docs/observers.md", "study force", "a quarter of an hour"),
    ("docs/recordings.md", "import log.csv", "a file of one's own"),
    ("docs/rig.md", "rig check", "a rig, or its emulator in real time: emulate.rs"),
    ("docs/rig.md", "rig calibrate", "a rig, or its emulator in real time: record.rs"),
    ("docs/rig.md", "rig emulate", "runs until it is stopped: emulate.rs"),
    ("docs/rig.md", "rig recover", "what a lost run has left: record.rs"),
    ("docs/rig.md", "record --rig my-rig.toml", "a rig"),
    ("docs/rig.md", "record --rig out/rig/rig.toml", "the emulator in real time: record.rs"),
    ("docs/sensing.md", "identify-servo KNOWN_TENSIONS", "recordings of one's own: identify_servo.rs"),
    ("docs/sensing.md", "fit-sensor", "recordings of one's own: sense.rs"),
    ("docs/sensing.md", "sense SCENE", "recordings of one's own: sense.rs"),
    ("docs/sensing.md", "record --rig RIG", "a rig: record.rs"),
    (
        "docs/your-robot.md",
        "check out/my-robot/scene.toml out/my-robot/recordings",
        "recordings of one's own",
    ),
    ("docs/your-robot.md", "check out/my-robot", "a scene that the page shows: your_robot.rs"),
    ("docs/your-robot.md", "simulate", "a scene that the page shows: your_robot.rs"),
    ("docs/your-robot.md", "fit-material", "recordings of one's own"),
];

/// A command of a document.
struct Typed {
    document: String,
    /// Words after `hysteron`, or `cargo run --release --`; of another command of cargo, those after `cargo`.
    words: Vec<String>,
}

impl Typed {
    fn line(&self) -> String {
        self.words.join(" ")
    }

    fn not_run(&self) -> Option<&'static str> {
        let is_of = |(document, begins, _): &&(&str, &str, &str)| {
            self.document == *document && self.line().starts_with(begins)
        };
        NOT_RUN.iter().find(is_of).map(|(_, _, why)| *why)
    }
}

/// README and the documents, in the order of their names.
fn documents() -> Vec<String> {
    let docs = names_in(&root().join("docs")).into_iter().filter(|name| name.ends_with(".md"));
    [String::from("README.md")].into_iter().chain(docs.map(|name| format!("docs/{name}"))).collect()
}

/// The commands of a document, in order: lines of code that begin with the program, a prompt before it or not, up to a comment.
fn commands(document: &str) -> Vec<Typed> {
    let text = std::fs::read_to_string(root().join(document)).unwrap().replace("\\\n", " ");
    let mut is_fenced = false;
    let mut found = Vec::new();
    for line in text.lines() {
        if line.starts_with("```") {
            is_fenced = !is_fenced;
            continue;
        }
        if !is_fenced && !line.starts_with("    ") {
            continue;
        }
        let line = line.trim_start().trim_start_matches("$ ");
        let ours =
            ["hysteron ", "cargo run --release -- "].iter().find_map(|begins| line.strip_prefix(begins));
        let Some(rest) = ours.or_else(|| line.strip_prefix("cargo ").filter(|rest| rest.starts_with("test")))
        else {
            continue;
        };
        let words: Vec<String> =
            rest.split_whitespace().take_while(|word| *word != "#").map(str::to_owned).collect();
        found.push(Typed { document: document.to_owned(), words });
    }
    found
}

/// Copies files of the repository that commands name.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for name in names_in(from) {
        let (from, to) = (from.join(&name), to.join(&name));
        if from.is_dir() {
            copy(&from, &to);
        } else {
            std::fs::copy(&from, &to).unwrap();
        }
    }
}

#[test]
fn every_command_of_readme_and_docs_runs_as_typed() {
    let mut n_run = 0;
    for document in documents() {
        let commands: Vec<Typed> =
            commands(&document).into_iter().filter(|typed| typed.not_run().is_none()).collect();
        if commands.is_empty() {
            continue;
        }
        // A place like the root of the repository, for each document its own.
        let place = tempfile::tempdir().unwrap();
        for folder in ["meshes", "arm/dynamics/robots"] {
            copy(&root().join(folder), &place.path().join(folder));
        }
        for typed in commands {
            let words: Vec<&str> = typed.words.iter().map(String::as_str).collect();
            let outcome = run(place.path(), &words);
            assert_eq!(outcome.code, Some(0), "{document}: {}\n{}", typed.line(), outcome.stderr);
            n_run += 1;
        }
    }
    assert!(n_run >= 20, "{n_run}");
}

#[test]
fn commands_that_do_not_run_are_typed_with_options_that_exist() {
    let all: Vec<Typed> = documents().iter().flat_map(|document| commands(document)).collect();
    assert!(all.len() > 45, "{}", all.len());
    for (document, begins, why) in NOT_RUN {
        let is_there = |typed: &Typed| typed.document == document && typed.line().starts_with(begins);
        assert!(all.iter().any(is_there), "{document} has no command `{begins}` ({why})");
    }
    for typed in all.iter().filter(|typed| typed.not_run().is_some() && typed.words[0] != "test") {
        // Verbs are the words before the first that is none.
        let is_verb = |word: &&String| {
            word.chars().all(|c| c.is_ascii_lowercase() || c == '-') && !word.starts_with('-')
        };
        let mut verbs: Vec<&str> = typed.words.iter().take_while(is_verb).map(String::as_str).collect();
        verbs.truncate(if verbs[0] == "arm" { 3 } else { 2 });
        let help = loop {
            let outcome = run(root(), &[&verbs[..], &["--help"]].concat());
            if outcome.code == Some(0) {
                break outcome.stdout;
            }
            assert!(verbs.pop().is_some() && !verbs.is_empty(), "{}: {}", typed.document, typed.line());
        };
        for option in typed.words.iter().filter(|word| word.starts_with("--")) {
            let option = option.split('=').next().unwrap();
            let is_word = |c: char| c.is_ascii_alphanumeric() || c == '-';
            let is_there = help.split(|c| !is_word(c)).any(|word| word == option);
            assert!(is_there, "{}: {} has no {option}", typed.document, verbs.join(" "));
        }
    }
}
