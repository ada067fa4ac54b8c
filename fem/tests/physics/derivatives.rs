//! Force is the gradient of the energy, stiffness that of the force.

use hysteron_base::MaterialLaw;
use hysteron_fem::{Error, FemModel};

use super::*;

const SIZE: [f64; 3] = [0.02, 0.02, 0.03];
/// Step of the central differences, relative to an element of 1 cm: its square, 1e-10, bounds the
/// truncation; round-off divided by it is of the same size.
const STEP: f64 = 1e-5 * 0.01;
/// Both errors above, times the curvature of the laws at strains up to 0.5.
const ACC: f64 = 1e-7;

fn model(law: MaterialLaw, order: Order) -> FemModel {
    let mesh = box_mesh([2, 2, 3], SIZE, 0.2, order);
    let base = nodes_where(&mesh, |x| x[2] == 0.0);
    FemModel::new(&mesh, material(law, 0.4), &base).unwrap()
}

/// A bent and twisted state with strains of some tens of per cent.
fn deformed(model: &FemModel) -> Vec<[f64; 4]> {
    let map = |x: Vector3<f64>| rotation(40.0 * x[2]) * Vector3::new(1.1 * x[0], x[1], 1.2 * x[2]);
    shaken(model, positions(model, map), 4e-4)
}

/// A random direction for the free nodes, of length about one.
fn direction(model: &FemModel) -> Vec<[f64; 4]> {
    shaken(model, vec![[0.0; 4]; model.n_nodes()], 1.0)
}

fn moved(x: &[[f64; 4]], step: f64, along: &[[f64; 4]]) -> Vec<[f64; 4]> {
    x.iter().zip(along).map(|(x, d)| std::array::from_fn(|c| x[c] + step * d[c])).collect()
}

#[test]
fn force_is_gradient_of_energy() {
    for order in ORDERS {
        for law in POTENTIALS {
            let model = model(law, order);
            let (x, d) = (deformed(&model), direction(&model));
            let energy = |step: f64| model.energy(&moved(&x, step, &d));
            let difference = (energy(STEP) - energy(-STEP)) / (2.0 * STEP);
            let slope = dot(&free(&model, &force(&model, &x)), &free(&model, &d));
            let scale = max_norm(&free(&model, &force(&model, &x)));
            assert!(slope.abs() > 1e-3 * scale && slope != difference, "{law:?}: {slope} {difference}");
            assert_close(&format!("{law:?} {order:?}"), difference, slope, ACC, scale);
        }
    }
}

#[test]
fn exact_tangent_is_gradient_of_force() {
    for order in ORDERS {
        for law in POTENTIALS {
            let model = model(law, order);
            let (x, d) = (deformed(&model), direction(&model));
            let force_at = |step: f64| free(&model, &force(&model, &moved(&x, step, &d)));
            let slope = multiply(&stiffness(&model, &x, Tangent::Exact), &free(&model, &d));
            let scale = max_norm(&slope);
            assert!(scale > 0.0);
            let mut identical = true;
            for (i, (ahead, behind)) in force_at(STEP).iter().zip(force_at(-STEP)).enumerate() {
                let difference = (ahead - behind) / (2.0 * STEP);
                identical &= difference == slope[i];
                assert_close(&format!("{law:?} {order:?} unknown {i}"), difference, slope[i], ACC, scale);
            }
            assert!(!identical);
        }
    }
}

#[test]
fn difference_of_forces_is_symmetric() {
    // The stored matrix is symmetric by construction; forces show whether the true derivative is.
    for order in ORDERS {
        for law in POTENTIALS {
            let model = model(law, order);
            let (x, d) = (deformed(&model), direction(&model));
            let e: Vec<[f64; 4]> = d.iter().rev().map(|d| [d[1], -d[2], d[0], 0.0]).collect();
            let e: Vec<[f64; 4]> =
                e.iter().enumerate().map(|(i, e)| if i < model.n_free { *e } else { [0.0; 4] }).collect();
            let along = |a: &[[f64; 4]], b: &[[f64; 4]]| {
                let ahead = free(&model, &force(&model, &moved(&x, STEP, a)));
                let behind = free(&model, &force(&model, &moved(&x, -STEP, a)));
                (dot(&ahead, &free(&model, b)) - dot(&behind, &free(&model, b))) / (2.0 * STEP)
            };
            let (one, other) = (along(&d, &e), along(&e, &d));
            let scale = max_norm(&multiply(&stiffness(&model, &x, Tangent::Exact), &free(&model, &d)));
            assert!(one.abs() > 1e-3 * scale, "{law:?} {order:?}: {one} of {scale}");
            assert_close(&format!("{law:?} {order:?}"), one, other, ACC, scale);
        }
    }
}

#[test]
fn warped_tangent_is_exact_at_small_strain_and_after_a_rigid_turn() {
    const ROUND_OFF: f64 = 1e-13;
    for order in ORDERS {
        for law in POTENTIALS {
            let model = model(law, order);
            let turns = law != MaterialLaw::SmallStrain;
            let x = if turns { positions(&model, |x| rotation(2.0) * x) } else { deformed(&model) };
            let exact = stiffness(&model, &x, Tangent::Exact);
            let warped = stiffness(&model, &x, Tangent::Warped);
            let scale = max_norm(exact.blocks.as_flattened().as_flattened());
            let off = exact.blocks.iter().zip(&warped.blocks).flat_map(|(a, b)| {
                a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| a - b).collect::<Vec<_>>()
            });
            let off: Vec<f64> = off.collect();
            // A turned body is stress-free, but the couple term still differs by round-off in the turn.
            assert_close(&format!("{law:?} {order:?}"), max_norm(&off), 0.0, ROUND_OFF, scale);
        }
    }
}

#[test]
fn warped_tangent_has_a_factor_where_the_exact_one_has_none() {
    for order in ORDERS {
        let model = model(MaterialLaw::Corotational, order);
        // Squeezed to half its size: turning an element releases energy, 2μ < c / 2s.
        let x = positions(&model, |x| 0.5 * x);
        let squeezed = |kind| {
            let k = stiffness(&model, &x, kind);
            StiffnessFactor::new(&k.pattern, FactorKind::Supernodal, model.isa).factorize(&k)
        };
        let refusal = squeezed(Tangent::Exact);
        assert!(matches!(refusal, Err(Error::NotPositiveDefinite { .. })), "{refusal:?}");
        squeezed(Tangent::Warped).unwrap();

        let k = stiffness(&model, &deformed(&model), Tangent::Warped);
        StiffnessFactor::new(&k.pattern, FactorKind::Supernodal, model.isa).factorize(&k).unwrap();
    }
}

#[test]
fn edge_frames_agree_with_polar_frames_to_first_order_in_strain() {
    // Their force is not the gradient of their energy, so there is nothing to differentiate. Against the
    // polar frames the forces differ in second order: twice the strain, four times the difference, and half
    // of it relative to the force.
    let (edges, polar) = (
        model(MaterialLaw::CorotationalEdges, Order::Linear),
        model(MaterialLaw::Corotational, Order::Linear),
    );
    let forces = |model: &FemModel, strain: f64| {
        let x = shaken(model, positions(model, |x| x), strain * 0.01);
        let turned: Vec<[f64; 4]> = x
            .iter()
            .map(|x| {
                let y = rotation(0.9) * Vector3::new(x[0], x[1], x[2]);
                [y[0], y[1], y[2], 0.0]
            })
            .collect();
        free(model, &force(model, &turned))
    };
    let difference = |strain: f64| {
        let (a, b) = (forces(&edges, strain), forces(&polar, strain));
        let off: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
        (max_norm(&off), max_norm(&b))
    };
    let ((small, at_small), (large, _)) = (difference(1e-3), difference(2e-3));
    assert!((3.9..4.1).contains(&(large / small)), "{}", large / small);
    // At a strain of 1e-3 the frames turn by about as much.
    assert!(small < 3e-3 * at_small && small > 0.0, "{}", small / at_small);
}

#[test]
fn edge_frame_tangent_is_gradient_of_force_where_nothing_is_strained() {
    // Without stress a turn of the frame changes nothing, so the warped tangent is exact.
    let model = model(MaterialLaw::CorotationalEdges, Order::Linear);
    let (x, d) = (positions(&model, |x| rotation(2.0) * x), direction(&model));
    let force_at = |step: f64| free(&model, &force(&model, &moved(&x, step, &d)));
    let slope = multiply(&stiffness(&model, &x, Tangent::Exact), &free(&model, &d));
    let scale = max_norm(&slope);
    assert!(scale > 0.0);
    for (i, (ahead, behind)) in force_at(STEP).iter().zip(force_at(-STEP)).enumerate() {
        let difference = (ahead - behind) / (2.0 * STEP);
        assert_close(&format!("unknown {i}"), difference, slope[i], ACC, scale);
    }
}
