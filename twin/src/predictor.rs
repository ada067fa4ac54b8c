//! Guesses the next equilibrium from the last ones.
//!
//! An elastic body's shape is a smooth function of its strokes, whatever the path in time. Around the
//! present state it is close to quadratic, so a polynomial-kernel regression over the last states, in
//! the space of commands, predicts the next state to third order; noise in the strokes does not matter,
//! because the noisy strokes themselves are the coordinates.
//!
//! # Reference
//! Schölkopf, Smola (2002), Learning with kernels, sec. 4.3 (kernel ridge regression).

use hysteron_fem::{Isa, axpy};

/// States kept.
const CAPACITY: usize = 12;
/// Ridge relative to the kernel of the farthest state: the accuracy of a state relative to the distance
/// between states, squared.
const RIDGE: f64 = 1e-10;
/// A command farther away than this many times the spread of the states is not extrapolated to.
const REACH: f64 = 3.0;

#[derive(Debug, Clone)]
struct Entry {
    /// Command: strokes, and tensions times compliance [m].
    command: Vec<f64>,
    /// Free unknowns, then tensions.
    point: Vec<f64>,
}

/// The last equilibria.
#[derive(Debug, Clone)]
pub(crate) struct Predictor {
    isa: Isa,
    entries: Vec<Entry>,
    n_entries: usize,
    newest: usize,
}

impl Predictor {
    /// For points of `n` numbers and `n_commands` commands.
    pub fn new(isa: Isa, n: usize, n_commands: usize) -> Self {
        let blank = Entry { command: vec![0.0; n_commands], point: vec![0.0; n] };
        Self { isa, entries: vec![blank; CAPACITY], n_entries: 0, newest: 0 }
    }

    /// Forgets all states: the body now answers differently (a tendon went slack or taut).
    pub fn clear(&mut self) {
        self.n_entries = 0;
    }

    /// Adds the newest equilibrium; `write` fills in (command, point).
    pub fn push(&mut self, write: impl FnOnce(&mut [f64], &mut [f64])) {
        self.newest = if self.n_entries == 0 { 0 } else { (self.newest + 1) % CAPACITY };
        self.n_entries = (self.n_entries + 1).min(CAPACITY);
        let entry = &mut self.entries[self.newest];
        write(&mut entry.command, &mut entry.point);
    }

    /// Adds to `change` (zeroed by the caller) the predicted change of the point from the newest state
    /// to `command`; only commands where `counts` holds matter. Leaves zero where there is no history.
    pub fn predict(&self, command: &[f64], counts: impl Fn(usize) -> bool, change: &mut [f64]) {
        let n = self.n_entries.saturating_sub(1);
        if n == 0 {
            return;
        }
        let base = &self.entries[self.newest];
        let other = |i: usize| &self.entries[(self.newest + CAPACITY - 1 - i) % CAPACITY];
        let inner = |a: &[f64], b: &[f64]| -> f64 {
            (0..command.len())
                .filter(|&j| counts(j))
                .map(|j| (a[j] - base.command[j]) * (b[j] - base.command[j]))
                .sum()
        };
        let spread = (0..n).map(|i| inner(&other(i).command, &other(i).command)).fold(0.0, f64::max);
        let distance = inner(command, command);
        if spread == 0.0 || distance > REACH * REACH * spread {
            return;
        }
        let kernel = |product: f64| {
            let cosine = product / spread;
            cosine + 0.5 * cosine * cosine
        };
        let mut matrix = [[0.0; CAPACITY]; CAPACITY];
        let mut factors = [0.0; CAPACITY];
        for i in 0..n {
            for j in 0..=i {
                matrix[i][j] = kernel(inner(&other(i).command, &other(j).command));
            }
            matrix[i][i] += RIDGE;
            factors[i] = kernel(inner(&other(i).command, command));
        }
        if !solve_positive_definite(&mut matrix, &mut factors, n) {
            return;
        }
        let mut total = 0.0;
        for (i, factor) in factors.iter().enumerate().take(n) {
            axpy(self.isa, *factor, &other(i).point, change);
            total += factor;
        }
        axpy(self.isa, -total, &base.point, change);
    }
}

/// Cholesky on the lower triangle; false where the matrix is not positive definite.
fn solve_positive_definite(a: &mut [[f64; CAPACITY]; CAPACITY], x: &mut [f64; CAPACITY], n: usize) -> bool {
    for i in 0..n {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| a[i][k] * a[j][k]).sum();
            let rest = a[i][j] - known;
            if i == j && (rest <= 0.0 || rest.is_nan()) {
                return false;
            }
            a[i][j] = if i == j { rest.sqrt() } else { rest / a[j][j] };
        }
        let known: f64 = (0..i).map(|k| a[i][k] * x[k]).sum();
        x[i] = (x[i] - known) / a[i][i];
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|k| a[k][i] * x[k]).sum();
        x[i] = (x[i] - known) / a[i][i];
    }
    true
}
