//! Training by epochs: the moving average of the weights, the best of them, and their file.

use hysteron_base::json;
use hysteron_learn::{Adam, Backprop, HeadOutputs, Memory, Network, SequenceBatch, Trainer, Training};

use super::{architecture, mean_square, uniform};

fn network() -> Network {
    Network::new(&architecture(5, 2, 0.2), 1).unwrap()
}

fn training(ema: Option<f32>) -> Training<Network> {
    Training::new(network(), Adam::default(), ema).unwrap()
}

/// One epoch of two updates that ends with the given error.
fn epoch(training: &mut Training<Network>, error: f64) {
    let passes = Backprop::new(training.model().architecture(), 2).unwrap();
    let mut memory = Memory::zeros(training.model().architecture(), 4);
    for k in 0..2 {
        let name = format!("{k} of {}", training.epochs());
        let (inputs, targets) = (uniform(&name, 6 * 4 * 3), uniform(&name, 6 * 4 * 2));
        let batch = SequenceBatch { inputs: &inputs, steps: 6, rows: 4, outputs: HeadOutputs::All };
        passes.update(training, &batch, &mut memory, mean_square(&targets)).unwrap();
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
    let (mut resumed, details) = Training::load::<json::Value>(&path, &network()).unwrap();
    assert_eq!(details, json!({ "seed": 3 }));
    errors[2..].iter().for_each(|&error| epoch(&mut resumed, error));
    assert_eq!(resumed.evaluated(), whole.evaluated());
    assert_eq!(resumed.best(), whole.best());
    assert_eq!(resumed.curve(), whole.curve());
    assert_eq!(whole.curve()[1], [2.0 * (0.1 + 0.2), 0.1 + 0.2]);
    let (best, epochs, error) = whole.best().unwrap();
    assert_eq!((epochs, error, whole.epochs()), (2, 0.1 + 0.2, 4));
    assert_ne!(best, whole.evaluated());
    assert!(whole.is_stuck(2) && !whole.is_stuck(3));
}

#[test]
fn the_average_lies_between_the_weights_before_and_after() {
    // With all of it replaced it is the weights themselves.
    let [mut own, mut replaced, mut average] = [None, Some(1.0), Some(0.5)].map(training);
    let before = own.evaluated().clone();
    for training in [&mut own, &mut replaced, &mut average] {
        epoch(training, 1.0);
    }
    assert_eq!(own.evaluated(), replaced.evaluated());
    assert_ne!(own.evaluated(), average.evaluated());
    assert_ne!(&before, average.evaluated());
    let error = Training::new(before, Adam::default(), Some(0.0)).err().unwrap().to_string();
    assert!(error.starts_with("ema: "), "{error}");
}

#[test]
fn a_file_of_another_network_or_family_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.training");
    Trainer::new(network(), Adam::default(), 2).unwrap().save(&path, &json!(null)).unwrap();
    let wider = Network::new(&architecture(6, 2, 0.2), 1).unwrap();
    let refusal = Training::load::<()>(&path, &wider).unwrap_err().to_string();
    assert!(refusal.contains("shape") && refusal.contains("out.training"), "{refusal}");
    let vector = hysteron_learn::ParameterVector::new(vec![0.0f32; 3]);
    let refusal = Training::load::<()>(&path, &vector).unwrap_err().to_string();
    assert!(refusal.contains("family: expected vector, got lstm"), "{refusal}");
}
