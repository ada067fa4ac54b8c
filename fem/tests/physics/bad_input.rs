//! Errors of a model, and the nodes that they name.

use hysteron_base::MaterialLaw;
use hysteron_fem::{Error, FemModel};

use super::*;
use crate::mesh::bad_input;

fn refusal(law: MaterialLaw, order: Order, clamped: &[u32]) -> String {
    let mesh = box_mesh([1, 1, 1], [1.0; 3], 0.0, order);
    bad_input(FemModel::new(&mesh, material(law, 0.3), clamped)).to_string()
}

#[test]
fn body_that_nothing_holds_is_refused() {
    assert_eq!(
        refusal(MaterialLaw::Corotational, Order::Linear, &[]),
        "clamp: expected at least three nodes held still, got none \
         (hint: a body that nothing holds has no equilibrium)"
    );
}

#[test]
fn body_held_everywhere_is_refused() {
    let all: Vec<u32> = (0..8).collect();
    assert_eq!(
        refusal(MaterialLaw::Corotational, Order::Linear, &all),
        "clamp: expected some free nodes, got all nodes clamped"
    );
}

#[test]
fn clamped_node_that_the_mesh_lacks_is_refused() {
    assert_eq!(
        refusal(MaterialLaw::Corotational, Order::Linear, &[0, 8]),
        "clamp: expected nodes below 8, got 8"
    );
}

#[test]
fn edge_frames_on_quadratic_elements_are_refused() {
    assert_eq!(
        refusal(MaterialLaw::CorotationalEdges, Order::Quadratic, &[0, 1, 2]),
        "material.law: expected linear tetrahedra for corotational_edges, got ten-node tetrahedra \
         (hint: use corotational)"
    );
}

#[test]
fn body_held_in_two_points_has_no_factor() {
    let mesh = box_mesh([1, 1, 2], [1.0; 3], 0.1, Order::Linear);
    let factorize = |clamped: &[u32]| {
        let model = FemModel::new(&mesh, material(MaterialLaw::SmallStrain, 0.3), clamped).unwrap();
        let mut k = stiffness(&model, &model.rest, Tangent::Exact);
        // A turn about the line through both points costs nothing: its pivot is round-off of either sign.
        // Far less than any strain costs is taken away to make it negative.
        for node in 0..model.n_free {
            let slot = k.pattern.slot(node, node).unwrap();
            for c in 0..3 {
                k.blocks[slot][c][c] -= 1e-6 * YOUNG;
            }
        }
        StiffnessFactor::new(&k.pattern, FactorKind::Supernodal, model.isa).factorize(&k)
    };
    let refusal = factorize(&[0, 1]);
    let Err(Error::NotPositiveDefinite { unknown, n_unknowns, hint }) = refusal else {
        panic!("expected no factor, got {refusal:?}")
    };
    assert!(unknown < n_unknowns && n_unknowns == 3 * (mesh.nodes.len() - 2));
    assert!(hint.contains("held in too few points"));
    factorize(&[0, 1, 2]).unwrap();
}

#[test]
fn a_clamp_about_which_the_body_turns_is_refused() {
    let mesh = box_mesh([1, 1, 2], [1.0; 3], 0.0, Order::Linear);
    let check = |clamped: &[u32]| {
        FemModel::new(&mesh, material(MaterialLaw::Corotational, 0.3), clamped).unwrap().check_clamp()
    };
    let on_an_edge = nodes_where(&mesh, |x| x[0] == 0.0 && x[1] == 0.0);
    for (clamped, found) in
        [(&[0][..], "one node"), (&[0, 1], "two nodes"), (&on_an_edge, "3 nodes in one line")]
    {
        let bad = bad_input(check(clamped));
        assert_eq!((bad.place.as_str(), bad.found.as_str()), ("clamp", found));
    }
    check(&nodes_where(&mesh, |x| x[2] == 0.0)).unwrap();
}

#[test]
fn values_that_are_not_finite_name_the_node_of_the_file() {
    let mesh = box_mesh([2, 2, 3], [1.0; 3], 0.1, Order::Linear);
    let base = nodes_where(&mesh, |x| x[2] == 0.0);
    let model = FemModel::new(&mesh, material(MaterialLaw::Corotational, 0.3), &base).unwrap();
    let mut x = model.rest.clone();
    model.check_finite("position", &x).unwrap();
    x[model.model_node[20] as usize][1] = f64::NAN;
    let refusal = model.check_finite("position", &x);
    assert!(matches!(refusal, Err(Error::NotFinite { quantity: "position", node: 20 })), "{refusal:?}");
    assert_eq!(refusal.unwrap_err().to_string(), "position of node 20 is not finite");
}

#[test]
fn file_order_is_restored() {
    let mesh = box_mesh([2, 2, 3], [1.0; 3], 0.1, Order::Quadratic);
    let base = nodes_where(&mesh, |x| x[2] == 0.0);
    let model = FemModel::new(&mesh, material(MaterialLaw::Corotational, 0.3), &base).unwrap();
    assert_eq!(model.in_file_order(&model.rest), mesh.nodes);
    assert_eq!(model.n_free + base.len(), mesh.nodes.len());
    let clamped: Vec<u32> = model.file_node[model.n_free..].to_vec();
    assert_eq!(clamped, base);
}
