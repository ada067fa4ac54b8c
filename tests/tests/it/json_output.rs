//! `--json` prints the contents of `metrics.json`, for every verb that has both; results read back as they were written.

use hysteron_base::json;
use hysteron_tests::{Workplace, root};
use hysteron_workflow::shared::outcome::rewrite;
use serde_json::Value;

/// Two short motions within the limits of the virtual rig.
const PLAN: &str = "format = \"hysteron-plan\"\nversion = 1\nname = \"short\"\nseed = 1\nrate_hz = 100\n\
    tendon_angles_deg = [0, 90, 180, 270]\nrelease = 1\nrest_before_s = 0.5\nrest_after_s = 0.5\nstroke_max_mm = 20\n\
    stroke_rate_max_mm_s = 50\n\
    [[trajectory]]\nname = \"a\"\nrole = \"training\"\nfamily = \"circle\"\namplitude_mm = 2.5\nperiod_s = 3\nattack_s = 3\n\
    sustain_s = 1\ndecay_s = 3\n\
    [[trajectory]]\nname = \"b\"\nrole = \"training\"\nfamily = \"circle\"\namplitude_mm = 2\nperiod_s = 4\nattack_s = 3\n\
    sustain_s = 1\ndecay_s = 3\n";
const FIT: &str = "format = \"hysteron-fit\"\nversion = 1\n[fit]\nzero_mm = [-1.0, 1.0]\n";

/// Runs a verb with `--json`: the same value is in `metrics.json` of `folder`, and reads back from both texts that it has.
#[track_caller]
fn is_the_same(place: &Workplace, line: &str, folder: &str) {
    let arguments: Vec<&str> = line.split_whitespace().chain(["--json"]).collect();
    let outcome = place.run(&arguments).succeeded();
    let printed: Value = json::from_text(&outcome.stdout).unwrap_or_else(|error| panic!("{line}: {error}"));
    let written: Value = json::from_text(place.read(&format!("{folder}/metrics.json"))).unwrap();
    assert_eq!(printed, written, "{line}");
    assert_eq!(written["format"], "hysteron-metrics", "{line}");
    let words: Vec<&str> = line.split(' ').collect();
    let verb = if words[0] == "arm" { words[..2].join(" ") } else { words[0].to_owned() };
    // Where the outcome has a type, it holds every key, and numbers that are not finite too.
    if let Some(rewritten) = rewrite(&verb, &outcome.stdout) {
        let rewritten: Value =
            json::from_text(rewritten.unwrap_or_else(|error| panic!("{line}: {error}"))).unwrap();
        assert_eq!(rewritten, written, "{line}");
    }
    for text in [json::to_line(&written).unwrap(), json::to_text(&written).unwrap()] {
        assert_eq!(json::from_text::<Value>(text).unwrap(), written, "{line}");
    }
}

#[test]
fn verbs_of_tendon_robots_print_their_metrics() {
    let place = Workplace::new();
    place.write("plan.toml", PLAN);
    place.write("fit.toml", FIT);
    place.write_circle("strokes.csv", 120);
    for (line, folder) in [
        ("record --rig virtual:typical --plan plan.toml --out data", "data"),
        ("simulate scene.toml --strokes strokes.csv --out sim/tip.csv --figures sim", "sim"),
        ("reach scene.toml --goals sim/tip.csv --out reach.csv --figures reach", "reach"),
        (
            "fit-material scene.toml sim/tip.csv --fit-file fit.toml --every-mm 0.2 --out fitted.toml --figures fit",
            "fit",
        ),
        ("identify scene-coreact.toml sim/tip.csv --rounds 1 --out identified", "identified"),
        ("identify scene-coreact.toml data/b.parquet --rounds 1 --out identified", "identified"),
        ("fit-residual identified --out r.safetensors --epochs 1 --members 1 --figures residual", "residual"),
        (
            "adapt r.safetensors data/b.parquet --scene scene-coreact.toml --out q.safetensors --figures adapted",
            "adapted",
        ),
        ("generate scene.toml --plan plan.toml --out synthetic", "synthetic"),
        ("train data --epochs 1 --hidden 8 --out i.safetensors --figures trained", "trained"),
        ("command i.safetensors --target circle:4 --out command.csv --figures command", "command"),
        ("track i.safetensors --rig virtual:typical --target circle:4 --out tracked", "tracked"),
        ("evaluate --target circle:4 data/a.parquet --out evaluated", "evaluated"),
        ("target circle:4 --scene scene.toml --out target.csv --figures target", "target"),
        (
            "import sim/tip.csv --map time_s=time_s;stroke_*_mm=stroke_*_mm;tip_x_mm=tip_x_mm --out in.parquet --figures in",
            "in",
        ),
    ] {
        is_the_same(&place, line, folder);
    }
}

#[test]
fn verbs_of_arms_print_their_metrics() {
    let place = Workplace::new();
    std::fs::copy(root().join("arm/dynamics/tests/data/torques.csv"), place.path().join("torques.csv"))
        .unwrap();
    for (line, folder) in [
        (
            "arm simulate three-link --torques torques.csv --start 0.3,-0.4,0.5 --out motion.csv --figures motion",
            "motion",
        ),
        (
            "arm excite three-link --speed-limit 2 --generations 2 --out excited.csv --figures excited",
            "excited",
        ),
        ("arm identify inertia three-link motion.csv --out inertia.json --figures inertia", "inertia"),
        ("arm identify friction motion.csv --out friction.json --figures friction", "friction"),
        (
            "arm generate --subsets force_unlabeled --splits train,validation --trajectories 2 --out nad",
            "nad",
        ),
    ] {
        is_the_same(&place, line, folder);
    }
}
