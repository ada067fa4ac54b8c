//! Scenes and commands of the repository work as typed.

use hysteron_base::Recording;
use hysteron_tests::{names_in, root, run};

#[test]
fn the_main_job_runs_in_full() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("tip.parquet");
    let strokes = root().join("meshes/tpu80/strokes-circle.csv");
    let [out_text, strokes_text] = [&out, &strokes].map(|path| path.to_str().unwrap());
    run(root(), &["simulate", "meshes/tpu80/scene.toml", "--strokes", strokes_text, "--out", out_text])
        .succeeded();
    let (strokes, tip) = (Recording::read(&strokes).unwrap(), Recording::read(&out).unwrap());
    assert_eq!(tip.time(), strokes.time());
    assert_eq!(tip.strokes(), strokes.strokes());
    // The CoReAct paper reports some 25 mm to every side for this kind of robot.
    let [x, y, _] = tip.tip().unwrap();
    for values in [x, y] {
        let (low, high) = values.iter().fold((0.0f64, 0.0f64), |(low, high), v| (low.min(*v), high.max(*v)));
        assert!((-30e-3..-15e-3).contains(&low) && (15e-3..30e-3).contains(&high), "{low} {high}");
    }
    // Back at rest, straight.
    let last = tip.n_samples() - 1;
    assert!(x[last].abs() < 1e-4 && y[last].abs() < 1e-4);
}

#[test]
fn help_explains_every_verb() {
    let help = run(root(), &["--help"]).succeeded().stdout;
    assert!(help.contains("Exit codes"));
    for verb in ["simulate", "mesh", "check", "target", "evaluate", "run", "demo"] {
        assert!(help.contains(verb), "{verb}");
        let help = run(root(), &[verb, "--help"]).succeeded().stdout;
        for part in ["Exit codes", "Example", &format!("hysteron {verb} ")] {
            assert!(help.contains(part), "{part} in the help of {verb}");
        }
    }
}

/// The commands in a help text: lines that begin with the program, with what a backslash continues.
fn examples(help: &str) -> Vec<Vec<String>> {
    let joined = help.replace("\\\n", " ");
    let commands = joined.lines().filter_map(|line| line.strip_prefix("  hysteron "));
    commands.map(|line| line.split_whitespace().map(str::to_owned).collect()).collect()
}

/// A shell would take the rest of a wrapped example for a command of its own.
#[test]
fn no_example_of_the_help_is_wrapped() {
    let (mut left, mut n_read) = (vec![Vec::<String>::new()], 0);
    while let Some(verb) = left.pop() {
        let arguments: Vec<&str> = verb.iter().map(String::as_str).chain(["--help"]).collect();
        let help = run(root(), &arguments).succeeded().stdout;
        let verbs = help.lines().skip_while(|line| *line != "Commands:").skip(1);
        // What a verb does may go on in the next line, further to the right.
        let verbs = verbs.take_while(|line| !line.is_empty()).filter(|line| !line.starts_with("   "));
        let verbs = verbs.filter_map(|line| line.split_whitespace().next()).filter(|verb| *verb != "help");
        left.extend(verbs.map(|own| [&verb[..], &[own.to_owned()]].concat()));
        let wrapped = |pair: &[&str]| {
            let is_example = pair[0].starts_with("  hysteron ") && !pair[0].ends_with('\\');
            is_example && pair[1].starts_with("  ") && !pair[1].starts_with("  hysteron ")
        };
        let lines: Vec<&str> = help.lines().collect();
        let found = lines.windows(2).find(|pair| wrapped(pair));
        assert!(found.is_none(), "{verb:?}: {found:?}");
        n_read += 1;
    }
    assert!(n_read > 40, "{n_read}");
}

#[test]
fn examples_of_the_help_run_as_typed() {
    // A place like the root of the repository, in which `out/` may appear.
    let folder = tempfile::tempdir().unwrap();
    for robot in ["tpu80", "tentacle"] {
        let meshes = folder.path().join("meshes").join(robot);
        std::fs::create_dir_all(&meshes).unwrap();
        for name in names_in(&root().join("meshes").join(robot)) {
            std::fs::copy(root().join("meshes").join(robot).join(&name), meshes.join(&name)).unwrap();
        }
    }
    let mut n_run = 0;
    // Two results are compared; one of them is what `track` shows first.
    let tracked = examples(&run(root(), &["track", "--help"]).succeeded().stdout);
    run(folder.path(), &tracked[0].iter().map(String::as_str).collect::<Vec<_>>()).succeeded();
    for verb in [&["simulate"][..], &["mesh"], &["check"], &["rig", "emulate"], &["target"], &["evaluate"]] {
        for example in examples(&run(root(), &[verb, &["--help"]].concat()).succeeded().stdout) {
            run(folder.path(), &example.iter().map(String::as_str).collect::<Vec<_>>()).succeeded();
            n_run += 1;
        }
    }
    assert_eq!(n_run, 11);
}
