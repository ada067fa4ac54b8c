#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod anchors;
mod bad_input;
mod beams;
mod convergence;
mod derivatives;
mod embedding;
mod factors;
mod invariance;
mod patch;

use std::collections::BTreeMap;
use std::sync::Arc;

use hysteron_base::{Material, MaterialLaw, rng};
use hysteron_fem::{Cells, FactorKind, FemModel, Mesh, Order, Stiffness, StiffnessFactor, Tangent};
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use rand::RngExt;

pub const YOUNG: f64 = 2e5;
pub const ORDERS: [Order; 2] = [Order::Linear, Order::Quadratic];
/// Laws whose force is the gradient of their energy.
pub const POTENTIALS: [MaterialLaw; 3] =
    [MaterialLaw::SmallStrain, MaterialLaw::Corotational, MaterialLaw::NeoHookean];

/// Fails unless `found` is `expected` within `acc * max(scale, |expected|)`; `TOL_SCALE=0` prints residuals.
#[track_caller]
#[expect(clippy::print_stderr, reason = "asked for by TOL_SCALE")]
pub fn assert_close(what: &str, found: f64, expected: f64, acc: f64, scale: f64) {
    let tol = acc * scale.abs().max(expected.abs());
    let residual = (found - expected).abs();
    if std::env::var("TOL_SCALE").is_ok_and(|scale| scale == "0") {
        eprintln!("{what}: residual {residual:.3e}, tolerance {tol:.3e}");
    }
    assert!(residual <= tol, "{what}: {found:e}, expected {expected:e}: off by {residual:.3e} > {tol:.3e}");
}

pub fn material(law: MaterialLaw, poisson_ratio: f64) -> Material {
    Material { law, youngs_modulus: YOUNG, poisson_ratio, density: 1200.0 }
}

/// A box from the origin, cut into `n` cubes along each axis and six tetrahedra a cube (Kuhn); inner nodes
/// are moved by up to `jitter` of the cube's edges. Group `boundary`: all nodes on the surface.
pub fn box_mesh(n: [usize; 3], size: [f64; 3], jitter: f64, order: Order) -> Mesh {
    let index = |i: [usize; 3]| ((i[2] * (n[1] + 1) + i[1]) * (n[0] + 1) + i[0]) as u32;
    let mut stream = rng(7, "test/box");
    let mut nodes = Vec::new();
    for k in 0..=n[2] {
        for j in 0..=n[1] {
            for i in 0..=n[0] {
                let at = [i, j, k];
                let inner = (0..3).all(|c| at[c] > 0 && at[c] < n[c]);
                let reach = if inner { jitter } else { 0.0 };
                nodes.push([0, 1, 2].map(|c| {
                    (at[c] as f64 + reach * stream.random_range(-1.0..1.0)) * size[c] / n[c] as f64
                }));
            }
        }
    }
    const PATHS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let mut cells = Vec::new();
    for k in 0..n[2] {
        for j in 0..n[1] {
            for i in 0..n[0] {
                for (p, path) in PATHS.into_iter().enumerate() {
                    let mut at = [i, j, k];
                    let mut cell = [index(at); 4];
                    for (corner, axis) in (1..).zip(path) {
                        at[axis] += 1;
                        cell[corner] = index(at);
                    }
                    // Odd permutations give a left-handed path.
                    if p >= 3 {
                        cell.swap(2, 3);
                    }
                    cells.push(cell);
                }
            }
        }
    }
    let mesh = Mesh { nodes, cells: Cells::Tet4(cells), groups: BTreeMap::new() };
    let mut mesh = if order == Order::Quadratic { mesh.to_quadratic() } else { mesh };
    let on_surface = |x: &[f64; 3]| (0..3).any(|c| x[c] < 1e-9 * size[c] || x[c] > (1.0 - 1e-9) * size[c]);
    let boundary = nodes_where(&mesh, on_surface);
    mesh.groups.insert("boundary".into(), boundary);
    mesh
}

/// Numbers of the nodes for which `chosen` holds.
pub fn nodes_where(mesh: &Mesh, chosen: impl Fn(&[f64; 3]) -> bool) -> Vec<u32> {
    (0..mesh.nodes.len() as u32).filter(|&i| chosen(&mesh.nodes[i as usize])).collect()
}

/// Positions `map(X)` of all nodes, model order.
pub fn positions(model: &FemModel, map: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Vec<[f64; 4]> {
    let moved = model.rest.iter().map(|x| map(Vector3::new(x[0], x[1], x[2])));
    moved.map(|x| [x[0], x[1], x[2], 0.0]).collect()
}

/// Adds a random displacement of up to `size` to the free nodes.
pub fn shaken(model: &FemModel, mut x: Vec<[f64; 4]>, size: f64) -> Vec<[f64; 4]> {
    let mut stream = rng(11, "test/shaken");
    for point in &mut x[..model.n_free] {
        for c in 0..3 {
            point[c] += size * stream.random_range(-1.0..1.0);
        }
    }
    x
}

pub fn random_matrix(name: &str) -> Matrix3<f64> {
    let mut stream = rng(13, name);
    Matrix3::from_fn(|_, _| stream.random_range(-1.0..1.0))
}

/// A rotation about an oblique axis.
pub fn rotation(angle: f64) -> Matrix3<f64> {
    Rotation3::from_axis_angle(&Unit::new_normalize(Vector3::new(0.3, -0.8, 0.5)), angle).into_inner()
}

pub fn force(model: &FemModel, x: &[[f64; 4]]) -> Vec<[f64; 4]> {
    let mut out = vec![[f64::NAN; 4]; model.n_nodes()];
    model.internal_force_into(x, &mut out);
    out
}

/// The free unknowns of an array over nodes.
pub fn free(model: &FemModel, values: &[[f64; 4]]) -> Vec<f64> {
    values[..model.n_free].iter().flat_map(|v| [v[0], v[1], v[2]]).collect()
}

pub fn stiffness(model: &FemModel, x: &[[f64; 4]], kind: Tangent) -> Stiffness {
    let mut stiffness = Stiffness::zeros(Arc::new(model.stiffness_pattern(&[])));
    model.stiffness_into(x, kind, &mut stiffness);
    stiffness
}

pub fn multiply(stiffness: &Stiffness, x: &[f64]) -> Vec<f64> {
    let mut y = vec![f64::NAN; x.len()];
    stiffness.multiply_into(x, &mut y);
    y
}

pub fn max_norm(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |a, b| if b.is_nan() { f64::NAN } else { b.abs().max(a) })
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Newton's method for internal = `load` on the free nodes, the clamped ones held where `x` has them.
/// Stops when the residual no longer matters or after `steps`; returns the last residual.
pub fn solve_equilibrium(model: &FemModel, load: &[f64], x: &mut [[f64; 4]], steps: usize) -> f64 {
    let mut factor: Option<StiffnessFactor> = None;
    for step in 0.. {
        let residual: Vec<f64> = free(model, &force(model, x)).iter().zip(load).map(|(f, l)| l - f).collect();
        if step == steps {
            return max_norm(&residual);
        }
        let k = stiffness(model, x, Tangent::Exact);
        let factor =
            factor.get_or_insert_with(|| StiffnessFactor::new(&k.pattern, FactorKind::Supernodal, model.isa));
        factor.factorize(&k).unwrap();
        let mut u = residual;
        factor.solve(&mut u);
        for (point, u) in x.iter_mut().zip(u.chunks_exact(3)) {
            for c in 0..3 {
                point[c] += u[c];
            }
        }
    }
    unreachable!("the loop returns")
}
