//! How closely two closed curves cover each other.
//!
//! The plane is cut into horizontal slabs at every corner and every crossing. Within a slab edges are straight and
//! in one order, so what is inside is a row of trapezoids, and areas are exact to rounding however often a curve
//! crosses itself. No polygons are made, of which a crossing point could belong to several.

use super::curve::PlanarPoint;

/// Intersection over union of the polygons that two curves enclose [-], each closed from its last point to its
/// first; `None` where neither encloses anything, or where they cross millions of times.
///
/// Inside is what a curve goes around an odd number of times (even-odd rule): of a curve that crosses itself, as a
/// Lissajous figure, every lobe counts once, and what it goes around twice does not.
///
/// # Reference
/// CoReAct paper, section V-B, "polygon IoU"; its rule for curves that cross themselves is not stated.
pub fn iou(a: &[PlanarPoint], b: &[PlanarPoint]) -> Option<f64> {
    let mut edges: Vec<Edge> = edges(a, 0).chain(edges(b, 1)).collect();
    edges.sort_by(|one, other| one.low[1].total_cmp(&other.low[1]));
    let [intersection, union] = areas(&edges, &heights(&edges)?);
    (union > 0.0).then(|| intersection / union)
}

/// A side of a polygon that is not level.
#[derive(Debug, Clone, Copy)]
struct Edge {
    low: PlanarPoint,
    high: PlanarPoint,
    /// Which curve it is of, 0 or 1.
    curve: usize,
}

impl Edge {
    /// x at height `y`.
    fn x(&self, y: f64) -> f64 {
        let part = (y - self.low[1]) / (self.high[1] - self.low[1]);
        self.low[0] + part * (self.high[0] - self.low[0])
    }
}

fn edges(points: &[PlanarPoint], curve: usize) -> impl Iterator<Item = Edge> + '_ {
    let n = points.len();
    (0..n).filter_map(move |i| {
        let (p, q) = (points[i], points[(i + 1) % n]);
        let [low, high] = if p[1] < q[1] { [p, q] } else { [q, p] };
        (low[1] < high[1]).then_some(Edge { low, high, curve })
    })
}

/// More ends and crossings than two outlines have: a scribble encloses nothing that could be compared.
const MAX_HEIGHTS: usize = 10_000_000;

/// Heights of all ends and crossings of edges (in order of their lower ends), in order; none where they are too many.
fn heights(edges: &[Edge]) -> Option<Vec<f64>> {
    let mut heights: Vec<f64> = edges.iter().flat_map(|edge| [edge.low[1], edge.high[1]]).collect();
    let mut active: Vec<Edge> = Vec::new();
    for edge in edges {
        active.retain(|earlier| earlier.high[1] > edge.low[1]);
        heights.extend(active.iter().filter_map(|earlier| crossing(earlier, edge)));
        if heights.len() > MAX_HEIGHTS {
            return None;
        }
        active.push(*edge);
    }
    heights.sort_by(f64::total_cmp);
    heights.dedup();
    Some(heights)
}

/// Height at which two edges cross, if they do between their ends.
fn crossing(one: &Edge, other: &Edge) -> Option<f64> {
    let (from, to) = (one.low[1].max(other.low[1]), one.high[1].min(other.high[1]));
    let (before, after) = (one.x(from) - other.x(from), one.x(to) - other.x(to));
    (before * after < 0.0).then(|| from + (to - from) * (before / (before - after)))
}

/// Areas of the intersection and of the union.
fn areas(edges: &[Edge], heights: &[f64]) -> [f64; 2] {
    let mut areas = [0.0; 2];
    let mut next = 0;
    let mut active: Vec<Edge> = Vec::new();
    let mut row: Vec<(f64, usize)> = Vec::new();
    for slab in heights.windows(2) {
        let (low, high, middle) = (slab[0], slab[1], 0.5 * (slab[0] + slab[1]));
        active.retain(|edge| edge.high[1] > low);
        while next < edges.len() && edges[next].low[1] <= low {
            active.push(edges[next]);
            next += 1;
        }
        row.clear();
        row.extend(active.iter().map(|edge| (edge.x(middle), edge.curve)));
        row.sort_by(|one, other| one.0.total_cmp(&other.0));
        let mut is_inside = [false; 2];
        for (k, (x, curve)) in row.iter().enumerate() {
            is_inside[*curve] = !is_inside[*curve];
            let right = row.get(k + 1).map_or(*x, |(right, _)| *right);
            let area = (right - x) * (high - low);
            if is_inside[0] && is_inside[1] {
                areas[0] += area;
            }
            if is_inside[0] || is_inside[1] {
                areas[1] += area;
            }
        }
    }
    areas
}
