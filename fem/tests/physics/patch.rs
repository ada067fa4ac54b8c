//! A homogeneous deformation is reproduced exactly by any mesh with straight edges.

use hysteron_base::MaterialLaw;
use hysteron_fem::{Embedding, FemModel, Order};
use nalgebra::{Matrix3, Vector3};

use super::*;

const SIZE: [f64; 3] = [0.03, 0.02, 0.025];
const SHIFT: Vector3<f64> = Vector3::new(0.01, -0.02, 0.03);

/// Energy density and first Piola-Kirchhoff stress by the textbook, with the rotation from an SVD.
fn textbook(law: MaterialLaw, nu: f64, f: &Matrix3<f64>) -> (f64, Matrix3<f64>) {
    let (lambda, mu) = (YOUNG * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), YOUNG / (2.0 * (1.0 + nu)));
    let one = Matrix3::identity();
    let linear = |e: Matrix3<f64>| {
        let stress = 2.0 * mu * e + lambda * e.trace() * one;
        (0.5 * stress.dot(&e), stress)
    };
    match law {
        MaterialLaw::SmallStrain => linear(0.5 * (f + f.transpose()) - one),
        MaterialLaw::Corotational | MaterialLaw::CorotationalEdges => {
            let svd = f.svd(true, true);
            let r = svd.u.unwrap() * svd.v_t.unwrap();
            let (energy, stress) = linear(r.transpose() * f - one);
            (energy, r * stress)
        }
        MaterialLaw::NeoHookean => {
            let ln_j = f.determinant().ln();
            let energy = 0.5 * mu * (f.norm_squared() - 3.0) - mu * ln_j + 0.5 * lambda * ln_j * ln_j;
            (energy, mu * f + (lambda * ln_j - mu) * f.try_inverse().unwrap().transpose())
        }
    }
}

fn model(law: MaterialLaw, nu: f64, order: Order) -> FemModel {
    let mesh = box_mesh([3, 3, 3], SIZE, 0.25, order);
    FemModel::new(&mesh, material(law, nu), &mesh.groups["boundary"]).unwrap()
}

/// F for which the law must pass the patch test. Frames taken from edges differ between elements unless
/// all directions stretch alike.
fn deformation(law: MaterialLaw) -> Matrix3<f64> {
    match law {
        MaterialLaw::CorotationalEdges => 1.15 * rotation(1.1),
        _ => {
            rotation(if law == MaterialLaw::SmallStrain { 0.0 } else { 1.1 })
                * (Matrix3::identity() + 0.2 * random_matrix("test/patch"))
        }
    }
}

#[test]
fn homogeneous_deformation_gives_textbook_energy_and_stress() {
    // Some thousand additions of terms of the size E strain: round-off.
    const ACC: f64 = 1e-12;
    for order in ORDERS {
        for law in [
            MaterialLaw::SmallStrain,
            MaterialLaw::Corotational,
            MaterialLaw::CorotationalEdges,
            MaterialLaw::NeoHookean,
        ] {
            if law == MaterialLaw::CorotationalEdges && order == Order::Quadratic {
                continue;
            }
            for nu in [0.0, 0.3, 0.49] {
                let what = format!("{law:?} {order:?} nu {nu}");
                let model = model(law, nu, order);
                let f = deformation(law);
                let x = positions(&model, |x| f * x + SHIFT);
                let (energy, stress) = textbook(law, nu, &f);
                let volume = SIZE.iter().product::<f64>();
                assert!(energy > 0.0);
                assert_close(&what, model.energy(&x), energy * volume, ACC, stress.norm() * volume);

                let forces = force(&model, &x);
                let force_scale = stress.norm() * SIZE[0] * SIZE[1];
                assert_close(&what, max_norm(&free(&model, &forces)), 0.0, ACC, force_scale);
                // Σ f ⊗ X = ∫ P dV, the mean stress.
                let mut moment = Matrix3::zeros();
                for (f, x) in forces.iter().zip(&model.rest) {
                    moment += Vector3::new(f[0], f[1], f[2]) * Vector3::new(x[0], x[1], x[2]).transpose();
                }
                let off = (moment / volume - stress).norm();
                assert_close(&what, off, 0.0, ACC, stress.norm());
            }
        }
    }
}

#[test]
fn boundary_displacement_alone_gives_the_homogeneous_deformation() {
    // Newton's last step leaves round-off; the condition of these small matrices is below 1e4.
    const ACC: f64 = 1e-11;
    for order in ORDERS {
        for law in POTENTIALS {
            let model = model(law, 0.3, order);
            let f = Matrix3::identity() + 0.15 * random_matrix("test/patch");
            let exact = positions(&model, |x| f * x + SHIFT);
            // Inside a homogeneous deformation a little off: the boundary must pull it right.
            let mut x = shaken(&model, exact.clone(), 0.05 * SIZE[1] / 3.0);
            let load = vec![0.0; model.n_unknowns()];
            solve_equilibrium(&model, &load, &mut x, 7);
            let off = x.as_flattened().iter().zip(exact.as_flattened()).map(|(a, b)| a - b);
            let off: Vec<f64> = off.collect();
            assert_close(&format!("{law:?} {order:?}"), max_norm(&off), 0.0, ACC, SIZE[0]);

            let inside = [0.4 * SIZE[0], 0.3 * SIZE[1], 0.7 * SIZE[2]];
            let expected = f * Vector3::from(inside) + SHIFT;
            let found = Vector3::from(Embedding::new(&model, inside).at(&x));
            assert_close("point inside", (found - expected).norm(), 0.0, ACC, SIZE[0]);
        }
    }
}

#[test]
fn edge_frames_pass_the_patch_test_only_to_first_order() {
    // Doubling the strain must quadruple the residual (second order), not double it; higher orders of the
    // strain add a few per cent.
    let model = model(MaterialLaw::CorotationalEdges, 0.3, Order::Linear);
    let residual = |strain: f64| {
        let f = rotation(0.7) * (Matrix3::identity() + strain * random_matrix("test/patch"));
        max_norm(&free(&model, &force(&model, &positions(&model, |x| f * x))))
    };
    let ratio = residual(2e-3) / residual(1e-3);
    assert!((3.8..4.2).contains(&ratio), "{ratio}");
}
