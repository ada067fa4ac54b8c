#![allow(clippy::unwrap_used)] // a test may stop where it stands

use std::sync::Arc;

use crate::vectors::{axpy, combine_into, dot};
use hysteron_base::{Material, MaterialLaw, rng};
use rand::RngExt;

use super::Isa;
use crate::{Cells, FactorKind, FemModel, Layers, Order, Stiffness, StiffnessFactor, Tangent, Tube};

const E: f64 = 2e5;
const HEIGHT: f64 = 0.03;

fn model(law: MaterialLaw, order: Order, isa: Isa) -> FemModel {
    let tube = Tube {
        profile: vec![[0.0, 0.01], [HEIGHT, 0.01]],
        bore_radius: 0.0,
        channels: Vec::new(),
        outer_divisions: 5,
        bore_divisions: 0,
        channel_divisions: 0,
        layers: Layers::Count(3),
        order,
    };
    let mesh = tube.mesh().unwrap();
    assert_ne!(mesh.cells.len() % super::LANES, 0, "the last batch must be filled up");
    let material = Material { law, youngs_modulus: E, poisson_ratio: 0.45, density: 1e3 };
    FemModel::new(&mesh, material, &mesh.groups["base"]).unwrap().with_isa(isa)
}

/// Bent, stretched and a little random, so that no two lanes are alike.
fn deformed(model: &FemModel) -> Vec<[f64; 4]> {
    let mut stream = rng(3, "test/isa");
    let moved = model.rest.iter().map(|&[x, y, z, _]| {
        let (sin, cos) = (20.0 * z).sin_cos();
        let noise = [0; 3].map(|_| 2e-4 * stream.random_range(-1.0..1.0));
        [cos * x - sin * y + noise[0], sin * x + cos * y + noise[1], 1.2 * z + noise[2], 0.0]
    });
    moved.collect()
}

fn max_norm(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |a, b| if b.is_nan() { f64::NAN } else { b.abs().max(a) })
}

#[track_caller]
fn assert_near(what: &str, found: &[f64], expected: &[f64], acc: f64) {
    let off: Vec<f64> = found.iter().zip(expected).map(|(a, b)| a - b).collect();
    let (off, tol) = (max_norm(&off), acc * max_norm(expected));
    assert!(found.len() == expected.len() && tol > 0.0 && off <= tol, "{what}: {off:.3e} > {tol:.3e}");
}

/// Energy, forces, both stiffnesses.
fn results(model: &FemModel) -> [Vec<f64>; 4] {
    let x = deformed(model);
    let mut force = vec![[0.0; 4]; model.n_nodes()];
    assert!(model.internal_force_into(&x, &mut force));
    let pattern = Arc::new(model.stiffness_pattern(&[]));
    let [exact, warped] = [Tangent::Exact, Tangent::Warped].map(|kind| {
        let mut k = Stiffness::zeros(pattern.clone());
        model.stiffness_into(&x, kind, &mut k);
        k.blocks.concat().concat()
    });
    [vec![model.energy(&x)], force.concat(), exact, warped]
}

#[test]
fn instruction_sets_agree_on_energy_force_and_stiffness() {
    // Sums in another order, and polar iterations stopped by another lane: round-off.
    const ACC: f64 = 1e-13;
    for order in [Order::Linear, Order::Quadratic] {
        for law in [
            MaterialLaw::SmallStrain,
            MaterialLaw::Corotational,
            MaterialLaw::CorotationalEdges,
            MaterialLaw::NeoHookean,
        ] {
            if law == MaterialLaw::CorotationalEdges && order == Order::Quadratic {
                continue;
            }
            let expected = results(&model(law, order, Isa::portable()));
            for isa in Isa::all() {
                for (found, expected) in results(&model(law, order, isa)).iter().zip(&expected) {
                    assert_near(&format!("{law:?} {order:?} {isa:?}"), found, expected, ACC);
                }
            }
        }
    }
}

#[test]
fn inverted_element_is_noticed_in_every_law_and_named() {
    for order in [Order::Linear, Order::Quadratic] {
        for law in [
            MaterialLaw::SmallStrain,
            MaterialLaw::Corotational,
            MaterialLaw::CorotationalEdges,
            MaterialLaw::NeoHookean,
        ] {
            if law == MaterialLaw::CorotationalEdges && order == Order::Quadratic {
                continue;
            }
            for isa in Isa::all() {
                let model = model(law, order, isa);
                let mut force = vec![[0.0; 4]; model.n_nodes()];
                let mut x = deformed(&model);
                assert!(model.internal_force_into(&x, &mut force) && model.first_inverted(&x).is_none());
                // One node of the last element mirrored across the plane of three others: far beyond its opposite face.
                let cell: Vec<u32> = match &model.cells {
                    Cells::Tet4(cells) => cells[cells.len() - 1].to_vec(),
                    Cells::Tet10(cells) => cells[cells.len() - 1].to_vec(),
                };
                let at = |x: &[[f64; 4]], a: usize| {
                    let [a, b, c, _] = x[cell[a] as usize];
                    nalgebra::Vector3::new(a, b, c)
                };
                let normal = (at(&x, 1) - at(&x, 0)).cross(&(at(&x, 2) - at(&x, 0))).normalize();
                let mirrored = at(&x, 3) - 4.0 * (at(&x, 3) - at(&x, 0)).dot(&normal) * normal;
                x[cell[3] as usize][..3].copy_from_slice(mirrored.as_slice());
                assert!(!model.internal_force_into(&x, &mut force), "{law:?} {order:?} {isa:?}");
                let (element, determinant) = model.first_inverted(&x).unwrap();
                assert!(determinant <= 0.0);
                let has_node = match &model.cells {
                    Cells::Tet4(cells) => cells[element].contains(&cell[3]),
                    Cells::Tet10(cells) => cells[element].contains(&cell[3]),
                };
                assert!(has_node, "element {element}");
            }
        }
    }
}

#[test]
fn instruction_sets_agree_on_envelope_solutions() {
    // Single precision; the condition of this short body is below 1e4.
    const ACC: f64 = 1e4 * f32::EPSILON as f64;
    let solutions = |isa: Isa, order: Order| {
        let model = model(MaterialLaw::Corotational, order, isa);
        let mut k = Stiffness::zeros(Arc::new(model.stiffness_pattern(&[])));
        model.stiffness_into(&deformed(&model), Tangent::Warped, &mut k);
        let mut factor = StiffnessFactor::new(&k.pattern, FactorKind::Envelope, isa);
        factor.factorize(&k).unwrap();
        let mut stream = rng(5, "test/isa");
        let mut draw = || (0..model.n_unknowns()).map(|_| stream.random_range(-1.0..1.0)).collect();
        let mut alone: Vec<f64> = draw();
        let mut sides: Vec<Vec<f64>> = (0..18).map(|_| draw()).collect();
        factor.solve(&mut alone);
        factor.solve_many(&mut sides);
        [alone, sides.concat()]
    };
    for order in [Order::Linear, Order::Quadratic] {
        let expected = solutions(Isa::portable(), order);
        for isa in Isa::all() {
            for (found, expected) in solutions(isa, order).iter().zip(&expected) {
                assert_near(&format!("{order:?} {isa:?}"), found, expected, ACC);
            }
        }
    }
}

#[test]
fn long_vectors_match_plain_sums() {
    // A hundred products: round-off.
    const ACC: f64 = 1e-14;
    for n in [1, 15, 16, 17, 100] {
        let a: Vec<f64> = (0..n).map(|i| 1.0 + f64::from(i)).collect();
        let b: Vec<f64> = a.iter().map(|a| 1.0 / a + a).collect();
        let columns: [Vec<f32>; 3] = [0.5_f32, 9.0, 0.25].map(|s| a.iter().map(|a| s * *a as f32).collect());
        for isa in Isa::all() {
            let sum: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
            assert_near("dot", &[dot(isa, &a, &b)], &[sum], ACC);
            let mut y = b.clone();
            axpy(isa, -0.3, &a, &mut y);
            let expected: Vec<f64> = a.iter().zip(&b).map(|(a, b)| b - 0.3 * a).collect();
            assert_near("axpy", &y, &expected, ACC);
            let mut y = b.clone();
            combine_into(isa, &[2.0, 0.0, 4.0], &columns, &mut y);
            let expected: Vec<f64> = a.iter().zip(&b).map(|(a, b)| b + 2.0 * a).collect();
            assert_near("combine", &y, &expected, ACC);
        }
    }
}
