//! The inverse controller on a robot whose inverse is known: a tip behind backlash.

use std::collections::BTreeMap;
use std::path::Path;

use hysteron_base::{Bounds, Channel, Metadata, Recording, rng};
use hysteron_control::inverse::{
    Axes, Commands, DataOrigin, Dataset, Demonstration, FittedController, InverseController, InverseModel,
    PUBLISHED, RecurrentOptions, TipPosition, fit_base, fit_recurrent, fit_windowed,
};
use hysteron_control::{Error, StrokeLimits};
use hysteron_learn::{SequenceOptions, TrainingProgress, TrainingSession, WindowOptions};
use rand::RngExt;

/// Width of the play between stroke and tip [m].
const WIDTH: f64 = 0.8e-3;
/// Tip over stroke [-].
const GAIN: f64 = 3.0;
const RATE_HZ: f64 = 20.0;

/// A minute of an ellipse that grows and shrinks, run through by four tendons with opposite pairs: the tip follows each
/// coordinate with play, plus noise of 0.03 mm.
fn demonstration(name: &str, index: u64) -> Demonstration {
    recorded(name, index, Metadata::default())
}

fn recorded(name: &str, index: u64, meta: Metadata) -> Demonstration {
    Demonstration::new(name, &format!("hash of {name}"), &recording(index, meta), Axes::Planar).unwrap()
}

fn recording(index: u64, meta: Metadata) -> Recording {
    // Pairs alike, one either way round: where all went one way, the place would tell the direction.
    let mut stream = rng(index / 2, "robot");
    let [size, aspect, hertz, phase] =
        [3.0e-3..6.0e-3, 0.5..1.0, 0.08..0.16, 0.0..6.0].map(|range| stream.random_range(range));
    let n = 1200;
    let time: Vec<f64> = (0..n).map(|i| i as f64 / RATE_HZ).collect();
    let axis = |lag: f64, size: f64| -> Vec<f64> {
        let at = |t: f64| {
            let envelope = (std::f64::consts::PI * t / 60.0).sin();
            size * envelope * (std::f64::consts::TAU * hertz * t + phase + lag).sin()
        };
        time.iter().map(|&t| at(t)).collect()
    };
    let quarter = if index.is_multiple_of(2) { 0.5 } else { -0.5 } * std::f64::consts::PI;
    let commanded = [axis(0.0, size), axis(quarter, aspect * size)];
    let mut tip = |strokes: &[f64]| -> Vec<f64> {
        let mut behind = 0.0f64;
        let mut follow = |stroke: &f64| {
            behind = behind.clamp(stroke - 0.5 * WIDTH, stroke + 0.5 * WIDTH);
            GAIN * behind + 0.03e-3 * (stream.random_range(-1.7..1.7))
        };
        strokes.iter().map(&mut follow).collect()
    };
    let tips = [tip(&commanded[0]), tip(&commanded[1])];
    let [a, b] = commanded;
    let negative = |values: &[f64]| values.iter().map(|v| -v).collect::<Vec<f64>>();
    let (c, d) = (negative(&a), negative(&b));
    let [x, y] = tips;
    let names = ["stroke_1_m", "stroke_2_m", "stroke_3_m", "stroke_4_m", "tip_x_m", "tip_y_m"];
    let channels = names.into_iter().zip([a, b, c, d, x, y]).map(|(name, values)| Channel::new(name, values));
    Recording::new(time, channels.collect(), Vec::new(), meta).unwrap()
}

fn dataset() -> Dataset {
    let all = (0..10).map(|k| demonstration(&format!("ellipse-{k}"), k)).collect();
    Dataset::new(all, &["ellipse-4".to_owned(), "ellipse-5".to_owned()], 1).unwrap()
}

fn quick() -> RecurrentOptions {
    let default = RecurrentOptions::default();
    let learning = SequenceOptions {
        hidden: 24,
        epochs: 60,
        truncation: 100,
        ema: 0.02,
        learning_rate: 5e-3,
        ..default.learning
    };
    // A delay would compensate a part of the backlash: here the regression must not have one.
    RecurrentOptions { learning, largest_delay_s: 0.0, ..default }
}

fn quick_for(epochs: usize) -> RecurrentOptions {
    let quick = quick();
    RecurrentOptions { learning: quick.learning.with([Some(epochs), None]), ..quick }
}

fn tiny() -> WindowOptions {
    WindowOptions { window: 20, hidden: 8, stride: 40, epochs: 3, batch: 32, ..PUBLISHED }
}

fn fit(data: &Dataset, options: &RecurrentOptions) -> FittedController {
    fit_recurrent(data, options, &mut TrainingSession { file: None, progress: &mut |_| true }).unwrap()
}

fn root_mean(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

/// Limits that never bind.
const WIDE: StrokeLimits = StrokeLimits { stroke: Bounds { min: -1.0, max: 1.0 }, stroke_rate: 1e6 };

fn command(model: &InverseModel, path: &[TipPosition], limits: StrokeLimits) -> Commands {
    model.command(path, limits, &mut |_| true).unwrap()
}

/// Root mean square error of strokes for the tip of a demonstration [mm].
fn rmse_mm(model: &InverseModel, one: &Demonstration) -> f64 {
    let commands = command(model, &one.tip, WIDE);
    let errors: Vec<f64> = commands.strokes.iter().zip(&one.strokes).map(|(a, b)| 1e3 * (a - b)).collect();
    root_mean(&errors)
}

#[test]
fn a_delay_is_offered_to_regression_and_network_alike() {
    let of = |largest_delay_s| fit(&dataset(), &RecurrentOptions { largest_delay_s, ..quick_for(1) });
    let (late, at_once) = (of(0.5), of(0.0));
    let delay = late.model.training.delay_s.unwrap();
    // The play of 0.8 mm puts the tip 0.4 mm behind strokes of some 3 mm/s.
    assert!((0.05..0.3).contains(&delay), "{delay}");
    let [with, without] = [&late, &at_once].map(|fitted| fitted.report.together()[0]);
    assert!(with < 0.9 * without, "{with} {without}");
    assert!(late.report.methods.len() == 2 && late.base_mm[0] == late.report.channels[0].errors[0]);
}

#[test]
fn backlash_is_taken_back_where_statics_cannot() {
    let data = dataset();
    let fitted = fit(&data, &quick());
    let (ours, without_memory) = (root_mean(&fitted.held_out_mm), root_mean(&fitted.base_mm));
    // The tip is half the width behind on one side or the other: what depends on the tip alone misses half a width,
    // less while the strokes are within the gap, at the beginning and at each reversal.
    let half_mm = 0.5e3 * WIDTH;
    assert!((0.7 * half_mm..1.05 * half_mm).contains(&without_memory), "{without_memory} of {half_mm} mm");
    // Memory knows the side, but the tip rests while the strokes cross the gap. Of a half period with amplitude a
    // that takes acos(1 - w/a)/π, a fifth for the 4 mm here; a guess in the middle of the gap then misses w/√12. So
    // without looking ahead √0.2 w/√12 = 0.13 w is left, compared with √0.8 w/2 = 0.45 w.
    assert!(ours < 0.4 * without_memory, "{ours} of {without_memory} mm");
    // Streaming is the same arithmetic in another order: f32 rounding of a correction of about a millimetre.
    let streamed: Vec<f64> = data.validation.iter().map(|one| rmse_mm(&fitted.model, one)).collect();
    assert!((root_mean(&streamed) - ours).abs() < 1e-4 * ours, "{streamed:?} {ours}");
}

#[test]
fn the_regression_alone_is_a_controller_like_the_others() {
    let data = dataset();
    let fitted = fit_base(&data, &quick()).unwrap();
    assert_eq!(fitted.held_out_mm, fitted.base_mm);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("h.safetensors");
    fitted.model.write(&path).unwrap();
    let read = InverseModel::read(&path).unwrap();
    // Its network adds nothing: the strokes are those that the errors of the fit are of, to rounding.
    let streamed: Vec<f64> = data.validation.iter().map(|one| rmse_mm(&read, one)).collect();
    let expected = root_mean(&fitted.base_mm);
    assert!((root_mean(&streamed) - expected).abs() < 1e-9 * expected, "{streamed:?} {expected}");
}

#[test]
fn synthetic_demonstrations_are_validated_on_only_without_real_ones() {
    let of = |key: &str, value: &str| {
        let mut meta = Metadata::default();
        match key {
            "scene" => meta.scene_hash = value.to_owned(),
            key => drop(meta.extra.insert(key.to_owned(), value.to_owned())),
        }
        meta
    };
    let real = |k: u64| recorded(&format!("r{k}"), k, of("rig.sha256", "r"));
    let synthetic = |k: u64| recorded(&format!("s{k}"), k, of("scene", "t"));
    let origins = |all: Vec<Demonstration>| -> Vec<DataOrigin> {
        Dataset::new(all, &[], 1).unwrap().validation.iter().map(|one| one.origin).collect()
    };
    let both = || (0..2).map(real).chain((2..9).map(synthetic));
    assert_eq!(origins(both().collect()), [DataOrigin::Real]);
    assert_eq!(origins((2..9).map(synthetic).collect()), [DataOrigin::Synthetic]);
    let data = Dataset::new(both().collect(), &[], 1).unwrap();
    let recorded = data.only(DataOrigin::Real).unwrap();
    assert_eq!((recorded.training.len(), recorded.validation.len()), (1, 1));
    assert_eq!(data.only(DataOrigin::Synthetic), None);
}

/// As many tendons as coordinates, each of which only one of them moves.
fn in_space(name: &str, index: u64, axes: Axes) -> Demonstration {
    let (a, b) = (recording(2 * index, Metadata::default()), recording(2 * index + 21, Metadata::default()));
    let of = |from: &Recording, name: &str, to: &str| Channel::new(to, from.channel(name).unwrap().to_vec());
    let channels = vec![
        of(&a, "stroke_1_m", "stroke_1_m"),
        of(&a, "stroke_2_m", "stroke_2_m"),
        of(&b, "stroke_1_m", "stroke_3_m"),
        of(&a, "tip_x_m", "tip_x_m"),
        of(&a, "tip_y_m", "tip_y_m"),
        of(&b, "tip_x_m", "tip_z_m"),
    ];
    let recording = Recording::new(a.time().to_vec(), channels, Vec::new(), Metadata::default()).unwrap();
    Demonstration::new(name, name, &recording, axes).unwrap()
}

#[test]
fn a_tip_in_space_determines_more_than_one_in_the_plane() {
    let dataset = |axes| {
        let all = (0..10).map(|k| in_space(&format!("ellipse-{k}"), k, axes)).collect();
        Dataset::new(all, &["ellipse-4".to_owned(), "ellipse-5".to_owned()], 1).unwrap()
    };
    let (plane, space) = (dataset(Axes::Planar), dataset(Axes::Spatial));
    let (blind, seeing) = (fit(&plane, &quick()), fit(&space, &quick()));
    // The third stroke, several millimetres, is not in x and y at all; with z it is one like the others.
    assert!(blind.held_out_mm[2] > 1.0, "{:?}", blind.held_out_mm);
    assert!(root_mean(&seeing.held_out_mm) < 0.5 * WIDTH * 1e3, "{:?}", seeing.held_out_mm);
    assert_eq!((blind.model.axes(), seeing.model.axes()), (Axes::Planar, Axes::Spatial));
    let windowed =
        fit_windowed(&space, &tiny(), &mut TrainingSession { file: None, progress: &mut |_| true }).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("h.safetensors");
    for model in [&seeing.model, &windowed.model] {
        model.write(&path).unwrap();
        assert_eq!(&InverseModel::read(&path).unwrap(), model);
        assert!(rmse_mm(model, &space.validation[0]).is_finite());
    }
}

#[test]
fn a_checkpoint_comes_back_and_commands_alike() {
    let data = dataset();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("h.safetensors");
    let recurrent = fit(&data, &quick_for(1));
    let mut session = TrainingSession { file: None, progress: &mut |_| true };
    let windowed = fit_windowed(&data, &tiny(), &mut session).unwrap();
    for fitted in [recurrent, windowed] {
        fitted.model.write(&path).unwrap();
        let read = InverseModel::read(&path).unwrap();
        assert_eq!(read, fitted.model);
        let tip = &data.validation[0].tip;
        assert_eq!(command(&read, tip, WIDE), command(&fitted.model, tip, WIDE));
    }
}

#[test]
fn windows_of_a_command_are_those_of_the_training() {
    let data = dataset();
    let options = WindowOptions { stride: 1, epochs: 1, ..tiny() };
    let fitted =
        fit_windowed(&data, &options, &mut TrainingSession { file: None, progress: &mut |_| true }).unwrap();
    let streamed: Vec<f64> = data.validation.iter().map(|one| rmse_mm(&fitted.model, one)).collect();
    let held_out = root_mean(&fitted.held_out_mm);
    // Only the rounding of sums differs.
    assert!((root_mean(&streamed) - held_out).abs() < 1e-4 * held_out, "{streamed:?} {held_out}");
}

/// A design with its data and options.
type Fit<'a> = &'a dyn Fn(&mut TrainingSession<'_>) -> hysteron_control::Result<FittedController>;

/// Trains until `epochs` are done, with a file to resume from.
fn until(epochs: usize, file: &Path, fit: Fit<'_>) -> FittedController {
    let mut progress = |progress: &TrainingProgress| match progress {
        TrainingProgress::Epoch(epoch) => epoch.number < epochs,
        // Ends in the middle of the epoch after.
        TrainingProgress::Step { epoch, done, .. } => *epoch < epochs || *done < 2,
    };
    fit(&mut TrainingSession { file: Some(file), progress: &mut progress }).unwrap()
}

#[test]
fn an_interrupted_training_ends_as_one_that_was_not() {
    let data = dataset();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("h.training");
    let recurrent = quick_for(4);
    let windowed = tiny();
    let fits: [Fit<'_>; 2] = [&|session| fit_recurrent(&data, &recurrent, session), &|session| {
        fit_windowed(&data, &windowed, session)
    }];
    for fit in fits {
        let whole = fit(&mut TrainingSession { file: None, progress: &mut |_| true }).unwrap();
        let part = until(2, &file, fit);
        assert!(whole.is_finished && !part.is_finished);
        let resumed = until(usize::MAX, &file, fit);
        assert_eq!(resumed, whole);
        std::fs::remove_file(&file).unwrap();
    }
}

#[test]
fn the_file_of_another_training_is_refused() {
    let data = dataset();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("h.training");
    let options = quick_for(2);
    until(1, &file, &|session| fit_recurrent(&data, &options, session));
    let other = RecurrentOptions { seed: 2, ..options };
    let mut session = TrainingSession { file: Some(&file), progress: &mut |_| true };
    let refusal = fit_recurrent(&data, &other, &mut session).unwrap_err().to_string();
    assert!(refusal.contains("another one (options)"), "{refusal}");
    // Nothing is kept of a first epoch that did not come to its end.
    std::fs::remove_file(&file).unwrap();
    let mut session = TrainingSession { file: None, progress: &mut |_| false };
    assert!(matches!(
        fit_recurrent(&data, &other, &mut session),
        Err(Error::Learn(hysteron_learn::Error::NothingTrained))
    ));
}

#[test]
fn limits_hold_and_leaving_the_workspace_is_flagged() {
    let data = dataset();
    let model = fit(&data, &quick_for(1)).model;
    let tip = &data.validation[0].tip;
    let tight = StrokeLimits { stroke: Bounds { min: -1e-3, max: 2e-3 }, stroke_rate: 1e-3 };
    let held = command(&model, tip, tight);
    let (n, largest) = (model.n_tendons, tight.stroke_rate * model.step_s);
    assert!(held.strokes.iter().all(|stroke| (-1e-3..=2e-3).contains(stroke)));
    for (before, after) in held.strokes.iter().zip(&held.strokes[n..]) {
        assert!((after - before).abs() <= largest * (1.0 + 1e-12));
    }
    assert!(held.steps.iter().any(|step| step.is_limited));
    assert!(command(&model, tip, WIDE).steps.iter().all(|step| !step.is_limited));
    // Far outside every path of the training, and on it.
    let inside = [[1e-3, 1e-3, 0.0]; 30];
    let outside = [[40e-3, 0.0, 0.0]; 30];
    assert!(command(&model, &inside, WIDE).steps.iter().all(|step| !step.is_extrapolating));
    assert!(command(&model, &outside, WIDE).steps.iter().all(|step| step.is_extrapolating));
}

#[test]
fn data_that_do_not_go_together_are_refused() {
    let meta = |rig: &str, scene: &str| Metadata {
        scene_hash: scene.to_owned(),
        extra: BTreeMap::from([("rig.sha256".to_owned(), rig.to_owned())]),
        ..Metadata::default()
    };
    let (real, other) = (recorded("a", 0, meta("r", "")), recorded("b", 1, meta("other", "")));
    let (twin, other_twin) = (recorded("c", 2, meta("", "t")), recorded("d", 3, meta("", "other")));
    assert_eq!((real.origin, twin.origin), (DataOrigin::Real, DataOrigin::Synthetic));
    let refusal = |all: &[&Demonstration], held_out: &[&str]| {
        let held_out: Vec<String> = held_out.iter().map(|name| (*name).to_owned()).collect();
        Dataset::new(all.iter().map(|one| (*one).clone()).collect(), &held_out, 1).unwrap_err().to_string()
    };
    assert!(refusal(&[&real, &other], &[]).contains("recordings of one robot, r as a, got other"));
    assert!(refusal(&[&twin, &real, &other_twin], &[]).contains("recordings of one robot, t as c"));
    assert!(refusal(&[&real], &[]).contains("at least two"));
    assert!(refusal(&[&real, &twin], &["e"]).contains("of a, c, got e"));
    assert!(refusal(&[&real, &twin], &["a", "c"]).contains("some recordings for training"));
    let slower = Demonstration { step: 0.1, ..twin.clone() };
    assert!(refusal(&[&real, &slower], &[]).contains("20.0000 Hz, as a, got 10.0000 Hz"));
    let spatial = Demonstration { axes: Axes::Spatial, ..twin.clone() };
    assert!(refusal(&[&real, &spatial], &[]).contains("tips measured along x, y, as a, got x, y, z"));
    let fewer = Demonstration { n_tendons: 2, ..twin.clone() };
    assert!(refusal(&[&real, &fewer], &[]).contains("4 tendons, as a, got 2"));
    // Rig and twin together, validated on the rig.
    let hybrid = Dataset::new(vec![twin, real], &[], 1).unwrap();
    assert_eq!((hybrid.validation[0].origin, hybrid.count(DataOrigin::Synthetic)), (DataOrigin::Real, 1));
    assert_eq!(hybrid.robots(), ["r", "t"]);
}

#[test]
fn recordings_without_what_is_needed_are_refused() {
    let whole = recording(0, Metadata::default());
    let with = |change: &dyn Fn(&mut Vec<Channel>)| {
        let mut channels = whole.channels().to_vec();
        change(&mut channels);
        Recording::new(whole.time().to_vec(), channels, Vec::new(), Metadata::default()).unwrap()
    };
    let refusal =
        |recording: &Recording| Demonstration::new("a", "", recording, Axes::Planar).unwrap_err().to_string();
    for missing in ["tip_x_m", "tip_y_m"] {
        let without = with(&|channels| channels.retain(|channel| channel.name != missing));
        assert!(refusal(&without).contains(missing));
    }
    let without = with(&|channels| channels.retain(|channel| !channel.name.starts_with("stroke")));
    assert!(refusal(&without).contains("stroke_1_m"));
    let partly = with(&|channels| {
        channels.push(Channel::new("tip_x_per_stroke_1_ratio", vec![1.0; whole.n_samples()]));
    });
    assert!(refusal(&partly).contains("of 4 tendons, got [1, 0]"));
    let mut time = whole.time().to_vec();
    time[5] += 0.02;
    let uneven = Recording::new(time, whole.channels().to_vec(), Vec::new(), Metadata::default()).unwrap();
    assert!(refusal(&uneven).contains("a fixed rate"));
}

#[test]
fn a_recorded_jacobian_weighs_strokes_by_what_they_do() {
    // Of the last two tendons the tip takes no notice, so with a heavy weight only the first two must fit.
    let mut data = dataset();
    for one in data.training.iter_mut() {
        one.jacobian =
            (0..one.len()).flat_map(|_| [[GAIN, 0.0, 0.0, 0.0], [0.0, GAIN, 0.0, 0.0]]).flatten().collect();
    }
    let mut options = quick_for(15);
    options.loss.tip = 100.0;
    let weighed = fit(&data, &options).held_out_mm;
    let (effective, ineffective) = (root_mean(&weighed[..2]), root_mean(&weighed[2..]));
    assert!(effective < ineffective, "{weighed:?}");
}

#[test]
fn a_common_pull_can_be_asked_for() {
    let data = dataset();
    let mut options = quick_for(25);
    options.loss.co_contraction_min_m = 0.2e-3;
    let model = fit(&data, &options).model;
    let commands = command(&model, &data.validation[0].tip, WIDE);
    let mean = commands.strokes.iter().sum::<f64>() / commands.strokes.len() as f64;
    // The recordings have none: with a weight of 1, e²/1 + (p - e)² is least at half the pull asked for.
    assert!((0.07e-3..0.13e-3).contains(&mean), "{mean}");
}

#[test]
fn controllers_refuse_what_they_cannot_follow() {
    let data = dataset();
    let model = fit(&data, &quick_for(1)).model;
    let refusal =
        |path: &[TipPosition], limits| InverseController::new(&model, path, limits).unwrap_err().to_string();
    assert!(refusal(&[], WIDE).contains("at least one sample"));
    assert!(refusal(&[[0.0, f64::NAN, 0.0]], WIDE).contains("finite positions"));
    let upside_down = StrokeLimits { stroke: Bounds { min: 1.0, max: 0.0 }, ..WIDE };
    assert!(refusal(&[[0.0; 3]], upside_down).contains("min <= max"));
    assert!(refusal(&[[0.0; 3]], StrokeLimits { stroke_rate: 0.0, ..WIDE }).contains("a rate > 0"));
    let refusal = model.check_step(0.01).unwrap_err().to_string();
    assert!(refusal.contains("samples of 0.05 s"), "{refusal}");
}
