//! The run of `study ablation`.

use anyhow::Result;
use hysteron_workflow::{Context, WorkflowError};
use rayon::prelude::*;

use super::outcome::{AblatedRobot, AblationMetrics, AblationPath, LEVELS, LevelResult};
use crate::tendon::commands::{ChainCommands, FRICTION, Strokes};
use crate::tendon::path_following::{Followed, FollowedKeys};
use crate::tendon::{Options, Outcome, session};

const PRESETS: [&str; 3] = ["mild", "typical", "harsh"];
/// Members of the population around `typical`.
const MEMBERS: u64 = 10;
const TARGETS: [&str; 3] = ["circle:50", "diamond:60", "lissajous:56"];
/// The path that the last ablation level is fitted to.
const WATCHED: &str = "square:40";

/// The paper's network, on the presets only: every hundredth sample ends a window, and 16 are a step. Every one of
/// them, as published, would be eight hours a robot.
const PAPER: [&str; 6] = ["--design", "paper", "--stride", "100", "--batch", "16"];

/// Plan of the calibrated twin in addition to the recorded minute: five minutes, twice as far.
const SYNTHETIC: &str = r#"format = "hysteron-plan"
version = 1
name = "ladder"
seed = 1
rate_hz = 100
tendon_angles_deg = [0, 90, 180, 270]
release = 1.0
rest_before_s = 1.3
rest_after_s = 2
stroke_max_mm = 15
stroke_rate_max_mm_s = 12
"#;
/// Families of it: kind and the other keys of its entry.
const FAMILIES: [(&str, &str); 3] =
    [("circle", ""), ("rose", "swings = [0.4, 1.6]\n"), ("square", "orientation_deg = [45, 45]\n")];

/// One robot: for every target the result of each ablation level; none where the rig would not follow the
/// strokes.
struct Robot {
    name: String,
    found: Vec<[Option<Followed>; LEVELS.len()]>,
}

impl Robot {
    fn result(&self, targets: &[&str]) -> AblatedRobot {
        let level = |(level, found): (&&str, &Option<Followed>)| LevelResult {
            level: (*level).to_owned(),
            followed: FollowedKeys::of(found.as_ref()),
        };
        let paths = targets.iter().zip(&self.found).map(|(target, found)| AblationPath {
            target: (*target).to_owned(),
            rungs: LEVELS.iter().zip(found).map(level).collect(),
        });
        AblatedRobot { robot: self.name.clone(), paths: paths.collect() }
    }
}

/// Runs the study; quick: one robot, one target.
///
/// # Errors
/// A command fails, or an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome<AblationMetrics>, WorkflowError> {
    session::run("ablation", &options.out, context, || measure(options, context))
}

fn measure(options: &Options, context: &Context) -> Result<AblationMetrics> {
    let members = (1..=MEMBERS).map(|member| format!("typical/{member}"));
    let names: Vec<String> = PRESETS.iter().map(|preset| (*preset).to_owned()).chain(members).collect();
    let (names, targets) =
        if options.quick { (&names[..1], &TARGETS[..1]) } else { (&names[..], &TARGETS[..]) };
    let one = |name: &String| {
        let folder = options.out.join(name.replace('/', "-"));
        ablate(&ChainCommands::new(&folder, &options.repository, context)?, name, targets)
    };
    let robots = names.par_iter().map(one).collect::<Result<Vec<Robot>>>()?;
    Ok(AblationMetrics { robots: robots.iter().map(|robot| robot.result(targets)).collect() })
}

/// All ablation levels on one robot.
fn ablate(chain: &ChainCommands<'_>, name: &str, targets: &[&str]) -> Result<Robot> {
    let (rig, scene) = (format!("virtual:{name}"), &chain.scene_path(FRICTION.1));
    chain.record(name, "quick", "data")?;
    let recordings = chain.training_recordings()?;
    chain.calibrate("twin", FRICTION.1, &recordings, 1, None)?;
    let twin = chain.path("twin-1.safetensors")?;
    let synthetic = chain.generate(scene, &twin, &synthetic_plan(), "synthetic")?;
    let both = [&recordings[..], &[synthetic]].concat();
    let inverse = chain.train_inverse("inverse", &recordings, &[])?;
    let hybrid = chain.train_inverse("hybrid", &both, &[])?;
    let is_preset = PRESETS.contains(&name);
    let paper = if is_preset { Some(chain.train_inverse("paper", &both, &PAPER)?) } else { None };

    let steered = Strokes::Twin { scene, residual: Some(&twin) };
    let adapted = chain.path("adapted.safetensors")?;
    chain.track(&rig, steered, WATCHED, [1, 1], "watched")?;
    let watched = chain.path("watched/repeat-1.parquet")?;
    chain.once(&adapted, &["adapt", &twin, "--scene", scene, &watched, "--out", &adapted])?;
    let methods = [
        Some(Strokes::Twin { scene, residual: None }),
        Some(Strokes::Network(&inverse)),
        paper.as_deref().map(Strokes::Network),
        Some(Strokes::Network(&hybrid)),
        Some(steered),
        Some(Strokes::Twin { scene, residual: Some(&adapted) }),
    ];
    let mut found = Vec::new();
    for target in targets {
        let mut row = [None; LEVELS.len()];
        for (k, (cell, method)) in row.iter_mut().zip(methods).enumerate() {
            let name = format!("tracked/{k}-{}", target.replace(':', ""));
            let Some(method) = method else { continue };
            *cell = chain.track(&rig, method, target, [1, 1], &name)?.map(|repeats| repeats[0]);
        }
        found.push(row);
    }
    Ok(Robot { name: name.to_owned(), found })
}

/// Plan of the calibrated twin.
fn synthetic_plan() -> String {
    let mut text = SYNTHETIC.to_owned();
    for (family, own) in FAMILIES {
        text += &format!(
            "\n[[draw]]\nname = \"more-{family}\"\nrole = \"training\"\nfamily = \"{family}\"\ncount = 2\n\
             amplitude_mm = [4, 12]\nperiod_s = [12, 20]\n{own}attack_s = 8\nsustain_s = 20\ndecay_s = 20\n"
        );
    }
    text
}
