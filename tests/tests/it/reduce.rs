//! `hysteron reduce` and `simulate --reduced`: a chain in place of the finite elements.

use std::process::{Command, Stdio};
use std::time::Duration;

use hysteron_base::{Recording, json};
use hysteron_tests::{Workplace, emulated, names_in, program};

fn recording(place: &Workplace, name: &str) -> Recording {
    Recording::read(place.path().join(name)).unwrap()
}

#[test]
fn a_chain_follows_the_finite_elements_as_closely_as_its_file_states() {
    let place = Workplace::new();
    place.write_circle("strokes.csv", 300);
    place.simulate("strokes.csv", "mesh.csv").succeeded();
    let reduce = ["reduce", "scene.toml", "--count", "6", "--out", "chain.json"];
    let outcome = place.run(&reduce).succeeded();
    assert!(outcome.stdout.contains("verdict: Usable"), "{}", outcome.stdout);
    let stored: json::Value = json::from_text(place.read("chain.json")).unwrap();
    assert_eq!(stored["format"], "hysteron-chain");
    let largest = stored["validation"]["tip"]["largest"].as_f64().unwrap();
    assert!(largest > 0.0);
    let simulate = ["simulate", "scene.toml", "--strokes", "strokes.csv", "--reduced", "chain.json"];
    let out = ["--out", "chain.csv", "--figures", "figures", "--vtu", "vtu", "--exact-every", "50"];
    place.run(&[&simulate[..], &out].concat()).succeeded();
    let (mesh, chain) = (recording(&place, "mesh.csv"), recording(&place, "chain.csv"));
    let (a, b) = (mesh.tip().unwrap(), chain.tip().unwrap());
    let rest = a.map(|axis| axis[0]);
    let far = |of: &dyn Fn(usize, usize) -> f64| {
        (0..a[0].len()).map(|i| (0..3).map(|c| of(c, i).powi(2)).sum::<f64>().sqrt()).fold(0.0, f64::max)
    };
    let (error, moved) = (far(&|c, i| a[c][i] - b[c][i]), far(&|c, i| a[c][i] - rest[c]));
    // The circle is within the strokes of the validation; its errors scatter by their own size.
    assert!(moved > 1e-3 && error < 2.0 * largest * moved, "{error} of {moved} m, {largest}");
    assert!(error > 0.0);
    let metrics: json::Value = json::from_text(place.read("figures/metrics.json")).unwrap();
    let exact = &metrics["run"]["exact"];
    assert_eq!((exact["samples"].as_u64(), exact["unsolved"].as_u64()), (Some(6), Some(0)), "{exact}");
    // Of some of the same samples, without friction.
    let most = exact["tip_largest_m"].as_f64().unwrap();
    assert!(most > 0.2 * error && most < 1.05 * error, "{most} and {error}");
    assert_eq!(metrics["robot"]["chain"]["sections"], 17);
    assert!(chain.meta().extra.contains_key("chain_sha256"));
    assert!(names_in(&place.path().join("vtu")).len() > 2);
    // The same command gives the same file; what was interrupted or differs is no part of it.
    let before = place.read("chain.json");
    place.run(&reduce).succeeded();
    assert_eq!(place.read("chain.json"), before);
}

#[test]
fn a_chain_of_another_body_and_options_without_sense_are_refused() {
    let place = Workplace::new();
    place.write_circle("strokes.csv", 20);
    place.run(&["reduce", "scene.toml", "--count", "1", "--out", "chain.json"]).succeeded();
    let simulate =
        ["simulate", "scene.toml", "--strokes", "strokes.csv", "--out", "r.csv", "--reduced", "chain.json"];
    let with = |more: &[&str]| place.run(&[&simulate[..], more].concat());
    let mesh = ["simulate", "scene.toml", "--strokes", "strokes.csv", "--out", "r.csv", "--exact-every", "5"];
    assert!(place.run(&mesh).error(2).contains("--exact-every"));
    place.replace("scene.toml", "poisson_ratio = 0.45", "poisson_ratio = 0.44");
    assert!(with(&[]).error(2).contains("make it again"));
    for (option, value) in
        [("--stroke-mm", "0"), ("--stroke-mm", "nan"), ("--tension-n", "nan"), ("--count", "0")]
    {
        let refused = place.run(&["reduce", "scene.toml", "--out", "new.json", option, value]);
        assert!(refused.error(2).contains(option), "{option} {value}");
    }
    assert!(!names_in(place.path()).contains(&"new.json".to_owned()));
}

#[test]
fn a_scene_that_names_a_chain_resumes_and_reaches_with_it() {
    let place = Workplace::new();
    place.write_circle("strokes.csv", 60);
    place.run(&["reduce", "scene.toml", "--count", "2", "--out", "chain.json"]).succeeded();
    // What a chain follows may change after it was made.
    place.replace("scene.toml", "youngs_modulus_mpa = 20.0", "youngs_modulus_mpa = 15.0");
    place.replace("scene.toml", "[clamp]", "[reduced]\nfile = \"chain.json\"\n\n[clamp]");
    let checked = place.run(&["check", "scene.toml"]).succeeded();
    assert!(checked.stdout.contains("moved by chain.json: 17 sections"), "{}", checked.stdout);
    let whole = ["simulate", "scene.toml", "--strokes", "strokes.csv", "--out", "whole.csv"];
    place.run(&[&whole[..], &["--save-state", "end.state"]].concat()).succeeded();
    let with = recording(&place, "whole.csv");
    let from = ["--from", "end.state", "--out", "on.csv"];
    place.run(&[&["simulate", "scene.toml", "--strokes", "strokes.csv"][..], &from].concat()).succeeded();
    let on = recording(&place, "on.csv");
    // The circle ends where it begins, but for the rest before it.
    let [first, last] = [on.tip().unwrap().map(|x| x[59]), with.tip().unwrap().map(|x| x[59])];
    let moved = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
    assert!(moved(first, last) < 1e-6, "{first:?} {last:?}");
    let rest = with.tip().unwrap().map(|x| x[0]);
    assert!(moved(first, rest) > 1e-5);
    // A state of the chain is none of the mesh.
    let named = String::from_utf8(place.read("scene.toml")).unwrap();
    place.replace("scene.toml", "[reduced]\nfile = \"chain.json\"\n\n", "");
    let refused =
        ["simulate", "scene.toml", "--strokes", "strokes.csv", "--from", "end.state", "--out", "no.csv"];
    assert!(place.run(&refused).error(2).contains("scene_hash"));
    place.write("scene.toml", named);
    // Goals where the tip has been are reached again.
    let goals =
        format!("time_s,tip_x_m,tip_y_m,tip_z_m\n0,{0},{1},{2}\n1,{0},{1},{2}\n", last[0], last[1], last[2]);
    std::fs::write(place.path().join("goals.csv"), goals).unwrap();
    let reach = ["reach", "scene.toml", "--goals", "goals.csv", "--out", "reach.csv"];
    for _ in 0..4 {
        place.replace("scene.toml", "drive = \"stroke\"", "drive = \"free\"");
    }
    place.run(&reach).succeeded();
    let reached = recording(&place, "reach.csv");
    assert!(moved(reached.tip().unwrap().map(|x| x[1]), last) < 2e-4);
}

#[test]
fn an_interrupted_comparison_goes_on_from_its_equilibria() {
    let place = Workplace::new();
    let reduce = |out: &str| ["reduce", "scene.toml", "--count", "200", "--out", out].map(str::to_owned);
    let run = |out: &str| place.run(&reduce(out).each_ref().map(String::as_str)).succeeded();
    run("whole.json");
    let mut command = Command::new(program());
    command.args(reduce("chain.json")).current_dir(place.path()).stdout(Stdio::null()).stderr(Stdio::piped());
    let process = command.spawn().unwrap();
    // Of the four seconds that it takes.
    std::thread::sleep(Duration::from_millis(1500));
    emulated::signal(&process, "INT");
    let output = process.wait_with_output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    let saved = place.path().join("chain.json.equilibria");
    assert!(output.status.code() == Some(1) && errors.contains("goes on from there"), "{errors}");
    assert!(saved.exists() && !place.path().join("chain.json").exists());
    let resumed = run("chain.json");
    assert!(resumed.stderr.contains("going on from chain.json.equilibria"), "{}", resumed.stderr);
    let errors_of = |name: &str| {
        let file: json::Value = json::from_text(place.read(name)).unwrap();
        file["validation"].clone()
    };
    assert_eq!(errors_of("chain.json"), errors_of("whole.json"));
    assert!(!saved.exists());
    // Anything else of that name is no reason to fail.
    std::fs::write(place.path().join("few.json.equilibria"), "{").unwrap();
    place.run(&["reduce", "scene.toml", "--count", "2", "--out", "few.json"]).succeeded();
}
