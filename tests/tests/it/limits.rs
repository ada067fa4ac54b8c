//! Sizes that no machine has, and robots that cannot be: refused at once, with exit code 2 and little memory.

use std::time::{Duration, Instant};

use hysteron_tests::{Workplace, measured, names_in};

/// A refusal takes well below a second; the rest is for a machine that has other work.
const PATIENCE: Duration = Duration::from_secs(10);
/// Most memory of a refusal [MB].
const MEMORY: u64 = 500;

/// Runs `typed` (words apart by blanks), expects an error with these parts, in time and memory, and no new file.
fn refused(place: &Workplace, typed: &str, parts: &[&str]) {
    let before = names_in(place.path());
    let start = Instant::now();
    let (outcome, peak) = measured(place.path(), &typed.split(' ').collect::<Vec<_>>());
    let error = outcome.error(2);
    for part in parts {
        assert!(error.contains(part), "{part:?} in {error:?}");
    }
    assert!(start.elapsed() < PATIENCE, "{typed}: {:?}", start.elapsed());
    assert!(peak < MEMORY, "{typed}: {peak} MB");
    assert_eq!(names_in(place.path()), before, "{typed}");
}

#[test]
fn numbers_on_the_command_line_end_where_machines_do() {
    let place = Workplace::new();
    for (typed, option, most) in [
        ("train data --out a.safetensors --hidden 100000", "--hidden", "4096"),
        ("train data --out a.safetensors --epochs 1000000000", "--epochs", "100000"),
        ("train data --out a.safetensors --batch 1000000000", "--batch", "65536"),
        ("train data --out a.safetensors --stride 1000000000", "--stride", "65536"),
        (
            "train data --out a.safetensors --co-contraction-min-mm 1e300",
            "--co-contraction-min-mm",
            "1000000.0 mm",
        ),
        ("fit-residual data --out a.safetensors --hidden 100000", "--hidden", "4096"),
        ("fit-residual data --out a.safetensors --members 1000000000", "--members", "32"),
        ("identify scene.toml data --out o --rounds 1000000000", "--rounds", "100"),
        ("identify scene.toml data --out o --regularisation 1e300", "--regularisation", "1000000000000000.0"),
        ("fit-material scene.toml data --out o.toml --steps 99999999999999999999", "--steps", "10000000"),
        ("fit-material scene.toml data --out o.toml --step-mm 1e300", "--step-mm", "1000000.0 mm"),
        (
            "adapt a.safetensors data --scene scene.toml --out b.safetensors --memory-s 1e300",
            "--memory-s",
            "1000000000.0 s",
        ),
        (
            "track a.safetensors --target circle:4 --rig virtual:typical --out o --repeats 1000000000",
            "--repeats",
            "100",
        ),
        ("check scene.toml --threads 1000000000", "--threads", ""),
        (
            "command a.safetensors --target circle:4 --out o.csv --stroke-max-mm 1e300",
            "--stroke-max-mm",
            "1000000.0 mm",
        ),
        (
            "mesh --edge-mm 1 --length-mm 1e300 --outer-diameter-mm 8 --out a.msh",
            "--length-mm",
            "1000000.0 mm",
        ),
        ("mesh --length-mm 80 --outer-diameter-mm 8 --layers 4000000000 --out a.msh", "--layers", "20000"),
        (
            "mesh --length-mm 80 --outer-diameter-mm 8 --layers 4 --outer-sides 100000 --out a.msh",
            "--outer-sides",
            "512",
        ),
        (
            "mesh --length-mm 80 --outer-diameter-mm 8 --layers 4 --channels 4000000000 --out a.msh",
            "--channels",
            "64",
        ),
    ] {
        refused(&place, typed, &[&format!("error: {option}: expected at most {most}")]);
    }
    refused(
        &place,
        "check scene.toml --threads 10000",
        &["error: --threads: expected at most ", "got 10000 (hint: this machine has"],
    );
    for (typed, part) in [
        (
            "reach scene.toml --goals a.csv --out b.csv --tolerance-mm 1e-300",
            "--tolerance-mm: expected at least",
        ),
        (
            "target circle:4 --out b.csv --scene scene.toml --tolerance-mm 0",
            "--tolerance-mm: expected at least",
        ),
        (
            "command a.safetensors --target circle:4 --out o.csv --stroke-max-mm -1",
            "--stroke-max-mm: expected more than 0",
        ),
        (
            "command a.safetensors --target circle:4 --out o.csv --stroke-min-mm 1",
            "--stroke-min-mm: expected at most 0",
        ),
        (
            "command --scene scene.toml --target circle:4 --out o.csv --stroke-rate-max-mm-s 1e-300",
            "--stroke-rate-max-mm-s",
        ),
        (
            "command --scene scene.toml --target circle:4 --out o.csv --stroke-rate-max-mm-s 1e-5",
            "largest rate",
        ),
        (
            "mesh --edge-mm 1e-9 --length-mm 80 --outer-diameter-mm 8 --out a.msh",
            "divisions: expected 3 to 512",
        ),
        ("mesh --edge-mm 0.05 --length-mm 1000 --outer-diameter-mm 4 --out a.msh", "at most"),
        ("mesh --layers 20000 --outer-sides 512 --length-mm 80 --outer-diameter-mm 8 --out a.msh", "at most"),
    ] {
        refused(&place, typed, &[part]);
    }
}

#[test]
fn scenes_of_robots_that_cannot_be() {
    let scene = |from: &str, to: &str, parts: &[&str]| {
        let place = Workplace::new();
        place.replace("scene.toml", from, to);
        place.write_circle("strokes.csv", 5);
        refused(&place, "simulate scene.toml --strokes strokes.csv --out tip.csv", parts);
    };
    scene(
        "youngs_modulus_mpa = 20.0",
        "youngs_modulus_mpa = 1e-30",
        &["material.youngs_modulus_mpa", "from 0.000001"],
    );
    scene(
        "[tip]\ngroup = \"tip\"",
        "[tip]\ngroup = \"base\"",
        &["tip: expected a part of the body that can move"],
    );
    let one_node = "box_min_mm = [5.9, -0.1, -0.1]\nbox_max_mm = [6.1, 0.1, 0.1]";
    scene("group = \"base\"", one_node, &["clamp: expected at least three nodes", "got one node"]);
    scene(
        "stroke_max_mm = 20.0",
        "stroke_max_mm = 0.01",
        &["stroke of tendon p1", "-20 to 0.01 mm", "the bounds of tendon"],
    );

    let place = Workplace::new();
    let text = String::from_utf8(place.read("scene-coreact.toml")).unwrap();
    let with = |key: &str, value: &str, text: &str| {
        text.lines()
            .map(|line| if line.starts_with(key) { format!("{key} = {value}") } else { line.to_owned() })
            .collect::<Vec<_>>()
            .join("\n")
    };
    place.write("many.toml", with("cables_per_segment", "100", &with("segments", "1000", &text)));
    refused(&place, "check many.toml", &["at most 500, got 100000"]);
}

/// A plan with these trajectories.
fn plan(more: &str) -> String {
    format!(
        "format = \"hysteron-plan\"\nversion = 1\nname = \"large\"\nseed = 1\nrate_hz = 100\n\
         tendon_angles_deg = [0, 90, 180, 270]\nrelease = 1\nrest_before_s = 1\nrest_after_s = 1\n\
         stroke_max_mm = 20\nstroke_rate_max_mm_s = 50\n{more}"
    )
}

fn trajectory(k: usize, sustain_s: f64) -> String {
    format!(
        "[[trajectory]]\nname = \"t-{k}\"\nrole = \"training\"\nfamily = \"circle\"\namplitude_mm = 5\n\
         period_s = 10\nattack_s = 5\nsustain_s = {sustain_s}\ndecay_s = 5\n"
    )
}

#[test]
fn plans_of_a_century() {
    let place = Workplace::new();
    let record = "record --rig virtual:typical --plan plan.toml --out out";
    place.write("plan.toml", plan(&trajectory(1, 1e8)));
    refused(&place, record, &["trajectory.t-1", "fewer than 1e7 samples", "1.00000"]);
    // Each of them is short enough.
    let many: String = (0..200).map(|k| trajectory(k, 9e4)).collect();
    place.write("plan.toml", plan(&many));
    refused(&place, record, &["trajectories: expected at most 1e7 samples in all"]);
    let draw = "[[draw]]\nname = \"d\"\nrole = \"training\"\nfamily = \"circle\"\ncount = 100000\n\
                amplitude_mm = [1, 5]\nperiod_s = [10, 20]\nattack_s = 5\nsustain_s = 5\ndecay_s = 5\n";
    place.write("plan.toml", plan(draw));
    refused(&place, record, &["trajectories: expected at most 10000, got 100000"]);
    let typed: String = (0..20_000).map(|k| trajectory(k, 1.0)).collect();
    place.write("plan.toml", plan(&typed));
    refused(&place, record, &["trajectories: expected at most 10000, got 20000"]);
}

#[test]
fn outlines_that_unfold() {
    let place = Workplace::new();
    let svg = |inside: &str| {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"80mm\" viewBox=\"0 0 80 80\">{inside}</svg>"
        )
    };
    let target = |name: &str, text: String, parts: &[&str]| {
        place.write(name, text);
        refused(&place, &format!("target {name} --out out.csv"), parts);
    };
    target("a.svg", svg("<circle cx=\"40\" cy=\"40\" r=\"1e300\"/>"), &["circle.r", "1e7"]);
    target("a.svg", svg("<path d=\"M0 0 A1e300 1e300 0 0 1 10 10 L0 5 Z\"/>"), &["path.d", "1e7"]);
    target(
        "a.svg",
        svg("<circle transform=\"scale(1e200)\" cx=\"4\" cy=\"4\" r=\"1\"/>"),
        &["a shape of at most 100 m"],
    );
    let arcs: String = (0..100_000).map(|k| format!("A 5 5 0 0 1 {} {}", k % 7, k % 11)).collect();
    target("a.svg", svg(&format!("<path d=\"M0 0 {arcs}\"/>")), &["path.d: expected at most 20000"]);
    let entity = format!("<!DOCTYPE svg [<!ENTITY a \"{}\">]>", "L 1 2 ".repeat(10_000));
    let uses = svg(&format!("<path d=\"M0 0 {}\"/>", "&a;".repeat(10_000)));
    target("a.svg", format!("{entity}{uses}"), &["ENTITY", "at most 1048576"]);
    let nested = "<!DOCTYPE svg [<!ENTITY a \"L 1 2\"><!ENTITY b \"&a;&a;\">]>";
    target("a.svg", format!("{nested}{}", svg("<path d=\"M0 0 &b;\"/>")), &["ENTITY", "other entities"]);
    let attributes: String = (0..200_000).map(|k| format!(" a{k}=\"\"")).collect();
    target("a.svg", svg(&format!("<path{attributes} d=\"M0 0\"/>")), &["attributes of an element"]);
    target(
        "a.svg",
        svg(&format!("{}{}", "<g>".repeat(50_000), "</g>".repeat(50_000))),
        &["elements in each other"],
    );
    let points: String = (0..600_000).map(|k| format!("{},{}\n", k % 1000, k / 1000)).collect();
    target("a.csv", format!("x_mm,y_mm\n{points}"), &["points: expected at most 500000"]);

    let toml = |keys: &str, curve: &str| {
        format!("format = \"hysteron-target\"\nversion = 1\nname = \"t\"\n{keys}\n[curve]\n{curve}\n")
    };
    let keys = "rate_hz = 100\nspeed_mm_s = 10\nramp_s = 1\nrest_s = 1\nlead_in_s = 3";
    let circle = "family = \"circle\"\nsize_mm = 40";
    for (from, to, part) in [
        ("rate_hz = 100", "rate_hz = 1e12", "rate_hz"),
        ("rate_hz = 100", "rate_hz = 1e-300", "rate_hz"),
        ("speed_mm_s = 10", "speed_mm_s = 1e-9", "speed_mm_s"),
        ("rest_s = 1", "rest_s = 1e300", "rest_s"),
        ("rest_s = 1", "rest_s = 1e5", "fewer than 1e6 samples"),
        ("lead_in_s = 3", "lead_in_s = 1e300", "lead_in_s"),
        ("ramp_s = 1", "ramp_s = 1e-300", "ramp_s"),
        ("lead_in_s = 3", "lead_in_s = 3\nlaps = 4000000000", "laps"),
        ("lead_in_s = 3", "lead_in_s = 3\ncentre_mm = [1e300, 0]", "centre_mm[0]"),
    ] {
        target("a.toml", toml(&keys.replace(from, to), circle), &[part]);
    }
    target("a.toml", toml(keys, "family = \"circle\"\nsize_mm = 1e300"), &["curve.size_mm"]);
    target("a.toml", toml(keys, "family = \"spiral\"\nsize_mm = 40\nturns = 1e300"), &["curve.turns"]);
}

#[test]
fn recordings_of_a_hundred_thousand_columns() {
    let place = Workplace::new();
    let names: String = (1..=100_000).map(|k| format!(",aux_{k}_mm")).collect();
    let zeros = ",0".repeat(100_000);
    place.write("strokes.csv", format!("time_s{names}\n0{zeros}\n1{zeros}\n"));
    refused(
        &place,
        "simulate scene.toml --strokes strokes.csv --out tip.csv",
        &["columns: expected at most 5000, got 100001"],
    );
}
