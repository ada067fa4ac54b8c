//! Fewer points for the same line.

/// The points that keep the line within `tolerance` of all of them (Douglas and Peucker, 1973).
pub fn simplified(points: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let mut selected = vec![false; points.len()];
    selected[0] = true;
    selected[points.len() - 1] = true;
    let mut spans = vec![(0, points.len() - 1)];
    while let Some((first, last)) = spans.pop() {
        let (mut farthest, mut at) = (tolerance, None);
        for i in first + 1..last {
            let distance = distance(points[i], points[first], points[last]);
            if distance > farthest {
                (farthest, at) = (distance, Some(i));
            }
        }
        if let Some(i) = at {
            selected[i] = true;
            spans.push((first, i));
            spans.push((i, last));
        }
    }
    points.iter().zip(selected).filter(|(_, selected)| *selected).map(|(point, _)| *point).collect()
}

/// Distance of `p` from the segment `a` to `b`.
fn distance(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (along, offset) = ((b.0 - a.0, b.1 - a.1), (p.0 - a.0, p.1 - a.1));
    let squared = along.0 * along.0 + along.1 * along.1;
    let t = if squared > 0.0 {
        ((along.0 * offset.0 + along.1 * offset.1) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (offset.0 - t * along.0).hypot(offset.1 - t * along.1)
}

/// Parts of a line whose corners are blunt: where it turns back on itself, the bitmap backend would join its
/// edges far outside.
pub fn between_sharp_turns(line: &[(f64, f64)]) -> impl Iterator<Item = &[(f64, f64)]> {
    let is_sharp = |k: usize| {
        let (before, here, after) = (line[k - 1], line[k], line[k + 1]);
        (here.0 - before.0) * (after.0 - here.0) + (here.1 - before.1) * (after.1 - here.1) <= 0.0
    };
    let corners = (1..line.len().saturating_sub(1)).filter(move |&k| is_sharp(k));
    let ends = corners.clone().chain(line.len().checked_sub(1));
    [0].into_iter().chain(corners).zip(ends).map(|(start, end)| &line[start..=end])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_keeps_its_ends() {
        let line: Vec<(f64, f64)> = (0..100).map(|i| (f64::from(i), 2.0 * f64::from(i))).collect();
        assert_eq!(simplified(&line, 1e-9), [line[0], line[99]]);
    }

    #[test]
    fn every_point_stays_within_the_tolerance() {
        let curve: Vec<(f64, f64)> =
            (0..1000).map(|i| (f64::from(i) / 1000.0, (f64::from(i) / 50.0).sin())).collect();
        let fewer = simplified(&curve, 1e-3);
        assert!(fewer.len() < 300, "{} points", fewer.len());
        for point in curve {
            let nearest = fewer.windows(2).map(|w| distance(point, w[0], w[1])).fold(f64::MAX, f64::min);
            assert!(nearest <= 1e-3, "{nearest}");
        }
    }

    #[test]
    fn a_line_is_cut_where_it_turns_back() {
        let line = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.5), (1.0, 0.5), (0.0, 0.5)];
        let parts: Vec<&[(f64, f64)]> = between_sharp_turns(&line).collect();
        assert_eq!(parts, [&line[..3], &line[2..]]);
        assert_eq!(between_sharp_turns(&[]).count(), 0);
    }
}
