//! Is this mesh fit to be computed with, and how good are its tetrahedra?
//!
//! Main decision: what would make the stiffness singular, or a step fail far from its cause, is an error
//! here, with the number of the tetrahedron; what only costs accuracy is a figure in the report.

use std::f64::consts::PI;

use hysteron_base::BadInput;
use nalgebra::{Matrix3, Vector3};

use crate::mesh::faces::{EDGE_CORNERS, sorted_faces};
use crate::{Cells, Mesh, Result};

/// Radius ratio below which a tetrahedron counts as a sliver, and is reported \[-\].
const SLIVER: f64 = 0.01;

/// Volume below which a tetrahedron counts as flat, over the cube of its longest edge \[-\].
const FLAT: f64 = 1e-12;

/// Quality figures of a mesh that passed [`check_mesh`].
#[derive(Debug, Clone, PartialEq)]
pub struct MeshQuality {
    /// Number of nodes.
    pub n_nodes: usize,
    /// Number of tetrahedra.
    pub n_cells: usize,
    /// Volume of every tetrahedron \[m³\], curved edges included.
    pub volume: Distribution,
    /// Three times the radius of the inscribed over that of the circumscribed sphere \[-\]: 1 for the
    /// regular tetrahedron, 0 for a flat one. From the corners.
    pub radius_ratio: Distribution,
    /// Smallest angle between two faces \[rad\]; at most 1.231 (70.5°). From the corners.
    pub smallest_angle: Distribution,
    /// Number of slivers: tetrahedra with a radius ratio below 0.01. A step can be computed with them.
    pub slivers: usize,
    /// How many times stiffer than the median tetrahedron the stiffest is, by the squares of its faces over its volume
    /// \[-\].
    pub stiffness_spread: f64,
}

impl MeshQuality {
    /// Warnings of a mesh that costs accuracy or time, with the tetrahedron and its effect; empty for a good
    /// mesh.
    pub fn warnings(&self) -> Vec<String> {
        if self.slivers == 0 {
            return Vec::new();
        }
        let others = match self.slivers - 1 {
            0 => String::new(),
            1 => ", and another one is".to_owned(),
            n => format!(", and {n} others are"),
        };
        vec![format!(
            "tetrahedron {} is a sliver (radius ratio {:.1e}){others}: the stiffest tetrahedron is {:.0e} times as stiff \
             as the median one, so that the body bends too little there and steps take more iterations (hint: \
             mesh the part again, with `gmsh -optimize_netgen`)",
            self.radius_ratio.min_cell, self.radius_ratio.min, self.stiffness_spread,
        )]
    }
}

/// How one figure is spread over the tetrahedra.
#[derive(Debug, Clone, PartialEq)]
pub struct Distribution {
    /// Smallest value.
    pub min: f64,
    /// Tetrahedron that has it.
    pub min_cell: usize,
    /// Value that 1 % of the tetrahedra stay below.
    pub percentile_1: f64,
    /// Value that 5 % stay below.
    pub percentile_5: f64,
    /// Value that half stay below.
    pub median: f64,
    /// Mean.
    pub mean: f64,
    /// Largest value.
    pub max: f64,
    /// Sum.
    pub sum: f64,
    /// Limits of the bins, one more than there are bins.
    pub limits: Vec<f64>,
    /// Tetrahedra per bin.
    pub counts: Vec<usize>,
}

/// Evaluates every tetrahedron and the mesh as a whole. `place` names the mesh in errors, usually its file.
///
/// # Errors
/// `BadInput` for an index out of range, a coordinate that is not finite, a node of no tetrahedron, a
/// tetrahedron that is inverted or flat (volume below 1e-12 of its longest edge cubed), for ten-node ones also a
/// Jacobian that is not positive at the corners and integration points, a face of more than two tetrahedra, and
/// parts that no face connects. Slivers are figures of the result: [`MeshQuality::warnings`].
pub fn check_mesh(mesh: &Mesh, place: &str) -> Result<MeshQuality> {
    let quality = evaluate(mesh).map_err(|e| if place.is_empty() { e } else { e.within(place) })?;
    Ok(quality)
}

fn evaluate(mesh: &Mesh) -> std::result::Result<MeshQuality, BadInput> {
    check_indices(mesh)?;
    let n_cells = mesh.cells.len();
    let mut volumes = Vec::with_capacity(n_cells);
    let mut ratios = Vec::with_capacity(n_cells);
    let mut angles = Vec::with_capacity(n_cells);
    let mut stiffness = Vec::with_capacity(n_cells);
    for e in 0..n_cells {
        let x = mesh.cells.corners(e).map(|n| Vector3::from(mesh.nodes[n as usize]));
        let Corners { volume, radius_ratio, smallest_angle, stiffness: own } = evaluate_corners(&x, e)?;
        ratios.push(radius_ratio);
        angles.push(smallest_angle);
        stiffness.push(own);
        volumes.push(match &mesh.cells {
            Cells::Tet4(_) => volume,
            Cells::Tet10(cells) => {
                curved_volume(&cells[e].map(|n| Vector3::from(mesh.nodes[n as usize])), e)?
            }
        });
    }
    check_faces(&mesh.cells)?;

    let largest = volumes.iter().copied().fold(0.0, f64::max);
    stiffness.sort_unstable_by(f64::total_cmp);
    let tenths = |top: f64| (0..=10).map(|i| top * f64::from(i) / 10.0).collect();
    Ok(MeshQuality {
        n_nodes: mesh.nodes.len(),
        n_cells,
        volume: distribution(&volumes, tenths(largest)),
        radius_ratio: distribution(&ratios, tenths(1.0)),
        smallest_angle: distribution(&angles, (0..=8).map(|i| f64::from(10 * i).to_radians()).collect()),
        slivers: ratios.iter().filter(|ratio| **ratio < SLIVER).count(),
        stiffness_spread: stiffness[n_cells - 1] / stiffness[n_cells / 2],
    })
}

fn check_indices(mesh: &Mesh) -> std::result::Result<(), BadInput> {
    let n = mesh.nodes.len();
    if mesh.cells.is_empty() {
        return Err(BadInput::new("mesh", "tetrahedra", "none"));
    }
    for (node, x) in mesh.nodes.iter().enumerate() {
        if x.iter().any(|v| !v.is_finite()) {
            return Err(BadInput::new(format!("node {node}"), "finite coordinates", format!("{x:?}")));
        }
    }
    let expected = format!("nodes below {n}");
    let mut used = vec![false; n];
    for e in 0..mesh.cells.len() {
        for &node in mesh.cells.nodes(e) {
            match used.get_mut(node as usize) {
                Some(flag) => *flag = true,
                None => {
                    return Err(BadInput::new(format!("tetrahedron {e}"), expected, node.to_string()));
                }
            }
        }
    }
    if let Some(node) = used.iter().position(|&flag| !flag) {
        return Err(BadInput::new(format!("node {node}"), "a tetrahedron that uses it", "none")
            .hint("a loose node can move freely; take it out"));
    }
    for (name, set) in &mesh.groups {
        if let Some(node) = set.iter().find(|&&node| node as usize >= n) {
            return Err(BadInput::new(format!("group {name}"), expected, node.to_string()));
        }
    }
    Ok(())
}

/// Volume and shape of a straight tetrahedron, from its corners.
struct Corners {
    /// \[m³\].
    volume: f64,
    /// \[-\].
    radius_ratio: f64,
    /// Dihedral \[rad\].
    smallest_angle: f64,
    /// Sum of its squared faces over nine times its volume, the stiffness over the modulus \[m\].
    stiffness: f64,
}

/// Refuses a tetrahedron without a volume.
fn evaluate_corners(x: &[Vector3<f64>; 4], e: usize) -> std::result::Result<Corners, BadInput> {
    let length = EDGE_CORNERS.map(|[i, j]| (x[j] - x[i]).norm());
    let longest = length.iter().copied().fold(0.0, f64::max);
    let volume = (x[1] - x[0]).dot(&(x[2] - x[0]).cross(&(x[3] - x[0]))) / 6.0;
    let flat = FLAT * longest.powi(3);
    let shown = format!("{:.3e} mm³", volume * 1e9);
    if volume < -flat {
        return Err(BadInput::new(format!("tetrahedron {e}"), "a positive volume", shown)
            .hint("it is inside out: two of its nodes are exchanged, or the mesh folds over itself"));
    }
    if volume <= flat {
        return Err(BadInput::new(format!("tetrahedron {e}"), "a volume", format!("none ({shown})"))
            .hint("its four corners lie in one plane: optimise the mesh, or mesh again"));
    }
    // Twice the outward area vector of the face opposite to each corner.
    let normal = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]
        .map(|[a, b, c]: [usize; 3]| (x[b] - x[a]).cross(&(x[c] - x[a])));
    let area: f64 = normal.iter().map(|n| n.norm() / 2.0).sum();
    let inscribed = 3.0 * volume / area;
    // Products of opposite edges: the circumscribed radius is the area of the triangle with these sides,
    // over 6 V (Crelle's formula).
    let (p, q, r) = (length[0] * length[5], length[1] * length[3], length[2] * length[4]);
    let crelle = (p + q + r) * (p + q - r) * (p - q + r) * (q + r - p);
    let circumscribed = crelle.max(0.0).sqrt() / 4.0 / (6.0 * volume);
    // Round-off may leave no circumscribed sphere to the flattest ones.
    let radius_ratio = if circumscribed > 0.0 { 3.0 * inscribed / circumscribed } else { 0.0 };
    let mut angle = PI;
    for i in 0..4 {
        for j in 0..i {
            angle = angle.min(PI - normal[i].angle(&normal[j]));
        }
    }
    let squares: f64 = normal.iter().map(|n| n.norm_squared() / 4.0).sum();
    Ok(Corners { volume, radius_ratio, smallest_angle: angle, stiffness: squares / (9.0 * volume) })
}

/// Volume of a ten-node tetrahedron \[m³\] after a look at its Jacobian.
fn curved_volume(x: &[Vector3<f64>; 10], e: usize) -> std::result::Result<f64, BadInput> {
    // Barycentric coordinates: the corners, the four points of degree 2, and the five of degree 3, of which
    // the last is the centre.
    let with = |big: f64, small: f64| {
        (0..4).map(move |i| {
            let mut l = [small; 4];
            l[i] = big;
            l
        })
    };
    let four = (5.0 - 5.0_f64.sqrt()) / 20.0;
    let points = with(1.0, 0.0)
        .chain(with(1.0 - 3.0 * four, four))
        .chain(with(0.5, 1.0 / 6.0))
        .chain(with(0.25, 0.25).take(1));
    let mut volume = 0.0;
    for (k, l) in points.enumerate() {
        let determinant = jacobian(x, &l).determinant();
        if determinant.is_nan() || determinant <= 0.0 {
            return Err(BadInput::new(
                format!("tetrahedron {e}"),
                "a positive Jacobian at the corners and integration points",
                format!("{:.3e} mm³ at barycentric {l:.3?}", determinant * 1e9),
            )
            .hint("its curved edges fold over: use straight edges there, or smaller tetrahedra"));
        }
        // Zienkiewicz & Taylor, five points of degree 3: exact, the determinant being a cubic.
        volume += match k {
            8..12 => 9.0 / 20.0 * determinant / 6.0,
            12 => -4.0 / 5.0 * determinant / 6.0,
            _ => 0.0,
        };
    }
    Ok(volume)
}

/// Derivative of the position by the last three barycentric coordinates, at `l` (3 × 3) \[m\].
fn jacobian(x: &[Vector3<f64>; 10], l: &[f64; 4]) -> Matrix3<f64> {
    let mut by = [Vector3::zeros(); 4];
    for i in 0..4 {
        by[i] += x[i] * (4.0 * l[i] - 1.0);
    }
    for (k, [i, j]) in EDGE_CORNERS.into_iter().enumerate() {
        by[i] += x[4 + k] * (4.0 * l[j]);
        by[j] += x[4 + k] * (4.0 * l[i]);
    }
    Matrix3::from_columns(&[by[1] - by[0], by[2] - by[0], by[3] - by[0]])
}

/// Every face belongs to one or two tetrahedra, and faces connect them all.
fn check_faces(cells: &Cells) -> std::result::Result<(), BadInput> {
    let faces = sorted_faces(cells);
    let mut part: Vec<usize> = (0..cells.len()).collect();
    for same in faces.chunk_by(|a, b| a.0 == b.0) {
        if same.len() > 2 {
            return Err(BadInput::new(
                format!("face of nodes {:?}", same[0].0),
                "one or two tetrahedra",
                format!("{} (the first are {} and {})", same.len(), same[0].1.cell, same[1].1.cell),
            )
            .hint("tetrahedra are doubled or overlap"));
        }
        if let [a, b] = same {
            let (a, b) = (root(&mut part, a.1.cell as usize), root(&mut part, b.1.cell as usize));
            part[a.max(b)] = a.min(b);
        }
    }
    let mut size = vec![0_usize; cells.len()];
    for e in 0..cells.len() {
        size[root(&mut part, e)] += 1;
    }
    // The root of a part is its first tetrahedron.
    let mut parts: Vec<(usize, usize)> = size.into_iter().enumerate().filter(|&(_, size)| size > 0).collect();
    parts.sort_by_key(|&(_, size)| std::cmp::Reverse(size));
    if parts.len() > 1 {
        let few: Vec<String> = parts.iter().take(5).map(|(_, size)| size.to_string()).collect();
        let more = if parts.len() > 5 { ", …" } else { "" };
        return Err(BadInput::new(
            "mesh",
            "one part, connected through faces",
            format!(
                "{} parts of {}{more} tetrahedra (tetrahedron {} is not in the largest)",
                parts.len(),
                few.join(", "),
                parts[1].0,
            ),
        )
        .hint("fuse the bodies before meshing, and merge coincident nodes"));
    }
    Ok(())
}

fn root(part: &mut [usize], mut e: usize) -> usize {
    while part[e] != e {
        part[e] = part[part[e]];
        e = part[e];
    }
    e
}

/// `values` is not empty and finite; values outside the limits count in the first and last bin.
fn distribution(values: &[f64], limits: Vec<f64>) -> Distribution {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| sorted[(share * (sorted.len() - 1) as f64).round() as usize];
    let sum: f64 = values.iter().sum();
    let mut counts = vec![0; limits.len() - 1];
    for v in values {
        let bin = limits.partition_point(|limit| limit <= v).clamp(1, counts.len()) - 1;
        counts[bin] += 1;
    }
    Distribution {
        min: sorted[0],
        min_cell: values.iter().position(|v| *v == sorted[0]).unwrap_or(0),
        percentile_1: at(0.01),
        percentile_5: at(0.05),
        median: at(0.5),
        mean: sum / values.len() as f64,
        max: sorted[sorted.len() - 1],
        sum,
        limits,
        counts,
    }
}
