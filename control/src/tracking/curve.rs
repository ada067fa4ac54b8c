//! Distances between curves in the plane: lines through points, in the order of the points.
//!
//! The nearest point is looked for on the lines between the points, so that no distance depends on how densely a curve
//! was sampled; only the discrete Fréchet distance pairs the points themselves, by its definition.

/// A point in the plane [m].
pub type PlanarPoint = [f64; 2];

/// The point of the curve that is nearest to `p`: q̂ of the CoReAct paper, eq. 21. The curve has at least one point.
pub fn nearest(p: PlanarPoint, curve: &[PlanarPoint]) -> PlanarPoint {
    if curve.len() == 1 {
        return curve[0];
    }
    let mut best = (f64::INFINITY, curve[0]);
    for pair in curve.windows(2) {
        let q = foot(p, pair[0], pair[1]);
        let squared = (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2);
        if squared < best.0 {
            best = (squared, q);
        }
    }
    best.1
}

/// Distance of every point of `from` (points) to the curve `to` [m].
pub fn distances(from: &[PlanarPoint], to: &[PlanarPoint]) -> Vec<f64> {
    from.iter().map(|p| distance(*p, nearest(*p, to))).collect()
}

/// Symmetric Chamfer distance [m]: the mean distance of the points of each curve from the other, averaged over both.
pub fn chamfer(a: &[PlanarPoint], b: &[PlanarPoint]) -> f64 {
    0.5 * (mean(&distances(a, b)) + mean(&distances(b, a)))
}

/// Hausdorff distance [m]: the largest distance of a point of either curve from the other.
pub fn hausdorff(a: &[PlanarPoint], b: &[PlanarPoint]) -> f64 {
    distances(a, b).into_iter().chain(distances(b, a)).fold(0.0, f64::max)
}

/// Discrete Fréchet distance [m]: the shortest leash with which both curves can be walked, point by point and never
/// back. Each has at least one point.
///
/// # Reference
/// T. Eiter and H. Mannila, Computing discrete Fréchet distance, TU Wien, 1994.
pub fn frechet(a: &[PlanarPoint], b: &[PlanarPoint]) -> f64 {
    // Row by row of their table: leash[j] for the walk to a[i], b[j].
    let mut leash = vec![0.0f64; b.len()];
    for (i, p) in a.iter().enumerate() {
        let mut diagonal = f64::INFINITY;
        for (j, q) in b.iter().enumerate() {
            let before = match (i, j) {
                (0, 0) => 0.0,
                (0, _) => leash[j - 1],
                (_, 0) => leash[0],
                _ => leash[j].min(leash[j - 1]).min(diagonal),
            };
            diagonal = leash[j];
            leash[j] = before.max(distance(*p, *q));
        }
    }
    leash[b.len() - 1]
}

/// The point between `a` and `b` that is nearest to `p`.
fn foot(p: PlanarPoint, a: PlanarPoint, b: PlanarPoint) -> PlanarPoint {
    let along = [b[0] - a[0], b[1] - a[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    if squared == 0.0 {
        return a;
    }
    let part = ((p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1]) / squared;
    let part = part.clamp(0.0, 1.0);
    [a[0] + part * along[0], a[1] + part * along[1]]
}

pub(super) fn distance(a: PlanarPoint, b: PlanarPoint) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
