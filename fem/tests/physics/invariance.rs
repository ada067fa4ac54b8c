//! Rigid motions cost nothing, and turning a deformed body turns its forces.

use std::f64::consts::PI;

use hysteron_base::MaterialLaw;
use hysteron_fem::FemModel;

use super::*;

const SIZE: [f64; 3] = [0.02, 0.02, 0.03];
const SHIFT: Vector3<f64> = Vector3::new(0.5, -0.2, 0.1);
/// Round-off of positions half a metre away, in elements of a centimetre, with some margin.
const ACC: f64 = 1e-12;
const ANGLES: [f64; 4] = [0.3, 1.7, 3.0, PI];

fn models(laws: &[MaterialLaw]) -> Vec<(String, FemModel)> {
    let mut models = Vec::new();
    for &law in laws {
        for order in ORDERS {
            if law == MaterialLaw::CorotationalEdges && order == Order::Quadratic {
                continue;
            }
            let mesh = box_mesh([2, 2, 3], SIZE, 0.2, order);
            let base = nodes_where(&mesh, |x| x[2] == 0.0);
            let model = FemModel::new(&mesh, material(law, 0.4), &base).unwrap();
            models.push((format!("{law:?} {order:?}"), model));
        }
    }
    models
}

const FORCE_SCALE: f64 = YOUNG * 0.01 * 0.01;
const ENERGY_SCALE: f64 = YOUNG * SIZE[0] * SIZE[1] * SIZE[2];

#[test]
fn rigid_motion_costs_nothing() {
    for (what, model) in
        models(&[MaterialLaw::Corotational, MaterialLaw::CorotationalEdges, MaterialLaw::NeoHookean])
    {
        for angle in ANGLES {
            let q = rotation(angle);
            let x = positions(&model, |x| q * x + SHIFT);
            assert_close(&what, model.energy(&x), 0.0, ACC, ENERGY_SCALE);
            assert_close(&what, max_norm(force(&model, &x).as_flattened()), 0.0, ACC, FORCE_SCALE);
        }
    }
}

#[test]
fn small_strain_ignores_translations_but_not_rotations() {
    for (what, model) in models(&[MaterialLaw::SmallStrain]) {
        let x = positions(&model, |x| x + SHIFT);
        assert_close(&what, model.energy(&x), 0.0, ACC, ENERGY_SCALE);
        assert_close(&what, max_norm(force(&model, &x).as_flattened()), 0.0, ACC, FORCE_SCALE);
        // A rotation by 0.3 looks like a compression of 1 - cos(0.3) = 4 %.
        let turned = positions(&model, |x| rotation(0.3) * x);
        assert!(model.energy(&turned) > 1e-4 * ENERGY_SCALE);
    }
}

#[test]
fn turning_a_deformed_body_turns_its_forces() {
    for (what, model) in
        models(&[MaterialLaw::Corotational, MaterialLaw::CorotationalEdges, MaterialLaw::NeoHookean])
    {
        let x = shaken(&model, positions(&model, |x| x), 1e-3);
        let (energy, forces) = (model.energy(&x), force(&model, &x));
        assert!(energy > 1e-4 * ENERGY_SCALE);
        for angle in ANGLES {
            let q = rotation(angle);
            let turned: Vec<[f64; 4]> = x
                .iter()
                .map(|x| {
                    let y = q * Vector3::new(x[0], x[1], x[2]) + SHIFT;
                    [y[0], y[1], y[2], 0.0]
                })
                .collect();
            assert_close(&what, model.energy(&turned), energy, ACC, ENERGY_SCALE);
            for (f, g) in forces.iter().zip(force(&model, &turned)) {
                let expected = q * Vector3::new(f[0], f[1], f[2]);
                let off = (Vector3::new(g[0], g[1], g[2]) - expected).norm();
                assert_close(&what, off, 0.0, ACC, FORCE_SCALE);
            }
        }
    }
}
