//! A runner and a sequence are the same network.

use hysteron_learn::{
    Adam, Architecture, ChannelRange, HeadActivation, HeadOutputs, Memory, Network, NetworkRunner,
    Normaliser, SequenceBatch, Trainer, WeightFormat,
};

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
        let batch = SequenceBatch { inputs: &inputs, steps: 40, rows: 1, outputs: HeadOutputs::All };
        let mut runner = NetworkRunner::new(&network);
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
fn weights_are_kept_in_sixteen_bits_where_that_is_asked_for_and_only_there() {
    let architecture = architecture(256, 2, 0.0);
    let network = Network::new(&architecture, 3).unwrap();
    assert!(4 * network.n_parameters() > 1 << 20);
    let inputs = uniform("inputs", 400 * 3);
    let batch = SequenceBatch { inputs: &inputs, steps: 400, rows: 1, outputs: HeadOutputs::All };
    let runners = [WeightFormat::Float32, WeightFormat::Int16]
        .map(|format| NetworkRunner::with_weights(&network, format));
    let trainer = Trainer::new(network, Adam::default(), 0).unwrap();
    let expected = trainer.predict(&batch, &mut Memory::zeros(&architecture, 1)).unwrap();
    let [single, short] = runners.map(|mut runner| {
        let mut largest = 0.0f32;
        for (input, expected) in inputs.chunks(3).zip(expected.chunks(2)) {
            for (found, expected) in runner.step(input).iter().zip(expected) {
                largest = largest.max((found - expected).abs());
            }
        }
        largest
    });
    // Sums of 512 products instead of 70.
    assert!(single <= TOL * (512.0f32 / 70.0).sqrt(), "{single}");
    // Outputs of a controller are scaled to strokes of ±15 mm, and less than a micrometre is to be lost.
    assert!(single < short && short < 1e-6 / 15e-3, "{short}");
}

#[test]
fn a_sequence_may_be_cut_anywhere() {
    let architecture = architecture(8, 2, 0.0);
    let trainer = Trainer::new(Network::new(&architecture, 3).unwrap(), Adam::default(), 0).unwrap();
    let inputs = uniform("inputs", 10 * 2 * 3);
    let predict = |inputs: &[f32], memory: &mut Memory| {
        let batch = SequenceBatch { inputs, steps: inputs.len() / 6, rows: 2, outputs: HeadOutputs::All };
        trainer.predict(&batch, memory).unwrap()
    };
    let (mut whole, mut parts) = (Memory::zeros(&architecture, 2), Memory::zeros(&architecture, 2));
    let expected = predict(&inputs, &mut whole);
    let found = [predict(&inputs[..18], &mut parts), predict(&inputs[18..], &mut parts)].concat();
    assert_eq!(found, expected);
    assert_eq!(parts, whole);
    // The last outputs alone.
    let last = SequenceBatch { inputs: &inputs, steps: 10, rows: 2, outputs: HeadOutputs::Last };
    let found = trainer.predict(&last, &mut Memory::zeros(&architecture, 2)).unwrap();
    assert_eq!(found, expected[36..]);
}

#[test]
fn joined_networks_give_the_mean_of_their_outputs() {
    let architecture = Architecture { head: HeadActivation::Linear, ..architecture(11, 2, 0.0) };
    let members: Vec<Network> = (0..3).map(|seed| Network::new(&architecture, seed).unwrap()).collect();
    let joined = Network::mean_of(&members).unwrap();
    assert_eq!(joined.architecture().hidden, 33);
    let (mut joined, mut runners) =
        (NetworkRunner::new(&joined), members.iter().map(NetworkRunner::new).collect::<Vec<NetworkRunner>>());
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
    let bad = Network::mean_of(&[members[0].clone(), wider]).unwrap_err();
    assert_eq!(bad.expected, "one shape, with a linear head");
    assert_eq!(Network::mean_of(&[]).unwrap_err().expected, "at least one");
}

#[test]
fn a_network_for_other_ranges_is_the_same_function() {
    let range = |name: &str, min: f64, max: f64| ChannelRange { name: name.to_owned(), min, max };
    let inputs = |widths: [f64; 3]| {
        let channels =
            ["a", "b", "c"].iter().zip(widths).map(|(name, width)| range(name, -0.3 * width, 0.7 * width));
        Normaliser::new(channels.collect()).unwrap()
    };
    let outputs = |at: f64| Normaliser::new(vec![range("u", at, at + 0.5), range("v", -at, 2.0)]).unwrap();
    // A channel that was constant in training has no information, for any other ranges.
    let own = [inputs([1.0, 2.0, 0.0]), outputs(0.1)];
    let union = [
        Normaliser::union(&[&own[0], &inputs([3.0, 1.0, 2.0])]).unwrap(),
        Normaliser::union(&[&own[1], &outputs(0.4)]).unwrap(),
    ];
    let architecture = Architecture { head: HeadActivation::Linear, ..architecture(11, 2, 0.0) };
    let network = Network::new(&architecture, 5).unwrap();
    let moved = network.for_ranges([&own[0], &own[1]], [&union[0], &union[1]]).unwrap();
    let step = |runner: &mut NetworkRunner, [inputs, outputs]: &[Normaliser; 2], values: &[f64]| {
        let mut normalised = [0.0; 3];
        inputs.normalise_into(values, &mut normalised);
        let mut found = [0.0; 2];
        outputs.restore_into(runner.step(&normalised), &mut found);
        found
    };
    let (mut here, mut there) = (NetworkRunner::new(&network), NetworkRunner::new(&moved));
    for values in uniform("values", 40 * 3).chunks(3) {
        let values: Vec<f64> = values.iter().map(|v| f64::from(*v)).collect();
        let [a, b] = [step(&mut here, &own, &values), step(&mut there, &union, &values)];
        // Ranges up to three times as wide, each rounding once more.
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 3.0 * 2.0 * f64::from(TOL)), "{a:?} {b:?}");
    }
    let tanh = Network::new(&Architecture { head: HeadActivation::Tanh, ..architecture }, 5).unwrap();
    let bad = tanh.for_ranges([&own[0], &own[1]], [&union[0], &union[1]]).unwrap_err();
    assert_eq!(bad.expected, "a linear head");
}
