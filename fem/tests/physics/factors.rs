//! Both factorisations against each other and against K x.

use std::path::PathBuf;

use hysteron_base::MaterialLaw;
use hysteron_fem::{Error, FemModel, Stiffness, StiffnessPattern};

use super::*;

const KINDS: [FactorKind; 2] = [FactorKind::Envelope, FactorKind::Supernodal];

/// A clamped block whose unknowns do not fill whole blocks of 16.
fn block(order: Order) -> FemModel {
    let mesh = box_mesh([2, 4, 5], [0.02, 0.04, 0.05], 0.2, order);
    let base = nodes_where(&mesh, |x| x[2] == 0.0);
    let model = FemModel::new(&mesh, material(MaterialLaw::Corotational, 0.4), &base).unwrap();
    assert_ne!(model.n_unknowns() % 16, 0);
    model
}

fn robot(file: &str) -> FemModel {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../meshes/tpu80").join(file);
    let mesh = hysteron_fem::read_mesh(&path, 1e-3).unwrap();
    FemModel::new(&mesh, material(MaterialLaw::Corotational, 0.45), &mesh.groups["base"]).unwrap()
}

fn factor(k: &Stiffness, kind: FactorKind, model: &FemModel) -> StiffnessFactor {
    let mut factor = StiffnessFactor::new(&k.pattern, kind, model.isa);
    assert_eq!(factor.kind(), kind);
    factor.factorize(k).unwrap();
    factor
}

fn random_vector(n: usize, k: usize) -> Vec<f64> {
    let mut stream = rng(19, &format!("test/vector/{k}"));
    (0..n).map(|_| stream.random_range(-1.0..1.0)).collect()
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    let off: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    max_norm(&off)
}

/// Relative error of a solve: round-off times the condition of the blocks, some 1e3, with a margin of ten.
fn accuracy(kind: FactorKind) -> f64 {
    match kind {
        FactorKind::Envelope => 1e4 * f64::from(f32::EPSILON),
        FactorKind::Supernodal => 1e4 * f64::EPSILON,
    }
}

#[test]
fn solving_undoes_multiplying() {
    for order in ORDERS {
        let model = block(order);
        let x = shaken(&model, model.rest.clone(), 5e-4);
        let k = stiffness(&model, &x, Tangent::Warped);
        let expected = random_vector(model.n_unknowns(), 0);
        for kind in KINDS {
            let mut u = multiply(&k, &expected);
            factor(&k, kind, &model).solve(&mut u);
            assert_close(&format!("{kind:?}"), difference(&u, &expected), 0.0, accuracy(kind), 1.0);
        }
    }
}

#[test]
fn many_sides_are_solved_as_one_by_one() {
    for order in ORDERS {
        let model = block(order);
        let k = stiffness(&model, &model.rest, Tangent::Exact);
        for kind in KINDS {
            let mut factor = factor(&k, kind, &model);
            for n_sides in [0, 1, 4, 5, 16, 17, 21, 40] {
                let sides: Vec<Vec<f64>> =
                    (0..n_sides).map(|s| random_vector(model.n_unknowns(), s)).collect();
                let mut together = sides.clone();
                factor.solve_many(&mut together);
                for (side, found) in sides.into_iter().zip(together) {
                    let mut alone = side;
                    factor.solve(&mut alone);
                    let off = difference(&found, &alone);
                    assert_close(&format!("{kind:?}"), off, 0.0, accuracy(kind), max_norm(&alone));
                }
            }
        }
    }
}

#[test]
fn refined_envelope_solutions_reach_the_supernodal_ones() {
    for file in ["tpu80.msh", "tpu80-fine.msh"] {
        let model = robot(file);
        let k = stiffness(&model, &model.rest, Tangent::Exact);
        let b = random_vector(model.n_unknowns(), 0);
        let mut exact = b.clone();
        factor(&k, FactorKind::Supernodal, &model).solve(&mut exact);
        // Slender bodies are ill-conditioned: residual over matrix times solution, not errors.
        let scale = max_norm(k.blocks.as_flattened().as_flattened()) * max_norm(&exact);
        assert_close(file, difference(&multiply(&k, &exact), &b), 0.0, 1e-14, scale);

        let mut envelope = factor(&k, FactorKind::Envelope, &model);
        let mut u = vec![0.0; b.len()];
        let mut errors = vec![max_norm(&exact)];
        for _ in 0..6 {
            let mut step: Vec<f64> = b.iter().zip(multiply(&k, &u)).map(|(b, ku)| b - ku).collect();
            envelope.solve(&mut step);
            u.iter_mut().zip(&step).for_each(|(u, s)| *u += s);
            errors.push(difference(&u, &exact));
        }
        // The condition, 3e6 and 1e7, times the single round-off, 6e-8: each step leaves a few per cent.
        assert!(errors[1] > 0.0);
        assert!(errors.windows(2).take(4).all(|e| e[1] < 0.1 * e[0]), "{errors:?}");
    }
}

#[test]
fn copied_factor_solves_alike() {
    let model = block(Order::Linear);
    let k = stiffness(&model, &model.rest, Tangent::Exact);
    for kind in KINDS {
        let mut original = factor(&k, kind, &model);
        let mut copy = original.clone();
        let mut u = random_vector(model.n_unknowns(), 0);
        let mut v = u.clone();
        original.solve(&mut u);
        copy.solve(&mut v);
        assert_eq!(u, v);
        assert_eq!(original.n_stored(), copy.n_stored());
    }
}

#[test]
fn factor_is_replaced_by_new_numbers() {
    let model = block(Order::Linear);
    let mut k = stiffness(&model, &model.rest, Tangent::Exact);
    for kind in KINDS {
        let mut factor = factor(&k, kind, &model);
        let b = random_vector(model.n_unknowns(), 0);
        let mut stiff = b.clone();
        factor.solve(&mut stiff);
        let scale = |k: &mut Stiffness, by: f64| {
            k.blocks.as_flattened_mut().as_flattened_mut().iter_mut().for_each(|v| *v *= by);
        };
        scale(&mut k, 0.25);
        factor.factorize(&k).unwrap();
        scale(&mut k, 4.0);
        let mut soft = b;
        factor.solve(&mut soft);
        // Four has the square root two: only exponents move.
        let fourfold: Vec<f64> = stiff.iter().map(|u| 4.0 * u).collect();
        assert_eq!(soft, fourfold, "{kind:?}");
    }
}

#[test]
fn matrices_without_a_factor_are_refused() {
    let model = block(Order::Linear);
    let good = stiffness(&model, &model.rest, Tangent::Exact);
    let node = model.n_free / 2;
    for value in [-1.0, f64::NAN] {
        let mut bad = good.clone();
        let slot = bad.pattern.slot(node, node).unwrap();
        bad.blocks[slot][1][1] = value;
        for kind in KINDS {
            let mut factor = StiffnessFactor::new(&bad.pattern, kind, model.isa);
            let refusal = factor.factorize(&bad);
            let Err(Error::NotPositiveDefinite { unknown, n_unknowns, .. }) = refusal else {
                panic!("{kind:?} {value}: {refusal:?}")
            };
            assert_eq!(n_unknowns, model.n_unknowns());
            // faer counts in its own elimination order.
            match kind {
                FactorKind::Envelope => assert_eq!(unknown, 3 * node + 1),
                FactorKind::Supernodal => assert!(unknown < n_unknowns),
            }
            // And it recovers.
            factor.factorize(&good).unwrap();
        }
    }
}

#[test]
fn cliques_make_room_and_change_nothing() {
    let model = block(Order::Linear);
    let (first, last) = (0, model.n_free as u32 - 1);
    let clamped = model.n_nodes() as u32 - 1;
    let plain = model.stiffness_pattern(&[]);
    let wide = model.stiffness_pattern(&[vec![last, clamped, first]]);
    let slot = |pattern: &StiffnessPattern| pattern.slot(last as usize, first as usize);
    assert_eq!(slot(&plain), None);
    assert!(slot(&wide).is_some());
    assert_eq!(wide.n_blocks(), plain.n_blocks() + 1);
    assert_eq!(wide.slot(clamped as usize, first as usize), None);

    let k = stiffness(&model, &model.rest, Tangent::Exact);
    let mut roomy = Stiffness::zeros(Arc::new(wide));
    model.stiffness_into(&model.rest, Tangent::Exact, &mut roomy);
    let x = random_vector(model.n_unknowns(), 0);
    assert_eq!(multiply(&k, &x), multiply(&roomy, &x));
    for kind in KINDS {
        let (mut u, mut v) = (x.clone(), x.clone());
        factor(&k, kind, &model).solve(&mut u);
        factor(&roomy, kind, &model).solve(&mut v);
        assert_close(&format!("{kind:?}"), difference(&u, &v), 0.0, accuracy(kind), max_norm(&u));
    }
}

#[test]
fn slender_bodies_get_the_envelope_and_bulky_ones_do_not() {
    for (file, kind) in [
        ("tpu80.msh", FactorKind::Envelope),
        ("tpu80-fine.msh", FactorKind::Envelope),
        ("tpu80-quadratic.msh", FactorKind::Supernodal),
    ] {
        assert_eq!(FactorKind::fastest(&robot(file).stiffness_pattern(&[])), kind, "{file}");
    }
}

#[test]
fn signed_factor_solves_indefinite_matrices_and_counts_their_negative_eigenvalues() {
    for order in ORDERS {
        let model = block(order);
        let n = model.n_unknowns();
        let mut k = stiffness(&model, &model.rest, Tangent::Exact);
        let dense = |k: &Stiffness| {
            let columns = (0..n).flat_map(|j| {
                let unit: Vec<f64> = (0..n).map(|i| f64::from(u8::from(i == j))).collect();
                multiply(k, &unit)
            });
            nalgebra::DMatrix::from_iterator(n, n, columns)
        };
        let mut values: Vec<f64> = dense(&k).symmetric_eigenvalues().iter().copied().collect();
        values.sort_by(f64::total_cmp);
        for n_negative in [0, 1, 7] {
            // Half way between two eigenvalues, all below become negative.
            let shift =
                if n_negative == 0 { 0.0 } else { 0.5 * (values[n_negative - 1] + values[n_negative]) };
            let mut shifted = k.clone();
            for node in 0..n / 3 {
                let slot = k.pattern.slot(node, node).unwrap();
                for c in 0..3 {
                    shifted.blocks[slot][c][c] -= shift;
                }
            }
            let mut factor = StiffnessFactor::new(&k.pattern, FactorKind::Supernodal, model.isa);
            assert_eq!(factor.factorize(&shifted).is_ok(), n_negative == 0);
            assert_eq!(factor.factorize_signed(&shifted).unwrap(), n_negative);
            let expected = random_vector(n, n_negative);
            let mut u = multiply(&shifted, &expected);
            factor.solve(&mut u);
            // Round-off times the condition of the shifted matrix.
            let nearest = values.iter().map(|value| (value - shift).abs()).fold(f64::INFINITY, f64::min);
            let tol = 100.0 * f64::EPSILON * values[n - 1] / nearest;
            assert_close(&format!("{order:?}, {n_negative}"), difference(&u, &expected), 0.0, tol, 1.0);
        }
        // Usable again as a positive definite factor.
        k.blocks.iter_mut().flatten().flatten().for_each(|entry| *entry *= 2.0);
        let mut factor = factor(&k, FactorKind::Supernodal, &model);
        let mut u = multiply(&k, &random_vector(n, 3));
        factor.solve(&mut u);
        assert_close(
            "positive",
            difference(&u, &random_vector(n, 3)),
            0.0,
            accuracy(FactorKind::Supernodal),
            1.0,
        );
    }
}
