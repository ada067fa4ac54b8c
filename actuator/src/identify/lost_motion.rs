//! Lost motion between pulleys and their outputs, from both alone: play, and motion lost to friction in the
//! guides.
//!
//! Pulley k travels s_k; behind a gap of width w_k goes x_k (the operator of [`Play`]). What is moved, as the tip, is taken for a smooth
//! function of all x:
//! ```text
//! y = a + Σ b_k x_k + Σ c_kl x_k x_l + error
//! ```
//! Coefficients are linear least squares for any widths; the widths are those that leave least.

use hysteron_base::BadInput;
use nalgebra::{DMatrix, DVector};

use crate::backlash::Play;

/// Most rows that are fitted; more are thinned out.
const MAX_ROWS: usize = 1500;
/// Fewest rows.
const MIN_ROWS: usize = 200;
/// Most pulleys for which squares and products are terms.
const MAX_SQUARED: usize = 8;
/// Widest gap that is sought, as a share of a pulley's range.
const WIDEST: f64 = 0.3;
/// Widths that are tried at once.
const TRIED: usize = 12;
/// Rounds over all pulleys, each over a range that is narrower by [`NARROWER`].
const ROUNDS: usize = 4;
const NARROWER: f64 = 0.35;
/// Parts of the time, each omitted once for the standard errors (jackknife).
const PARTS: usize = 5;
/// Part of the matrix's diagonal that is added to it, against pulleys that move as one.
const RIDGE: f64 = 1e-9;

/// Lost motion of every pulley, in the unit of its travel.
#[derive(Debug, Clone, PartialEq)]
pub struct LostMotion {
    /// Widths (n).
    pub width: Vec<f64>,
    /// Their standard errors, by omitting parts of the time one by one (n).
    pub standard_error: Vec<f64>,
    /// Root mean square of what is left of the outputs, with these widths and with none.
    pub left: [f64; 2],
}

/// Travels of pulleys and what they moved, on one clock.
struct TravelData<'a> {
    travel: &'a [Vec<f64>],
    moved: &'a [Vec<f64>],
    /// Rows that are fitted.
    rows: Vec<usize>,
    ranges: Vec<f64>,
}

/// Finds the gaps between `travel` (n series) and the motion that follows it (m series), all at the same times.
///
/// # Errors
/// `BadInput` for series of different lengths, too few samples, numbers that are not finite, or a pulley that rests throughout.
pub fn lost_motion(travel: &[Vec<f64>], moved: &[Vec<f64>]) -> Result<LostMotion, BadInput> {
    let n_rows = travel.first().map_or(0, Vec::len);
    if n_rows < MIN_ROWS || travel.iter().chain(moved).any(|series| series.len() != n_rows) {
        let expected = format!("series of {MIN_ROWS} samples or more, alike in length");
        return Err(BadInput::new("lost motion", expected, n_rows.to_string()));
    }
    for (what, all) in [("travel of pulley", travel), ("output", moved)] {
        for (k, series) in all.iter().enumerate() {
            if let Some(i) = series.iter().position(|x| !x.is_finite()) {
                let place = format!("lost motion, {what} {}, sample {}", k + 1, i + 1);
                return Err(BadInput::new(place, "a finite number", series[i].to_string()));
            }
        }
    }
    let range = |series: &Vec<f64>| {
        let [least, most] = series
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b]: [f64; 2], x| [a.min(*x), b.max(*x)]);
        most - least
    };
    let ranges: Vec<f64> = travel.iter().map(range).collect();
    if let Some(k) = ranges.iter().position(|range| !(*range > 0.0 && range.is_finite())) {
        let place = format!("lost motion, pulley {}", k + 1);
        return Err(BadInput::new(place, "a pulley that moves", "one that rests throughout"));
    }
    let rows = (0..n_rows).step_by(n_rows.div_ceil(MAX_ROWS)).collect();
    let data = TravelData { travel, moved, rows, ranges };
    let width = data.widths(None);
    let without: Vec<Vec<f64>> = (0..PARTS).map(|part| data.widths(Some((part, &width)))).collect();
    let standard_error = (0..travel.len())
        .map(|k| {
            let mean = without.iter().map(|own| own[k]).sum::<f64>() / PARTS as f64;
            let squares: f64 = without.iter().map(|own| (own[k] - mean).powi(2)).sum();
            (squares * (PARTS - 1) as f64 / PARTS as f64).sqrt()
        })
        .collect();
    let left = [&width, &vec![0.0; width.len()]].map(|widths| {
        let columns = (0..widths.len()).map(|k| data.behind(k, widths[k])).collect::<Vec<_>>();
        let n = (data.rows.len() * moved.len()) as f64;
        (data.misfit(&columns, None) / n).sqrt()
    });
    Ok(LostMotion { width, standard_error, left })
}

impl TravelData<'_> {
    /// Travel behind pulley `k` with a gap of that width, at the rows that are fitted, over its range
    /// (n_rows) [-].
    fn behind(&self, k: usize, width: f64) -> Vec<f64> {
        let series = &self.travel[k];
        let mut play = Play::new(width, series[0]);
        let mut next = self.rows.iter().copied().peekable();
        let mut out = Vec::with_capacity(self.rows.len());
        for (i, s) in series.iter().enumerate() {
            let x = play.follow(*s);
            if next.next_if_eq(&i).is_some() {
                out.push((x - series[0]) / self.ranges[k]);
            }
        }
        out
    }

    /// The widths that leave least, of all rows or of those outside a part of the time; then sought near `start`.
    fn widths(&self, without: Option<(usize, &[f64])>) -> Vec<f64> {
        let n = self.travel.len();
        let (part, start) = (without.map(|(part, _)| part), without.map(|(_, start)| start));
        let mut widths = start.map_or_else(|| vec![0.0; n], <[f64]>::to_vec);
        let mut columns: Vec<Vec<f64>> = (0..n).map(|k| self.behind(k, widths[k])).collect();
        let mut span = if start.is_some() { WIDEST * NARROWER } else { WIDEST };
        for _ in 0..ROUNDS {
            for k in 0..n {
                let reach = span * self.ranges[k];
                let low = (widths[k] - 0.5 * reach).max(0.0);
                let mut best = (f64::INFINITY, widths[k], columns[k].clone());
                for j in 0..=TRIED {
                    let width = low + reach * j as f64 / TRIED as f64;
                    columns[k] = self.behind(k, width);
                    let misfit = self.misfit(&columns, part);
                    if misfit < best.0 {
                        best = (misfit, width, columns[k].clone());
                    }
                }
                (widths[k], columns[k]) = (best.1, best.2);
            }
            span *= NARROWER;
        }
        widths
    }

    /// Sum of squares that the best coefficients leave.
    fn misfit(&self, columns: &[Vec<f64>], without: Option<usize>) -> f64 {
        let n = columns.len();
        let products = if n <= MAX_SQUARED { n * (n + 1) / 2 } else { 0 };
        let terms = 1 + n + products;
        let m = self.moved.len();
        let mut matrix = DMatrix::<f64>::zeros(terms, terms);
        let mut right = DMatrix::<f64>::zeros(terms, m);
        let mut squares = 0.0;
        let mut x = DVector::<f64>::zeros(terms);
        let part = self.rows.len().div_ceil(PARTS);
        for (at, row) in self.rows.iter().enumerate() {
            if without.is_some_and(|left_out| at / part == left_out) {
                continue;
            }
            x[0] = 1.0;
            for k in 0..n {
                x[1 + k] = columns[k][at];
            }
            if products > 0 {
                let mut next = 1 + n;
                for k in 0..n {
                    for l in k..n {
                        x[next] = columns[k][at] * columns[l][at];
                        next += 1;
                    }
                }
            }
            matrix.syger(1.0, &x, &x, 1.0);
            for (j, moved) in self.moved.iter().enumerate() {
                let y = moved[*row];
                squares += y * y;
                right.column_mut(j).axpy(y, &x, 1.0);
            }
        }
        let scale = matrix.diagonal().max();
        for k in 0..terms {
            matrix[(k, k)] += RIDGE * scale;
        }
        // `syger` fills the lower triangle, which is all that Cholesky reads.
        let Some(factor) = matrix.cholesky() else { return f64::INFINITY };
        let found = factor.solve(&right);
        (squares - found.dot(&right)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use hysteron_base::rng;
    use rand::RngExt;

    use super::*;

    /// Two pulleys with gaps move a point along a curve that bends.
    fn moved(widths: [f64; 2], noise: f64) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
        let mut stream = rng(1, "lost-motion/test");
        let mut gaps = widths.map(|width| Play::new(width, 0.0));
        let (mut travel, mut moved) = (vec![Vec::new(); 2], vec![Vec::new(); 2]);
        for i in 0..4000 {
            let t = 0.01 * f64::from(i);
            let s = [2.0 * (0.9 * t).sin() + 0.7 * (0.31 * t).sin(), 1.5 * (0.53 * t + 0.4).sin()];
            let x = [0, 1].map(|k: usize| gaps[k].follow(s[k]));
            let y = [3.0 * x[0] + 0.2 * x[0] * x[1], -2.0 * x[1] + 0.1 * x[0] * x[0]];
            for k in 0..2 {
                travel[k].push(s[k]);
                moved[k].push(y[k] + noise * stream.random_range(-1.0..1.0));
            }
        }
        (travel, moved)
    }

    #[test]
    fn one_number_that_is_not_finite_is_refused() {
        for bad in [f64::NAN, f64::INFINITY] {
            let (mut travel, moved) = moved([0.1, 0.2], 0.05);
            travel[1][7] = bad;
            let error = lost_motion(&travel, &moved).unwrap_err();
            assert_eq!(error.place, "lost motion, travel of pulley 2, sample 8");
        }
        let (travel, mut moved) = moved([0.1, 0.2], 0.05);
        moved[0][3999] = f64::NAN;
        assert_eq!(lost_motion(&travel, &moved).unwrap_err().place, "lost motion, output 1, sample 4000");
    }

    #[test]
    fn widths_come_back_under_noise_and_none_is_found_where_there_is_none() {
        for widths in [[0.0, 0.0], [0.1, 0.2], [0.3, 0.05]] {
            let (travel, moved) = moved(widths, 0.05);
            let found = lost_motion(&travel, &moved).unwrap();
            for (k, width) in widths.into_iter().enumerate() {
                // Noise of 0.03 along 2 to 3 per unit of travel, over thousands of samples: a grid of 0.3 % of the range is coarser.
                assert!((found.width[k] - width).abs() < 0.02, "{widths:?} {found:?}");
                assert!(found.standard_error[k] < 0.02, "{found:?}");
            }
            let noise = 0.05 / 3.0_f64.sqrt();
            assert!((found.left[0] / noise - 1.0).abs() < 0.1, "{found:?}");
            assert!(widths == [0.0; 2] || found.left[1] > 1.1 * found.left[0], "{found:?}");
        }
    }

    #[test]
    fn a_pulley_that_rests_and_a_short_recording_are_refused() {
        let (mut travel, moved) = moved([0.1; 2], 0.0);
        travel[1].fill(0.3);
        let refused = lost_motion(&travel, &moved).unwrap_err().to_string();
        assert!(refused.contains("pulley 2: expected a pulley that moves"), "{refused}");
        let short: Vec<Vec<f64>> = moved.iter().map(|series| series[..50].to_vec()).collect();
        let refused = lost_motion(&short, &short).unwrap_err();
        assert!(refused.expected.contains("samples or more, alike in length"), "{refused}");
    }
}
