//! Parameters of a twin come back from recordings of it. Measuring and modelling are then the same program, so this
//! checks the fit and not the physics; the cantilever is checked against a closed form.

use hysteron_base::{
    Bounds, Channel, Friction, Metadata, PrescribedQuantity, Recording, Scene, TipDefinition,
};
use hysteron_fem::{Mesh, Order};
use hysteron_twin::fit::{
    FitBody, FitParameter, FitSamples, Identifiability, MaterialFit, MaterialOptions, Stepping, TipFrame,
    courses, fit_material, select,
};
use hysteron_twin::{Result, RobotMotion, Target, Twin, rollout};
use rand::RngExt;

use super::{assert_close, rng, scenes};

const STEPPING: Stepping = Stepping { step: 0.1e-3, every: 0.1e-3, most: usize::MAX };
const OPTIONS: MaterialOptions<'_> = MaterialOptions {
    frame: TipFrame::Checked,
    stepping: STEPPING,
    huber: None,
    tension_max: None,
    watch: &|_| true,
};

/// Sum of twelve even numbers less six: nearly normal, with variance one.
fn normal(rng: &mut impl RngExt) -> f64 {
    (0..12).map(|_| rng.random_range(0.0..1.0)).sum::<f64>() - 6.0
}

/// Strokes of four antagonistic tendons through a figure of eight (n rows) [m].
fn figure_of_eight(n: usize) -> Vec<[f64; 4]> {
    let row = |i: usize| {
        let angle = std::f64::consts::TAU * i as f64 / (n - 1) as f64;
        let (x, y) = (1.5e-3 * angle.sin(), 1.0e-3 * (2.0 * angle).sin());
        [x, y, -x, -y]
    };
    (0..n).map(row).collect()
}

/// A recording of the scene's twin under these strokes, with noise of `noise` on the tip [m].
fn recording(scene: &Scene, mesh: &Mesh, strokes: &[[f64; 4]], noise: f64, seed: &str) -> Recording {
    let twin = Twin::new(scene, mesh).unwrap();
    let targets: Vec<Vec<Target>> = strokes.iter().map(|row| row.map(Target::Stroke).to_vec()).collect();
    let mut rng = rng(seed);
    let mut tips = rollout(&twin, &twin.rest(), &targets).unwrap().tips;
    tips.iter_mut().flatten().for_each(|c| *c += noise * normal(&mut rng));
    record(strokes, &tips)
}

fn record(strokes: &[[f64; 4]], tips: &[[f64; 3]]) -> Recording {
    let time = (0..strokes.len()).map(|i| 0.1 * i as f64).collect();
    let mut channels: Vec<Channel> = (0..4)
        .map(|k| Channel::new(format!("stroke_{}_m", k + 1), strokes.iter().map(|row| row[k]).collect()))
        .collect();
    for (c, axis) in ["x", "y", "z"].iter().enumerate() {
        channels.push(Channel::new(format!("tip_{axis}_m"), tips.iter().map(|tip| tip[c]).collect()));
    }
    Recording::new(time, channels, vec![], Metadata::default()).unwrap()
}

fn motion(scene: &Scene, mesh: &Mesh, recording: &Recording) -> Result<RobotMotion> {
    RobotMotion::new(&Twin::new(scene, mesh).unwrap(), recording, "rec")
}

fn fitted(
    scene: &Scene,
    mesh: &Mesh,
    recording: &Recording,
    names: &[&str],
    frame: TipFrame,
) -> Result<MaterialFit> {
    let motions = [motion(scene, mesh, recording)?];
    let names: Vec<_> = names.iter().copied().map(FitParameter::named).collect();
    fit_material(
        scene,
        FitBody { mesh, chain: None },
        &motions,
        &select(scene, &names)?,
        &MaterialOptions { frame, ..OPTIONS },
    )
}

#[test]
fn zeros_are_recovered_and_the_modulus_is_not() {
    let (scene, mesh) = scenes::robot();
    let mut truth = scene.clone();
    for (tendon, zero) in truth.tendons.iter_mut().zip([0.3e-3, 0.1e-3, 0.2e-3, 0.4e-3]) {
        tendon.zero = zero;
    }
    let (sigma, strokes) = (0.02e-3, figure_of_eight(60));
    let recording = recording(&truth, &mesh, &strokes, sigma, "fit/zeros");
    let found = fitted(&scene, &mesh, &recording, &["youngs_modulus", "zero"], TipFrame::Checked).unwrap();
    let estimates = &found.fit.estimates;
    assert_eq!(estimates[0].identifiability, Identifiability::Undetermined(vec![]));
    assert_eq!(found.scene.material, scene.material);
    for (estimate, tendon) in estimates[1..].iter().zip(&truth.tendons) {
        // Four standard errors: one of four misses three in a hundred runs.
        let error = estimate.standard_error.unwrap();
        assert!(error < 0.1e-3, "{estimate:?}");
        assert_close(&estimate.name, estimate.value, tendon.zero, 4.0 * error);
    }
    // What remains is the noise, less what seven parameters of 180 take.
    assert_close("noise", found.errors[1].distance, 3f64.sqrt() * sigma, 0.2 * sigma * 3f64.sqrt());
    assert!(found.errors[0].distance > 5.0 * found.errors[1].distance);
}

#[test]
fn moved_tracker_is_refused_or_its_frame_found() {
    let (scene, mesh) = scenes::robot();
    let mut truth = scene.clone();
    truth.tendons.iter_mut().zip([0.3e-3, 0.0, 0.0, 0.2e-3]).for_each(|(tendon, zero)| tendon.zero = zero);
    let strokes = figure_of_eight(60);
    let straight = recording(&truth, &mesh, &strokes, 0.01e-3, "fit/frame");
    // A quarter turn about z and a shift.
    let [x, y, z] = straight.tip().unwrap();
    let tips: Vec<[f64; 3]> = (0..strokes.len()).map(|i| [0.02 - y[i], x[i], z[i]]).collect();
    let moved = record(&strokes, &tips);
    let error = fitted(&scene, &mesh, &moved, &["zero"], TipFrame::Checked).unwrap_err();
    assert!(error.bad_input().unwrap().hint.contains("tracker"), "{error}");
    let found = fitted(&scene, &mesh, &moved, &["zero"], TipFrame::Fitted).unwrap();
    assert!(found.errors[1].distance < 0.03e-3, "{:?}", found.errors);
    let (turn, _) = found.frame;
    // Noise of 0.01 mm over a motion of centimetres.
    assert_close("turn", turn[1][0], 1.0, 1e-3);
}

#[test]
fn cantilever_under_known_tension_gives_its_modulus() {
    // A short pull by a tendon along the whole length is an end moment M = T r, and the tip of a beam of constant
    // curvature κ = M / (E I) lies at (1 - cos κL) / κ.
    let (length, r) = (0.08, scenes::TENDON_RADIUS);
    let mesh = scenes::tube(length, scenes::OUTER, 0.0025, 20, Order::Quadratic);
    let mut scene = scenes::scene("cantilever", hysteron_base::MaterialLaw::Corotational);
    scene.tendons = vec![scenes::tendon(0, length, r, 20)];
    scene.tendons[0].drive = PrescribedQuantity::Tension;
    scene.tip = TipDefinition::Group("tip".into());
    let octagon = |radius: f64| {
        // Second moment of a regular octagon with corners on the circle.
        let a = std::f64::consts::FRAC_PI_4;
        8.0 * radius.powi(4) * a.sin() * (2.0 + a.cos()) / 24.0
    };
    let (modulus, second_moment) = (8e6, octagon(scenes::OUTER) - octagon(0.0025));
    let tensions: Vec<f64> = (0..12).map(|i| 0.02 * f64::from(i)).collect();
    let tip = |tension: f64| {
        let curvature = tension * r / (modulus * second_moment);
        let angle = curvature * length;
        if angle == 0.0 {
            [0.0, 0.0, length]
        } else {
            [(1.0 - angle.cos()) / curvature, 0.0, angle.sin() / curvature]
        }
    };
    let column = |c: usize| tensions.iter().map(|t| tip(*t)[c]).collect();
    let channels = vec![
        Channel::new("tension_1_n", tensions.clone()),
        Channel::new("tip_x_m", column(0)),
        Channel::new("tip_y_m", column(1)),
        Channel::new("tip_z_m", column(2)),
    ];
    let time = (0..12).map(f64::from).collect();
    let recording = Recording::new(time, channels, vec![], Metadata::default()).unwrap();
    let twin = Twin::new(&scene, &mesh).unwrap();
    let motions = [RobotMotion::new(&twin, &recording, "rec").unwrap()];
    assert_eq!(motions[0].axes, [true, false, true]);
    let selected = select(&scene, &[FitParameter::named("youngs_modulus")]).unwrap();
    let stepping = Stepping { step: 1e-6, every: 1e-6, ..STEPPING };
    let options = MaterialOptions { stepping, ..OPTIONS };
    let found =
        fit_material(&scene, FitBody { mesh: &mesh, chain: None }, &motions, &selected, &options).unwrap();
    // Beam theory: the clamp hinders the section over one radius, r / L = 7 % of it hindered by ν² = 16 %.
    assert_close("modulus", found.fit.estimates[0].value, modulus, 0.03 * modulus);
}

#[test]
fn bad_recordings_are_refused() {
    let (scene, mesh) = scenes::robot();
    let strokes = figure_of_eight(60);
    let good = recording(&scene, &mesh, &strokes, 0.0, "fit/bad");
    let with = |change: &dyn Fn(&mut Vec<Channel>)| {
        let mut channels = good.channels().to_vec();
        change(&mut channels);
        let n = channels[0].values.len();
        let changed =
            Recording::new(good.time()[..n].to_vec(), channels, vec![], Metadata::default()).unwrap();
        let motion = motion(&scene, &mesh, &changed)?;
        courses(std::slice::from_ref(&motion), &STEPPING).map(|_| motion)
    };
    let refused = |change: &dyn Fn(&mut Vec<Channel>)| with(change).unwrap_err().bad_input().unwrap().clone();
    let another = refused(&|channels| drop(channels.remove(3)));
    assert!(another.place.contains("stroke") && another.hint.contains("another robot"), "{another}");
    let units = refused(&|channels| channels[4].values.iter_mut().for_each(|v| *v = 1e3 * *v + 1.0));
    assert!(units.hint.contains("unit"), "{units}");
    let short = refused(&|channels| channels.iter_mut().for_each(|channel| channel.values.truncate(5)));
    assert!(short.expected.contains("rows"), "{short}");
    let frozen = refused(&|channels| channels[4..].iter_mut().for_each(|c| c.values.fill(0.01)));
    assert!(frozen.found.contains("never moves"), "{frozen}");
    let no_tip = refused(&|channels| channels.truncate(5));
    assert!(no_tip.expected.contains("tip_y_m"), "{no_tip}");
    let flat = with(&|channels| channels[5].values.fill(0.0)).unwrap();
    assert_eq!(flat.axes, [true, false, true]);
}

#[test]
fn gaps_are_passed_through_but_not_compared() {
    let (scene, mesh) = scenes::robot();
    let good = recording(&scene, &mesh, &figure_of_eight(60), 0.0, "fit/gaps");
    let gap: Vec<bool> = (0..60).map(|i| i % 3 == 1).collect();
    let gappy =
        Recording::new(good.time().to_vec(), good.channels().to_vec(), gap.clone(), Metadata::default())
            .unwrap();
    let motion = motion(&scene, &mesh, &gappy).unwrap();
    let course = FitSamples::new(&motion, &Stepping { every: 0.0, ..STEPPING }, usize::MAX).unwrap();
    for (sample, tip) in course.samples.iter().zip(&course.tips) {
        assert_eq!(tip.is_none(), gap[*sample]);
    }
}

#[test]
fn course_steps_by_stroke_from_the_beginning() {
    let (scene, mesh) = scenes::robot();
    let strokes = figure_of_eight(400);
    let motion = motion(&scene, &mesh, &recording(&scene, &mesh, &strokes, 0.0, "fit/course")).unwrap();
    let stepping = Stepping { step: 0.1e-3, every: 0.3e-3, most: 80 };
    let whole = FitSamples::new(&motion, &stepping, usize::MAX).unwrap();
    let apart =
        |a: usize, b: usize| (0..4).map(|k| (strokes[a][k] - strokes[b][k]).abs()).fold(0.0, f64::max);
    let farthest = (1..400).map(|i| apart(i, i - 1)).fold(0.0, f64::max);
    assert_eq!(whole.samples[0], 0);
    for pair in whole.samples.windows(2) {
        let moved = apart(pair[0], pair[1]);
        assert!(moved <= stepping.step.max(farthest), "{moved}");
    }
    let compared: Vec<usize> =
        whole.samples.iter().zip(&whole.tips).filter(|(_, tip)| tip.is_some()).map(|(s, _)| *s).collect();
    assert!(compared.len() < whole.samples.len() / 2);
    assert!(compared.windows(2).all(|pair| apart(pair[0], pair[1]) >= stepping.every));
    // Two motions share the steps.
    let half = &courses(&[motion.clone(), motion], &stepping).unwrap()[1];
    assert_eq!(half.samples[..], whole.samples[..40]);
}

#[test]
fn however_long_the_steps_strokes_turn_back_at_a_sample() {
    let (scene, mesh) = scenes::robot();
    // To and fro five times, farther each time: nine turns, at samples that no step length meets by itself.
    let mut strokes = vec![[0.0; 4]];
    for turn in 1..=10 {
        let goal = 0.137e-3 * f64::from(turn) * if turn % 2 == 0 { -1.0 } else { 1.0 };
        while (strokes[strokes.len() - 1][0] - goal).abs() > 1e-9 {
            let from = strokes[strokes.len() - 1][0];
            let to = from + (goal - from).clamp(-0.01e-3, 0.01e-3);
            strokes.push([to, 0.0, -to, 0.0]);
        }
    }
    let motion = motion(&scene, &mesh, &recording(&scene, &mesh, &strokes, 0.0, "fit/turns")).unwrap();
    let stepping = Stepping { step: 0.5e-3, every: 0.0, most: usize::MAX };
    let course = FitSamples::new(&motion, &stepping, usize::MAX).unwrap();
    let turns: Vec<usize> = (1..strokes.len() - 1)
        .filter(|&i| (strokes[i + 1][0] - strokes[i][0]) * (strokes[i][0] - strokes[i - 1][0]) < 0.0)
        .collect();
    assert_eq!(turns.len(), 9);
    assert!(turns.iter().all(|turn| course.samples.contains(turn)), "{turns:?} {:?}", course.samples);
    assert!(course.samples.len() < strokes.len() / 10);
}

#[test]
fn friction_and_backlash_come_back() {
    let (mut truth, mesh) = scenes::robot();
    truth.tendons.iter_mut().for_each(|tendon| (tendon.compliance, tendon.zero) = (0.02e-3, 0.2e-3));
    let friction = Friction {
        points: 3,
        coefficient: 0.2,
        coulomb: 0.0,
        sheath_exponent: 0.0,
        sheath_coulomb: 0.0,
        sheath_compliance_share: 0.0,
        backlash: 0.1e-3,
    };
    truth.friction = Some(friction);
    let strokes: Vec<[f64; 4]> = figure_of_eight(240).into_iter().cycle().take(400).collect();
    let recording = recording(&truth, &mesh, &strokes, 0.01e-3, "fit/friction");
    let mut scene = truth.clone();
    scene.friction = Some(Friction { coefficient: 0.05, backlash: 0.02e-3, ..friction });
    let motions = [motion(&scene, &mesh, &recording).unwrap()];
    let names = ["coefficient", "backlash"].map(FitParameter::named);
    // Every sample is a step: friction depends on all samples before.
    let stepping = Stepping { step: 0.0, ..STEPPING };
    let options = MaterialOptions { stepping, ..OPTIONS };
    let found = fit_material(
        &scene,
        FitBody { mesh: &mesh, chain: None },
        &motions,
        &select(&scene, &names).unwrap(),
        &options,
    )
    .unwrap();
    for (estimate, expected) in found.fit.estimates.iter().zip([0.2, 0.1e-3]) {
        // Four standard errors; a tenth of the value or less shows that the recording determines both.
        let error = estimate.standard_error.unwrap();
        assert!(error < 0.1 * expected, "{estimate:?}");
        assert_close(&estimate.name, estimate.value, expected, 4.0 * error);
    }
    assert!(found.fit.condition > 1.0 && found.fit.condition < 30.0, "{}", found.fit.condition);
}

#[test]
fn selection_is_checked() {
    let (scene, _) = scenes::robot();
    let place = |names: &[(&str, Option<Bounds>)]| {
        let parameter = |(name, bounds): &(&str, Option<Bounds>)| FitParameter {
            bounds: *bounds,
            ..FitParameter::named(*name)
        };
        let names: Vec<_> = names.iter().map(parameter).collect();
        select(&scene, &names).err().map(|error| error.bad_input().unwrap().place.clone())
    };
    assert_eq!(place(&[("youngs_modulus_mpa", None), ("zero", None)]), None);
    assert_eq!(place(&[("stiffness", None)]).as_deref(), Some("--fit"));
    assert_eq!(place(&[("zero", None), ("common_zero", None)]).as_deref(), Some("--fit"));
    assert_eq!(place(&[]).as_deref(), Some("--fit"));
    // This robot has no friction.
    assert_eq!(place(&[("backlash", None)]).as_deref(), Some("--fit"));
    let (inverted, elsewhere) = (Bounds { min: 2.0, max: 1.0 }, Bounds { min: 50.0, max: 60.0 });
    assert_eq!(place(&[("youngs_modulus", Some(inverted))]).as_deref(), Some("bounds of youngs_modulus"));
    assert_eq!(place(&[("youngs_modulus", Some(elsewhere))]).as_deref(), Some("start of youngs_modulus"));
}

/// A scene of the robot with this gravity, in a material so soft and heavy that it counts.
fn heavy(scene: &Scene, gravity: [f64; 3]) -> Scene {
    let mut heavy = Scene { gravity, ..scene.clone() };
    (heavy.material.density, heavy.material.youngs_modulus) = (3000.0, 0.4e6);
    heavy
}

#[test]
fn gravity_that_points_the_wrong_way_is_named_and_found() {
    let (robot, mesh) = scenes::robot();
    // It hangs from a wall, a little off its axes; in the scene it is upright.
    let direction = [9.2, 2.0, -2.7];
    let size = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
    let truth = heavy(&robot, direction.map(|c: f64| 9.81 * c / size));
    let recording = recording(&truth, &mesh, &figure_of_eight(60), 0.02e-3, "fit/gravity");
    let scene = heavy(&robot, [0.0, 0.0, -9.81]);
    let fit = |names: &[&str]| fitted(&scene, &mesh, &recording, names, TipFrame::Trusted).unwrap();

    // Without it the fit reports what is missing, and does not run away with the modulus.
    let blind = fit(&["youngs_modulus", "zero"]);
    let hint = blind.hints.iter().find(|hint| hint.fit == "gravity");
    let hint = hint.unwrap_or_else(|| panic!("{:?}", (&blind.hints, &blind.fit, blind.errors)));
    assert!(hint.instead.starts_with("gravity along (9.81, 0.00, 0.00)"), "{:?}", blind.hints);
    assert!(hint.rms[1] < 0.95 * hint.rms[0], "{hint:?}");
    let modulus = blind.scene.material.youngs_modulus;
    assert!((0.1e6..1.6e6).contains(&modulus), "two factors of two: {modulus}");

    let found = fit(&["youngs_modulus", "zero", "gravity"]);
    let cosine: f64 =
        (0..3).map(|c| found.scene.gravity[c] * truth.gravity[c]).sum::<f64>() / 9.81f64.powi(2);
    // Noise of 0.02 mm against a sag of millimetres; the nearest axis of the scene is 20° off.
    assert!(cosine > 10f64.to_radians().cos(), "{:?} {:?}", found.scene.gravity, found.fit.estimates);
    assert!(found.errors[1].distance < 0.2 * blind.errors[1].distance, "{:?}", found.errors);
}

#[test]
fn tilted_tracker_is_named_and_found() {
    let (scene, mesh) = scenes::robot();
    let mut truth = scene.clone();
    truth.tracker.turn = [0.05, -0.03, 0.02];
    truth.tracker.shift = [0.4e-3, 0.0, -0.6e-3];
    let recording = recording(&truth, &mesh, &figure_of_eight(60), 0.02e-3, "fit/tilt");
    let blind = fitted(&scene, &mesh, &recording, &["zero"], TipFrame::Checked).unwrap();
    assert!(blind.hints.iter().any(|hint| hint.fit == "tracker"), "{:?}", blind.hints);
    let found = fitted(&scene, &mesh, &recording, &["tracker"], TipFrame::Checked).unwrap();
    for (name, found, truth) in [
        ("turn", found.scene.tracker.turn, truth.tracker.turn),
        ("shift", found.scene.tracker.shift.map(|c| 1e2 * c), truth.tracker.shift.map(|c| 1e2 * c)),
    ] {
        for c in 0..3 {
            // Half a degree; 0.1 mm.
            assert_close(name, found[c], truth[c], 0.01);
        }
    }
    assert!(found.errors[1].distance < 0.05e-3, "{:?}", found.errors);
}

#[test]
fn tension_beyond_what_drives_can_make_counts_against_a_fit() {
    let (mut truth, mesh) = scenes::robot();
    truth.tendons.iter_mut().for_each(|tendon| tendon.compliance = 0.05e-3);
    let recording = recording(&truth, &mesh, &figure_of_eight(60), 0.02e-3, "fit/limit");
    let motions = [motion(&truth, &mesh, &recording).unwrap()];
    // Strokes alone do not separate E from 1/C, so the scene may be ten times too stiff in both.
    let mut scene = truth.clone();
    scene.material.youngs_modulus *= 4.0;
    scene.tendons.iter_mut().for_each(|tendon| tendon.compliance /= 4.0);
    let selected = select(&scene, &["youngs_modulus", "compliance"].map(FitParameter::named)).unwrap();
    let largest = |tension_max: Option<f64>| {
        let options = MaterialOptions { tension_max, ..OPTIONS };
        let found = fit_material(&scene, FitBody { mesh: &mesh, chain: None }, &motions, &selected, &options)
            .unwrap();
        found.tensions.iter().copied().fold(0.0, f64::max)
    };
    let free = largest(None);
    let limited = largest(Some(0.5 * free));
    assert!(limited < 0.6 * free, "{limited} of {free} N");
}
