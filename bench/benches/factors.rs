//! Factorisations and solves: the own envelope compared with faer, and faer's orderings.
#![allow(missing_docs)] // criterion's macros make undocumented functions
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a benchmark may stop where it stands, and prints its proof

use criterion::{Criterion, criterion_group, criterion_main};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Par, Side};
use hysteron_bench::repository;
use hysteron_bench::targets::rest_stiffness;
use hysteron_fem::{FactorKind, FemModel, Order, Stiffness, StiffnessFactor};
use hysteron_studies::tendon::scenes::{N_PRIMARY, Setting, sofa_mesh, sofa_scene, tube, tube_scene};

fn kinds(criterion: &mut Criterion, body: &FemModel) {
    let stiffness = rest_stiffness(body);
    let n = body.n_unknowns();
    let right: Vec<f64> = (0..n).map(|i| (0.1 * i as f64).sin()).collect();
    for (name, kind) in [("envelope", FactorKind::Envelope), ("supernodal", FactorKind::Supernodal)] {
        let mut factor = StiffnessFactor::new(&stiffness.pattern, kind, body.isa);
        criterion.bench_function(&format!("factor/{name}/n={n}"), |bencher| {
            bencher.iter(|| factor.factorize(&stiffness).unwrap());
        });
        let mut x = right.clone();
        criterion.bench_function(&format!("solve/{name}/n={n}"), |bencher| {
            bencher.iter(|| {
                x.copy_from_slice(&right);
                factor.solve(&mut x);
            });
        });
        println!(
            "    {} numbers stored, residual of the solve {:.1e}",
            factor.n_stored(),
            residual(&stiffness, &x, &right)
        );
        let mut columns = vec![right.clone(); 40];
        criterion.bench_function(&format!("solve/{name}/40 sides/n={n}"), |bencher| {
            bencher.iter(|| {
                columns.iter_mut().for_each(|column| column.copy_from_slice(&right));
                factor.solve_many(&mut columns);
            });
        });
        println!("    residual of the last {:.1e}", residual(&stiffness, &columns[39], &right));
    }
}

/// |K x - f| / |f|.
fn residual(stiffness: &Stiffness, x: &[f64], right: &[f64]) -> f64 {
    let mut product = vec![0.0; x.len()];
    stiffness.multiply_into(x, &mut product);
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|c| c * c).sum::<f64>().sqrt();
    norm(&mut product.iter().zip(right).map(|(p, f)| p - f)) / norm(&mut right.iter().copied())
}

/// faer on the model's own numbering, with minimum degree on top and without.
fn orderings(criterion: &mut Criterion, body: &FemModel) {
    let stiffness = rest_stiffness(body);
    let n = body.n_unknowns();
    let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    // Upper triangle by columns: the lower one by rows.
    for row in 0..n {
        for column in 0..=row {
            if let Some(slot) = stiffness.pattern.slot(row / 3, column / 3) {
                rows.push(column);
                values.push(stiffness.blocks[slot][row % 3][column % 3]);
            }
        }
        starts.push(rows.len());
    }
    let pattern = SymbolicSparseColMat::new_checked(n, n, starts, None, rows);
    for (name, ordering) in [("amd", SymmetricOrdering::Amd), ("natural", SymmetricOrdering::Identity)] {
        let parameters = CholeskySymbolicParams::default();
        let symbolic =
            factorize_symbolic_cholesky(pattern.as_ref(), Side::Upper, ordering, parameters).unwrap();
        let mut factor = vec![0.0; symbolic.len_val()];
        let request = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = MemBuffer::new(request);
        criterion.bench_function(&format!("factor/faer/{name}/n={n}"), |bencher| {
            bencher.iter(|| {
                symbolic
                    .factorize_numeric_llt(
                        &mut factor,
                        SparseColMatRef::new(pattern.as_ref(), &values),
                        Side::Upper,
                        LltRegularization::default(),
                        Par::Seq,
                        MemStack::new(&mut memory),
                        Default::default(),
                    )
                    .unwrap();
            });
        });
        println!("    {} numbers stored", factor.len());
    }
}

fn factors(criterion: &mut Criterion) {
    let small = sofa_scene(repository(), Setting::TARGETS, &sofa_mesh(repository()).unwrap(), N_PRIMARY)
        .unwrap()
        .body;
    kinds(criterion, &small);
    orderings(criterion, &small);
    let mesh = tube(19, Order::Linear).mesh().unwrap();
    let large = tube_scene(Setting::TARGETS, &mesh).unwrap().body;
    kinds(criterion, &large);
    orderings(criterion, &large);
    let mesh = tube(8, Order::Quadratic).mesh().unwrap();
    orderings(criterion, &tube_scene(Setting::TARGETS, &mesh).unwrap().body);
}

criterion_group!(benches, factors);
criterion_main!(benches);
