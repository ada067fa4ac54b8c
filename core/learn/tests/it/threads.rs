//! Training gives the same bits on any number of threads.

use std::process::Command;

use hysteron_learn::{
    Adam, Architecture, HeadActivation, HeadOutputs, Memory, Network, SequenceBatch, Trainer,
};

use super::{mean_square, uniform};

const THREADS: &str = "RAYON_NUM_THREADS";

/// Sum of the bits of everything that two steps of training leave behind.
fn digest() -> u64 {
    let architecture = Architecture {
        inputs: 3,
        hidden: 96,
        layers: 2,
        outputs: 5,
        head: HeadActivation::Tanh,
        dropout: 0.2,
    };
    let (steps, rows) = (40, 70);
    let network = Network::new(&architecture, 3).unwrap();
    let mut trainer = Trainer::new(network, Adam::default(), 7).unwrap();
    let (inputs, targets) = (uniform("inputs", steps * rows * 3), uniform("targets", steps * rows * 5));
    let batch = SequenceBatch { inputs: &inputs, steps, rows, outputs: HeadOutputs::All };
    let mut memory = Memory::zeros(&architecture, rows);
    for _ in 0..2 {
        trainer.step(&batch, &mut memory, mean_square(&targets)).unwrap();
    }
    let outputs = trainer.predict(&batch, &mut memory).unwrap();
    outputs.iter().fold(0, |sum, v| sum.rotate_left(5).wrapping_add(u64::from(v.to_bits())))
}

#[test]
fn bits_do_not_depend_on_threads() {
    // Threads are counted once in a process: each count has its own.
    let name = "threads::prints_a_digest";
    let run = |threads: &str| {
        let mut command = Command::new(std::env::current_exe().unwrap());
        let output = command.args([name, "--exact", "--nocapture"]).env(THREADS, threads).output().unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        let digest = text.lines().find_map(|line| line.split("digest ").nth(1)).map(str::to_owned);
        digest.unwrap_or_else(|| panic!("no digest in {text}"))
    };
    let expected = run("1");
    assert_ne!(expected, "0");
    for threads in ["2", "3", "8"] {
        assert_eq!(run(threads), expected, "{threads} threads");
    }
}

#[test]
fn prints_a_digest() {
    let digest = digest();
    assert_ne!(digest, 0);
    // For the test above, which reads it from other processes.
    std::io::Write::write_all(&mut std::io::stderr(), format!("\ndigest {digest}\n").as_bytes()).unwrap();
}
