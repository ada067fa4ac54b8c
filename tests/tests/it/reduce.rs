//! `hysteron reduce` and `simulate --reduced`: a chain in place of the finite elements.

use hysteron_base::{Recording, json};
use hysteron_tests::{Workplace, names_in};

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
    let out = ["--out", "chain.csv", "--figures", "figures", "--vtu", "vtu"];
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
    assert!(chain.meta().extra.contains_key("chain_sha256"));
    assert!(names_in(&place.path().join("vtu")).len() > 2);
    // The same command gives the same file; what was interrupted or differs is no part of it.
    let before = place.read("chain.json");
    place.run(&reduce).succeeded();
    assert_eq!(place.read("chain.json"), before);
}

#[test]
fn a_chain_of_another_scene_and_runs_that_begin_elsewhere_are_refused() {
    let place = Workplace::new();
    place.write_circle("strokes.csv", 20);
    place.run(&["reduce", "scene.toml", "--count", "1", "--out", "chain.json"]).succeeded();
    let simulate =
        ["simulate", "scene.toml", "--strokes", "strokes.csv", "--out", "r.csv", "--reduced", "chain.json"];
    let with = |more: &[&str]| place.run(&[&simulate[..], more].concat());
    assert!(with(&["--save-state", "end.state"]).error(2).contains("cannot be used with"));
    place.replace("scene.toml", "seed = ", "seed = 1");
    assert!(with(&[]).error(2).contains("make it again"));
    for (option, value) in
        [("--stroke-mm", "0"), ("--stroke-mm", "nan"), ("--tension-n", "nan"), ("--count", "0")]
    {
        let refused = place.run(&["reduce", "scene.toml", "--out", "new.json", option, value]);
        assert!(refused.error(2).contains(option), "{option} {value}");
    }
    assert!(!names_in(place.path()).contains(&"new.json".to_owned()));
}
