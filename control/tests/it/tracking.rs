//! Facts that hold for any pair of curves.

use hysteron_control::tracking::{PlanarPoint, chamfer, distances, frechet, hausdorff, iou, nearest};
use proptest::prelude::*;

fn curve() -> impl Strategy<Value = Vec<PlanarPoint>> {
    prop::collection::vec((-10.0..10.0_f64, -10.0..10.0_f64).prop_map(|(x, y)| [x, y]), 3..40)
}

/// A mapping that keeps distances.
fn turned(points: &[PlanarPoint], angle: f64) -> Vec<PlanarPoint> {
    let (sin, cos) = angle.sin_cos();
    points.iter().map(|[x, y]| [3.0 + cos * x - sin * y, -2.0 + sin * x + cos * y]).collect()
}

fn apart(a: PlanarPoint, b: PlanarPoint) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Rounding of a distance of curves of this size.
const ROUNDING: f64 = 1e-12;
/// Rounding of areas of this size over areas that may be small: of a thin triangle among points at random.
const AREA: f64 = 1e-9;

proptest! {
    #[test]
    fn distances_are_symmetric_and_ordered(a in curve(), b in curve()) {
        let (farthest, mean, leash) = (hausdorff(&a, &b), chamfer(&a, &b), frechet(&a, &b));
        prop_assert_eq!(farthest, hausdorff(&b, &a));
        prop_assert!((mean - chamfer(&b, &a)).abs() <= ROUNDING);
        prop_assert_eq!(leash, frechet(&b, &a));
        prop_assert!(mean <= farthest + ROUNDING && farthest <= leash + ROUNDING);
        // A walk takes both starts and both ends.
        prop_assert!(leash >= apart(a[0], b[0]) && leash >= apart(a[a.len() - 1], b[b.len() - 1]));
    }

    #[test]
    fn equal_curves_are_not_apart(a in curve()) {
        prop_assert!(hausdorff(&a, &a) <= ROUNDING && chamfer(&a, &a) <= ROUNDING);
        prop_assert_eq!(frechet(&a, &a), 0.0);
        if let Some(iou) = iou(&a, &a) {
            prop_assert!((iou - 1.0).abs() <= AREA, "{iou}");
        }
    }

    #[test]
    fn nothing_depends_on_where_the_curves_lie(a in curve(), b in curve(), angle in -3.0..3.0_f64) {
        let (c, d) = (turned(&a, angle), turned(&b, angle));
        prop_assert!((hausdorff(&a, &b) - hausdorff(&c, &d)).abs() <= ROUNDING);
        prop_assert!((chamfer(&a, &b) - chamfer(&c, &d)).abs() <= ROUNDING);
        prop_assert!((frechet(&a, &b) - frechet(&c, &d)).abs() <= ROUNDING);
        if let (Some(before), Some(after)) = (iou(&a, &b), iou(&c, &d)) {
            prop_assert!((0.0..=1.0).contains(&before) && (before - after).abs() <= AREA, "{before} {after}");
        }
    }

    #[test]
    fn the_nearest_point_is_not_farther_than_any_other(a in curve(), p in (-10.0..10.0_f64, -10.0..10.0_f64)) {
        let p = [p.0, p.1];
        let least = apart(p, nearest(p, &a));
        for pair in a.windows(2) {
            for part in [0.0, 0.1, 0.5, 0.7, 1.0] {
                let q = [0, 1].map(|c| pair[0][c] + part * (pair[1][c] - pair[0][c]));
                prop_assert!(least <= apart(p, q) + ROUNDING);
            }
        }
        prop_assert!(distances(&[nearest(p, &a)], &a)[0] <= ROUNDING);
    }
}
