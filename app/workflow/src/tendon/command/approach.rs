//! From rest to where a path begins, and from where it ends back to rest: outside the path's own time.

use super::answer::Answer;

/// Time in which the robot comes to rest where its path begins [s]: servos and tracker are a tenth of a second late, and a viscous body
/// has crept most of its way.
const SETTLED_S: f64 = 0.5;
/// Strokes below this are rest [m]: what a rig's servos cannot resolve.
const REST: f64 = 1e-6;

impl Answer {
    /// The same, its strokes from none to none: along half a cosine whose fastest change is `rate` [m/s], with a rest where the
    /// path begins. Samples are `step` apart [s].
    pub(super) fn with_approach(mut self, rate: f64, step: f64) -> Self {
        let at =
            |row: usize, strokes: &[Vec<f64>]| strokes.iter().map(|stroke| stroke[row]).collect::<Vec<_>>();
        let n = self.limited.len();
        let (first, last) = (at(0, &self.strokes), at(n - 1, &self.strokes));
        let [rise, fall] = [&first, &last].map(|strokes| n_samples(strokes, rate, step));
        let rest = if rise > 0 { (SETTLED_S / step).round() as usize } else { 0 };
        let approach = rise + rest;
        for (k, stroke) in self.strokes.iter_mut().enumerate() {
            let up = (0..rise).map(|i| part(i, rise) * first[k]).chain(std::iter::repeat_n(first[k], rest));
            let down = (1..=fall).map(|i| part(fall - i, fall) * last[k]);
            *stroke = up.chain(stroke.iter().copied()).chain(down).collect();
        }
        for flags in [&mut self.limited, &mut self.extrapolating] {
            *flags = std::iter::repeat_n(0.0, approach)
                .chain(flags.iter().copied())
                .chain(std::iter::repeat_n(0.0, fall))
                .collect();
        }
        self.approach = approach;
        self
    }
}

/// Samples from rest to `strokes` [m]; none where these are rest.
fn n_samples(strokes: &[f64], rate: f64, step: f64) -> usize {
    let largest = strokes.iter().fold(0.0f64, |largest, stroke| largest.max(stroke.abs()));
    if largest == 0.0 {
        return 0;
    }
    // Half a cosine is steepest in its middle, by π/2 of its mean.
    let duration = std::f64::consts::FRAC_PI_2 * largest.max(REST) / rate;
    (duration / step).ceil().max(1.0) as usize
}

/// Part of the way after `i` of `n` samples.
fn part(i: usize, n: usize) -> f64 {
    0.5 - 0.5 * (std::f64::consts::PI * i as f64 / n as f64).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(strokes: Vec<Vec<f64>>) -> Answer {
        let n = strokes[0].len();
        Answer {
            approach: 0,
            strokes,
            twin: None,
            limited: vec![1.0; n],
            extrapolating: vec![0.0; n],
            tip_band: Vec::new(),
        }
    }

    #[test]
    fn strokes_begin_and_end_at_rest_within_the_speed_limit_and_the_path_is_untouched() {
        let (rate, step) = (12e-3, 0.01);
        let path: Vec<Vec<f64>> = vec![vec![6e-3, 6.1e-3, 6.2e-3], vec![-3e-3, -3e-3, 1e-3]];
        let found = answer(path.clone()).with_approach(rate, step);
        // 6 mm at 12 mm/s and π/2 of that are 0.785 s, and half a second of rest.
        assert_eq!(found.approach, 79 + 50);
        for (stroke, path) in found.strokes.iter().zip(&path) {
            let n = stroke.len();
            assert_eq!(stroke[found.approach..found.approach + 3], path[..]);
            assert_eq!((stroke[0], stroke[n - 1]), (0.0, 0.0));
            let fastest = stroke.windows(2).map(|pair| (pair[1] - pair[0]).abs() / step);
            let outside = fastest.enumerate().filter(|(i, _)| *i < found.approach || *i > found.approach + 1);
            assert!(outside.map(|(_, rate)| rate).fold(0.0, f64::max) <= rate * (1.0 + 1e-12));
        }
        assert_eq!(found.limited.len(), found.strokes[0].len());
        assert_eq!(found.limited.iter().sum::<f64>(), 3.0);
    }

    #[test]
    fn a_path_from_rest_to_rest_needs_neither() {
        let path = vec![vec![0.0, 1e-3, 0.0]];
        let found = answer(path.clone()).with_approach(12e-3, 0.01);
        assert_eq!((found.approach, found.strokes), (0, path));
    }
}
