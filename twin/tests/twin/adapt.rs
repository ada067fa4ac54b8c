//! A twin finds how its robot has changed, and nothing where it has not.

use hysteron_base::{Channel, Metadata, Recording, rng};
use hysteron_learn::{Architecture, ChannelRange, HeadActivation, Network, Normaliser};
use hysteron_twin::coreact::AuxiliaryLimits;
use hysteron_twin::residual::{
    AdaptMotions, AdaptOptions, Adapted, AdaptedParts, CorrectedRollout, ResidualDesign, ResidualModel,
    ResidualTraining, RobotChange, adapt, n_samples,
};
use hysteron_twin::{Plant, RobotMotion, Twin};
use rand::RngExt;

use super::scenes;

const STEP: f64 = 0.01;
/// The tracker of these tests is off by this much along every axis, and has this much noise [m].
const ASIDE: f64 = 1.5e-4;
const NOISE: f64 = 2e-5;

fn twin() -> Twin {
    let (mut scene, mesh) = scenes::actuated(4);
    scenes::roughen(&mut scene, 2e-4);
    Twin::new(&scene, &mesh).expect("a good scene")
}

/// A network whose outputs are all zero.
fn silent(twin: &Twin, auxiliary: &AuxiliaryLimits) -> ResidualModel {
    let architecture = Architecture {
        inputs: twin.n_primary + 3,
        hidden: 2,
        layers: 1,
        outputs: auxiliary.len(),
        head: HeadActivation::Linear,
        dropout: 0.0,
    };
    let ranges = |n: usize, half: f64| {
        let channel = |k: usize| ChannelRange { name: format!("channel_{k}"), min: -half, max: half };
        Normaliser::new((0..n).map(channel).collect()).unwrap()
    };
    ResidualModel {
        network: Network::new(&architecture, 1).unwrap(),
        inputs: ranges(architecture.inputs, 1.0),
        outputs: ranges(architecture.outputs, 0.0),
        design: ResidualDesign::Windowed { window: 1 },
        n_aux: auxiliary.len(),
        step_s: STEP,
        scene_hash: "00".into(),
        change: None,
        adaptation: None,
        training: ResidualTraining::default(),
    }
}

/// Strokes of three motions: a circle and two lines.
fn strokes(motion: usize, i: usize) -> [f64; 4] {
    let (sin, cos) = (0.04 * i as f64).sin_cos();
    let [a, b] = [[cos, sin], [cos, 0.4 * cos], [-0.5 * sin, sin]][motion];
    let ramp = 1.2e-3 * (i as f64 / 60.0).min(1.0);
    [a * ramp, b * ramp, -a * ramp, -b * ramp]
}

/// Recordings of a tracker, of a robot that is the twin with a change.
fn motions(twin: &Twin, auxiliary: &AuxiliaryLimits, change: &RobotChange) -> Vec<RobotMotion> {
    let robot = ResidualModel { change: Some(change.clone()), ..silent(twin, auxiliary) };
    let motion = |m: usize| {
        let mut rollout = CorrectedRollout::new(twin, auxiliary, &robot, STEP).unwrap();
        let mut stream = rng(m as u64, "adapt/noise");
        let mut columns = vec![Vec::new(); 7];
        let n = 400;
        for i in 0..n {
            let tip = rollout.step(&strokes(m, i)).unwrap().tip;
            let seen = tip.map(|c| c + ASIDE + NOISE * stream.random_range(-1.7..1.7));
            for (column, value) in columns.iter_mut().zip(strokes(m, i).iter().chain(&seen)) {
                column.push(*value);
            }
        }
        let names = ["stroke_1_m", "stroke_2_m", "stroke_3_m", "stroke_4_m", "tip_x_m", "tip_y_m", "tip_z_m"];
        let channels =
            names.into_iter().zip(columns).map(|(name, values)| Channel::new(name, values)).collect();
        let time = (0..n).map(|i| STEP * i as f64).collect();
        let recording = Recording::new(time, channels, Vec::new(), Metadata::default()).unwrap();
        RobotMotion::for_identification(twin, &recording, &format!("motion-{m}")).unwrap()
    };
    (0..3).map(motion).collect()
}

fn adapted(change: &RobotChange) -> Adapted {
    adapted_from(None, change)
}

/// Of a robot that had a change `before` already, which its twin does not know.
fn adapted_from(before: Option<&RobotChange>, change: &RobotChange) -> Adapted {
    let twin = twin();
    let auxiliary = AuxiliaryLimits::new(&twin).unwrap();
    let now = motions(&twin, &auxiliary, change);
    let before = before.map_or(Vec::new(), |before| motions(&twin, &auxiliary, before));
    let motions = AdaptMotions { now: &now, before: &before };
    let n_done = std::sync::atomic::AtomicUsize::new(0);
    let on_sample = || {
        n_done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        true
    };
    let model = silent(&twin, &auxiliary);
    let found =
        adapt(&twin, &auxiliary, &model, motions, &AdaptOptions::default(), &on_sample).unwrap().unwrap();
    assert!(n_done.into_inner() <= n_samples(&twin, motions));
    println!("{:?} {:?} {:?}", found.kept, found.held_out_m, found.found);
    found
}

#[test]
fn a_robot_that_has_not_changed_keeps_its_twin() {
    let found = adapted(&RobotChange::none(4));
    assert_eq!(found.kept, AdaptedParts::Nothing);
    assert_eq!(found.model.change, None);
    assert!(found.motions.iter().all(|motion| motion.before_m == motion.after_m));
}

#[test]
fn an_error_that_the_twin_had_before_is_no_change_of_the_robot() {
    // The twin is wrong by this from the beginning, and a change would make up for it.
    let own = RobotChange { zeros_m: vec![0.0, -4e-4, 0.0, 0.0], ..RobotChange::none(4) };
    let found = adapted_from(Some(&own), &own);
    assert_eq!((found.kept, &found.model.change), (AdaptedParts::Nothing, &None));
    // The same motion and noise before and after.
    assert!((found.known_error_m.unwrap() / found.held_out_m[0].1 - 1.0).abs() < 1e-9);
    let more = RobotChange { zeros_m: vec![0.0, -9e-4, 0.0, 0.0], ..RobotChange::none(4) };
    assert_eq!(adapted_from(Some(&own), &more).kept, AdaptedParts::Change);
}

#[test]
fn slack_and_play_of_a_changed_robot_are_made_up_for() {
    let changes = [
        RobotChange { zeros_m: vec![0.0, -4e-4, 0.0, 0.0], ..RobotChange::none(4) },
        RobotChange { play_m: 3e-4, ..RobotChange::none(4) },
    ];
    for change in changes {
        let found = adapted(&change);
        assert_eq!(found.kept, AdaptedParts::Change, "{change:?}");
        assert!(found.model.change.is_some());
        // Zeros and play are not asked for one by one: slack, pull of the other tendons and play show much the same
        // at the tip.
        let length = |errors: Vec<f64>| errors.iter().map(|e| e * e).sum::<f64>().sqrt();
        let before = length(found.motions.iter().map(|motion| motion.before_m).collect());
        let after = length(found.motions.iter().map(|motion| motion.after_m).collect());
        assert!(after < 0.7 * before, "{change:?}: {before} {after}");
    }
}

#[test]
fn a_change_stays_in_its_file_and_one_of_another_robot_is_refused() {
    let twin = twin();
    let auxiliary = AuxiliaryLimits::new(&twin).unwrap();
    let first = RobotChange { zeros_m: vec![1e-4, 0.0, 0.0, 0.0], play_m: 1e-4, friction_ratio: 1.2 };
    let model = ResidualModel { change: Some(first.clone()), ..silent(&twin, &auxiliary) };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("changed.safetensors");
    model.write(&path).unwrap();
    assert_eq!(ResidualModel::read(&path).unwrap().change, Some(first));
    let bad = ResidualModel { change: Some(RobotChange::none(3)), ..model };
    bad.write(&path).unwrap();
    let refusal = ResidualModel::read(&path).unwrap_err().to_string();
    assert!(refusal.contains("change.zeros_m"), "{refusal}");
}
