//! The one conversion from what was typed to what is valid; reads everything that a study names, before anything runs.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use hysteron_base::schema::{between, check_header, count, text};
use hysteron_base::size::check_at_most;
use hysteron_base::{BadInput, Scene, file};
use hysteron_control::plan::{Trajectory, TrajectoryRole};
use hysteron_control::{MotionPlan, TargetPath};
use hysteron_learn::{MAX_EPOCHS, MAX_HIDDEN};
use hysteron_twin::Twin;
use hysteron_twin::coreact::AuxiliaryLimits;
use hysteron_twin::fit::{FitParameter, select};

use super::definition::{PlanChoice, Rig, SceneChoice, Study, Target, Track};
use super::method::Method;
use super::schema;
use super::stage::Argument;
use hysteron_workflow::rig::record::jobs::check_against_rig;
use hysteron_workflow::rig::record::source::Source;
use hysteron_workflow::shared::paths::plain;
use hysteron_workflow::shared::plan;
use hysteron_workflow::tendon::fit_material::MAX_STEPS;
use hysteron_workflow::tendon::fit_residual::MAX_MEMBERS;
use hysteron_workflow::tendon::identify::MAX_ROUNDS;

const FORMAT: (&str, i64) = ("hysteron-study", 1);
/// More than any study has; keeps a slip of the hand from running for a year.
const MAX_REPEATS: i64 = 100;
const MAX_TARGETS: usize = 1000;

impl Study {
    /// Reads and validates a study file, and everything that it names.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let text = file::read_text(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        valid(&text, folder).with_context(|| path.display().to_string())
    }
}

fn valid(text: &str, folder: &Path) -> anyhow::Result<Study> {
    let typed: schema::StudyFile = hysteron_base::schema::parse(text)?;
    check_header((&typed.format, typed.version), FORMAT)?;
    check_numbers(&typed)?;
    check_parts(&typed)?;
    let name = folder_name("name", &typed.name)?;
    let (rig, source) = rig(&typed.rig, folder).context("rig")?;
    let (choice, recorded) = named_plan(&typed.plan, folder).context("plan")?;
    check_against_rig(&recorded, &source).context("plan")?;
    if typed.residual.is_some() || typed.train.is_some() {
        enough(&choice, &recorded)?;
    }
    let scene = scene(&typed, folder, &source).context("scene")?;
    if let Some(calibrate) = &typed.calibrate {
        check_calibration(calibrate, &recorded, &scene.1)?;
    }
    let generate = typed.generate.map(|typed| generate(&typed, folder, &recorded, &scene.1)).transpose()?;
    let track = typed.track.map(|typed| track(typed, folder, &recorded)).transpose()?;
    Ok(Study {
        name,
        seed: typed.seed,
        rig,
        plan: choice,
        scene: scene.0,
        calibrate: typed.calibrate,
        identify: typed.identify,
        residual: typed.residual,
        generate,
        train: typed.train,
        track,
    })
}

/// A name that can be one of a folder on any system.
fn folder_name(key: &str, typed: &str) -> Result<String, BadInput> {
    let is_one = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if typed.is_empty() || typed.len() > 100 || !typed.chars().all(is_one) {
        return Err(BadInput::new(key, "a name of letters, digits, - and _", format!("{typed:?}")));
    }
    Ok(typed.to_owned())
}

fn check_numbers(typed: &schema::StudyFile) -> Result<(), BadInput> {
    let calibrate = typed.calibrate.as_ref();
    let (identify, residual, train) =
        (typed.identify.as_ref(), typed.residual.as_ref(), typed.train.as_ref());
    let whole = [
        ("calibrate.steps", calibrate.and_then(|it| it.steps), MAX_STEPS),
        ("identify.rounds", identify.and_then(|it| it.rounds), MAX_ROUNDS),
        ("residual.epochs", residual.and_then(|it| it.epochs), MAX_EPOCHS),
        ("residual.hidden", residual.and_then(|it| it.hidden), MAX_HIDDEN),
        ("residual.members", residual.and_then(|it| it.members), MAX_MEMBERS),
        ("train.epochs", train.and_then(|it| it.epochs), MAX_EPOCHS),
        ("train.hidden", train.and_then(|it| it.hidden), MAX_HIDDEN),
    ];
    for (key, value, most) in whole {
        value.map(|value| count(key, value, most as i64)).transpose()?;
    }
    residual.and_then(|it| it.passes).map(|passes| count("residual.passes", passes, 2)).transpose()?;
    let lengths = [
        ("calibrate.step_mm", calibrate.and_then(|it| it.step_mm)),
        ("calibrate.every_mm", calibrate.and_then(|it| it.every_mm)),
    ];
    for (key, value) in lengths {
        value.map(|value| between(key, value, [1e-9, 1e6])).transpose()?;
    }
    Ok(())
}

/// Refuses a section that needs another one which is missing.
fn check_parts(typed: &schema::StudyFile) -> Result<(), BadInput> {
    let has = |method: Method| typed.track.as_ref().is_some_and(|track| track.methods.contains(&method));
    let needs = [
        ("residual", typed.residual.is_some(), "identify", typed.identify.is_some()),
        ("generate", typed.generate.is_some(), "residual", typed.residual.is_some()),
        ("generate", typed.generate.is_some(), "train", typed.train.is_some()),
        ("track.methods: twin", has(Method::Twin), "residual", typed.residual.is_some()),
        ("track.methods: network", has(Method::Network), "train", typed.train.is_some()),
    ];
    match needs.into_iter().find(|(_, is_there, _, is_satisfied)| *is_there && !is_satisfied) {
        None => Ok(()),
        Some((place, _, missing, _)) => {
            Err(BadInput::new(place, format!("a section [{missing}] in the study file"), "none"))
        }
    }
}

/// A path in the study file, from the current folder.
fn resolved(folder: &Path, typed: &str) -> PathBuf {
    plain(&folder.join(typed))
}

fn rig(typed: &str, folder: &Path) -> anyhow::Result<(Rig, Source)> {
    let argument = match typed.strip_prefix("virtual:") {
        None => Argument::file(&resolved(folder, typed)),
        Some(robot) => {
            let (base, member) =
                robot.rsplit_once('/').filter(|(base, _)| base.ends_with(".toml")).unwrap_or((robot, ""));
            if base.ends_with(".toml") {
                let path = resolved(folder, base);
                let member = if member.is_empty() { String::new() } else { format!("/{member}") };
                let file = Argument::file(&path);
                Argument {
                    typed: format!("virtual:{}{member}", file.typed),
                    key: format!("virtual:{}{member}", file.key),
                    reads: file.reads,
                }
            } else {
                Argument::word(text("rig", typed.to_owned())?)
            }
        }
    };
    let source = Source::read(Path::new(&argument.typed))?;
    let rig = Rig {
        argument,
        description: source.description(),
        is_virtual: matches!(source, Source::Virtual { .. }),
        first_angle: source.rig().tendons.first().map_or(0.0, |tendon| tendon.angle),
    };
    Ok((rig, source))
}

fn named_plan(typed: &str, folder: &Path) -> anyhow::Result<(PlanChoice, MotionPlan)> {
    let argument = match Path::new(typed).extension() {
        Some(_) => Argument::file(&resolved(folder, typed)),
        None => Argument::word(typed),
    };
    let (plan, _) = plan::read(&argument.typed)?;
    let of = |is_training: bool| {
        let chosen =
            plan.trajectories().iter().filter(|one| (one.role == TrajectoryRole::Training) == is_training);
        chosen.map(|one: &Trajectory| (one.name.clone(), one.n_samples())).collect()
    };
    Ok((PlanChoice { argument, training: of(true), checks: of(false) }, plan))
}

/// A plan for the twin, whose recordings are added to those of the rig.
fn generate(
    typed: &schema::Generate,
    folder: &Path,
    recorded: &MotionPlan,
    scene: &Scene,
) -> anyhow::Result<PlanChoice> {
    const KEY: &str = "generate.plan";
    let (choice, more) = named_plan(&typed.plan, folder).context(KEY)?;
    plan::check_tendons(&more, &plan::angles_of(scene), &format!("scene {}", scene.name)).context(KEY)?;
    let names: Vec<&str> = recorded.trajectories().iter().map(|one| one.name.as_str()).collect();
    for one in more.trajectories() {
        check_rate(KEY, one.rate_hz, recorded)?;
        if names.contains(&one.name.as_str()) {
            let found = format!("\"{}\" again", one.name);
            return Err(BadInput::new(KEY, "trajectories of other names than those of plan", found).into());
        }
    }
    Ok(choice)
}

/// Checks that all recorded trajectories have this rate [Hz]: a network is valid only at its training rate.
fn check_rate(place: &str, rate_hz: f64, recorded: &MotionPlan) -> Result<(), BadInput> {
    match recorded.trajectories().iter().find(|one| one.rate_hz != rate_hz) {
        None => Ok(()),
        Some(one) => {
            let expected = format!("rate_hz = {}, as plan {} has", one.rate_hz, recorded.name);
            Err(BadInput::new(place, expected, rate_hz.to_string()))
        }
    }
}

/// A network stops by a trajectory that it does not learn from.
fn enough(choice: &PlanChoice, plan: &MotionPlan) -> Result<(), BadInput> {
    if choice.training.len() >= 2 {
        return Ok(());
    }
    let found = format!("{} in plan {}", choice.training.len(), plan.name);
    Err(BadInput::new("plan", "at least two trajectories for training", found)
        .hint("a network learns from some and stops by the others"))
}

fn scene(typed: &schema::StudyFile, folder: &Path, source: &Source) -> anyhow::Result<(SceneChoice, Scene)> {
    let path = resolved(folder, &typed.scene);
    let scene = Scene::read(&path)?;
    check_tendons(&scene, source)?;
    let twin = Twin::from_scene(&scene)?;
    if typed.identify.is_some() {
        AuxiliaryLimits::new(&twin)?;
    }
    let choice = SceneChoice {
        mesh: plain(&scene.mesh_path),
        reduced: scene.reduced_path.as_deref().map(plain),
        path,
        robot: scene.name.clone(),
    };
    Ok((choice, scene))
}

/// Refuses a scene whose tendons run elsewhere than the rig's.
fn check_tendons(scene: &Scene, source: &Source) -> Result<(), BadInput> {
    let shown = |angles: Vec<f64>| {
        angles.iter().map(|angle| format!("{:.0}", angle.to_degrees())).collect::<Vec<_>>().join(", ")
    };
    let rig = source.rig().tendons.iter().map(|tendon| tendon.angle.rem_euclid(TAU)).collect();
    let [rig, scene] = [rig, plan::angles_of(scene)].map(shown);
    if rig == scene {
        return Ok(());
    }
    let expected = format!("tendons at {rig} deg, as rig \"{}\" has", source.rig().name);
    Err(BadInput::new("tendon", expected, format!("at {scene} deg")))
}

fn check_calibration(typed: &schema::Calibrate, plan: &MotionPlan, scene: &Scene) -> anyhow::Result<()> {
    let names: Vec<&str> = plan.trajectories().iter().map(|one| one.name.as_str()).collect();
    let unknown = typed.recordings.iter().find(|name| !names.contains(&name.as_str()));
    let found = match (unknown, typed.recordings.is_empty()) {
        (None, false) => None,
        (None, true) => Some("none".to_owned()),
        (Some(unknown), _) => Some(format!("\"{unknown}\"")),
    };
    if let Some(found) = found {
        return Err(BadInput::new("calibrate.recordings", format!("of {}", names.join(", ")), found).into());
    }
    let fit: Vec<_> = typed.fit.iter().map(FitParameter::named).collect();
    select(scene, &fit).context("calibrate.fit")?;
    Ok(())
}

fn track(typed: schema::Track, folder: &Path, recorded: &MotionPlan) -> anyhow::Result<Track> {
    let repeats = count("track.repeats", typed.repeats, MAX_REPEATS)?;
    check_at_most("track.targets", typed.targets.len(), MAX_TARGETS)?;
    let mut methods: Vec<Method> = Vec::new();
    for method in typed.methods {
        if methods.contains(&method) {
            return Err(
                BadInput::new("track.methods", "each once", format!("\"{}\" again", method.name())).into()
            );
        }
        methods.push(method);
    }
    let mut targets: Vec<Target> = Vec::new();
    for (k, named) in typed.targets.iter().enumerate() {
        let key = format!("track.targets[{}]", k + 1);
        let target = target(named, folder).with_context(|| key.clone())?;
        if methods.iter().any(|method| !matches!(method, Method::Nominal | Method::Scene)) {
            check_rate(&key, target.path.rate_hz, recorded)?;
        }
        if targets.iter().any(|earlier| earlier.name == target.name) {
            return Err(
                BadInput::new(key, "a target of another name", format!("\"{}\" again", target.name)).into()
            );
        }
        targets.push(target);
    }
    for (key, n) in [("track.methods", methods.len()), ("track.targets", targets.len())] {
        if n == 0 {
            return Err(BadInput::new(key, "at least one", "none").into());
        }
    }
    Ok(Track { targets, methods, repeats })
}

fn target(typed: &str, folder: &Path) -> anyhow::Result<Target> {
    let has_ending =
        ["toml", "svg", "csv", "parquet"].map(|it| Path::new(typed).extension().is_some_and(|e| e == it));
    let (argument, name) = if has_ending.contains(&true) {
        let path = resolved(folder, typed);
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        (Argument::file(&path), stem)
    } else {
        (Argument::word(typed), typed.replace(':', "-"))
    };
    let path = TargetPath::open(&argument.typed)?;
    let name: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    Ok(Target { argument, name, path })
}
