//! The bound-constrained QP against clarabel and against every active set there is.
#![allow(clippy::print_stdout)] // residuals, for whoever runs it with --nocapture

use hysteron_fit::qp::{Activity, BoxQp, QpSolver, QpStatus, RowQp, solve_rows};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Error of a solution's objective and conditions, relative to the problem's size: the solver accepts
/// violations of 1e-9 and adds 1e-10 to a unit diagonal.
const CERTIFICATE: f64 = 3e-9;

/// Fails unless `found` and `expected` agree within `tol`.
#[track_caller]
fn assert_close(what: &str, found: f64, expected: f64, tol: f64) {
    assert!((found - expected).abs() <= tol, "{what}: {found}, expected {expected} within {tol}");
}

#[derive(Debug, Clone)]
struct Problem {
    n: usize,
    w: Vec<f64>,
    b: Vec<f64>,
    lo: Vec<f64>,
    hi: Vec<f64>,
}

impl Problem {
    /// Random W = A Aᵀ of the given rank, compliances from 1e-5 to 1e-3 m/N and strokes of mm.
    fn random(rng: &mut ChaCha8Rng, n: usize, rank: usize) -> Self {
        let a: Vec<f64> = (0..n * rank).map(|_| rng.random_range(-1.0..1.0)).collect();
        let scale: Vec<f64> = (0..n).map(|_| 10f64.powf(rng.random_range(-2.5..-1.5))).collect();
        let mut w = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                let product: f64 = (0..rank).map(|k| a[i * rank + k] * a[j * rank + k]).sum();
                w[i * n + j] = product * scale[i] * scale[j];
            }
        }
        // Strokes in the range of W, so that a singular problem without bounds still has an answer.
        let reach: Vec<f64> = (0..n).map(|_| rng.random_range(-20.0..20.0)).collect();
        let b = (0..n).map(|i| (0..n).map(|j| w[i * n + j] * reach[j]).sum()).collect();
        let (mut lo, mut hi) = (vec![0.0; n], vec![0.0; n]);
        for j in 0..n {
            let from = rng.random_range(-15.0..5.0);
            let width = rng.random_range(0.0..30.0);
            (lo[j], hi[j]) = match rng.random_range(0..8) {
                0 => (f64::NEG_INFINITY, f64::INFINITY),
                1 => (from, f64::INFINITY),
                2 => (f64::NEG_INFINITY, from),
                3 => (from, from),
                4 => (0.0, width),
                5 => (0.0, f64::INFINITY),
                _ => (from, from + width),
            };
        }
        Self { n, w, b, lo, hi }
    }

    fn gradient(&self, x: &[f64], i: usize) -> f64 {
        (0..self.n).map(|j| self.w[i * self.n + j] * x[j]).sum::<f64>() - self.b[i]
    }

    fn objective(&self, x: &[f64]) -> f64 {
        (0..self.n).map(|i| 0.5 * x[i] * (self.gradient(x, i) - self.b[i])).sum()
    }

    /// Compliance root of a variable: makes strokes and tensions dimensionless.
    fn root(&self, j: usize) -> f64 {
        self.w[j * (self.n + 1)].sqrt()
    }

    /// Size of the dimensionless strokes, for tolerances.
    fn size(&self, x: &[f64]) -> f64 {
        (0..self.n)
            .map(|j| (self.b[j] / self.root(j)).abs().max((x[j] * self.root(j)).abs()))
            .fold(0.0, f64::max)
    }

    /// Largest violation of the optimality conditions, dimensionless and relative.
    fn violation(&self, x: &[f64]) -> f64 {
        let size = self.size(x);
        let mut largest = 0.0f64;
        for j in 0..self.n {
            let root = self.root(j);
            let outside = (self.lo[j] - x[j]).max(x[j] - self.hi[j]).max(0.0) * root;
            let g = self.gradient(x, j) / root;
            // At a bound, within what counts as outside, the gradient may have one sign.
            let near = CERTIFICATE * size / root;
            let pushes = if self.lo[j] == self.hi[j] {
                0.0
            } else if x[j] <= self.lo[j] + near {
                (-g).max(0.0)
            } else if x[j] >= self.hi[j] - near {
                g.max(0.0)
            } else {
                g.abs()
            };
            largest = largest.max(outside).max(pushes);
        }
        if size == 0.0 { largest } else { largest / size }
    }

    /// The least objective over all 3ⁿ active sets with a feasible stationary point.
    fn brute_force(&self) -> Option<f64> {
        let n = self.n;
        let mut best: Option<f64> = None;
        'sets: for code in 0..3usize.pow(n as u32) {
            let place = |j: usize| code / 3usize.pow(j as u32) % 3;
            let mut x = vec![0.0; n];
            for j in 0..n {
                x[j] = match place(j) {
                    1 => self.lo[j],
                    2 => self.hi[j],
                    _ => 0.0,
                };
                if !x[j].is_finite() {
                    continue 'sets;
                }
            }
            let free: Vec<usize> = (0..n).filter(|&j| place(j) == 0).collect();
            let matrix = nalgebra::DMatrix::from_fn(free.len(), free.len(), |i, j| {
                self.w[free[i] * n + free[j]] / (self.root(free[i]) * self.root(free[j]))
            });
            let right = nalgebra::DVector::from_fn(free.len(), |i, _| {
                -self.gradient(&x, free[i]) / self.root(free[i])
            });
            if !free.is_empty() {
                let eigen = matrix.symmetric_eigen();
                if eigen.eigenvalues.min() < 1e-9 {
                    continue;
                }
                let scaled = eigen.eigenvectors.transpose() * &right;
                let solved = &eigen.eigenvectors * scaled.component_div(&eigen.eigenvalues);
                for (i, &j) in free.iter().enumerate() {
                    x[j] = solved[i] / self.root(j);
                }
            }
            if (0..n).all(|j| x[j] >= self.lo[j] - 1e-9 && x[j] <= self.hi[j] + 1e-9) {
                let objective = self.objective(&x);
                best = Some(best.map_or(objective, |least| objective.min(least)));
            }
        }
        best
    }

    fn solve_cold(&self) -> (Vec<f64>, QpStatus, QpSolver) {
        self.solve_with(&mut BoxQp::new(self.n))
    }

    fn solve_with(&self, qp: &mut BoxQp) -> (Vec<f64>, QpStatus, QpSolver) {
        qp.set_matrix(&self.w);
        let mut x = vec![f64::NAN; self.n];
        let (status, solver) = qp.solve(&self.b, &self.lo, &self.hi, &mut x);
        (x, status, solver)
    }

    /// The same problem for clarabel, dimensionless.
    fn as_rows(&self) -> RowQp {
        let n = self.n;
        let hessian = (0..n * n).map(|k| self.w[k] / (self.root(k / n) * self.root(k % n))).collect();
        RowQp {
            hessian,
            linear: (0..n).map(|j| -self.b[j] / self.root(j)).collect(),
            bounds: (0..n).map(|j| [self.lo[j] * self.root(j), self.hi[j] * self.root(j)]).collect(),
            rows: Vec::new(),
            row_bounds: Vec::new(),
        }
    }

    fn clarabel(&self) -> (Vec<f64>, QpStatus) {
        let (x, status) = solve_rows(&self.as_rows());
        ((0..self.n).map(|j| x[j] / self.root(j)).collect(), status)
    }
}

#[test]
fn active_set_is_the_best_of_all_active_sets() {
    let mut rng = hysteron_base::rng(1, "brute force");
    let (mut n_clarabel, mut n_compared) = (0, 0);
    let mut worst = 0.0f64;
    const PROBLEMS: usize = 3000;
    for _ in 0..PROBLEMS {
        let n = rng.random_range(1..=6);
        let problem = Problem::random(&mut rng, n, n + 1);
        let (x, status, solver) = problem.solve_cold();
        assert_eq!(status, QpStatus::Solved, "{problem:?}");
        n_clarabel += usize::from(solver == QpSolver::Clarabel);
        worst = worst.max(problem.violation(&x));
        assert!(problem.violation(&x) < CERTIFICATE, "{} {problem:?}", problem.violation(&x));
        // Some random W are nearly singular; those have no trustworthy enumeration.
        if let Some(best) = problem.brute_force() {
            let size = problem.size(&x).powi(2);
            assert!(problem.objective(&x) < best + 1e-8 * size, "{problem:?}");
            assert!(problem.objective(&x) > best - 1e-7 * size, "{problem:?}");
            n_compared += 1;
        }
    }
    println!(
        "{PROBLEMS} regular problems: {n_clarabel} by clarabel, {n_compared} compared, violation {worst:.1e}"
    );
    assert!(n_compared > PROBLEMS * 9 / 10, "{n_compared}");
    assert!(n_clarabel < PROBLEMS / 100, "{n_clarabel}");
}

#[test]
fn singular_problems_are_solved() {
    let mut rng = hysteron_base::rng(1, "singular");
    let mut n_clarabel = 0;
    let mut worst = 0.0f64;
    const PROBLEMS: usize = 3000;
    for _ in 0..PROBLEMS {
        let n = rng.random_range(2..=6);
        let rank = rng.random_range(1..n);
        let problem = Problem::random(&mut rng, n, rank);
        let (x, status, solver) = problem.solve_cold();
        assert_eq!(status, QpStatus::Solved, "{problem:?}");
        n_clarabel += usize::from(solver == QpSolver::Clarabel);
        worst = worst.max(problem.violation(&x));
        assert!(problem.violation(&x) < CERTIFICATE, "{} {problem:?}", problem.violation(&x));
    }
    println!("{PROBLEMS} singular problems: {n_clarabel} by clarabel, violation {worst:.1e}");
    assert!(n_clarabel < PROBLEMS / 100, "{n_clarabel}");
}

#[test]
fn clarabel_agrees() {
    let mut rng = hysteron_base::rng(1, "clarabel");
    let mut worst = 0.0f64;
    for k in 0..500 {
        // Every fiftieth as large as the robot of the CoReAct paper with its auxiliary cables.
        let n = if k % 50 == 0 { 40 } else { rng.random_range(1..=8) };
        let problem = Problem::random(&mut rng, n, n + 2);
        let (x, ..) = problem.solve_cold();
        let (oracle, status) = problem.clarabel();
        assert_eq!(status, QpStatus::Solved, "{problem:?}");
        let size = problem.size(&x).powi(2);
        let error = (problem.objective(&x) - problem.objective(&oracle)).abs() / size;
        worst = worst.max(error);
        // Clarabel's gap of 1e-11 on a cost of at most a few hundred.
        assert!(error < 1e-8, "{error} {problem:?}");
    }
    println!("objective against clarabel: relative {worst:.1e}");
}

#[test]
fn degenerate_problems_are_solved() {
    let mut rng = hysteron_base::rng(1, "degenerate");
    let mut n_clarabel = 0;
    for _ in 0..2000 {
        let n = rng.random_range(1..=6);
        let mut problem = Problem::random(&mut rng, n, n + 1);
        match rng.random_range(0..4) {
            // Nothing is asked for: zero must be able to stay zero.
            0 => problem.b.fill(0.0),
            // The free answer lies exactly on bounds.
            1 => {
                for j in 0..n {
                    problem.lo[j] = problem.lo[j].max(-1.0).round();
                    problem.hi[j] = problem.lo[j] + 3.0;
                }
                let lo = problem.lo.clone();
                problem.b = (0..n).map(|i| problem.gradient(&lo, i) + problem.b[i]).collect();
            }
            // Two tendons that are the same.
            2 => {
                for k in 0..n {
                    problem.w[(n - 1) * n + k] = problem.w[k];
                }
                for k in 0..n {
                    problem.w[k * n + n - 1] = problem.w[k * n];
                }
                problem.b[n - 1] = problem.b[0];
            }
            // A command of almost nothing next to large bounds.
            _ => problem.b.iter_mut().for_each(|b| *b *= 1e-9),
        }
        let (x, status, solver) = problem.solve_cold();
        n_clarabel += usize::from(solver == QpSolver::Clarabel);
        assert_eq!(status, QpStatus::Solved, "{problem:?}");
        assert!(problem.violation(&x) < CERTIFICATE, "{} {problem:?}", problem.violation(&x));
    }
    println!("2000 degenerate problems: {n_clarabel} by clarabel");
}

#[test]
fn bounds_are_met_exactly() {
    let mut rng = hysteron_base::rng(1, "exact bounds");
    let mut n_at_bound = 0;
    for _ in 0..500 {
        let problem = Problem::random(&mut rng, 4, 5);
        let mut qp = BoxQp::new(4);
        let (x, ..) = problem.solve_with(&mut qp);
        for j in 0..4 {
            if qp.active_set()[j] != Activity::Free {
                let [lo, hi] = [problem.lo[j], problem.hi[j]];
                assert!(x[j] == lo || x[j] == hi, "{} in {lo}..{hi}", x[j]);
                n_at_bound += 1;
            }
        }
    }
    assert!(n_at_bound > 500, "{n_at_bound}");
}

#[test]
fn warm_start_gives_the_cold_answer() {
    let mut rng = hysteron_base::rng(1, "warm");
    let mut warm = BoxQp::new(5);
    let matrix = Problem::random(&mut rng, 5, 6);
    for _ in 0..2000 {
        let mut problem = Problem::random(&mut rng, 5, 6);
        if rng.random_range(0..10) > 0 {
            problem.w.clone_from(&matrix.w);
        }
        let (x, status, _) = problem.solve_with(&mut warm);
        let (cold, cold_status, _) = problem.solve_cold();
        assert_eq!((status, cold_status), (QpStatus::Solved, QpStatus::Solved));
        let size = problem.size(&cold).powi(2);
        let error = (problem.objective(&x) - problem.objective(&cold)).abs() / size;
        assert!(error < 1e-8, "{error} {problem:?}");
        assert!(problem.violation(&x) < CERTIFICATE, "{problem:?}");
    }
}

#[test]
fn answer_does_not_depend_on_units() {
    // Metres or millimetres, newtons or kilonewtons: powers of two, so that not even round-off differs.
    let mut rng = hysteron_base::rng(1, "units");
    for _ in 0..300 {
        let problem = Problem::random(&mut rng, 4, 5);
        let (length, force) = (1024.0, 1.0 / 4096.0);
        let scaled = Problem {
            n: 4,
            w: problem.w.iter().map(|w| w * length / force).collect(),
            b: problem.b.iter().map(|b| b * length).collect(),
            lo: problem.lo.iter().map(|x| x * force).collect(),
            hi: problem.hi.iter().map(|x| x * force).collect(),
        };
        let ((x, ..), (y, ..)) = (problem.solve_cold(), scaled.solve_cold());
        for j in 0..4 {
            let error = (y[j] / force - x[j]).abs();
            assert!(error < 1e-12 * problem.size(&x) / problem.root(j), "{error} {problem:?}");
        }
    }
}

#[test]
fn rows_and_their_bounds_are_kept() {
    // min ½|x|² - x1 - 2 x2 with x1 + x2 = 1 and x1 - x2 >= -0.2: x = (0.4, 0.6) by hand, the multiplier
    // of the inequality being positive.
    let qp = RowQp {
        hessian: vec![1.0, 0.0, 0.0, 1.0],
        linear: vec![-1.0, -2.0],
        bounds: vec![[f64::NEG_INFINITY, f64::INFINITY]; 2],
        rows: vec![vec![1.0, 1.0], vec![1.0, -1.0]],
        row_bounds: vec![[1.0, 1.0], [-0.2, f64::INFINITY]],
    };
    let (x, status) = solve_rows(&qp);
    assert_eq!(status, QpStatus::Solved);
    assert_close("x1", x[0], 0.4, 1e-9);
    assert_close("x2", x[1], 0.6, 1e-9);
}

#[test]
fn contradicting_rows_are_infeasible() {
    let qp = RowQp {
        hessian: vec![1.0],
        linear: vec![-1.0],
        bounds: vec![[0.0, 1.0]],
        rows: vec![vec![1.0]],
        row_bounds: vec![[2.0, 3.0]],
    };
    assert_eq!(solve_rows(&qp).1, QpStatus::Infeasible);
}

#[test]
fn problem_without_linear_term_is_solved() {
    let qp = RowQp {
        hessian: vec![1.0, 0.0, 0.0, 1.0],
        linear: vec![0.0; 2],
        bounds: vec![[1.0, 2.0], [-3.0, -0.5]],
        rows: Vec::new(),
        row_bounds: Vec::new(),
    };
    let (x, status) = solve_rows(&qp);
    assert_eq!(status, QpStatus::Solved);
    assert_close("x1", x[0], 1.0, 1e-9);
    assert_close("x2", x[1], -0.5, 1e-9);
}

#[test]
fn small_costs_are_solved_as_accurately_as_large_ones() {
    // Clarabel tests costs below one absolutely; a command of a nanometre must not come out as zero.
    for size in [1e-12, 1e-6, 1.0, 1e6] {
        let qp = RowQp {
            hessian: vec![2.0, 1.0, 1.0, 2.0],
            linear: vec![-3.0 * size, size],
            bounds: vec![[0.0, f64::INFINITY], [0.0, 0.5 * size]],
            rows: Vec::new(),
            row_bounds: Vec::new(),
        };
        let (x, status) = solve_rows(&qp);
        assert_eq!(status, QpStatus::Solved);
        assert_close("x1", x[0] / size, 1.5, 1e-8);
        assert_close("x2", x[1] / size, 0.0, 1e-8);
    }
}
