//! Baselines without a network that know the delay of the tip behind its strokes: a delay is the simplest
//! memory. Delays, widths and ridges are chosen on the validation trajectories of a network.

use anyhow::{Context, Result};
use hysteron_control::inverse::{
    Axes, Dataset, Demonstration, PathPoint, StaticRegression, TipPosition, ahead,
};
use nalgebra::DMatrix;

use crate::tendon::numbers::rms;

/// Delays to choose from go up to this [s], in steps of [`DELAY_STEP`] or of a sample, whichever is longer [s].
const LARGEST_DELAY: f64 = 0.5;
const DELAY_STEP: f64 = 0.05;
/// Times between the two tips of the kernel to choose from [s].
const APART: [f64; 2] = [0.1, 0.25];
/// Widths of the Gaussian, over the mean of squared differences, and ridges.
const WIDTHS: [f64; 3] = [0.1, 0.3, 1.0];
const RIDGES: [f64; 3] = [0.01, 0.1, 1.0];
/// Rows that the kernel is chosen with, and those that it is fitted to.
const CHOOSE_ROWS: usize = 600;
const FIT_ROWS: usize = 1800;

/// A baseline, its error on the test [mm], and the delay that it chose [s].
pub struct InverseBaseline {
    pub error: f64,
    pub delay_s: f64,
}

fn delays(step: f64) -> impl Iterator<Item = f64> {
    let by = DELAY_STEP.max(step);
    (0..=(LARGEST_DELAY / by) as usize).map(move |k| k as f64 * by)
}

fn points(tips: &[TipPosition]) -> Vec<PathPoint> {
    tips.iter().map(|&position| PathPoint { position, rate: [0.0; 3] }).collect()
}

/// All baselines: the regression without delay and with the best, and the kernel.
///
/// # Errors
/// Tips that do not move.
pub fn all(known: &Dataset, test: &[&Demonstration]) -> Result<[InverseBaseline; 3]> {
    let [plain, delayed] = regressions(known, test)?;
    Ok([plain, delayed, kernel(known, test)?])
}

/// The cubic regression of the strokes on the tip some time later: without delay, and with the best.
///
/// # Errors
/// Tips that do not move.
fn regressions(known: &Dataset, test: &[&Demonstration]) -> Result<[InverseBaseline; 2]> {
    let fitted = |delay: f64| -> Result<StaticRegression> {
        let paths: Vec<Vec<PathPoint>> =
            known.training.iter().map(|one| ahead(&points(&one.tip), delay / known.step)).collect();
        Ok(StaticRegression::new(Axes::Spatial, &known.training, &paths)?)
    };
    let error = |delay: f64, all: &[&Demonstration]| -> Result<f64> {
        let regression = fitted(delay)?;
        let mut off = Vec::new();
        for one in all {
            let mut strokes = vec![0.0; one.n_tendons];
            for (i, point) in ahead(&points(&one.tip), delay / known.step).iter().enumerate() {
                regression.strokes_into(point.position, &mut strokes);
                off.extend(strokes.iter().zip(one.strokes_at(i)).map(|(found, made)| 1e3 * (found - made)));
            }
        }
        Ok(rms(off))
    };
    let validation: Vec<&Demonstration> = known.validation.iter().collect();
    let mut best = (f64::INFINITY, 0.0);
    for delay in delays(known.step) {
        let found = error(delay, &validation)?;
        if found < best.0 {
            best = (found, delay);
        }
    }
    let baseline = |delay_s: f64| {
        Ok::<InverseBaseline, anyhow::Error>(InverseBaseline { error: error(delay_s, test)?, delay_s })
    };
    Ok([baseline(0.0)?, baseline(best.1)?])
}

/// Parameters of the kernel.
#[derive(Clone, Copy)]
struct KernelSetting {
    delay: f64,
    apart: f64,
    width: f64,
    ridge: f64,
}

/// Ridge regression with a Gaussian kernel on two tips: one some time later, and one before that.
///
/// # Errors
/// A kernel matrix that has no factor.
fn kernel(known: &Dataset, test: &[&Demonstration]) -> Result<InverseBaseline> {
    let training: Vec<&Demonstration> = known.training.iter().collect();
    let validation: Vec<&Demonstration> = known.validation.iter().collect();
    let error = |setting: KernelSetting, rows: usize, all: &[&Demonstration]| -> Result<f64> {
        let [fitted, new] = [&training[..], all].map(|all| Rows::new(all, known.step, setting));
        let every = fitted.features.len().div_ceil(rows).max(1);
        let fitted = fitted.every(every);
        // Validation needs no more samples than training.
        let new = new.every(if rows == CHOOSE_ROWS { every } else { 1 });
        let found = fitted.predict(&new, setting)?;
        let off = (&found - &new.strokes).iter().map(|off| 1e3 * off).collect::<Vec<f64>>();
        Ok(rms(off))
    };
    let mut best: Option<(f64, KernelSetting)> = None;
    for delay in delays(known.step) {
        for apart in APART {
            for (width, ridge) in WIDTHS.into_iter().flat_map(|width| RIDGES.map(|ridge| (width, ridge))) {
                let setting = KernelSetting { delay, apart, width, ridge };
                let found = error(setting, CHOOSE_ROWS, &validation)?;
                if best.is_none_or(|(least, _)| found < least) {
                    best = Some((found, setting));
                }
            }
        }
    }
    let (_, setting) = best.context("no delay to choose from")?;
    Ok(InverseBaseline { error: error(setting, FIT_ROWS, test)?, delay_s: setting.delay })
}

/// Features and strokes, row by row.
struct Rows {
    features: Vec<[f64; 6]>,
    strokes: DMatrix<f64>,
}

impl Rows {
    fn new(all: &[&Demonstration], step: f64, setting: KernelSetting) -> Self {
        let mut features = Vec::new();
        let mut strokes: Vec<f64> = Vec::new();
        for one in all {
            let path = points(&one.tip);
            let later = ahead(&path, setting.delay / step);
            // A tip before the one that comes later is one that comes later by less, or has been.
            let before = |i: usize| {
                let at = i as f64 + (setting.delay - setting.apart.max(step)) / step;
                path[(at.round().max(0.0) as usize).min(path.len() - 1)].position
            };
            for (i, point) in later.iter().enumerate() {
                let ([a, b, c], [d, e, f]) = (point.position, before(i));
                features.push([a, b, c, a - d, b - e, c - f]);
            }
            strokes.extend(&one.strokes);
        }
        let n_tendons = all.first().map_or(1, |one| one.n_tendons);
        Self { strokes: DMatrix::from_row_slice(features.len(), n_tendons, &strokes), features }
    }

    fn every(&self, n: usize) -> Self {
        let picked: Vec<usize> = (0..self.features.len()).step_by(n).collect();
        Self {
            features: picked.iter().map(|&i| self.features[i]).collect(),
            strokes: self.strokes.select_rows(&picked),
        }
    }

    fn predict(&self, new: &Self, setting: KernelSetting) -> Result<DMatrix<f64>> {
        let n = self.features.len() as f64;
        let mean: [f64; 6] = std::array::from_fn(|c| self.features.iter().map(|x| x[c]).sum::<f64>() / n);
        let deviation: [f64; 6] = std::array::from_fn(|c| {
            (self.features.iter().map(|x| (x[c] - mean[c]).powi(2)).sum::<f64>() / n).sqrt().max(1e-12)
        });
        let gram = |a: &[[f64; 6]], b: &[[f64; 6]]| {
            DMatrix::from_fn(a.len(), b.len(), |i, j| {
                let squares: f64 = (0..6).map(|c| ((a[i][c] - b[j][c]) / deviation[c]).powi(2)).sum();
                (-setting.width * squares / 6.0).exp()
            })
        };
        let level = self.strokes.row_mean();
        let centred = DMatrix::from_fn(self.strokes.nrows(), self.strokes.ncols(), |i, k| {
            self.strokes[(i, k)] - level[k]
        });
        let own = gram(&self.features, &self.features)
            + DMatrix::identity(self.features.len(), self.features.len()) * setting.ridge;
        let weights = own.cholesky().context("a kernel matrix without factor")?.solve(&centred);
        let mut found = gram(&new.features, &self.features) * weights;
        found.row_iter_mut().for_each(|mut row| row += &level);
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    /// A tip that comes `delay` samples after its two strokes.
    fn late(name: &str, phase: f64, delay: f64) -> Demonstration {
        let stroke = |t: f64| [(0.05 * t + phase).sin(), (0.037 * t).cos()].map(|v| 3e-3 * v);
        let n = 500;
        let tip = (0..n).map(|i| {
            let [a, b] = stroke(f64::from(i) - delay);
            [4.0 * a + b, 3.0 * b, 20.0 * a * b]
        });
        let strokes = (0..n).flat_map(|i| stroke(f64::from(i))).collect();
        super::super::demonstrations::demonstration(name.to_owned(), 0.01, tip.collect(), 2, strokes)
    }

    #[test]
    fn baselines_find_a_delay_and_what_is_left_is_little() {
        let all = vec![late("a", 0.0, 15.0), late("b", 1.0, 15.0), late("c", 2.0, 15.0)];
        let known = Dataset::new(all, &["c".to_owned()], 1).unwrap();
        let test = late("d", 3.0, 15.0);
        let [without, with] = regressions(&known, &[&test]).unwrap();
        assert!((with.delay_s - 0.15).abs() < 1e-12, "{}", with.delay_s);
        assert!(with.error < 0.2 * without.error, "{} {}", with.error, without.error);
        let kernel = kernel(&known, &[&test]).unwrap();
        // Two tips determine a direction, so that it can do with another delay.
        assert!(kernel.error < 0.3 * without.error, "{} {}", kernel.error, without.error);
    }
}
