//! A chain of sections as the body of a twin, next to the finite elements that it was made from.

use hysteron_base::{Channel, MaterialLaw, Metadata, Recording};
use hysteron_fem::Order;
use hysteron_twin::chain::{Chain, Equilibrium, ValidationOptions};
use hysteron_twin::coreact::{AuxiliaryLimits, Identifier, IdentifyOptions, identify};
use hysteron_twin::synthetic::{OUTSIDE_VALIDATION, RecordedStrokes, SyntheticOutcome, synthesise};
use hysteron_twin::{
    FrictionPoints, PhysicsTwin, RobotMotion, Stepper, Target, TipGoal, Twin, TwinState, rollouts,
};

use super::{distance, scenes, strokes};

/// Finite elements with auxiliary tendons and friction, and the same robot moved by their chain.
fn both() -> (Twin, Twin) {
    let (mut scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, 24);
    scene.auxiliary = scenes::actuated(4).0.auxiliary;
    scenes::roughen(&mut scene, 2e-4);
    let mesh = Twin::new(&scene, &mesh).unwrap();
    let chain = mesh.clone().with_chain(Chain::new(&mesh).unwrap());
    (mesh, chain)
}

/// Strokes of a small circle, with antagonists released.
fn circle(i: usize) -> [f64; 4] {
    let (sin, cos) = (0.05 * i as f64).sin_cos();
    let ramp = 1e-3 * (i as f64 / 60.0).min(1.0);
    [cos * ramp, sin * ramp, -cos * ramp, -sin * ramp]
}

#[test]
fn tip_of_the_finite_elements_with_secret_strokes_is_met_by_their_chain() {
    let (mesh, chain) = both();
    let auxiliary = AuxiliaryLimits::new(&mesh).unwrap();
    let (mut stepper, mut targets, n) = (Stepper::new(&mesh), Vec::new(), 150usize);
    let mut columns = vec![Vec::new(); 7];
    for i in 0..n {
        let late = circle(i.saturating_sub(8));
        let secret: Vec<f64> = (0..auxiliary.len()).map(|k| 0.02 * late[k % 4]).collect();
        auxiliary.targets_into(&circle(i), &secret, &mut targets);
        stepper.step(&mesh, &targets).unwrap();
        let row = circle(i).into_iter().chain(mesh.tip_of(stepper.state()));
        columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
    }
    let names = ["stroke_1_m", "stroke_2_m", "stroke_3_m", "stroke_4_m", "tip_x_m", "tip_y_m", "tip_z_m"];
    let channels = names.into_iter().zip(columns).map(|(name, values)| Channel::new(name, values)).collect();
    let time = (0..n).map(|i| 0.01 * i as f64).collect();
    let recording = Recording::new(time, channels, Vec::new(), Metadata::default()).unwrap();
    let motion = RobotMotion::for_identification(&chain, &recording, "rec").unwrap();
    let options =
        IdentifyOptions { regularisation: 1e-6, rounds: 4, tolerance: 1e-7, ..IdentifyOptions::default() };
    let auxiliary = AuxiliaryLimits::new(&chain).unwrap();
    let mut identifier = Identifier::new(&chain, &auxiliary, options);
    let done =
        identify(&chain, &mut identifier, &motion, Metadata::default(), &mut || true).unwrap().unwrap();
    // Half of the samples end at the tolerance; the others change what sticks and slips, which the linearisation does not see.
    let [before, after] = [&done.summary.before, &done.summary.after];
    assert!(after.median_m < 1e-7 && after.p99_m < 0.1 * before.p99_m, "{:?}", done.summary);
    assert!(done.summary.before.median_m > 2e-5, "{:?}", done.summary.before);
    // No validation, so nothing can lie outside of one.
    assert_eq!(done.summary.samples_outside_validation, 0);
}

#[test]
fn work_on_a_chain_with_friction_is_lost_on_every_closed_cycle_and_never_gained() {
    let (_, twin) = both();
    let mut stepper = Stepper::new(&twin);
    let resting = twin.tendons[twin.n_primary..].iter().map(|_| Target::Tension(0.0));
    let targets =
        |i: usize| -> Vec<Target> { strokes(&circle(i)).into_iter().chain(resting.clone()).collect() };
    let step = |stepper: &mut Stepper, i: usize| -> (Vec<f64>, Vec<f64>) {
        stepper.step(&twin, &targets(i)).unwrap();
        (stepper.state().tensions[..4].to_vec(), stepper.commands(&twin)[..4].to_vec())
    };
    // Twice around after the ramp; 126 samples are a turn within a tenth of a sample.
    (0..100).for_each(|i| drop(step(&mut stepper, i)));
    let mut before = step(&mut stepper, 100);
    let mut work = [0.0; 2];
    for i in 101..=352 {
        let now = step(&mut stepper, i);
        work[(i - 101) / 126] +=
            (0..4).map(|j| 0.5 * (now.0[j] + before.0[j]) * (now.1[j] - before.1[j])).sum::<f64>();
        before = now;
    }
    // The same cycle again loses as much: what remains is the tenth of a sample, and the friction that lags a step behind.
    assert!(work[0] > 0.0 && (work[1] / work[0] - 1.0).abs() < 0.02, "{work:?}");
}

#[test]
fn chain_reaches_goals_resumes_and_rolls_out_as_any_body() {
    let (mesh, chain) = both();
    let resting = |twin: &Twin| vec![Target::Tension(0.0); twin.tendons.len() - twin.n_primary];
    let with = |values: &[f64]| [strokes(values), resting(&chain)].concat();
    let mut stepper = Stepper::new(&chain);
    stepper.step(&chain, &with(&[1e-3, 2e-4, -1e-3, -2e-4])).unwrap();
    let bent = stepper.state().clone();
    let n_interfaces = chain.chain.as_ref().unwrap().n_sections() + 1;
    assert!(bent.positions.is_empty() && bent.interfaces.len() == n_interfaces);
    // In a file, and on from there.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("chain.state");
    bent.write(&path, &chain, "abc", "test").unwrap();
    let read = TwinState::read(&path, &chain, "abc").unwrap();
    assert_eq!(read, bent);
    let refused = TwinState::read(&path, &mesh, "abc").expect_err("a mesh has no interfaces").to_string();
    assert!(refused.contains(&format!("{n_interfaces} interfaces")), "{refused}");
    let mut other = Stepper::new(&mesh);
    assert!(other.restore(&mesh, &bent).is_err());
    let on: Vec<Vec<Target>> =
        (1..=5).map(|k| with(&[1e-3 + 1e-5 * f64::from(k), 2e-4, -1e-3, -2e-4])).collect();
    let rolled = rollouts(&chain, &read, &[on.clone(), on.clone()]);
    let [a, b] = &rolled[..] else { panic!("two") };
    assert_eq!(a.as_ref().unwrap(), b.as_ref().unwrap());
    stepper.step(&chain, &on[0]).unwrap();
    assert!(distance(chain.tip_of(stepper.state()), a.as_ref().unwrap().tips[0]) < 1e-8);
    // A goal where the bent tip was, from rest.
    let mut free = Stepper::new(&chain);
    let goal = TipGoal {
        position: chain.tip_of(&bent).map(Some),
        tolerance: 2e-5,
        regularisation: 1e-6,
        least_gain: 0.0,
    };
    let drives = [vec![Target::Free; 4], resting(&chain)].concat();
    let found = free.reach(&chain, &goal, &drives).unwrap();
    assert!(found.is_reached, "{found:?}");
    // Small pulls of the tip are those of the finite elements.
    let per_force = |twin: &Twin| {
        let mut stepper = Stepper::new(twin);
        stepper.step(twin, &with(&[1e-3, 2e-4, -1e-3, -2e-4])).unwrap();
        stepper.tip_response(twin, FrictionPoints::AsTheyAre).unwrap().per_force
    };
    let (found, expected) = (per_force(&chain), per_force(&mesh));
    let largest = expected.iter().flatten().fold(0.0f64, |max, c| max.max(c.abs()));
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        // The adjoints of the mesh leave a tenth of a per cent; the chain, as its steps, is off by as much.
        assert!((found - expected).abs() < 5e-3 * largest, "{found} for {expected}");
    }
}

#[test]
fn synthetic_data_flag_what_lies_beyond_a_validation() {
    let (mesh, _) = both();
    let mut chain = Chain::new(&mesh).unwrap();
    let options = ValidationOptions { count: 1, stroke: 2e-4, tension: 0.0, seed: 1 };
    chain.validate(&mesh, &options, &Equilibrium::all(&mesh, &options).unwrap()).unwrap();
    let time: Vec<f64> = (0..120).map(|i| 0.01 * f64::from(i)).collect();
    let columns = (0..4).map(|k| {
        let values = (0..120).map(|i| circle(i)[k]).collect();
        Channel::new(format!("stroke_{}_m", k + 1), values)
    });
    let commands = Recording::new(time, columns.collect(), Vec::new(), Metadata::default()).unwrap();
    let flags = |twin: &Twin| -> Option<Vec<f64>> {
        let mut drive = RecordedStrokes::new(twin, &commands).unwrap();
        let mut plant = PhysicsTwin::new(twin);
        let made = synthesise(twin, &mut plant, &mut drive, Metadata::default(), &mut || true).unwrap();
        let SyntheticOutcome::Made(recording) = made else { panic!("{made:?}") };
        recording.channel(OUTSIDE_VALIDATION).map(<[f64]>::to_vec)
    };
    assert_eq!(flags(&mesh), None);
    let found = flags(&mesh.with_chain(chain)).unwrap();
    assert_eq!((found[0], found[119]), (0.0, 1.0));
}
