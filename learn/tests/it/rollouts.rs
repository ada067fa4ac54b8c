//! A runner and a sequence are the same network.

use hysteron_learn::{Adam, Architecture, Batch, Head, Memory, Network, Outputs, Runner, Trainer};

use super::{architecture, uniform};

/// Round-off of sums of 70 products through 40 steps of a network whose memory fades: √70 · 2⁻²⁴ a step, and ten
/// times that.
const TOL: f32 = 10.0 * 8.4 * 0.5 * f32::EPSILON;

#[test]
fn runner_steps_as_the_sequence_does() {
    // 67 units: neither whole registers nor whole panels.
    for hidden in [5, 67] {
        let architecture = architecture(hidden, 2, 0.5);
        let network = Network::new(&architecture, 3).unwrap();
        let inputs = uniform("inputs", 40 * 3);
        let batch = Batch { inputs: &inputs, steps: 40, rows: 1, outputs: Outputs::All };
        let mut runner = Runner::new(&network);
        let trainer = Trainer::new(network, Adam::default(), 0).unwrap();
        let expected = trainer.predict(&batch, &mut Memory::zeros(&architecture, 1)).unwrap();
        for _ in 0..2 {
            for (input, expected) in inputs.chunks(3).zip(expected.chunks(2)) {
                for (found, expected) in runner.step(input).iter().zip(expected) {
                    assert!((found - expected).abs() <= TOL, "{found} {expected}");
                }
            }
            // Again from nothing.
            runner.reset();
        }
        assert!(expected[..2] != expected[78..], "the outputs move");
    }
}

#[test]
fn weights_of_a_large_network_are_kept_in_sixteen_bits() {
    let architecture = architecture(256, 2, 0.0);
    let network = Network::new(&architecture, 3).unwrap();
    assert!(4 * network.n_parameters() > 1 << 20);
    let inputs = uniform("inputs", 400 * 3);
    let batch = Batch { inputs: &inputs, steps: 400, rows: 1, outputs: Outputs::All };
    let mut runner = Runner::new(&network);
    let trainer = Trainer::new(network, Adam::default(), 0).unwrap();
    let expected = trainer.predict(&batch, &mut Memory::zeros(&architecture, 1)).unwrap();
    let mut largest = 0.0f32;
    for (input, expected) in inputs.chunks(3).zip(expected.chunks(2)) {
        for (found, expected) in runner.step(input).iter().zip(expected) {
            largest = largest.max((found - expected).abs());
        }
    }
    // Outputs of a controller stand for strokes of ±15 mm, and less than a micrometre is to be lost.
    assert!(0.0 < largest && largest < 1e-6 / 15e-3, "{largest}");
}

#[test]
fn a_sequence_may_be_cut_anywhere() {
    let architecture = architecture(8, 2, 0.0);
    let trainer = Trainer::new(Network::new(&architecture, 3).unwrap(), Adam::default(), 0).unwrap();
    let inputs = uniform("inputs", 10 * 2 * 3);
    let predict = |inputs: &[f32], memory: &mut Memory| {
        let batch = Batch { inputs, steps: inputs.len() / 6, rows: 2, outputs: Outputs::All };
        trainer.predict(&batch, memory).unwrap()
    };
    let (mut whole, mut parts) = (Memory::zeros(&architecture, 2), Memory::zeros(&architecture, 2));
    let expected = predict(&inputs, &mut whole);
    let found = [predict(&inputs[..18], &mut parts), predict(&inputs[18..], &mut parts)].concat();
    assert_eq!(found, expected);
    assert_eq!(parts, whole);
    // The last outputs alone.
    let last = Batch { inputs: &inputs, steps: 10, rows: 2, outputs: Outputs::Last };
    let found = trainer.predict(&last, &mut Memory::zeros(&architecture, 2)).unwrap();
    assert_eq!(found, expected[36..]);
}

#[test]
fn a_cleared_row_begins_anew() {
    let architecture = architecture(8, 2, 0.0);
    let trainer = Trainer::new(Network::new(&architecture, 3).unwrap(), Adam::default(), 0).unwrap();
    let inputs = uniform("inputs", 4 * 2 * 3);
    let batch = Batch { inputs: &inputs, steps: 4, rows: 2, outputs: Outputs::All };
    let mut memory = Memory::zeros(&architecture, 2);
    let first = trainer.predict(&batch, &mut memory).unwrap();
    memory.clear_row(1);
    let second = trainer.predict(&batch, &mut memory).unwrap();
    for (step, (first, second)) in first.chunks(4).zip(second.chunks(4)).enumerate() {
        assert_ne!(first[..2], second[..2], "row 0 remembers at step {step}");
        assert_eq!(first[2..], second[2..], "row 1 does not at step {step}");
    }
}

#[test]
fn joined_networks_give_the_mean_of_their_outputs() {
    let architecture = Architecture { head: Head::Linear, ..architecture(11, 2, 0.0) };
    let members: Vec<Network> = (0..3).map(|seed| Network::new(&architecture, seed).unwrap()).collect();
    let joined = Network::mean_of(&members).unwrap();
    assert_eq!(joined.architecture().hidden, 33);
    let (mut joined, mut runners) =
        (Runner::new(&joined), members.iter().map(Runner::new).collect::<Vec<Runner>>());
    for input in uniform("inputs", 40 * 3).chunks(3) {
        let mut mean = [0.0f32; 2];
        for runner in &mut runners {
            mean.iter_mut().zip(runner.step(input)).for_each(|(mean, output)| *mean += output / 3.0);
        }
        for (found, expected) in joined.step(input).iter().zip(mean) {
            assert!((found - expected).abs() <= TOL, "{found} {expected}");
        }
    }
    let wider = Network::new(&Architecture { hidden: 12, ..architecture }, 1).unwrap();
    assert!(Network::mean_of(&[members[0].clone(), wider]).is_err());
    assert!(Network::mean_of(&[]).is_err());
}
