//! Points carried by elements, nodal volumes and weight.

use hysteron_base::MaterialLaw;
use hysteron_fem::{Embedding, FemModel};
use nalgebra::Vector3;

use super::*;

/// Barycentric coordinates by one 3×3 inverse of elements of good shape: round-off.
const ACC: f64 = 1e-12;
const SIZE: [f64; 3] = [0.03, 0.02, 0.04];

fn model(order: Order) -> FemModel {
    let mesh = box_mesh([3, 2, 4], SIZE, 0.25, order);
    let base = nodes_where(&mesh, |x| x[2] == 0.0);
    FemModel::new(&mesh, material(MaterialLaw::Corotational, 0.3), &base).unwrap()
}

/// Points of the box, blown up about its centre by `factor`.
fn points(factor: f64) -> Vec<[f64; 3]> {
    let mut stream = rng(17, "test/embedding");
    (0..200).map(|_| SIZE.map(|s| s * (0.5 + 0.5 * factor * stream.random_range(-1.0..1.0)))).collect()
}

#[test]
fn weights_add_up_to_one_and_give_back_the_point() {
    for order in ORDERS {
        let model = model(order);
        // A fifth outside as well: extrapolated.
        for point in points(1.2) {
            let embedding = Embedding::new(&model, point);
            assert_close("sum", embedding.weights.iter().sum(), 1.0, ACC, 1.0);
            let off = Vector3::from(embedding.at(&model.rest)) - Vector3::from(point);
            assert_close("point", off.norm(), 0.0, ACC, SIZE[2]);
        }
    }
}

#[test]
fn affine_motion_is_carried_exactly_inside_and_outside() {
    let (a, b) = (random_matrix("test/embedding"), Vector3::new(0.3, -0.1, 0.2));
    for order in ORDERS {
        let model = model(order);
        let x = positions(&model, |x| a * x + b);
        for point in points(1.2) {
            let found = Vector3::from(Embedding::new(&model, point).at(&x));
            assert_close("moved", (found - (a * Vector3::from(point) + b)).norm(), 0.0, ACC, b.norm());
        }
    }
}

#[test]
fn quadratic_motion_is_carried_exactly_by_quadratic_elements_only() {
    let a = random_matrix("test/embedding") / 0.03;
    let map = |x: Vector3<f64>| x + (a * x).component_mul(&x);
    let worst = |order: Order| {
        let model = model(order);
        let x = positions(&model, map);
        let off = points(1.0).into_iter().map(|point| {
            (Vector3::from(Embedding::new(&model, point).at(&x)) - map(Vector3::from(point))).norm()
        });
        off.fold(0.0, f64::max)
    };
    assert_close("quadratic", worst(Order::Quadratic), 0.0, ACC, SIZE[2]);
    assert!(worst(Order::Linear) > 1e-3 * SIZE[2]);
}

#[test]
fn distance_is_zero_inside_and_exact_outside() {
    let [x, y, z] = SIZE;
    let d = 0.003;
    for order in ORDERS {
        let model = model(order);
        for point in points(1.0) {
            assert_eq!(Embedding::new(&model, point).distance, 0.0);
        }
        for (point, expected) in [
            ([x + d, 0.4 * y, 0.6 * z], d),
            ([0.3 * x, -d, 0.6 * z], d),
            ([x + d, y + d, 0.6 * z], 2_f64.sqrt() * d),
            ([-d, 0.3 * y, -d], 2_f64.sqrt() * d),
            ([x + d, -d, z + d], 3_f64.sqrt() * d),
        ] {
            assert_close("distance", Embedding::new(&model, point).distance, expected, ACC, z);
        }
    }
}

#[test]
fn nodal_volumes_add_up_and_weigh() {
    // Sums of some hundred terms: round-off.
    const SUM: f64 = 1e-13;
    let gravity = [1.0, -2.0, -9.81];
    for order in ORDERS {
        let model = model(order);
        let volume: f64 = SIZE.iter().product();
        assert_close("volume", model.nodal_volumes.iter().sum(), volume, SUM, volume);
        let mass = 1200.0 * volume;
        let weight = model.weight(gravity);
        for c in 0..3 {
            let sum: f64 = weight.iter().map(|w| w[c]).sum();
            assert_close("weight", sum, mass * gravity[c], SUM, mass);
            // Moment of the weight: that of the mass at the centre of the box.
            let moment: f64 = weight.iter().zip(&model.rest).map(|(w, x)| w[c] * x[2]).sum();
            assert_close("moment", moment, mass * gravity[c] * SIZE[2] / 2.0, SUM, mass * SIZE[2]);
        }
    }
}
