//! Static regressions: a ridge on cubic monomials, and a ridge on Gaussian kernels.
//!
//! Features are brought to mean zero and variance one. Every number that is not fitted is chosen from a grid, by the
//! error on quarters of the training patterns that are left out in turn.

use anyhow::{Context, Result};
use nalgebra::DMatrix;

use crate::tendon::numbers::distance;

type Tips = Vec<[f64; 3]>;

/// Ridge on all monomials up to the third degree.
///
/// # Errors
/// Normal equations that are singular.
pub fn cubic(features: &[Vec<f64>], tips: &[[f64; 3]], groups: &[usize], new: &[Vec<f64>]) -> Result<Tips> {
    let scale = Scale::of(features);
    let [known, new] =
        [features, new].map(|rows| rows.iter().map(|row| monomials(&scale.apply(row))).collect::<Vec<_>>());
    let grid = [1e-2, 1e-1, 1.0, 10.0, 1e2, 1e3, 1e4, 1e5].map(|ridge| [ridge, 0.0]);
    chosen(&known, tips, groups, &new, &grid, |a, tips, b, [ridge, _]| {
        let x = matrix(a);
        let normal = x.transpose() * &x + DMatrix::identity(x.ncols(), x.ncols()) * ridge;
        let weights = normal.cholesky().context("singular")?.solve(&(x.transpose() * targets(tips)));
        Ok(matrix(b) * weights)
    })
}

/// Ridge on Gaussian kernels.
///
/// # Errors
/// A kernel matrix that is singular.
pub fn kernel(features: &[Vec<f64>], tips: &[[f64; 3]], groups: &[usize], new: &[Vec<f64>]) -> Result<Tips> {
    let scale = Scale::of(features);
    let [known, new] =
        [features, new].map(|rows| rows.iter().map(|row| scale.apply(row)).collect::<Vec<_>>());
    let mut grid = Vec::new();
    for ridge in [0.01, 0.1, 1.0] {
        grid.extend([0.03, 0.1, 0.3, 1.0].map(|width| [ridge, width]));
    }
    chosen(&known, tips, groups, &new, &grid, |a, tips, b, [ridge, width]| {
        let gram = |a: &[Vec<f64>], b: &[Vec<f64>]| {
            DMatrix::from_fn(a.len(), b.len(), |i, j| {
                let squares: f64 = a[i].iter().zip(&b[j]).map(|(x, y)| (x - y).powi(2)).sum();
                (-width * squares / a[i].len() as f64).exp()
            })
        };
        let own = gram(a, a) + DMatrix::identity(a.len(), a.len()) * ridge;
        Ok(gram(b, a) * own.cholesky().context("singular")?.solve(&targets(tips)))
    })
}

/// Parts of the groups that are left out in turn.
const PARTS: usize = 4;

/// Predictions with the entry of the grid that is best on groups left out.
fn chosen(
    known: &[Vec<f64>],
    tips: &[[f64; 3]],
    groups: &[usize],
    new: &[Vec<f64>],
    grid: &[[f64; 2]],
    predict: impl Fn(&[Vec<f64>], &[[f64; 3]], &[Vec<f64>], [f64; 2]) -> Result<DMatrix<f64>>,
) -> Result<Tips> {
    let split =
        |part: usize, out: bool| (0..known.len()).filter(move |&i| (groups[i] % PARTS == part) == out);
    let rows = |part: usize, out: bool| split(part, out).map(|i| known[i].clone()).collect::<Vec<_>>();
    let ends = |part: usize, out: bool| split(part, out).map(|i| tips[i]).collect::<Tips>();
    // The mean is no part of a ridge.
    let centred = |rows: &[Vec<f64>], tips: &[[f64; 3]], new: &[Vec<f64>], with: [f64; 2]| -> Result<Tips> {
        let mean: [f64; 3] =
            std::array::from_fn(|c| tips.iter().map(|tip| tip[c]).sum::<f64>() / tips.len() as f64);
        let left: Tips = tips.iter().map(|tip| std::array::from_fn(|c| tip[c] - mean[c])).collect();
        let found = predict(rows, &left, new, with)?;
        Ok((0..new.len()).map(|i| std::array::from_fn(|c| mean[c] + found[(i, c)])).collect())
    };
    let mut errors = vec![0.0; grid.len()];
    for part in 0..PARTS {
        let ([inside, outside], [known_ends, ends]) =
            ([rows(part, false), rows(part, true)], [ends(part, false), ends(part, true)]);
        for (error, &with) in errors.iter_mut().zip(grid) {
            let found = centred(&inside, &known_ends, &outside, with)?;
            *error += found.iter().zip(&ends).map(|(a, b)| distance(*a, *b).powi(2)).sum::<f64>();
        }
    }
    let best = errors.iter().zip(grid).min_by(|a, b| a.0.total_cmp(b.0)).context("an empty grid")?;
    centred(known, tips, new, *best.1)
}

struct Scale {
    mean: Vec<f64>,
    deviation: Vec<f64>,
}

impl Scale {
    fn of(rows: &[Vec<f64>]) -> Self {
        let n = rows.len() as f64;
        let columns = 0..rows[0].len();
        let mean: Vec<f64> =
            columns.clone().map(|k| rows.iter().map(|row| row[k]).sum::<f64>() / n).collect();
        let deviation = columns
            .map(|k| (rows.iter().map(|row| (row[k] - mean[k]).powi(2)).sum::<f64>() / n).sqrt().max(1e-9))
            .collect();
        Self { mean, deviation }
    }

    fn apply(&self, row: &[f64]) -> Vec<f64> {
        (0..row.len()).map(|k| (row[k] - self.mean[k]) / self.deviation[k]).collect()
    }
}

/// One, and all products of up to three entries: squares do not have mean zero, so the constant is needed.
fn monomials(row: &[f64]) -> Vec<f64> {
    let n = row.len();
    let mut products = [&[1.0], row].concat();
    for i in 0..n {
        for j in i..n {
            products.push(row[i] * row[j]);
            products.extend((j..n).map(|k| row[i] * row[j] * row[k]));
        }
    }
    products
}

fn matrix(rows: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}

fn targets(tips: &[[f64; 3]]) -> DMatrix<f64> {
    DMatrix::from_fn(tips.len(), 3, |i, c| tips[i][c])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;
    use rand::RngExt;

    /// Points of a function of three numbers, in eight groups.
    fn points(n: usize) -> (Vec<Vec<f64>>, Tips, Vec<usize>) {
        let mut rng = hysteron_base::rng(1, "regression");
        let rows: Vec<Vec<f64>> =
            (0..n).map(|_| (0..3).map(|_| rng.random_range(-1.0..1.0)).collect()).collect();
        let tip =
            |x: &Vec<f64>| [x[0] * x[1] * x[2] - x[2].powi(3), 4.0 + x[0] - 2.0 * x[1] * x[1], 3.0 * x[2]];
        let tips = rows.iter().map(tip).collect();
        (rows, tips, (0..n).map(|i| i % 8).collect())
    }

    fn largest_error(found: &[[f64; 3]], tips: &[[f64; 3]]) -> f64 {
        found.iter().zip(tips).map(|(a, b)| distance(*a, *b)).fold(0.0, f64::max)
    }

    #[test]
    fn cubic_regression_finds_a_cubic() {
        let (rows, tips, groups) = points(400);
        let found = cubic(&rows[..300], &tips[..300], &groups[..300], &rows[300..]).unwrap();
        // x³ less its part along x varies by 1/7 - 3/25 = 0.023: the smallest ridge of the grid, 1e-2, takes 1e-2 /
        // (300 x 0.023) = 1.5e-3 of such a weight, and some of them add up in the corners. The function has size 4.
        assert!(largest_error(&found, &tips[300..]) < 1e-2);
    }

    #[test]
    fn kernel_regression_follows_a_smooth_function() {
        let (rows, tips, groups) = points(400);
        let found = kernel(&rows[..300], &tips[..300], &groups[..300], &rows[300..]).unwrap();
        // A tenth of the range, in the corners; the mean alone would miss by whole units.
        assert!(largest_error(&found, &tips[300..]) < 0.5);
    }
}
