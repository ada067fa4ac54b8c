//! Forces and assembly of one body, on the widest instruction set and on the portable path.
#![allow(missing_docs)] // criterion's macros make undocumented functions
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a benchmark may stop where it stands, and prints its proof

use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use hysteron_base::MaterialLaw;
use hysteron_base::lanes::Isa;
use hysteron_bench::repository;
use hysteron_fem::{FemModel, Mesh, Stiffness, Tangent};
use hysteron_studies::tendon::scenes::{N_PRIMARY, Setting, sofa_mesh, sofa_scene};
use hysteron_twin::{Stepper, Target};

/// The body and node positions with the robot bent by 3 mm of stroke.
fn bent(mesh: &Mesh) -> (FemModel, Vec<[f64; 4]>) {
    let setting = Setting { law: MaterialLaw::Corotational, ..Setting::TARGETS };
    let twin = sofa_scene(repository(), setting, mesh, N_PRIMARY).unwrap();
    let mut stepper = Stepper::new(&twin);
    let targets = [3e-3, 0.0, -3e-3, 0.0].map(Target::Stroke);
    stepper.step(&twin, &targets).unwrap();
    (std::sync::Arc::unwrap_or_clone(twin.body), stepper.state().positions.clone())
}

fn kernels(criterion: &mut Criterion) {
    let linear = sofa_mesh(repository()).unwrap();
    for (name, mesh) in [("tet10", linear.to_quadratic()), ("tet4", linear)] {
        let (body, x) = bent(&mesh);
        let n = body.n_unknowns();
        let mut force = vec![[0.0; 4]; body.n_nodes()];
        for (set, isa) in [("simd", Isa::detect()), ("portable", Isa::portable())] {
            let body = body.clone().with_isa(isa);
            criterion.bench_function(&format!("force/{name}/{set}/n={n}"), |bencher| {
                bencher.iter(|| body.internal_force_into(&x, &mut force));
            });
            let norm = force.as_flattened().iter().map(|f| f * f).sum::<f64>().sqrt();
            println!("    norm of the forces {norm:.12e} N");
            let mut stiffness = Stiffness::zeros(Arc::new(body.stiffness_pattern(&[])));
            for (kind, tangent) in [("warped", Tangent::Warped), ("exact", Tangent::Exact)] {
                criterion.bench_function(&format!("assembly/{name}/{kind}/{set}/n={n}"), |bencher| {
                    bencher.iter(|| body.stiffness_into(&x, tangent, &mut stiffness));
                });
                let entries = stiffness.blocks.as_flattened().as_flattened();
                let norm = entries.iter().map(|k| k * k).sum::<f64>().sqrt();
                println!("    norm of the blocks {norm:.12e} N/m");
            }
        }
    }
}

criterion_group!(benches, kernels);
criterion_main!(benches);
