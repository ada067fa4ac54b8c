//! Order of convergence against a smooth equilibrium known in closed form.

use hysteron_base::MaterialLaw;
use hysteron_fem::FemModel;

use super::*;

const NU: f64 = 0.3;

/// Papkovich-Neuber: u = 4 (1 - ν) B - ∇(X·B) is in equilibrium without body force for every harmonic
/// B = (0, 0, h); here h = exp(a x) sin(b y + 0.3) cos(c z) with a² = b² + c².
fn exact(x: Vector3<f64>) -> Vector3<f64> {
    let (a, b, c) = (2.5, 1.5, 2.0);
    let (along, (sin, cos)) = ((a * x[0]).exp(), (b * x[1] + 0.3).sin_cos());
    let (sin_z, cos_z) = (c * x[2]).sin_cos();
    let h = along * sin * cos_z;
    let gradient = Vector3::new(a * h, b * along * cos * cos_z, -c * along * sin * sin_z);
    let u = Vector3::new(0.0, 0.0, (4.0 * (1.0 - NU) - 1.0) * h) - x[2] * gradient;
    1e-3 * u
}

/// Shape functions, written here once more.
fn shape(n: usize, l: [f64; 4]) -> Vec<f64> {
    if n == 4 {
        return l.to_vec();
    }
    let corners = l.map(|l| l * (2.0 * l - 1.0));
    let middles =
        [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]].map(|[i, j]: [usize; 2]| 4.0 * l[i] * l[j]);
    [&corners[..], &middles[..]].concat()
}

/// L2 error of the displacement on a unit cube whose boundary nodes are displaced exactly, in quadrature
/// of degree 3.
fn l2_error(n: usize, order: Order) -> f64 {
    let mesh = box_mesh([n; 3], [1.0; 3], 0.15, order);
    let model =
        FemModel::new(&mesh, material(MaterialLaw::SmallStrain, NU), &mesh.groups["boundary"]).unwrap();
    let mut x = model.rest.clone();
    for (x, rest) in x[model.n_free..].iter_mut().zip(&model.rest[model.n_free..]) {
        let u = exact(Vector3::new(rest[0], rest[1], rest[2]));
        *x = std::array::from_fn(|c| rest[c] + if c < 3 { u[c] } else { 0.0 });
    }
    // The law is linear: one step solves.
    let before = max_norm(&free(&model, &force(&model, &x)));
    let left = solve_equilibrium(&model, &vec![0.0; model.n_unknowns()], &mut x, 1);
    assert!(left < 1e-9 * before, "{left} of {before}");

    let points = std::iter::once(([0.25; 4], -0.8)).chain((0..4).map(|k| {
        let mut l = [1.0 / 6.0; 4];
        l[k] = 0.5;
        (l, 0.45)
    }));
    let points: Vec<_> = points.map(|(l, weight)| (shape(model.cells.nodes(0).len(), l), weight)).collect();
    let mut sum = 0.0;
    for e in 0..model.cells.len() {
        let nodes = model.cells.nodes(e);
        let at = |x: &[[f64; 4]], i: usize| Vector3::new(x[i][0], x[i][1], x[i][2]);
        let [o, a, b, c] = model.cells.corners(e).map(|i| at(&model.rest, i as usize));
        let volume = (a - o).dot(&(b - o).cross(&(c - o))).abs() / 6.0;
        for (shape, weight) in &points {
            let interpolate = |x: &[[f64; 4]]| -> Vector3<f64> {
                nodes.iter().zip(shape).map(|(i, n)| *n * at(x, *i as usize)).sum()
            };
            let rest = interpolate(&model.rest);
            sum += weight * volume * (interpolate(&x) - rest - exact(rest)).norm_squared();
        }
    }
    sum.sqrt()
}

/// Observed order between two refinements, p = ln(e1 / e2) / ln(n2 / n1).
fn observed(n: [usize; 2], order: Order) -> f64 {
    let [coarse, fine] = n.map(|n| l2_error(n, order));
    (coarse / fine).ln() / (n[1] as f64 / n[0] as f64).ln()
}

#[test]
fn linear_elements_converge_with_second_order() {
    // Theory: 2. Random meshes that are not nested scatter the observed order by about 0.1.
    let order = observed([5, 10], Order::Linear);
    assert!((1.8..2.2).contains(&order), "{order}");
}

#[test]
fn quadratic_elements_converge_with_third_order() {
    // Theory: 3; as above.
    let order = observed([3, 6], Order::Quadratic);
    assert!((2.8..3.3).contains(&order), "{order}");
}
