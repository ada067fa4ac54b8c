//! Shape functions and quadrature of linear and quadratic tetrahedra.
//!
//! Natural coordinates are the four barycentric coordinates of the corners.

/// Edges of a ten-node tetrahedron, in the order of their middle nodes 4-9.
const EDGES: [(usize, usize); 6] = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)];

/// Values of the `N` shape functions at barycentric coordinates `l`.
pub(crate) fn shape_values<const N: usize>(l: [f64; 4]) -> [f64; N] {
    let mut values = [0.0; N];
    if N == 4 {
        values.copy_from_slice(&l);
        return values;
    }
    for a in 0..4 {
        values[a] = l[a] * (2.0 * l[a] - 1.0);
    }
    for (e, (a, b)) in EDGES.into_iter().enumerate() {
        values[4 + e] = 4.0 * l[a] * l[b];
    }
    values
}

/// Derivatives of the shape functions by the four barycentric coordinates.
pub(crate) fn shape_derivatives<const N: usize>(l: [f64; 4]) -> [[f64; 4]; N] {
    let mut derivatives = [[0.0; 4]; N];
    if N == 4 {
        for a in 0..4 {
            derivatives[a][a] = 1.0;
        }
        return derivatives;
    }
    for a in 0..4 {
        derivatives[a][a] = 4.0 * l[a] - 1.0;
    }
    for (e, (a, b)) in EDGES.into_iter().enumerate() {
        derivatives[4 + e][a] = 4.0 * l[b];
        derivatives[4 + e][b] = 4.0 * l[a];
    }
    derivatives
}

/// Quadrature points with equal weights, as barycentric coordinates: the centroid for one point, the
/// four-point rule of degree 2 otherwise (Keast 1986, rule 1).
pub(crate) fn quadrature<const Q: usize>() -> [[f64; 4]; Q] {
    if Q == 1 {
        return [[0.25; 4]; Q];
    }
    let (far, near) = (0.138_196_601_125_010_5, 0.585_410_196_624_968_5);
    std::array::from_fn(|q| std::array::from_fn(|a| if a == q { near } else { far }))
}
