//! Where the tip has been in training: the convex hull of its x and y, and the range of its z.

use super::{Axes, TipPosition};
use serde::{Deserialize, Serialize};

/// A convex region of the tip's x and y; of a tip in space, a prism over it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TipWorkspace {
    /// Corners of the hull, counter-clockwise [m].
    pub corners_m: Vec<[f64; 2]>,
    /// Smallest and largest z; none in the plane [m].
    #[serde(default)]
    pub height_m: Option<[f64; 2]>,
}

/// Twice the area of a triangle; positive where it runs counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

impl TipWorkspace {
    /// That of finite points.
    ///
    /// # Reference
    /// Andrew (1979), Another efficient algorithm for convex hulls in two dimensions.
    pub fn new(axes: Axes, tips: Vec<TipPosition>) -> Self {
        let range = |[min, max]: [f64; 2], tip: &TipPosition| [min.min(tip[2]), max.max(tip[2])];
        let height = || tips.iter().fold([f64::INFINITY, f64::NEG_INFINITY], range);
        let height_m = (axes == Axes::Spatial).then(height);
        let mut points: Vec<[f64; 2]> = tips.iter().map(|tip| [tip[0], tip[1]]).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        points.dedup();
        let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
            let mut chain: Vec<[f64; 2]> = Vec::new();
            for point in points {
                while chain.len() >= 2 && turn(chain[chain.len() - 2], chain[chain.len() - 1], point) <= 0.0 {
                    chain.pop();
                }
                chain.push(point);
            }
            // The last point begins the other half.
            chain.pop();
            chain
        };
        let mut corners_m = half(&mut points.iter().copied());
        corners_m.extend(half(&mut points.iter().rev().copied()));
        Self { corners_m, height_m }
    }

    /// Corners of the hull, counter-clockwise [m].
    pub fn corners(&self) -> &[[f64; 2]] {
        &self.corners_m
    }

    /// Its greater extent along x or y [m].
    pub fn width(&self) -> f64 {
        let span = |c: usize| {
            let ends = (f64::INFINITY, f64::NEG_INFINITY);
            let (min, max) = self
                .corners_m
                .iter()
                .fold(ends, |(min, max), corner| (min.min(corner[c]), max.max(corner[c])));
            max - min
        };
        span(0).max(span(1))
    }

    /// Its area [m²].
    pub fn area(&self) -> f64 {
        let Some(&first) = self.corners_m.first() else { return 0.0 };
        self.corners_m.windows(2).map(|pair| 0.5 * turn(first, pair[0], pair[1])).sum()
    }

    /// Whether a point lies further than `margin` outside [m]; a hull without area has no inside, and neither has NaN.
    pub fn is_outside(&self, tip: TipPosition, margin: f64) -> bool {
        let point = [tip[0], tip[1]];
        let is_level = |[min, max]: [f64; 2]| (min - margin..=max + margin).contains(&tip[2]);
        if !self.height_m.is_none_or(is_level) {
            return true;
        }
        let n = self.corners_m.len();
        let is_inside_of = |k: usize| {
            let (a, b) = (self.corners_m[k], self.corners_m[(k + 1) % n]);
            turn(a, b, point) >= -margin * (b[0] - a[0]).hypot(b[1] - a[1])
        };
        n < 3 || !(0..n).all(is_inside_of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_of_a_square_is_its_corners() {
        let grid = (0..25).map(|k| [f64::from(k % 5), f64::from(k / 5), f64::from(k)]).collect::<Vec<_>>();
        let spatial = TipWorkspace::new(Axes::Spatial, grid.clone());
        let workspace = TipWorkspace::new(Axes::Planar, grid);
        assert_eq!(workspace.width(), 4.0);
        assert_eq!(workspace.area(), 16.0);
        assert_eq!(workspace.corners_m, [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]);
        for (point, is_outside) in
            [([2.0, 2.0], false), ([4.4, 2.0], false), ([4.6, 2.0], true), ([f64::NAN, 2.0], true)]
        {
            let [x, y] = point;
            assert_eq!(workspace.is_outside([x, y, 1e9], 0.5), is_outside, "{point:?}");
            assert_eq!(spatial.is_outside([x, y, 24.4], 0.5), is_outside, "{point:?}");
            assert!(spatial.is_outside([x, y, 24.6], 0.5) && spatial.is_outside([x, y, -0.6], 0.5));
        }
    }

    #[test]
    fn a_line_has_no_inside() {
        let workspace = TipWorkspace::new(Axes::Planar, vec![[0.0; 3], [1.0; 3], [2.0; 3]]);
        assert!(workspace.is_outside([1.0; 3], 0.1));
    }
}
