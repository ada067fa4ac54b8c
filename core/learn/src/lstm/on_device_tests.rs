//! Trainings on the device against those on the host.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use hysteron_base::rng;
use rand::RngExt;

use crate::{
    Adam, Architecture, Backprop, HeadActivation, HeadOutputs, Memory, Network, Penalty, SequenceBatch,
    Training,
};

const STEPS: usize = 12;
const ROWS: usize = 5;
const UPDATES: u64 = 10;
/// A gradient differs by at most √(STEPS² ROWS) ≈ 27 rounding errors of 2⁻²⁴ and four times that, relative to the largest; with
/// ε = 1 an update passes on no more, and there are ten of them.
const ACC: f64 = 10.0 * 4.0 * 27.0 * 0.5 * f32::EPSILON as f64;

fn uniform(name: &str, n: usize) -> Vec<f32> {
    let mut stream = rng(1, name);
    (0..n).map(|_| stream.random_range(-1.0..1.0)).collect()
}

fn training(penalty: Penalty) -> Training<Network> {
    let architecture = Architecture {
        inputs: 3,
        hidden: 6,
        layers: 2,
        outputs: 2,
        head: HeadActivation::Linear,
        dropout: 0.2,
    };
    let clip_norm = (penalty == Penalty::Coupled).then_some(0.5);
    let adam =
        Adam { learning_rate: 0.05, epsilon: 1.0, weight_decay: 0.1, penalty, clip_norm, ..Adam::default() };
    Training::new(Network::new(&architecture, 5).unwrap(), adam, Some(0.3)).unwrap()
}

/// The losses of some updates, with what is called before and after each of them.
fn losses(
    passes: &Backprop,
    training: &mut Training<Network>,
    mut watch: impl FnMut(&super::backprop::Updates<'_>),
) -> Vec<f64> {
    let mut updates = passes.updates(training).unwrap();
    let mut losses = Vec::new();
    for step in 0..UPDATES {
        let inputs = uniform(&format!("inputs {step}"), STEPS * ROWS * 3);
        let targets = uniform(&format!("targets {step}"), STEPS * ROWS * 2);
        let batch = SequenceBatch { inputs: &inputs, steps: STEPS, rows: ROWS, outputs: HeadOutputs::All };
        let mut memory = Memory::zeros(updates.training().model().architecture(), ROWS);
        let loss = |found: &[f32], d: &mut [f32]| crate::mean_squared_error(found, &targets, d);
        losses.push(updates.step(&batch, &mut memory, loss).unwrap());
        watch(&updates);
    }
    updates.finish().unwrap();
    losses
}

#[track_caller]
fn assert_near(what: &str, found: &[Vec<f32>], expected: &[Vec<f32>]) {
    let mut n = 0;
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        let off = f64::from((found - expected).abs());
        assert!(off <= ACC, "{what}: {found} {expected}");
        n += 1;
    }
    assert!(n > 0, "{what}: nothing to compare");
}

#[test]
fn a_training_on_the_device_is_that_on_the_host() {
    use crate::TrainableModel;
    for penalty in [Penalty::Coupled, Penalty::Decoupled] {
        let (mut host, mut device) = (training(penalty), training(penalty));
        let architecture = host.model().architecture().clone();
        let on_host = losses(&Backprop::new(&architecture, 7).unwrap(), &mut host, |_| ());
        let on_device = losses(&Backprop::as_on_card(&architecture, 7), &mut device, |_| ());
        for (host, device) in on_host.iter().zip(&on_device) {
            assert!((host - device).abs() <= ACC * host, "{penalty:?}: {on_host:?} {on_device:?}");
        }
        assert_eq!((host.steps(), device.steps()), (UPDATES, UPDATES));
        assert_near("weights", device.model().parameters(), host.model().parameters());
        assert_near("average", device.evaluated().parameters(), host.evaluated().parameters());
        let moments = |training: &Training<Network>| -> Vec<Vec<f32>> {
            training.optimiser().1.iter().flat_map(|own| [own.mean.clone(), own.square.clone()]).collect()
        };
        assert_near("moments", &moments(&device), &moments(&host));
    }
}

#[test]
fn weights_do_not_leave_the_device_between_updates() {
    let [mut training, before] = [Penalty::Coupled; 2].map(training);
    let passes = Backprop::as_on_card(training.model().architecture(), 7);
    let mut variables = Vec::new();
    losses(&passes, &mut training, |updates| {
        let own = updates.on_device().unwrap();
        variables.push(own.weights().vectors().iter().map(|weights| weights.id()).collect::<Vec<_>>());
        // Host arrays that updates had been copied to would have changed.
        let host = updates.training();
        assert_eq!((host.model(), host.steps()), (before.model(), 0));
        assert_eq!(host.optimiser().1, before.optimiser().1);
    });
    assert!(variables.iter().all(|ids| *ids == variables[0]), "weights were taken to the device again");
    assert_ne!(training.model(), before.model());
}
