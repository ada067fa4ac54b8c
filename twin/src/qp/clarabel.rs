//! Dense QPs through clarabel. The only module that names it.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, SupportedConeT, ZeroConeT,
};

use super::QpStatus;

/// min ½ xᵀH x + gᵀx subject to bounds on x and on the rows A x; equal bounds are equalities, infinite
/// ones are left out. Everything dimensionless, of order one.
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

/// Solves with clarabel; the point returned means nothing unless the status is `Solved`.
pub fn solve_rows(qp: &RowQp) -> (Vec<f64>, QpStatus) {
    let n = qp.linear.len();
    // Clarabel tests costs below one absolutely: bring the linear term to order one.
    let size = qp.linear.iter().fold(0.0f64, |max, g| max.max(g.abs())).max(f64::MIN_POSITIVE);
    let unit = |j: usize| (0..n).map(|k| f64::from(u8::from(k == j))).collect::<Vec<f64>>();
    let variables = (0..n).map(unit).zip(&qp.bounds);
    let all: Vec<(Vec<f64>, [f64; 2])> = variables
        .map(|(row, b)| (row, *b))
        .chain(qp.rows.iter().cloned().zip(qp.row_bounds.iter().copied()))
        .collect();
    let mut rows = Vec::new();
    let mut right = Vec::new();
    for (row, [lo, hi]) in all.iter().filter(|(_, [lo, hi])| lo == hi) {
        debug_assert!(lo == hi);
        rows.push(row.clone());
        right.push(lo / size);
    }
    let n_equalities = rows.len();
    for (row, [lo, hi]) in all.iter().filter(|(_, [lo, hi])| lo != hi) {
        if hi.is_finite() {
            rows.push(row.clone());
            right.push(hi / size);
        }
        if lo.is_finite() {
            rows.push(row.iter().map(|a| -a).collect());
            right.push(-lo / size);
        }
    }
    let cones = [ZeroConeT(n_equalities), NonnegativeConeT(rows.len() - n_equalities)];
    let linear: Vec<f64> = qp.linear.iter().map(|g| g / size).collect();
    match run(&upper_triangle(&qp.hessian, n), &linear, &columns(&rows, n), &right, &cones) {
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
) -> Option<(Vec<f64>, QpStatus)> {
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-11,
        tol_gap_rel: 1e-11,
        tol_feas: 1e-11,
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

/// Dense rows as a column-compressed matrix, zeros left out.
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
