//! Dense QPs through clarabel. The only module that names it.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, SupportedConeT, ZeroConeT,
};

use super::QpStatus;

/// min ½ xᵀH x + gᵀx subject to bounds on x and on the rows A x; equal bounds are equalities, infinite
/// ones are dropped. Everything dimensionless, of order one.
#[derive(Debug, Clone)]
pub struct RowQp {
    /// H, row-major n × n, symmetric positive semidefinite.
    pub hessian: Vec<f64>,
    /// g.
    pub linear: Vec<f64>,
    /// Lower and upper bound of each variable.
    pub bounds: Vec<[f64; 2]>,
    /// Rows of A.
    pub rows: Vec<Vec<f64>>,
    /// Lower and upper bound of each row.
    pub row_bounds: Vec<[f64; 2]>,
}

/// Bounds farther away than this, in units of the problem's size, are tried without first: they would
/// spoil the solver's scaling and hardly ever bind.
const FAR: f64 = 1e3;
/// Accuracy of the first attempt, and of the second, clarabel's default.
const TIGHT: f64 = 1e-11;
const DEFAULT: f64 = 1e-8;

/// Solves with clarabel; the point returned means nothing unless the status is `Solved`.
pub fn solve_rows(qp: &RowQp) -> (Vec<f64>, QpStatus) {
    let size = size(qp);
    let near = |bound: f64| if bound.abs() > FAR * size { bound.signum() * f64::INFINITY } else { bound };
    let relaxed = RowQp {
        bounds: qp.bounds.iter().map(|bounds| bounds.map(near)).collect(),
        row_bounds: qp.row_bounds.iter().map(|bounds| bounds.map(near)).collect(),
        ..qp.clone()
    };
    let (x, status) = solve_scaled(&relaxed, size, TIGHT);
    if status == QpStatus::Solved && is_within(qp, &x) {
        return (x, status);
    }
    solve_scaled(qp, size, DEFAULT)
}

/// Size that the solution can be expected to have: that of the linear term, or of the bounds where they
/// keep the solution away from zero.
fn size(qp: &RowQp) -> f64 {
    let from_linear = qp.linear.iter().fold(0.0f64, |max, g| max.max(g.abs()));
    let bounds = qp.bounds.iter().chain(&qp.row_bounds);
    let size = bounds.fold(from_linear, |max, [lo, hi]| max.max(*lo).max(-hi));
    if size > 0.0 { size } else { 1.0 }
}

/// True when `x` meets all bounds that the relaxed problem may have dropped.
fn is_within(qp: &RowQp, x: &[f64]) -> bool {
    let within = |value: f64, [lo, hi]: [f64; 2]| {
        let slack = DEFAULT * (1.0 + value.abs());
        value >= lo - slack && value <= hi + slack
    };
    let rows = qp.rows.iter().map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum());
    x.iter().zip(&qp.bounds).all(|(x, bounds)| within(*x, *bounds))
        && rows.zip(&qp.row_bounds).all(|(value, bounds)| within(value, *bounds))
}

/// Solves for x / size: clarabel tests costs below one absolutely, so the linear term must be of order
/// one.
fn solve_scaled(qp: &RowQp, size: f64, tolerance: f64) -> (Vec<f64>, QpStatus) {
    let n = qp.linear.len();
    let unit = |j: usize| (0..n).map(|k| f64::from(u8::from(k == j))).collect::<Vec<f64>>();
    let of_variables = (0..n).map(unit).zip(qp.bounds.iter().copied());
    let of_rows = qp.rows.iter().cloned().zip(qp.row_bounds.iter().copied());
    let (equal, between): (Vec<_>, Vec<_>) = of_variables.chain(of_rows).partition(|(_, [lo, hi])| lo == hi);
    let n_equalities = equal.len();
    let (mut rows, mut right): (Vec<Vec<f64>>, Vec<f64>) =
        equal.into_iter().map(|(row, [value, _])| (row, value / size)).unzip();
    for (row, [lo, hi]) in between {
        if lo.is_finite() {
            rows.push(row.iter().map(|a| -a).collect());
            right.push(-lo / size);
        }
        if hi.is_finite() {
            rows.push(row);
            right.push(hi / size);
        }
    }
    let cones = [ZeroConeT(n_equalities), NonnegativeConeT(rows.len() - n_equalities)];
    let linear: Vec<f64> = qp.linear.iter().map(|g| g / size).collect();
    match run(&upper_triangle(&qp.hessian, n), &linear, &columns(&rows, n), &right, &cones, tolerance) {
        Some((x, status)) => (x.iter().map(|value| value * size).collect(), status),
        None => (vec![0.0; n], QpStatus::Failed),
    }
}

fn run(
    hessian: &CscMatrix<f64>,
    linear: &[f64],
    rows: &CscMatrix<f64>,
    right: &[f64],
    cones: &[SupportedConeT<f64>],
    tolerance: f64,
) -> Option<(Vec<f64>, QpStatus)> {
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: tolerance,
        tol_gap_rel: tolerance,
        tol_feas: tolerance,
        ..DefaultSettings::default()
    };
    let mut solver = DefaultSolver::new(hessian, linear, rows, right, cones, settings).ok()?;
    solver.solve();
    let status = match solver.solution.status {
        SolverStatus::Solved => QpStatus::Solved,
        SolverStatus::AlmostSolved => QpStatus::AlmostSolved,
        SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => QpStatus::Infeasible,
        _ => QpStatus::Failed,
    };
    Some((solver.solution.x.clone(), status))
}

fn upper_triangle(matrix: &[f64], n: usize) -> CscMatrix<f64> {
    let (mut starts, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for j in 0..n {
        for i in 0..=j {
            indices.push(i);
            values.push(matrix[i * n + j]);
        }
        starts.push(indices.len());
    }
    CscMatrix::new(n, n, starts, indices, values)
}

/// Dense rows as a column-compressed matrix, without zeros.
fn columns(rows: &[Vec<f64>], n: usize) -> CscMatrix<f64> {
    let (mut starts, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for j in 0..n {
        for (i, row) in rows.iter().enumerate() {
            if row[j] != 0.0 {
                indices.push(i);
                values.push(row[j]);
            }
        }
        starts.push(indices.len());
    }
    CscMatrix::new(rows.len(), n, starts, indices, values)
}
