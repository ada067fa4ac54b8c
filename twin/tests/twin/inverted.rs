//! Inverted elements: a balance with them is no equilibrium.

use std::collections::BTreeMap;

use hysteron_base::MaterialLaw;
use hysteron_fem::{Cells, Mesh};
use hysteron_twin::{Cause, Error, Stepper, Twin};

use super::scenes;

const HEIGHT: f64 = 0.01;

/// One element on its clamped face, with its free tip above.
fn pyramid(law: MaterialLaw, is_quadratic: bool) -> Twin {
    let nodes = vec![[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.002, 0.002, HEIGHT]];
    let groups = BTreeMap::from([("base".to_owned(), vec![0, 1, 2]), ("tip".to_owned(), vec![3])]);
    let linear = Mesh { nodes, cells: Cells::Tet4(vec![[0, 1, 2, 3]]), groups };
    let mesh = if is_quadratic { linear.to_quadratic() } else { linear };
    let mut scene = scenes::scene("pyramid", law);
    scene.tendons.clear();
    Twin::new(&scene, &mesh).unwrap()
}

fn inverted(result: &Result<hysteron_twin::StepReport, Error>) -> Option<usize> {
    match result {
        Err(Error::NoEquilibrium { cause: Cause::Inverted { element }, .. }) => Some(*element),
        _ => None,
    }
}

#[test]
fn mirrored_body_is_no_equilibrium_though_no_force_is_left() {
    // The nearest orthogonal matrix of a mirrored F is a reflection, with which nothing is strained: all forces are
    // zero.
    for (law, is_quadratic) in [
        (MaterialLaw::Corotational, false),
        (MaterialLaw::Corotational, true),
        (MaterialLaw::CorotationalEdges, false),
    ] {
        let twin = pyramid(law, is_quadratic);
        let mut state = twin.rest();
        for (node, rest) in state.positions.iter_mut().zip(&twin.body.rest) {
            node[2] = -rest[2];
        }
        let mut forces = vec![[0.0; 4]; twin.body.n_nodes()];
        twin.body.internal_force_into(&state.positions, &mut forces);
        let largest = forces.iter().flatten().fold(0.0f64, |max, f| max.max(f.abs()));
        let scale = twin.body.material.youngs_modulus * HEIGHT * HEIGHT;
        assert!(largest < 1e-9 * scale, "{law:?}: {largest} N of {scale}");
        let result = super::stepper_at(&twin, &state).step(&twin, &[]);
        assert_eq!(inverted(&result), Some(0), "{law:?} {is_quadratic}: {result:?}");
    }
}

#[test]
fn force_that_pushes_a_tip_through_its_base_has_no_equilibrium() {
    for (law, is_quadratic) in [
        (MaterialLaw::SmallStrain, false),
        (MaterialLaw::SmallStrain, true),
        (MaterialLaw::Corotational, false),
        (MaterialLaw::CorotationalEdges, false),
        (MaterialLaw::NeoHookean, false),
    ] {
        let mut twin = pyramid(law, is_quadratic);
        let tip = twin.tip.nodes[0] as usize;
        // A strain of several times one under the linear law.
        twin.loads[tip][2] = -5.0 * twin.body.material.youngs_modulus * 5e-5;
        let mut stepper = Stepper::new(&twin);
        let result = stepper.step(&twin, &[]);
        // Wherever it ends, nothing is inside out; the linear law alone would let the tip through.
        assert!(twin.body.first_inverted(&stepper.state().positions).is_none(), "{law:?}");
        match law {
            MaterialLaw::SmallStrain => assert_eq!(inverted(&result), Some(0), "{is_quadratic}: {result:?}"),
            _ => assert!(result.is_ok() || matches!(result, Err(Error::NoEquilibrium { .. })), "{result:?}"),
        }
    }
}
