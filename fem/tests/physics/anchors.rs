//! Anchors: moments of the bump, and what they are for, displacements that converge.

use hysteron_base::MaterialLaw;
use hysteron_fem::{Anchor, Embedding, FemModel};

use super::*;

/// Edge of the block [m].
const SIDE: f64 = 0.02;

const RADIUS: f64 = 0.006;

fn block(divisions: usize, order: Order) -> FemModel {
    let mesh = box_mesh([divisions; 3], [SIDE; 3], 0.0, order);
    let base = nodes_where(&mesh, |x| x[2] == 0.0);
    FemModel::new(&mesh, material(MaterialLaw::SmallStrain, 0.3), &base).unwrap()
}

fn anchor(center: [f64; 3]) -> Anchor {
    Anchor { center, radius: RADIUS, along: [0.3, -0.2, 1.0] }
}

/// Component of `point - center` across the anchor's direction [m].
fn off_axis(anchor: &Anchor, point: [f64; 3]) -> f64 {
    let arm = Vector3::from(point) - Vector3::from(anchor.center);
    let along = Vector3::from(anchor.along).normalize();
    (arm - along * along.dot(&arm)).norm()
}

#[test]
fn a_bump_inside_the_body_has_its_volume_and_its_center() {
    for order in [Order::Linear, Order::Quadratic] {
        let anchor = anchor([0.0101, 0.0097, 0.0102]);
        let found = anchor.carriers(&block(5, order)).unwrap();
        // The rule of degree 2 leaves a part h⁴ φ''''/V of each part of size h ≤ 0.2 R: some 1e-4.
        assert_close("volume", found.volume, anchor.whole_volume(), 1e-3, anchor.whole_volume());
        let exact = 32.0 * std::f64::consts::PI / 105.0 * RADIUS.powi(3);
        assert_close("closed form", anchor.whole_volume(), exact, 1e-14, exact);
        assert_close("sum", found.embedding.weights.iter().sum(), 1.0, 1e-12, 1.0);
        let point = found.embedding.at(&block(5, order).rest);
        assert!(off_axis(&anchor, point) < 1e-12 * SIDE, "{order:?}: {point:?}");
        // Along its direction by symmetry alone: the error of the rule, 1e-4 of the radius.
        let shift = (Vector3::from(point) - Vector3::from(anchor.center)).norm();
        assert!(shift < 1e-3 * RADIUS, "{order:?}: {shift}");
    }
}

#[test]
fn a_bump_that_the_surface_cuts_keeps_the_line_of_its_force() {
    // In a face, on an edge and next to the body.
    for center in [[SIDE, 0.009, 0.011], [SIDE, SIDE, 0.012], [SIDE + 0.001, 0.009, 0.01]] {
        let anchor = anchor(center);
        let model = block(5, Order::Linear);
        let found = anchor.carriers(&model).unwrap();
        assert!(found.volume < 0.6 * anchor.whole_volume());
        assert_close("sum", found.embedding.weights.iter().sum(), 1.0, 1e-12, 1.0);
        let point = found.embedding.at(&model.rest);
        assert!(off_axis(&anchor, point) < 1e-12 * SIDE, "{center:?}: {point:?}");
    }
}

#[test]
fn fewer_nodes_stand_for_all_in_every_affine_motion() {
    let model = block(10, Order::Quadratic);
    for center in [[0.0101, 0.0097, 0.0102], [SIDE, 0.009, 0.011], [SIDE, SIDE, 0.012]] {
        let all = anchor(center).carriers(&model).unwrap();
        let few = all.thinned(&model, 0.5 * RADIUS);
        assert!(
            // Cubes of half the radius in the bounding box of all elements that the bump touches, 2 mm beyond it.
            few.nodes.len() < 152 && few.nodes.len() * 4 < all.embedding.nodes.len(),
            "{} of {}",
            few.nodes.len(),
            all.embedding.nodes.len()
        );
        assert_close("sum", few.weights.iter().sum(), 1.0, 1e-9, 1.0);
        let (all, few) = (all.embedding.at(&model.rest), few.at(&model.rest));
        for c in 0..3 {
            // The bound on singular values, relative.
            assert_close("center", few[c], all[c], 1e-9, SIDE);
        }
    }
}

#[test]
fn an_anchor_beyond_the_body_is_none() {
    assert_eq!(anchor([2.0 * SIDE, 0.0, 0.0]).carriers(&block(2, Order::Linear)), None);
}

/// Displacement of a point under a unit force on itself [m/N], along x on the top of the block.
fn compliance(model: &FemModel, point: &Embedding) -> f64 {
    let mut load = vec![0.0; model.n_unknowns()];
    for (node, weight) in
        point.nodes.iter().zip(&point.weights).filter(|(n, _)| (**n as usize) < model.n_free)
    {
        load[3 * *node as usize] += weight;
    }
    let mut x = model.rest.clone();
    let left = solve_equilibrium(model, &load, &mut x, 1);
    assert!(left < 1e-9, "residual {left} of 1 N");
    point.at(&x)[0] - point.at(&model.rest)[0]
}

/// Change of the compliance from 4 to 8 divisions over that from 8 to 16.
fn contraction(carriers: impl Fn(&FemModel) -> Embedding) -> f64 {
    let [a, b, c] = [4, 8, 16].map(|n| {
        let model = block(n, Order::Linear);
        compliance(&model, &carriers(&model))
    });
    (b - a) / (c - b)
}

#[test]
fn displacements_of_an_anchor_converge_and_those_of_a_point_do_not() {
    let top = [0.4 * SIDE, 0.6 * SIDE, SIDE];
    // Energy of linear elements has an error of order h²: 4; of order h: 2.
    let anchored = contraction(|model| anchor(top).carriers(model).unwrap().embedding);
    assert!(anchored > 2.0, "{anchored}");
    // Under a point the energy grows as 1/h: 1/2.
    let at_a_point = contraction(|model| Embedding::new(model, top));
    assert!(at_a_point < 1.0, "{at_a_point}");
}
