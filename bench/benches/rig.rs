//! The virtual rig: one second of the commanded circle. Each sample restores the world saved on it. The virtual arm: a trajectory
//! with an object picked up and put down twice, drawn, simulated and recorded.
#![allow(missing_docs)] // criterion's macros make undocumented functions
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a benchmark may stop where it stands, and prints its proof

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use hysteron_base::Metadata;
use hysteron_bench::rig::Circling;
use hysteron_virtual_rig::virtual_arm::{VirtualArm, data_set};

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

fn arm(criterion: &mut Criterion) {
    let arm = VirtualArm::preset("open-manipulator-x").unwrap().individual(1);
    let name = "weight/pick_place_object_500g/test/001";
    let planned = data_set().into_iter().find(|one| one.name() == name).unwrap();
    let record = || arm.record(&planned.trial, 1, name, Metadata::default()).unwrap();
    criterion.bench_function("rig/virtual-arm/pick_place_500g/serial", |bencher| bencher.iter(record));
    let start = std::time::Instant::now();
    let recording = record();
    let taken = start.elapsed().as_secs_f64();
    let last = recording.time()[recording.n_samples() - 1];
    println!("    {last:.1} s recorded; real-time factor of one more: {:.0}", last / taken);
}

criterion_group!(benches, world, arm);
criterion_main!(benches);
