//! Training learns tasks that need memory, resumes from a file, and refuses invalid input.

use hysteron_base::json;
use hysteron_learn::{
    Adam, Architecture, Error, HeadActivation, HeadOutputs, Memory, Network, SequenceBatch, Trainer,
};

use super::{architecture, mean_square, uniform};

#[test]
fn remembers_what_was_shown_only_at_first() {
    // A sign is shown in the first of eight samples, the others are zero. Without memory the best answer at the
    // end is the mean, 0, with a mean square of 1.
    const STEPS: usize = 8;
    const ROWS: usize = 32;
    let architecture = Architecture {
        inputs: 1,
        hidden: 8,
        layers: 2,
        outputs: 1,
        head: HeadActivation::Tanh,
        dropout: 0.0,
    };
    let adam = Adam { learning_rate: 2e-2, clip_norm: Some(1.0), ..Adam::default() };
    let mut trainer = Trainer::new(Network::new(&architecture, 1).unwrap(), adam, 0).unwrap();
    let mut value = f64::INFINITY;
    for step in 0..150 {
        let signs: Vec<f32> = uniform(&format!("signs {step}"), ROWS).iter().map(|v| v.signum()).collect();
        let inputs = [&signs[..], &[0.0; (STEPS - 1) * ROWS]].concat();
        let batch = SequenceBatch { inputs: &inputs, steps: STEPS, rows: ROWS, outputs: HeadOutputs::Last };
        let mut memory = Memory::zeros(&architecture, ROWS);
        value = trainer.step(&batch, &mut memory, mean_square(&signs)).unwrap();
    }
    // The signs of the last batch are new; a hundredth of the error of a network without memory.
    assert!(value < 0.01, "{value}");
}

/// Losses of some steps of training from here on; the memory is carried over through them.
fn losses(trainer: &mut Trainer, memory: &mut Memory, range: std::ops::Range<usize>) -> Vec<f64> {
    let step = |k| {
        let (inputs, targets) =
            (uniform(&format!("x {k}"), 6 * 4 * 3), uniform(&format!("y {k}"), 6 * 4 * 2));
        let batch = SequenceBatch { inputs: &inputs, steps: 6, rows: 4, outputs: HeadOutputs::All };
        trainer.step(&batch, memory, mean_square(&targets)).unwrap()
    };
    range.map(step).collect()
}

#[test]
fn training_resumes_from_its_file_bit_for_bit() {
    let architecture = architecture(8, 3, 0.3);
    let adam = Adam { weight_decay: 1e-3, clip_norm: Some(0.1), learning_rate: 0.013, ..Adam::default() };
    let mut trainer = Trainer::new(Network::new(&architecture, 1).unwrap(), adam, u64::MAX).unwrap();
    let mut memory = Memory::zeros(&architecture, 4);
    losses(&mut trainer, &mut memory, 0..3);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("training.safetensors");
    let details = json!({ "epoch": 3, "best": 0.1 });
    trainer.save(&path, &details).unwrap();
    let (mut resumed, found) = Trainer::load::<json::Value>(&path, trainer.network()).unwrap();
    assert_eq!(found, details);
    let mut copy = memory.clone();
    let expected = losses(&mut trainer, &mut memory, 3..6);
    assert_eq!(losses(&mut resumed, &mut copy, 3..6), expected);
    assert_eq!(resumed.network(), trainer.network());
    assert!(expected[0] != expected[1]);
}

#[test]
fn dropout_acts_in_training_only() {
    let [with, without] = [0.5, 0.0].map(|dropout| {
        let architecture = architecture(16, 2, dropout);
        let mut trainer = Trainer::new(Network::new(&architecture, 1).unwrap(), Adam::default(), 9).unwrap();
        let inputs = uniform("inputs", 6 * 4 * 3);
        let batch = SequenceBatch { inputs: &inputs, steps: 6, rows: 4, outputs: HeadOutputs::All };
        let predicted = trainer.predict(&batch, &mut Memory::zeros(&architecture, 4)).unwrap();
        let mut trained = Vec::new();
        let loss = |outputs: &[f32], _: &mut [f32]| {
            trained = outputs.to_vec();
            0.0
        };
        trainer.step(&batch, &mut Memory::zeros(&architecture, 4), loss).unwrap();
        (predicted, trained)
    });
    assert_eq!(with.0, without.0);
    assert_eq!(without.0, without.1);
    assert_ne!(with.0, with.1);
}

#[test]
fn refuses_batches_that_do_not_fit() {
    let architecture = architecture(4, 1, 0.0);
    let trainer = Trainer::new(Network::new(&architecture, 1).unwrap(), Adam::default(), 0).unwrap();
    let refusal = |inputs: &[f32], steps, rows, memory_rows| {
        let batch = SequenceBatch { inputs, steps, rows, outputs: HeadOutputs::All };
        match trainer.predict(&batch, &mut Memory::zeros(&architecture, memory_rows)) {
            Err(Error::BadInput(bad)) => bad.place,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(refusal(&[0.0; 11], 2, 2, 2), "batch: inputs");
    assert_eq!(refusal(&[], 0, 2, 2), "batch: inputs");
    assert_eq!(refusal(&[0.0; 12], 2, 2, 3), "memory");
    let mut inputs = [0.0; 12];
    inputs[10] = f32::NAN;
    assert_eq!(refusal(&inputs, 2, 2, 2), "batch: inputs: step 1, row 1, channel 1");
}

#[test]
fn a_step_that_is_not_finite_leaves_the_weights() {
    let architecture = architecture(4, 1, 0.0);
    let network = Network::new(&architecture, 1).unwrap();
    let mut trainer = Trainer::new(network.clone(), Adam::default(), 0).unwrap();
    let batch = SequenceBatch { inputs: &[0.5; 3], steps: 1, rows: 1, outputs: HeadOutputs::Last };
    for (value, slope, name) in [(f64::NAN, 0.0, "loss"), (1.0, f32::INFINITY, "norm of the gradient")] {
        let loss = |_: &[f32], d_outputs: &mut [f32]| {
            d_outputs.fill(slope);
            value
        };
        let found = trainer.step(&batch, &mut Memory::zeros(&architecture, 1), loss);
        assert!(matches!(found, Err(Error::NotFinite { step: 0, what, .. }) if what == name), "{found:?}");
        assert_eq!(trainer.network(), &network);
    }
}

#[test]
fn refuses_settings_out_of_range() {
    let network = || Network::new(&architecture(4, 1, 0.0), 1).unwrap();
    let good = Adam::default();
    let cases = [
        ("learning_rate", Adam { learning_rate: -1.0, ..good }),
        ("beta1", Adam { beta1: 1.0, ..good }),
        ("beta2", Adam { beta2: f64::NAN, ..good }),
        ("epsilon", Adam { epsilon: 0.0, ..good }),
        ("weight_decay", Adam { weight_decay: f64::INFINITY, ..good }),
        ("clip_norm", Adam { clip_norm: Some(0.0), ..good }),
    ];
    for (name, adam) in cases {
        match Trainer::new(network(), adam, 0) {
            Err(Error::BadInput(bad)) => assert_eq!(bad.place, format!("adam: {name}")),
            other => panic!("{name}: {other:?}"),
        }
    }
    let good = architecture(4, 1, 0.0);
    let cases = [
        ("inputs", Architecture { inputs: 0, ..good.clone() }),
        ("hidden", Architecture { hidden: 0, ..good.clone() }),
        ("layers", Architecture { layers: 0, ..good.clone() }),
        ("outputs", Architecture { outputs: usize::MAX, ..good.clone() }),
        ("dropout", Architecture { dropout: 1.0, ..good.clone() }),
    ];
    for (name, architecture) in cases {
        match Network::new(&architecture, 1) {
            Err(Error::BadInput(bad)) => assert_eq!(bad.place, format!("architecture: {name}")),
            other => panic!("{name}: {other:?}"),
        }
    }
}
