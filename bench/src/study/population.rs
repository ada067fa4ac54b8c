//! The whole chain on robots of a wide population, `virtual:wide/1` to `virtual:wide/10`, each known from its
//! recordings alone.
//!
//! One procedure for all, no hand on any: record a plan of minutes; fit the nominal scene; calibrate the twin in two
//! passes; let it make data; train inverse networks; follow seven paths that are in no training. What was
//! done for a robot stays in its folder: the same command goes on. A robot on which a stage fails is counted
//! and named.
#![allow(clippy::print_stdout, clippy::print_stderr)] // this program prints tables, and which robot it is at

use std::path::Path;

use anyhow::Result;
use hysteron_base::{file, json};
use serde_json::Value;

use super::chain::{Chain, Strokes};
use super::followed::{Followed, HEADING, means, to_json};
use super::write_metrics;
use crate::table::print_cells;

/// Members of the population.
const ROBOTS: u64 = 10;
/// Paths, as far out as the recordings go.
const TARGETS: [&str; 7] =
    ["circle:40", "diamond:40", "square:30", "ellipse:40", "figure_eight:40", "lissajous:36", "rose:40"];
/// Ways to strokes.
const METHODS: [&str; 5] =
    ["nominal scene", "fitted scene", "network of recorded data", "calibrated twin", "hybrid network"];

/// The scene before any fit, from that of `typical`: the drawing, and data sheets for wire in channels and sheaths
/// lined with PTFE (`meshes/tpu80/scene-friction.toml`). Its mesh is named from the robot's folder.
const NOMINAL: (&str, [(&str, &str); 7]) = (
    include_str!("../../../meshes/tpu80/scene-typical-friction.toml"),
    [
        ("name = \"tpu80-typical-friction\"", "name = \"tpu80-nominal\""),
        ("compliance_mm_per_n = 0.0251065", "compliance_mm_per_n = 0.02"),
        ("zero_mm = 0.352247", "zero_mm = 0.0"),
        ("sheath_exponent = 0.51945", "sheath_exponent = 0.31"),
        ("sheath_compliance_share = 0.5", "sheath_compliance_share = 0.6"),
        ("backlash_mm = 0.260928", "backlash_mm = 0.05"),
        ("# The virtual rig's typical robot as", "# As drawn, not fitted:"),
    ],
);

/// Plan of the recordings: three minutes.
const RECORDED: &str = r#"format = "hysteron-plan"
version = 1
name = "population"
seed = 1
rate_hz = 100
tendon_angles_deg = [0, 90, 180, 270]
release = 1.0
rest_before_s = 1
rest_after_s = 1
stroke_max_mm = 9
stroke_rate_max_mm_s = 12
"#;
/// Its trajectories: name, family and what else its entry says. Roses pass the centre, and everything around it, in
/// ever new directions.
const TRAJECTORIES: [(&str, &str, &str); 8] = [
    (
        "circle",
        "circle",
        "amplitude_mm = 7.5\nphase_deg = 0\ndirection = \"counter_clockwise\"\nperiod_s = 8",
    ),
    ("circle-back", "circle", "amplitude_mm = 6\nphase_deg = 90\ndirection = \"clockwise\"\nperiod_s = 10"),
    (
        "square",
        "square",
        "amplitude_mm = 8\norientation_deg = 45\ndirection = \"counter_clockwise\"\nperiod_s = 10",
    ),
    ("diamond", "square", "amplitude_mm = 7\norientation_deg = 0\ndirection = \"clockwise\"\nperiod_s = 12"),
    ("rose-slow", "rose", "amplitude_mm = 8\nswings = 0.6\norientation_deg = 20\nperiod_s = 9"),
    ("rose", "rose", "amplitude_mm = 8\nswings = 1.6\norientation_deg = 70\nperiod_s = 12"),
    ("rose-back", "rose", "amplitude_mm = 7\nswings = 1.3\norientation_deg = 110\nperiod_s = 11"),
    ("diagonal", "sinusoid", "amplitude_mm = 7\norientation_deg = 45\nperiod_s = 8"),
];
/// Those that a scene is fitted to.
const FITTED: [&str; 3] = ["circle", "square", "rose"];
/// Options of the fit: the scene does not know where the tip rests.
const FIT: [&str; 8] = [
    "--fit",
    "zero,compliance,sheath_exponent,backlash,gravity,tracker",
    "--frame",
    "trust",
    "--step-mm",
    "0.2",
    "--every-mm",
    "0.4",
];

/// Plan of the calibrated twin in addition: its tip along curves drawn from ranges, as far out as the
/// recordings go and back. Family, how many, and what else.
const SYNTHETIC: [(&str, u32, &str); 4] = [
    ("rose", 48, "swings = [0.4, 2.4]"),
    ("circle", 12, ""),
    ("square", 24, ""),
    ("ellipse", 18, "aspect = [0.2, 0.8]"),
];

/// How much is done for a robot.
struct Effort {
    robots: u64,
    targets: &'static [&'static str],
    /// Steps of an evaluation of the fit.
    steps: &'static str,
    /// At most so many epochs of the twin's network, and of the inverse networks.
    twin_epochs: Option<&'static str>,
    inverse_epochs: &'static str,
}

const FULL: Effort =
    Effort { robots: ROBOTS, targets: &TARGETS, steps: "1500", twin_epochs: None, inverse_epochs: "90" };
/// Shows that it runs.
const QUICK: Effort =
    Effort { robots: 1, targets: &["circle:40"], steps: "300", twin_epochs: Some("3"), inverse_epochs: "3" };

/// One robot: for every path what each method came to, none where the rig would not carry the strokes out; or why there
/// is nothing.
struct Robot {
    name: String,
    found: Result<Vec<Row>, String>,
}

type Row = [Option<Followed>; METHODS.len()];

/// Runs the study on `robots` members from `first` on, or on all that are left; quick: one robot, one path, few steps
/// and epochs.
///
/// # Errors
/// The program cannot be built, or refusals of the file system.
pub fn run(folder: &Path, quick: bool, (first, robots): (u64, Option<u64>)) -> Result<()> {
    let effort = if quick { QUICK } else { FULL };
    let last = robots.map_or(effort.robots.max(first), |robots| first.saturating_add(robots) - 1);
    let mut all = Vec::new();
    for member in first..=last {
        let name = format!("wide/{member}");
        eprintln!("{name}");
        let found = known_from_recordings(&folder.join(name.replace('/', "-")), &name, &effort);
        all.push(Robot { found: found.map_err(|error| format!("{error:#}")), name });
        // After every robot, so that a study that is stopped has reported its results.
        print(&all, effort.targets);
        write_metrics(
            folder,
            "population",
            json!({ "robots": all.iter().map(|one| json_of(one, effort.targets)).collect::<Vec<_>>() }),
        )?;
    }
    Ok(())
}

/// The whole procedure on one robot.
fn known_from_recordings(folder: &Path, name: &str, effort: &Effort) -> Result<Vec<Row>> {
    let (chain, rig) = (Chain::new(folder)?, format!("virtual:{name}"));
    let nominal = nominal_scene(&chain)?;
    chain.record(name, &write_recorded_plan(&chain)?, "data")?;
    let recordings = chain.training_recordings()?;
    let fitted = fit(&chain, &nominal, effort.steps)?;
    chain.calibrate("twin", &fitted, &recordings, 1, effort.twin_epochs)?;
    let twin = chain.path("twin-1.safetensors")?;
    let mut both = recordings.clone();
    both.push(chain.generate(&fitted, &twin, &synthetic_plan(), "synthetic")?);
    let options = ["--epochs", effort.inverse_epochs];
    let recorded = chain.train_inverse("recorded", &recordings, &options)?;
    let hybrid = chain.train_inverse("hybrid", &both, &options)?;
    let steered = |scene, model| Strokes { scene: Some(scene), model };
    let methods: [Strokes; METHODS.len()] = [
        steered(nominal.as_str(), None),
        steered(fitted.as_str(), None),
        Strokes { scene: None, model: Some(&recorded) },
        steered(fitted.as_str(), Some(&twin)),
        Strokes { scene: None, model: Some(&hybrid) },
    ];
    let follow = |target: &&str| {
        let mut row: Row = [None; METHODS.len()];
        for (k, (cell, method)) in row.iter_mut().zip(methods).enumerate() {
            let name = format!("tracked/{k}-{}", target.replace(':', ""));
            *cell = chain
                .track(&rig, method, target, [1, 1], &name)?
                .and_then(|repeats| repeats.first().copied());
        }
        Ok(row)
    };
    effort.targets.iter().map(follow).collect()
}

/// The scene of every robot before its recordings are looked at.
fn nominal_scene(chain: &Chain) -> Result<String> {
    let mesh = Path::new(env!("CARGO_MANIFEST_DIR")).join("../meshes/tpu80/tpu80.msh").canonicalize()?;
    let mesh = format!("file = {:?}", mesh.display().to_string());
    let lines = [&NOMINAL.1[..], &[("file = \"tpu80.msh\"", &mesh)]].concat();
    chain.write_changed(NOMINAL.0, &lines, "nominal.toml")
}

/// Fits the nominal scene to some of the recordings.
fn fit(chain: &Chain, nominal: &str, steps: &str) -> Result<String> {
    let out = chain.path("fitted.toml")?;
    let recordings =
        FITTED.iter().map(|name| chain.path(&format!("data/{name}.parquet"))).collect::<Result<Vec<_>>>()?;
    let mut arguments = vec!["fit-material", nominal];
    arguments.extend(recordings.iter().map(String::as_str));
    arguments.extend(FIT);
    arguments.extend(["--steps", steps, "--out", &out]);
    chain.once(&out, &arguments)?;
    Ok(out)
}

/// Writes the plan of what is recorded of a robot; gives its path.
///
/// # Errors
/// Refusals of the file system.
pub fn write_recorded_plan(chain: &Chain) -> Result<String> {
    let path = chain.path("plan.toml")?;
    file::write_bytes(Path::new(&path), recorded_plan())?;
    Ok(path)
}

fn recorded_plan() -> String {
    let entry = |(name, family, own): &(&str, &str, &str)| {
        format!(
            "\n[[trajectory]]\nname = \"{name}\"\nrole = \"training\"\nfamily = \"{family}\"\n{own}\n\
             attack_s = 5\nsustain_s = 10\ndecay_s = 5\n"
        )
    };
    RECORDED.to_owned() + &TRAJECTORIES.iter().map(entry).collect::<String>()
}

/// The plan of the calibrated twin.
fn synthetic_plan() -> String {
    let mut text = RECORDED.replace("name = \"population\"", "name = \"synthetic\"\nspace = \"tip\"");
    text = text.replace("stroke_max_mm = 9", "stroke_max_mm = 12");
    for (family, count, own) in SYNTHETIC {
        text += &format!(
            "\n[[draw]]\nname = \"{family}\"\nrole = \"training\"\nfamily = \"{family}\"\ncount = {count}\n{own}\n\
             amplitude_mm = [10, 28]\nperiod_s = [9, 18]\nattack_s = 8\nsustain_s = 32\ndecay_s = 20\n"
        );
    }
    text
}

fn json_of(robot: &Robot, targets: &[&str]) -> Value {
    let method = |(method, cell): (&&str, &Option<Followed>)| to_json("method", method, cell.as_ref());
    let path = |(target, row): (&&str, &Row)| json!({ "target": target, "methods": METHODS.iter().zip(row).map(method).collect::<Vec<_>>() });
    match &robot.found {
        Ok(rows) => {
            json!({ "robot": robot.name, "paths": targets.iter().zip(rows).map(path).collect::<Vec<_>>() })
        }
        Err(why) => json!({ "robot": robot.name, "failed": why }),
    }
}

/// For each method a line per robot, and one for their mean: the mean over the paths of every number.
fn print(robots: &[Robot], targets: &[&str]) {
    println!("mean of {}", targets.join(", "));
    let mut cells = vec![vec![HEADING.to_owned()]];
    cells[0].extend(METHODS.map(str::to_owned));
    for robot in robots {
        cells.push(match &robot.found {
            Ok(rows) => line(&robot.name, rows),
            Err(why) => {
                let first = why.lines().next().unwrap_or_default();
                println!("{} failed: {first}", robot.name);
                [vec![robot.name.clone()], vec!["failed".to_owned(); METHODS.len()]].concat()
            }
        });
    }
    let all: Vec<Row> =
        robots.iter().filter_map(|robot| robot.found.as_ref().ok()).flatten().copied().collect();
    cells.push(line("all", &all));
    print_cells(&cells);
}

fn line(name: &str, rows: &[Row]) -> Vec<String> {
    let cell = |method: usize| means(&rows.iter().map(|row| row[method]).collect::<Vec<_>>());
    std::iter::once(name.to_owned()).chain((0..METHODS.len()).map(cell)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_base::Scene;
    use hysteron_control::Plan;

    #[test]
    fn plans_are_valid_and_the_nominal_scene_knows_no_robot() {
        let plan = Plan::from_toml(&recorded_plan(), "plan").expect("a good plan");
        assert_eq!(plan.trajectories().len(), TRAJECTORIES.len());
        Plan::from_toml(&synthetic_plan(), "plan").expect("a good plan");
        let folder = std::env::temp_dir().join(format!("hysteron-population-{}", std::process::id()));
        let text = NOMINAL.1.iter().fold(NOMINAL.0.to_owned(), |text, (from, to)| {
            assert!(text.contains(from), "{from}");
            text.replace(from, to)
        });
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(folder.join("nominal.toml"), text).expect("a file");
        std::fs::copy(
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../meshes/tpu80/tpu80.msh"),
            folder.join("tpu80.msh"),
        )
        .expect("a mesh");
        let scene = Scene::read(folder.join("nominal.toml")).expect("a good scene");
        std::fs::remove_dir_all(&folder).expect("its removal");
        assert!(scene.tendons.iter().all(|tendon| tendon.zero == 0.0 && tendon.compliance == 2e-5));
    }

    #[test]
    fn a_robot_that_failed_is_told_and_does_not_count() {
        let one = |nrmse_percent| {
            Some(Followed { nrmse_percent, iou: 0.9, aligned_rmse_mm: Some(1.0), lag_ms: Some(50.0) })
        };
        let mut rows = [[one(2.0); METHODS.len()]; 2];
        rows[1] = [one(1.0), None, one(1.0), one(1.0), one(1.0)];
        rows[0][1] = None;
        let cells = line("a", &rows);
        assert_eq!(cells[..4], ["a", "1.50, 0.900, 1.00, 50", "-", "1.50, 0.900, 1.00, 50"]);
        let failed = Robot { name: "b".to_owned(), found: Err("a stage".to_owned()) };
        assert_eq!(json_of(&failed, &TARGETS)["failed"], "a stage");
    }
}
