//! Whole steps of the circular drive. Each sample restores the state saved on the circle and takes the same steps.
#![allow(missing_docs)] // criterion's macros make undocumented functions
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a benchmark may stop where it stands, and prints its proof

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use hysteron_bench::drive::{N_RAMP, with_strokes, with_tensions};
use hysteron_bench::repository;
use hysteron_studies::tendon::scenes::{N_PRIMARY, N_TENDONS, Setting, sofa_mesh, sofa_scene};
use hysteron_twin::Stepper;

/// Steps before the state is saved, and steps of a sample.
const N_WARM: usize = N_RAMP + 50;
const N_SAMPLE: usize = 50;

fn steps(criterion: &mut Criterion) {
    let mesh = sofa_mesh(repository()).unwrap();
    for (n, setting) in
        [(N_PRIMARY, Setting::TARGETS), (N_PRIMARY, Setting::RUBBING), (N_TENDONS, Setting::TARGETS)]
    {
        let twin = sofa_scene(repository(), setting, &mesh, n).unwrap();
        let targets = if n == N_PRIMARY {
            with_tensions(n, N_WARM + N_SAMPLE, 0.0)
        } else {
            with_strokes(&twin, N_WARM + N_SAMPLE).unwrap()
        };
        let mut stepper = Stepper::new(&twin);
        for targets in &targets[..N_WARM] {
            stepper.step(&twin, targets).unwrap();
        }
        let mut worst = 0.0f64;
        let name = match twin.friction.len() {
            0 => format!("step/circle/{n}/{N_SAMPLE} steps"),
            points => format!("step/circle/{n} + {points} friction points/{N_SAMPLE} steps"),
        };
        criterion.bench_function(&name, |bencher| {
            bencher.iter_batched(
                || stepper.clone(),
                |mut stepper| {
                    for targets in &targets[N_WARM..] {
                        let report = stepper.step(&twin, targets).unwrap();
                        worst = worst.max(report.relative_residual);
                    }
                    stepper
                },
                BatchSize::LargeInput,
            );
        });
        println!("    worst relative residual {worst:.1e}");
    }
}

criterion_group!(benches, steps);
criterion_main!(benches);
