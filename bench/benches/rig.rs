//! The virtual rig: one second of the commanded circle. Each sample restores the world saved on it.
#![allow(missing_docs)] // criterion's macros make undocumented functions
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a benchmark may stop where it stands, and prints its proof

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use hysteron_bench::rig::Circling;

fn world(criterion: &mut Criterion) {
    let mut circling = Circling::new().unwrap();
    (0..1500).for_each(|_| circling.cycle());
    for (name, always) in [("kept factors", false), ("new factors", true)] {
        let mut start = circling.clone();
        if always {
            start.world.always_factorise();
        }
        let mut failures = 0;
        criterion.bench_function(&format!("rig/world/{name}/1 s at 100 Hz"), |bencher| {
            bencher.iter_batched(
                || start.clone(),
                |mut circling| {
                    (0..100).for_each(|_| circling.cycle());
                    failures = circling.world.balance_counts().failures;
                    circling
                },
                BatchSize::LargeInput,
            );
        });
        println!("    failures {failures}");
    }
}

criterion_group!(benches, world);
criterion_main!(benches);
