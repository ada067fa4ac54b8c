//! The Fréchet distance of closed curves, which does not depend on where they begin.
//!
//! The free space of two closed curves is a grid of one curve's points by twice the other's. A walk that begins at the
//! s-th point of the second curve is one from column s in the first row to column s + m in the last. Walks that cross share a cell, so
//! whether there is one for any s is known from the furthest and the nearest column that each beginning reaches
//! (H. Alt and M. Godau, Int. J. Comput. Geom. Appl. 5, 1995), in the time of a single walk.

use super::curve::{PlanarPoint, frechet};

/// Halvings of the range of distances before the distances that are left in it are tried.
const HALVINGS: usize = 24;
/// Most pairs of points; closed curves with more are compared on every so many of their points.
const MAX_PAIRS: usize = 4_000_000;
/// No column.
const NONE: u32 = u32::MAX;

/// Discrete Fréchet distance of two closed curves [m]: the shortest leash with which both can be walked once around, from any pair of
/// points on and never back. The first point may be repeated at the end. Of curves with more than four million pairs of points,
/// every so many points are compared, and the distance is right to the largest distance between these.
pub fn frechet_closed(a: &[PlanarPoint], b: &[PlanarPoint]) -> f64 {
    let (a, b) = (opened(a), opened(b));
    let thin = ((a.len() * b.len()) as f64 / MAX_PAIRS as f64).sqrt().ceil().max(1.0) as usize;
    let [a, b] = [a, b].map(|curve| curve.iter().step_by(thin).copied().collect::<Vec<PlanarPoint>>());
    let (n, m) = (a.len(), b.len());
    if n < 2 || m < 2 {
        return frechet(&a, &b);
    }
    let squares: Vec<f64> = a.iter().flat_map(|p| b.iter().map(|q| squared(*p, *q))).collect();
    // No point is nearer than its nearest, and any walk is an upper bound.
    let nearest = |row: &[f64]| row.iter().copied().fold(f64::INFINITY, f64::min);
    let by_rows = squares.chunks(m).map(nearest).fold(0.0, f64::max);
    let column = |j: usize| (0..n).map(|i| squares[i * m + j]).fold(f64::INFINITY, f64::min);
    let mut low = (0..m).map(column).fold(by_rows, f64::max);
    if is_reachable(&squares, n, m, low) {
        return low.sqrt();
    }
    let mut high = squares.iter().copied().fold(0.0, f64::max);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if is_reachable(&squares, n, m, middle) { high = middle } else { low = middle }
    }
    let mut left: Vec<f64> =
        squares.iter().copied().filter(|square| *square > low && *square <= high).collect();
    left.sort_by(f64::total_cmp);
    left.dedup();
    // The smallest leash is one of the distances.
    let at = left.partition_point(|square| !is_reachable(&squares, n, m, *square));
    left.get(at).copied().unwrap_or(high).sqrt()
}

/// The curve without its first point at its end.
fn opened(curve: &[PlanarPoint]) -> &[PlanarPoint] {
    match curve {
        [first, .., last] if first == last => &curve[..curve.len() - 1],
        _ => curve,
    }
}

fn squared(p: PlanarPoint, q: PlanarPoint) -> f64 {
    (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2)
}

/// Whether both curves can be walked once around with a leash of this square. `squares` (n × m).
fn is_reachable(squares: &[f64], n: usize, m: usize, leash: f64) -> bool {
    let width = 2 * m;
    let is_free = |i: usize, j: usize| squares[(i % n) * m + j % m] <= leash;
    // From the last row, that of the first point again, to the first: the nearest and the furthest column of the last row
    // that each cell reaches.
    let mut below: Vec<[u32; 2]> = vec![[NONE; 2]; width];
    let mut row = below.clone();
    for i in (0..=n).rev() {
        for j in (0..width).rev() {
            row[j] = [NONE; 2];
            if !is_free(i, j) {
                continue;
            }
            let mut reach = if i == n { [j as u32; 2] } else { [NONE; 2] };
            let right = if j + 1 < width { [row[j + 1], below[j + 1]] } else { [[NONE; 2]; 2] };
            let downward = if i < n { [below[j], right[1]] } else { [[NONE; 2]; 2] };
            for [nearest, furthest] in [right[0], downward[0], downward[1]] {
                if nearest != NONE {
                    reach[0] = reach[0].min(nearest);
                    reach[1] = if reach[1] == NONE { furthest } else { reach[1].max(furthest) };
                }
            }
            row[j] = reach;
        }
        std::mem::swap(&mut below, &mut row);
    }
    let reached = reached_columns(is_free, n, width);
    (0..m).any(|s| {
        let ([nearest, furthest], end) = (below[s], (s + m) as u32);
        nearest != NONE && nearest <= end && end <= furthest && reached[s + m]
    })
}

/// Columns of the last row that are reached from any of the first.
fn reached_columns(is_free: impl Fn(usize, usize) -> bool, n: usize, width: usize) -> Vec<bool> {
    let mut above = vec![false; width];
    let mut row = vec![false; width];
    for i in 0..=n {
        for j in 0..width {
            let before = j > 0 && (row[j - 1] || above[j - 1]);
            row[j] = is_free(i, j) && (i == 0 || above[j] || before);
        }
        std::mem::swap(&mut above, &mut row);
    }
    above
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_base::rng;
    use rand::RngExt;

    /// By its definition: the smallest of the distances of all beginnings.
    fn by_all_beginnings(a: &[PlanarPoint], b: &[PlanarPoint]) -> f64 {
        let around = |curve: &[PlanarPoint], s: usize| -> Vec<PlanarPoint> {
            (0..=curve.len()).map(|i| curve[(s + i) % curve.len()]).collect()
        };
        (0..b.len()).map(|s| frechet(&around(a, 0), &around(b, s))).fold(f64::INFINITY, f64::min)
    }

    fn curves(seed: u64) -> [Vec<PlanarPoint>; 2] {
        let mut stream = rng(seed, "closed");
        [(); 2].map(|()| {
            let n = stream.random_range(2..25);
            (0..n).map(|_| [(); 2].map(|()| stream.random_range(-1.0..1.0))).collect()
        })
    }

    #[test]
    fn the_distance_is_the_smallest_of_all_beginnings() {
        for seed in 0..300 {
            let [a, b] = curves(seed);
            let (found, expected) = (frechet_closed(&a, &b), by_all_beginnings(&a, &b));
            assert!((found - expected).abs() < 1e-12, "seed {seed}: {found} for {expected}");
        }
    }

    #[test]
    fn it_does_not_depend_on_where_either_curve_begins() {
        for seed in 0..40 {
            let [a, b] = curves(seed);
            let found = frechet_closed(&a, &b);
            for s in 0..a.len().max(b.len()) {
                let (mut x, mut y) = (a.clone(), b.clone());
                x.rotate_left(s % a.len());
                y.rotate_left((3 * s) % b.len());
                assert_eq!(frechet_closed(&x, &y), found, "seed {seed}, beginning {s}");
                x.push(x[0]);
                assert_eq!(frechet_closed(&x, &y), found, "seed {seed}, closed");
            }
        }
    }
}
