//! How closely two closed curves cover each other; the only module that knows the crate `geo`.

use super::curve::Point;
use geo::{Area, BooleanOps, Coord, LineString, Polygon};

/// Intersection over union of the polygons that two curves enclose [-], each closed from its last point to its
/// first; `None` where neither encloses anything.
///
/// Inside is what a curve goes around an odd number of times (even-odd rule): of a curve that crosses itself, as a
/// Lissajous figure, every lobe counts once, and what it goes around twice does not.
///
/// # Reference
/// Paper 003, section V-B, "polygon IoU"; its rule for curves that cross themselves is not stated.
pub fn iou(a: &[Point], b: &[Point]) -> Option<f64> {
    let (a, b) = (polygon(a), polygon(b));
    let union = a.union(&b).unsigned_area();
    (union > 0.0).then(|| a.intersection(&b).unsigned_area() / union)
}

fn polygon(points: &[Point]) -> Polygon<f64> {
    let ring = LineString::new(points.iter().map(|[x, y]| Coord { x: *x, y: *y }).collect());
    Polygon::new(ring, vec![])
}
