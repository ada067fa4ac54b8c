//! Training by epochs: the mean of the weights, the best of them, and their file.

use hysteron_learn::{Adam, Batch, Memory, Network, Outputs, Trainer, Training};
use serde_json::json;

use super::{architecture, mean_square, uniform};

fn training(renewed: Option<f32>) -> Training {
    let network = Network::new(&architecture(5, 2, 0.2), 1).unwrap();
    Training::new(Trainer::new(network, Adam::default(), 2).unwrap(), renewed)
}

/// One epoch of two steps that ends with the given error.
fn epoch(training: &mut Training, error: f64) {
    let mut memory = Memory::zeros(training.network().architecture(), 4);
    for k in 0..2 {
        let name = format!("{k} of {}", training.epochs());
        let (inputs, targets) = (uniform(&name, 6 * 4 * 3), uniform(&name, 6 * 4 * 2));
        let batch = Batch { inputs: &inputs, steps: 6, rows: 4, outputs: Outputs::All };
        training.step(&batch, &mut memory, mean_square(&targets)).unwrap();
    }
    training.end_epoch(2.0 * error, error);
}

#[test]
fn an_interrupted_training_ends_as_one_that_was_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.training");
    // The best comes before the interruption; a double that text of few digits would not keep.
    let errors = [1.0, 0.1 + 0.2, 0.7, 0.6];
    let mut whole = training(Some(0.1));
    errors.iter().for_each(|&error| epoch(&mut whole, error));
    let mut part = training(Some(0.1));
    errors[..2].iter().for_each(|&error| epoch(&mut part, error));
    part.save(&path, &json!({ "seed": 3 })).unwrap();
    let (mut resumed, details) = Training::load(&path).unwrap();
    assert_eq!(details, json!({ "seed": 3 }));
    errors[2..].iter().for_each(|&error| epoch(&mut resumed, error));
    assert_eq!(resumed.network(), whole.network());
    assert_eq!(resumed.best(), whole.best());
    assert_eq!(resumed.curve(), whole.curve());
    assert_eq!(whole.curve()[1], [2.0 * (0.1 + 0.2), 0.1 + 0.2]);
    let (best, epochs, error) = whole.best().unwrap();
    assert_eq!((epochs, error, whole.epochs()), (2, 0.1 + 0.2, 4));
    assert_ne!(best, whole.network());
    assert!(whole.is_stuck(2) && !whole.is_stuck(3));
}

#[test]
fn the_mean_lies_between_the_weights_before_and_after() {
    // With the whole renewed it is the weights themselves.
    let [mut own, mut renewed, mut mean] = [None, Some(1.0), Some(0.5)].map(training);
    let before = own.network().clone();
    for training in [&mut own, &mut renewed, &mut mean] {
        epoch(training, 1.0);
    }
    assert_eq!(own.network(), renewed.network());
    assert_ne!(own.network(), mean.network());
    assert_ne!(&before, mean.network());
}

#[test]
fn a_file_of_a_trainer_alone_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.training");
    let network = Network::new(&architecture(5, 2, 0.2), 1).unwrap();
    Trainer::new(network, Adam::default(), 2).unwrap().save(&path, &json!(null)).unwrap();
    let refusal = Training::load(&path).unwrap_err().to_string();
    assert!(refusal.contains("course") && refusal.contains("out.training"), "{refusal}");
}
