//! The curve alone, without time: straight lines from point to point, measured along its length.

use hysteron_base::BadInput;

/// Most points of an outline that may cross itself.
pub(super) const MAX_CROSSING_POINTS: usize = 500_000;

/// A point relative to the robot's rest [m]; z is 0 where a target is planar.
pub type OutlinePoint = [f64; 3];

/// Points nearer than this are one [m].
const SAME: f64 = 1e-12;

/// A line through at least three points, open or closed.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// Points in order [m]; the last is the first again where the line is closed.
    line: Vec<OutlinePoint>,
    /// Length from the first point to each (points) [m].
    arc: Vec<f64>,
}

impl Outline {
    /// A line through `points`; points that repeat the one before count once.
    ///
    /// # Errors
    /// `BadInput` if a coordinate is not finite, or if fewer than three different points in a row are left.
    pub fn new(mut points: Vec<OutlinePoint>, is_closed: bool) -> Result<Self, BadInput> {
        if let Some(i) = points.iter().position(|point| point.iter().any(|c| !c.is_finite())) {
            let place = format!("point {}", i + 1);
            return Err(BadInput::new(place, "finite coordinates", format!("{:?}", points[i])));
        }
        points.dedup_by(|b, a| distance(*a, *b) <= SAME);
        if is_closed && points.len() > 1 && distance(points[0], points[points.len() - 1]) <= SAME {
            points.pop();
        }
        if points.len() < 3 {
            return Err(BadInput::new("points", "at least three that differ", points.len().to_string()));
        }
        if is_closed {
            points.push(points[0]);
        }
        let mut arc = vec![0.0];
        for pair in points.windows(2) {
            arc.push(arc[arc.len() - 1] + distance(pair[0], pair[1]));
        }
        Ok(Self { line: points, arc })
    }

    /// Its points in order [m]; the last is the first again where it is closed.
    pub fn points(&self) -> &[OutlinePoint] {
        &self.line
    }

    /// True where it ends where it began.
    pub fn is_closed(&self) -> bool {
        self.line.first() == self.line.last()
    }

    /// Length of one lap [m].
    pub fn length(&self) -> f64 {
        self.arc[self.arc.len() - 1]
    }

    /// The point after this length along it [m]; its ends where that is outside.
    pub fn at(&self, length: f64) -> OutlinePoint {
        let next = self.arc.partition_point(|arc| *arc <= length).clamp(1, self.arc.len() - 1);
        let (from, to) = (self.arc[next - 1], self.arc[next]);
        let part = ((length - from) / (to - from)).clamp(0.0, 1.0);
        between(self.line[next - 1], self.line[next], part)
    }

    /// Points at equal lengths along it, ends included: as many as no two are farther apart than `spacing` [m].
    pub fn evenly(&self, spacing: f64) -> Vec<OutlinePoint> {
        let n = (self.length() / spacing).ceil().max(2.0) as usize;
        (0..=n).map(|i| self.at(self.length() * i as f64 / n as f64)).collect()
    }

    /// Where it crosses or touches itself in the plane (x, y) [m], the first such place. Lines that follow each
    /// other do not count.
    pub fn crossing(&self) -> Option<[f64; 2]> {
        let n = self.line.len() - 1;
        let plane = |i: usize| [self.line[i][0], self.line[i][1]];
        for i in 0..n {
            let a = [plane(i), plane(i + 1)];
            for j in i + 2..n {
                if i == 0 && j == n - 1 && self.is_closed() {
                    continue;
                }
                if let Some(place) = meeting(a, [plane(j), plane(j + 1)]) {
                    return Some(place);
                }
            }
        }
        None
    }

    /// The same line in another frame: every point mapped.
    pub(super) fn mapped(&self, map: impl Fn(OutlinePoint) -> OutlinePoint) -> Result<Self, BadInput> {
        Self::new(self.line.iter().map(|point| map(*point)).collect(), self.is_closed())
    }

    /// The same line, run through the other way from its first point (closed) or its last (open).
    pub(super) fn reversed(&self) -> Result<Self, BadInput> {
        Self::new(self.line.iter().rev().copied().collect(), self.is_closed())
    }
}

pub(super) fn distance(a: OutlinePoint, b: OutlinePoint) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}

pub(super) fn between(a: OutlinePoint, b: OutlinePoint, part: f64) -> OutlinePoint {
    std::array::from_fn(|c| a[c] + part * (b[c] - a[c]))
}

/// Where two line segments in the plane intersect; for collinear ones, an end that they share.
fn meeting(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> Option<[f64; 2]> {
    let apart =
        |c: usize| a[0][c].max(a[1][c]) < b[0][c].min(b[1][c]) || b[0][c].max(b[1][c]) < a[0][c].min(a[1][c]);
    if apart(0) || apart(1) {
        return None;
    }
    let side = |of: [[f64; 2]; 2], p: [f64; 2]| {
        (of[1][0] - of[0][0]) * (p[1] - of[0][1]) - (of[1][1] - of[0][1]) * (p[0] - of[0][0])
    };
    let [a0, a1, b0, b1] = [side(b, a[0]), side(b, a[1]), side(a, b[0]), side(a, b[1])];
    if a0 * a1 > 0.0 || b0 * b1 > 0.0 {
        return None;
    }
    if a0 == a1 {
        return Some(a[0]); // on one line, and not apart
    }
    let part = a0 / (a0 - a1);
    Some([0, 1].map(|c| a[0][c] + part * (a[1][c] - a[0][c])))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    fn flat(points: &[[f64; 2]], is_closed: bool) -> Outline {
        Outline::new(points.iter().map(|[x, y]| [*x, *y, 0.0]).collect(), is_closed).unwrap()
    }

    #[test]
    fn lengths_run_along_the_lines() {
        let square = flat(&[[0.0, 0.0], [2.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]], true);
        assert_eq!((square.length(), square.points().len()), (8.0, 5));
        for (length, place) in
            [(-1.0, [0.0, 0.0]), (1.0, [1.0, 0.0]), (3.0, [2.0, 1.0]), (7.5, [0.0, 0.5]), (9.0, [0.0, 0.0])]
        {
            assert_eq!(square.at(length), [place[0], place[1], 0.0], "{length}");
        }
        assert_eq!(square.evenly(1.0).len(), 9);
        assert_eq!(square.reversed().unwrap().at(1.0), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn crossings_are_found_where_they_are() {
        let bow = flat(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]], true);
        assert_eq!(bow.crossing(), Some([1.0, 1.0]));
        assert_eq!(flat(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]], true).crossing(), None);
        // A corner that touches another side.
        let touching = flat(&[[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.0, 0.0], [0.0, 2.0]], true);
        assert_eq!(touching.crossing(), Some([2.0, 0.0]));
        // Open, the last side away from the first.
        assert_eq!(flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], false).crossing(), None);
    }

    #[test]
    fn fewer_than_three_points_are_refused() {
        for (points, is_closed) in
            [(vec![], true), (vec![[1.0; 3]; 5], false), (vec![[0.0; 3], [1.0; 3], [0.0; 3]], true)]
        {
            let bad = Outline::new(points, is_closed).unwrap_err();
            assert_eq!(bad.expected, "at least three that differ");
        }
        let bad = Outline::new(vec![[0.0; 3], [f64::NAN; 3], [1.0; 3]], false).unwrap_err();
        assert_eq!(bad.place, "point 2");
    }
}
