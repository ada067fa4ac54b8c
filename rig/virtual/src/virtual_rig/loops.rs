//! How wide the loop is that a tip describes while one tendon is pulled and released.

/// The loop of one pull and release.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopWidth {
    /// Largest distance between the tip on the way there and on the way back at the same stroke [m].
    pub width: f64,
    /// Mean of that distance over the strokes [m].
    pub mean_width: f64,
    /// Largest distance of the tip from where it was at the smallest of these strokes [m].
    pub excursion: f64,
}

impl LoopWidth {
    /// Width over excursion [-].
    pub fn relative(&self) -> f64 {
        self.width / self.excursion
    }
}

/// Points of each branch that are compared.
const N_STROKES: usize = 100;

/// The loop of tip positions `tips` (n × 3) [m] over the strokes `strokes` (n) [m] of one tendon that is pulled and
/// then released; `None` where either branch has less than three points.
///
/// The pull ends at the largest stroke. On each branch the tip is interpolated linearly between samples whose strokes
/// advance; both branches are compared at equal strokes between the largest of their beginnings and the smallest of
/// their ends.
pub fn loop_width(strokes: &[f64], tips: &[[f64; 3]]) -> Option<LoopWidth> {
    let top = (0..strokes.len().min(tips.len())).max_by(|&i, &j| strokes[i].total_cmp(&strokes[j]))?;
    let branch = |order: &mut dyn Iterator<Item = usize>| {
        let mut points: Vec<(f64, [f64; 3])> = Vec::new();
        for i in order {
            // Towards the top: the strokes must grow.
            if points.last().is_none_or(|(stroke, _)| strokes[i] > *stroke) {
                points.push((strokes[i], tips[i]));
            }
        }
        points
    };
    let pull = branch(&mut (0..=top));
    let release = branch(&mut (top..strokes.len().min(tips.len())).rev());
    if pull.len() < 3 || release.len() < 3 {
        return None;
    }
    let low = pull[0].0.max(release[0].0);
    let high = pull[pull.len() - 1].0.min(release[release.len() - 1].0);
    if low >= high {
        return None;
    }
    let distance = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
    let start = at(&pull, low);
    let (mut width, mut sum, mut excursion) = (0.0f64, 0.0, 0.0f64);
    for i in 0..=N_STROKES {
        let stroke = low + (high - low) * i as f64 / N_STROKES as f64;
        let (there, back) = (at(&pull, stroke), at(&release, stroke));
        width = width.max(distance(there, back));
        sum += distance(there, back);
        excursion = excursion.max(distance(there, start)).max(distance(back, start));
    }
    (excursion > 0.0).then_some(LoopWidth { width, mean_width: sum / (N_STROKES + 1) as f64, excursion })
}

/// Tip at a stroke within the branch.
fn at(branch: &[(f64, [f64; 3])], stroke: f64) -> [f64; 3] {
    let after = branch.partition_point(|(s, _)| *s < stroke).clamp(1, branch.len() - 1);
    let ((s0, a), (s1, b)) = (branch[after - 1], branch[after]);
    let share = ((stroke - s0) / (s1 - s0)).clamp(0.0, 1.0);
    std::array::from_fn(|i| a[i] + share * (b[i] - a[i]))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may stop where it stands
mod tests {
    use super::*;

    #[test]
    fn width_is_that_of_a_known_loop() {
        // Play of 0.2 on a travel of 2: the way back is 0.2 ahead.
        let mut strokes = Vec::new();
        let mut tips = Vec::new();
        for i in 0..=100 {
            strokes.push(f64::from(i) * 0.02);
            tips.push([(f64::from(i) * 0.02 - 0.2).max(0.0), 0.0, 1.0]);
        }
        for i in (0..100).rev() {
            strokes.push(f64::from(i) * 0.02);
            tips.push([(f64::from(i) * 0.02).min(1.8), 0.0, 1.0]);
        }
        let found = loop_width(&strokes, &tips).unwrap();
        assert!((found.width - 0.2).abs() < 1e-12, "{found:?}");
        assert!((found.relative() - 0.2 / 1.8).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn one_way_is_no_loop() {
        assert_eq!(loop_width(&[0.0, 1.0, 2.0], &[[0.0; 3]; 3]), None);
        assert_eq!(loop_width(&[], &[]), None);
    }
}
