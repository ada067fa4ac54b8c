//! Identification and the residual network, on a robot that is a twin with something more in it.

use std::path::PathBuf;

use hysteron_base::{Channel, Friction, Metadata, Recording, json};
use hysteron_fit::qp::QpStatus;
use hysteron_learn::{SequenceOptions, TrainingProgress};
use hysteron_twin::coreact::{
    AuxiliaryIdentification, AuxiliaryLimits, AuxiliaryPolicy, Identifier, IdentifyOptions, TipMeasurement,
    identify,
};
use hysteron_twin::residual::{
    CorrectedRollout, DECODER, FittedResidual, PUBLISHED, RecurrentOptions, ResidualDesign, ResidualModel,
    ResidualPart, Sequence, Sessions, StrokeDecoder, fit_decoder, fit_recurrent, fit_windowed,
};
use hysteron_twin::{FrictionPoints, Plant, RobotMotion, Stepper, Target, Twin};

use super::scenes;

/// The robot of the tests with eight auxiliary tendons in four segments.
fn twin() -> Twin {
    let (scene, mesh) = scenes::actuated(4);
    Twin::new(&scene, &mesh).expect("a good scene")
}

/// The same with auxiliary tendons in `segments` segments, and with friction.
fn rough_twin(segments: usize, friction: impl Fn(Friction) -> Friction) -> Twin {
    let (mut scene, mesh) = scenes::actuated(segments);
    scenes::roughen(&mut scene, 2e-4);
    scene.friction = scene.friction.map(friction);
    Twin::new(&scene, &mesh).expect("a good scene")
}

/// Strokes of a small circle, with antagonists released.
fn strokes(i: usize) -> [f64; 4] {
    let (sin, cos) = (0.05 * i as f64).sin_cos();
    let ramp = 1e-3 * (i as f64 / 60.0).min(1.0);
    [cos * ramp, sin * ramp, -cos * ramp, -sin * ramp]
}

/// A recording of a twin whose auxiliary tendons follow `secret`: strokes (n_aux) [m] in a sample.
fn recording(
    twin: &Twin,
    auxiliary: &AuxiliaryLimits,
    n: usize,
    secret: impl Fn(usize) -> Vec<f64>,
) -> Recording {
    let (mut stepper, mut targets) = (Stepper::new(twin), Vec::new());
    let mut columns = vec![Vec::new(); 7];
    for i in 0..n {
        auxiliary.targets_into(&strokes(i), &secret(i), &mut targets);
        stepper.step(twin, &targets).expect("an equilibrium");
        let tip = twin.tip_of(stepper.state());
        for (column, value) in columns.iter_mut().zip(strokes(i).iter().chain(&tip)) {
            column.push(*value);
        }
    }
    let names = ["stroke_1_m", "stroke_2_m", "stroke_3_m", "stroke_4_m", "tip_x_m", "tip_y_m", "tip_z_m"];
    let channels = names.into_iter().zip(columns).map(|(name, values)| Channel::new(name, values)).collect();
    let time = (0..n).map(|i| 0.01 * i as f64).collect();
    Recording::new(time, channels, Vec::new(), Metadata::default()).expect("a recording")
}

/// Something slow and something that lags behind the strokes.
fn lagging(n_aux: usize, i: usize) -> Vec<f64> {
    let late = strokes(i.saturating_sub(8));
    (0..n_aux).map(|k| 0.02 * late[k % 4] * if k % 2 == 0 { 1.0 } else { -1.0 }).collect()
}

#[test]
fn tip_of_a_twin_with_secret_strokes_is_met() {
    let twin = twin();
    let auxiliary = AuxiliaryLimits::new(&twin).unwrap();
    let recording = recording(&twin, &auxiliary, 200, |i| lagging(auxiliary.len(), i));
    let motion = RobotMotion::for_identification(&twin, &recording, "rec").unwrap();
    let options =
        IdentifyOptions { regularisation: 1e-6, rounds: 4, tolerance: 1e-7, ..IdentifyOptions::default() };
    let mut identifier = Identifier::new(&twin, &auxiliary, options);
    let done = identify(&twin, &mut identifier, &motion, Metadata::default(), &mut || true).unwrap().unwrap();
    // Rounds of a linearisation that is off by a tenth or two, from moves of 0.1 mm: 1e-4 m times 0.2 to the fourth.
    assert!(done.summary.after.p99_m < 2e-6, "{:?}", done.summary.after);
    assert!(done.summary.before.median_m > 20.0 * done.summary.after.p99_m, "{:?}", done.summary);
    // The first sample brings the twin into balance and has no QP.
    assert!(done.summary.qps[0] >= 199 && done.summary.qps[1..] == [0; 3], "{:?}", done.summary.qps);
    assert_eq!(done.recording.aux().len(), auxiliary.len());
}

#[test]
fn bounds_of_stroke_and_rate_hold_and_are_counted() {
    let mut twin = twin();
    twin.auxiliary_rate = 5e-4;
    let auxiliary = AuxiliaryLimits::new(&twin).unwrap();
    let (mut identifier, far) = (Identifier::new(&twin, &auxiliary, IdentifyOptions::default()), 5e-3);
    let tip = twin.tip_of(&twin.rest());
    let goal = TipMeasurement { position: [tip[0] + far, tip[1], tip[2]], orientation: None };
    let mut before = vec![0.0; auxiliary.len()];
    let mut largest = 0.0f64;
    for _ in 0..40 {
        let step = identifier.step(&[0.0; 4], Some(&goal), 0.01).unwrap();
        assert!(step.statuses.iter().all(|status| *status == QpStatus::Solved));
        for (k, stroke) in identifier.strokes().iter().enumerate() {
            assert!(auxiliary.bounds[k].contains(*stroke), "{stroke}");
            // Round-off of a difference of strokes of a millimetre.
            assert!((stroke - before[k]).abs() <= 5e-6 + 1e-15, "{} m", stroke - before[k]);
            largest = largest.max((stroke - before[k]).abs());
        }
        before = identifier.strokes().to_vec();
    }
    assert!(largest > 4.9e-6, "a bound that never binds tests nothing: {largest}");
}

#[test]
fn sensitivity_is_derivative_of_the_tip_by_strokes() {
    let twin = twin();
    let auxiliary = AuxiliaryLimits::new(&twin).unwrap();
    let mut identifier = Identifier::new(&twin, &auxiliary, IdentifyOptions::default());
    // A strong bend, to which many steps lead, so that the factor is an old one.
    let pulled = [4e-3, 1e-3, -3e-3, 1e-3];
    let (mut way, mut targets) = (Stepper::new(&twin), Vec::new());
    let none = vec![0.0; auxiliary.len()];
    for k in 1..=100 {
        let strokes = pulled.map(|stroke| 0.01 * f64::from(k) * stroke);
        identifier.step(&strokes, None, 0.01).unwrap();
        auxiliary.targets_into(&strokes, &none, &mut targets);
        way.step(&twin, &targets).unwrap();
    }
    let sensitivity = identifier.sensitivity_where(FrictionPoints::AsTheyAre).unwrap();
    let mut stepper = Stepper::new(&twin);
    let mut tip = |k: usize, h: f64| {
        let mut secret = vec![0.0; auxiliary.len()];
        secret[k] = h;
        auxiliary.targets_into(&pulled, &secret, &mut targets);
        stepper.restore(&twin, way.state()).unwrap();
        stepper.step(&twin, &targets).unwrap();
        twin.tip_of(stepper.state())
    };
    let h = 2e-6;
    for k in [0, 3, 6] {
        let (ahead, behind) = (tip(k, h), tip(k, -h));
        let size = (0..3).map(|c| ((ahead[c] - behind[c]) / (2.0 * h)).abs()).fold(0.0, f64::max);
        for c in 0..3 {
            let difference = (ahead[c] - behind[c]) / (2.0 * h);
            // The adjoint solves leave a tenth of a per cent of the largest; small strokes ten times as much
            // of it.
            let missed = (sensitivity[c][k] - difference).abs();
            assert!(missed < 0.01 * size, "{} {difference} of {size}", sensitivity[c][k]);
        }
        assert!(size > 0.1, "a derivative that tests nothing: {size}");
    }
}

#[test]
fn sensitivity_knows_the_friction_points_that_stick() {
    // Friction beyond all tensions: every point sticks.
    let twin = rough_twin(4, |friction| Friction { coulomb: 20.0, sheath_coulomb: 5.0, ..friction });
    let auxiliary = AuxiliaryLimits::new(&twin).unwrap();
    let mut identifier = Identifier::new(&twin, &auxiliary, IdentifyOptions::default());
    let (mut stepper, mut targets) = (Stepper::new(&twin), Vec::new());
    let none = vec![0.0; auxiliary.len()];
    let pulled = [1e-4, 5e-5, 2e-5, 2e-5];
    for part in [0.25, 0.5, 0.75, 1.0] {
        let pulled = pulled.map(|stroke| part * stroke);
        identifier.step(&pulled, None, 0.01).unwrap();
        auxiliary.targets_into(&pulled, &none, &mut targets);
        stepper.step(&twin, &targets).unwrap();
    }
    let state = stepper.state().clone();
    let sensitivity = identifier.sensitivity_where(FrictionPoints::AsTheyAre).unwrap();
    let slipping = identifier.sensitivity_where(FrictionPoints::Slipping).unwrap();
    let mut tip = |k: usize, h: f64| {
        let mut strokes = none.clone();
        strokes[k] = h;
        auxiliary.targets_into(&pulled, &strokes, &mut targets);
        stepper.restore(&twin, &state).unwrap();
        stepper.step(&twin, &targets).unwrap();
        assert_eq!(stepper.state().slip, twin.rest().slip, "a point has slipped");
        twin.tip_of(stepper.state())
    };
    let mut stuck = 0.0f64;
    let h = 2e-6;
    for k in [0, 3, 6] {
        let (ahead, behind) = (tip(k, h), tip(k, -h));
        let difference: [f64; 3] = std::array::from_fn(|c| (ahead[c] - behind[c]) / (2.0 * h));
        let size = difference.iter().fold(0.0f64, |size, d| size.max(d.abs()));
        for c in 0..3 {
            // As without friction.
            let missed = (sensitivity[c][k] - difference[c]).abs();
            assert!(missed < 0.01 * size, "{} {} of {size}", sensitivity[c][k], difference[c]);
            stuck = stuck.max((slipping[c][k] - difference[c]).abs() / size);
        }
        assert!(size > 0.01, "a derivative that tests nothing: {size}");
    }
    assert!(stuck > 0.1, "friction that holds nothing: {stuck}");
}

#[test]
fn secret_strokes_are_found_through_friction_and_backlash() {
    // Two auxiliary tendons: their strokes are observable from the tip.
    let twin = rough_twin(1, |friction| Friction { backlash: 1e-4, ..friction });
    let auxiliary = AuxiliaryLimits::new(&twin).unwrap();
    let secret = |i: usize| lagging(auxiliary.len(), i);
    let recording = recording(&twin, &auxiliary, 400, secret);
    let motion = RobotMotion::for_identification(&twin, &recording, "rec").unwrap();
    let options =
        IdentifyOptions { regularisation: 1e-9, rounds: 4, tolerance: 1e-8, ..IdentifyOptions::default() };
    let mut identifier = Identifier::new(&twin, &auxiliary, options);
    let done = identify(&twin, &mut identifier, &motion, Metadata::default(), &mut || true).unwrap().unwrap();
    // As without friction. Where a bound of friction jumps, the rounds end sooner than the tip is met.
    assert!(done.summary.after.p99_m < 2e-6, "{:?}", done.summary.after);
    assert!(done.summary.before.median_m > 20.0 * done.summary.after.median_m, "{:?}", done.summary);
    let found = done.recording.aux();
    let mut missed: Vec<f64> = (1..motion.len())
        .flat_map(|i| secret(i).into_iter().enumerate().map(move |(k, stroke)| (i, k, stroke)))
        .map(|(i, k, stroke)| (found[k][i] - stroke).abs())
        .collect();
    missed.sort_by(f64::total_cmp);
    let median = missed[missed.len() / 2];
    println!("strokes of 20 um: {median:.1e} m in the median, {:.1e} m at most", missed[missed.len() - 1]);
    assert!(median < 1e-7, "{median}");
}

#[test]
fn zero_strokes_leave_the_bare_twin() {
    let twin = twin();
    let auxiliary = AuxiliaryLimits::new(&twin).unwrap();
    let (bare_scene, mesh) = scenes::robot();
    let bare = Twin::new(&bare_scene, &mesh).unwrap();
    let (mut with, mut without) = (Stepper::new(&twin), Stepper::new(&bare));
    let mut targets = Vec::new();
    for i in 0..50 {
        auxiliary.targets_into(&strokes(i), &vec![0.0; auxiliary.len()], &mut targets);
        with.step(&twin, &targets).unwrap();
        without.step(&bare, &strokes(i).map(Target::Stroke)).unwrap();
    }
    let (a, b) = (twin.tip_of(with.state()), bare.tip_of(without.state()));
    // Both are in balance to 1e-6 of their forces: some 1e-8 m at the tip.
    assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-7), "{a:?} {b:?}");
}

fn fit(
    sequences: &[Sequence],
    options: &RecurrentOptions,
    files: Vec<PathBuf>,
    progress: &(dyn Fn(usize, &TrainingProgress) -> bool + Sync),
) -> FittedResidual {
    fit_recurrent(sequences, (&[vec![0], vec![1]], 0), "scene", options, &Sessions { files, progress })
        .unwrap()
}

/// A motion whose tip lags, identified.
fn identified(
    twin: &Twin,
    auxiliary: &AuxiliaryLimits,
    n: usize,
) -> (RobotMotion, AuxiliaryIdentification, Sequence) {
    let recording = recording(twin, auxiliary, n, |i| lagging(auxiliary.len(), i));
    let motion = RobotMotion::for_identification(twin, &recording, "rec").unwrap();
    let mut identifier = Identifier::new(twin, auxiliary, IdentifyOptions::default());
    let found = identify(twin, &mut identifier, &motion, Metadata::default(), &mut || true);
    let found = found.unwrap().unwrap();
    let sequence = Sequence::new("circle", &found.recording, &found.sensitivities).unwrap();
    (motion, found, sequence)
}

/// The defaults without noise, with what a test changes.
fn learning(change: impl Fn(&mut SequenceOptions)) -> RecurrentOptions {
    let mut options = RecurrentOptions::default();
    options.learning.input_noise = 0.0;
    change(&mut options.learning);
    options
}

#[test]
fn an_interrupted_training_ends_as_one_that_was_not() {
    let twin = twin();
    let auxiliary = AuxiliaryLimits::new(&twin).unwrap();
    let sequence = identified(&twin, &auxiliary, 120).2;
    let sequences = [sequence.clone(), sequence];
    let options = learning(|of| {
        *of = SequenceOptions { hidden: 8, epochs: 4, truncation: 50, input_noise: 1.0, ..*of }
    });
    let folder = tempfile::tempdir().unwrap();
    let files: Vec<PathBuf> = (0..2).map(|k| folder.path().join(format!("{k}.training"))).collect();
    let whole = fit(&sequences, &options, Vec::new(), &|_, _| true);
    // One network is stopped after its second epoch, the other in the middle of its third.
    let part = fit(&sequences, &options, files.clone(), &|member, progress| match progress {
        TrainingProgress::Epoch(epoch) => member == 1 || epoch.number < 2,
        TrainingProgress::Step { epoch, done, .. } => *epoch < 2 || *done < 2,
    });
    assert!(whole.is_finished && !part.is_finished && part.model != whole.model);
    assert_eq!(fit(&sequences, &options, files.clone(), &|_, _| true), whole);
    let sessions = Sessions { files, progress: &|_, _| true };
    let other = RecurrentOptions { seed: 2, ..options };
    let refusal =
        fit_recurrent(&sequences, (&[vec![0], vec![1]], 0), "scene", &other, &sessions).unwrap_err();
    assert!(refusal.to_string().contains("another one (options)"), "{refusal}");
}

#[test]
fn network_learns_what_lags_and_its_checkpoint_rolls_out_the_same() {
    let twin = twin();
    let auxiliary = AuxiliaryLimits::new(&twin).unwrap();
    let n = 400;
    let (motion, found, sequence) = identified(&twin, &auxiliary, n);
    let options = learning(|of| {
        *of = SequenceOptions { hidden: 16, epochs: 400, patience: 400, truncation: 100, ..*of }
    });
    // The same recording twice: the test is only that it can be fitted and rolled out.
    let sequences = [sequence.clone(), sequence];
    let model = fit(&sequences, &options, Vec::new(), &|_, _| true).model;

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("residual.safetensors");
    model.write(&path).unwrap();
    let model = ResidualModel::read(&path).unwrap();
    let mut rollout = CorrectedRollout::new(&twin, &auxiliary, &model, 0.01).unwrap();
    let (mut bare, mut with) = (0.0, 0.0);
    let bare_tips = ["x", "y", "z"].map(|axis| found.recording.require(&format!("bare_{axis}_m")).unwrap());
    for i in 0..n {
        let step = Plant::step(&mut rollout, &strokes(i)).unwrap();
        for c in 0..3 {
            with += (step.tip[c] - motion.tips[i][c]).powi(2);
            bare += (bare_tips[c][i] - motion.tips[i][c]).powi(2);
        }
        assert!(
            rollout.strokes().iter().zip(&auxiliary.bounds).all(|(stroke, bounds)| bounds.contains(*stroke))
        );
        assert!(!step.is_extrapolating, "row {i}");
    }
    assert!(with < 0.05 * bare, "{with} of {bare}");
    // Twice the stroke is outside the training range.
    assert!(Plant::step(&mut rollout, &[2.5e-3, 0.0, -2.5e-3, 0.0]).unwrap().is_extrapolating);
    // Another rate or robot is refused.
    assert!(
        CorrectedRollout::new(&twin, &auxiliary, &model, 0.02).unwrap_err().to_string().contains("time_s")
    );
    let wrong = model.check(3, auxiliary.len(), 0.01).unwrap_err();
    assert!(wrong.to_string().contains("another robot"), "{wrong}");
}

#[test]
fn networks_of_all_learn_from_every_recording_for_as_long_as_the_folds_took() {
    let twin = twin();
    let auxiliary = AuxiliaryLimits::new(&twin).unwrap();
    let (motion, _, sequence) = identified(&twin, &auxiliary, 200);
    let sequences = [sequence.clone(), sequence];
    let options = learning(|of| *of = SequenceOptions { hidden: 16, epochs: 300, truncation: 100, ..*of });
    let epochs = std::sync::Mutex::new([0; 4]);
    let progress = |number: usize, progress: &TrainingProgress| {
        if let TrainingProgress::Epoch(epoch) = progress {
            epochs.lock().unwrap()[number] = epoch.number;
        }
        true
    };
    let sessions = Sessions { files: Vec::new(), progress: &progress };
    let held_out = [vec![0], vec![1]];
    let fitted = fit_recurrent(&sequences, (&held_out, 2), "scene", &options, &sessions).unwrap();
    let training = &fitted.model.training;
    assert_eq!((training.networks_of_all, training.members.len()), (Some(2), 2));
    let mean = training.members.iter().map(|member| member.epochs).sum::<usize>() as f64 / 2.0;
    assert_eq!(epochs.lock().unwrap()[2..], [mean.round() as usize; 2]);
    assert!(fitted.is_finished && training.members.iter().all(|member| member.is_kept));
    // It is a model like the others: it brings the tip closer than the twin alone.
    let mut rollout = CorrectedRollout::new(&twin, &auxiliary, &fitted.model, 0.01).unwrap();
    let found = identify(&twin, &mut rollout, &motion, Metadata::default(), &mut || true).unwrap().unwrap();
    let bare = fitted.reports[0].together()[0] * 3f64.sqrt();
    assert!(1e3 * found.summary.before.rms_m < bare, "{} {bare}", 1e3 * found.summary.before.rms_m);
}

#[test]
fn what_gains_nothing_on_a_recording_left_out_leaves_the_twin_as_it_is() {
    let twin = twin();
    let auxiliary = AuxiliaryLimits::new(&twin).unwrap();
    // The same motion, and errors of the other sign: what is learned on one makes the other twice as bad.
    let sequences = [1.0, -1.0].map(|sign| {
        let secret = |i| lagging(auxiliary.len(), i).iter().map(|stroke| sign * stroke).collect();
        let recording = recording(&twin, &auxiliary, 120, secret);
        let motion = RobotMotion::for_identification(&twin, &recording, "rec").unwrap();
        let mut identifier = Identifier::new(&twin, &auxiliary, IdentifyOptions::default());
        let found = identify(&twin, &mut identifier, &motion, Metadata::default(), &mut || true);
        let found = found.unwrap().unwrap();
        Sequence::new("circle", &found.recording, &found.sensitivities).unwrap()
    });
    let options = learning(|of| *of = SequenceOptions { hidden: 8, epochs: 20, truncation: 50, ..*of });
    let model = fit(&sequences, &options, Vec::new(), &|_, _| true).model;
    assert_eq!(model.training.part, Some(ResidualPart::Nothing));
    assert!(model.training.members.iter().all(|member| !member.is_kept));
    let mut rollout = CorrectedRollout::new(&twin, &auxiliary, &model, 0.01).unwrap();
    for i in 0..20 {
        Plant::step(&mut rollout, &strokes(i)).unwrap();
        assert!(rollout.strokes().iter().all(|stroke| *stroke == 0.0), "row {i}");
    }
}

#[test]
fn a_second_network_is_linearised_where_the_first_leads_the_twin() {
    let twin = twin();
    let auxiliary = AuxiliaryLimits::new(&twin).unwrap();
    let (motion, _, sequence) = identified(&twin, &auxiliary, 400);
    // A first network with hardly any training: the second one needs its strokes and tips, not that they are
    // good.
    let learn = |sequence: &Sequence, epochs: usize| {
        let options = learning(|of| *of = SequenceOptions { hidden: 16, epochs, truncation: 100, ..*of });
        fit(&[sequence.clone(), sequence.clone()], &options, Vec::new(), &|_, _| true).model
    };
    let again = |model: &ResidualModel| {
        let mut meta = Metadata::default();
        let ResidualDesign::Recurrent { decoder, .. } = &model.design else { panic!("recurrent") };
        meta.extra.insert(DECODER.to_owned(), json::to_line(decoder).unwrap());
        let mut rollout = CorrectedRollout::new(&twin, &auxiliary, model, 0.01).unwrap();
        identify(&twin, &mut rollout, &motion, meta, &mut || true).unwrap().unwrap()
    };
    let first = learn(&sequence, 5);
    let found = again(&first);
    assert_eq!(found.summary.qps, [0; 4]);
    let sequence = Sequence::new("circle", &found.recording, &found.sensitivities).unwrap();
    let second = learn(&sequence, 300);
    let decoder = |model: &ResidualModel| match &model.design {
        ResidualDesign::Recurrent { decoder, .. } => decoder.clone(),
        ResidualDesign::Windowed { .. } => panic!("recurrent"),
    };
    assert_eq!(decoder(&first), decoder(&second), "displacements mean the same");
    // The body's tip is recorded, without what the first network adds to it along the robot.
    let mut targets = Vec::new();
    let mut stepper = Stepper::new(&twin);
    for (i, secret) in strokes_of(&found.recording).iter().enumerate().take(50) {
        auxiliary.targets_into(&strokes(i), secret, &mut targets);
        stepper.step(&twin, &targets).unwrap();
        // Both are in balance to 1e-6 of their forces: some 1e-8 m at the tip.
        assert!((twin.tip_of(stepper.state())[2] - sequence.twin[i][2]).abs() < 1e-7, "row {i}");
    }
    let (before, after) = (found.summary.after.rms_m, again(&second).summary.after.rms_m);
    assert!(after < 0.5 * before, "{after} after {before}");
}

/// Auxiliary strokes of a recording, sample by sample [m].
fn strokes_of(recording: &Recording) -> Vec<Vec<f64>> {
    let aux = recording.aux();
    (0..recording.n_samples()).map(|i| aux.iter().map(|series| series[i]).collect()).collect()
}

#[test]
fn recordings_identified_in_different_ways_are_not_mixed() {
    let twin = twin();
    let auxiliary = AuxiliaryLimits::new(&twin).unwrap();
    let [identified, longer] = [120, 160].map(|n| identified(&twin, &auxiliary, n).2);
    let with = |decoder: Option<StrokeDecoder>| {
        let mut sequence = identified.clone();
        sequence.decoder = decoder;
        sequence
    };
    let [one, another] = [identified.clone(), longer].map(|sequence| fit_decoder(&[sequence]).unwrap());
    let refusal = |sequences: &[Sequence]| {
        let sessions = Sessions { files: Vec::new(), progress: &|_, _| true };
        let options = RecurrentOptions::default();
        fit_recurrent(sequences, (&[vec![0], vec![1]], 0), "scene", &options, &sessions)
            .unwrap_err()
            .to_string()
    };
    let mixed = refusal(&[with(Some(one.clone())), with(None)]);
    assert!(mixed.contains("got auxiliary strokes by identification"), "{mixed}");
    let two = refusal(&[with(Some(one.clone())), with(Some(another))]);
    assert!(two.contains("those of another network"), "{two}");
    let sessions = Sessions { files: Vec::new(), progress: &|_, _| true };
    let sequences = [with(Some(one))];
    let paper = fit_windowed(&sequences, &sequences, "scene", &PUBLISHED, &sessions).unwrap_err().to_string();
    assert!(paper.contains("without --residual"), "{paper}");
}

#[test]
fn recordings_of_something_else_are_refused() {
    let twin = twin();
    let auxiliary = AuxiliaryLimits::new(&twin).unwrap();
    let good = recording(&twin, &auxiliary, 120, |_| vec![0.0; auxiliary.len()]);
    let remade = |change: &dyn Fn(&str, f64) -> Option<f64>, gap: Vec<bool>| {
        let channels = good.channels().iter().filter_map(|channel| {
            let values: Option<Vec<f64>> =
                channel.values.iter().map(|value| change(&channel.name, *value)).collect();
            Some(Channel::new(channel.name.clone(), values?))
        });
        let made =
            Recording::new(good.time().to_vec(), channels.collect(), gap, Metadata::default()).unwrap();
        RobotMotion::for_identification(&twin, &made, "rec").map(|_| ()).unwrap_err().to_string()
    };
    let other_robot = remade(&|name, value| (name != "stroke_4_m").then_some(value), Vec::new());
    assert!(other_robot.contains("stroke columns: expected 4"), "{other_robot}");
    let units =
        remade(&|name, value| Some(if name.starts_with("stroke") { 1e3 * value } else { value }), Vec::new());
    assert!(units.contains("is the unit of the column"), "{units}");
    let tip_units =
        remade(&|name, value| Some(if name.starts_with("tip") { 1e3 * value } else { value }), Vec::new());
    assert!(tip_units.contains("is the unit"), "{tip_units}");
    let moved = remade(&|name, value| Some(if name == "tip_x_m" { value + 0.02 } else { value }), Vec::new());
    assert!(moved.contains("was the tracker moved"), "{moved}");
    let dead = remade(&|name, value| Some(if name == "tip_y_m" { 0.0 } else { value }), Vec::new());
    assert!(dead.contains("tip_y_m"), "{dead}");
    let gaps = remade(&|_, value| Some(value), vec![true; 120]);
    assert!(gaps.contains("filled in"), "{gaps}");
    let short = Recording::new(
        good.time()[..50].to_vec(),
        good.channels().iter().map(|c| Channel::new(c.name.clone(), c.values[..50].to_vec())).collect(),
        Vec::new(),
        Metadata::default(),
    );
    let short =
        RobotMotion::for_identification(&twin, &short.unwrap(), "rec").map(|_| ()).unwrap_err().to_string();
    assert!(short.contains("at least 100"), "{short}");
}
