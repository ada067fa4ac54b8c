//! Guesses the next equilibrium from the last ones.
//!
//! An elastic body's shape is a smooth function of its strokes, independent of the path in time. Around the
//! present state it is close to quadratic, so a polynomial-kernel regression over the last states, in
//! the space of commands, predicts the next state to third order; noise in the strokes does not matter,
//! because the noisy strokes themselves are the coordinates.
//!
//! A cable gives the state a stroke or a tension, whichever is prescribed: a taut tendon and a friction point that sticks
//! give their strokes; a slack tendon, one driven by tension, and a point that slips their tensions. Every state
//! knows both of every cable, so those from before a cable changed sides count as well as those after.
//!
//! # Reference
//! Schölkopf, Smola (2002), Learning with kernels, sec. 4.3 (kernel ridge regression).

use hysteron_base::lanes::Isa;
use hysteron_fem::vectors::{combine_into, dot};

/// States kept.
const CAPACITY: usize = 12;
/// Ridge relative to the kernel of the farthest state: the accuracy of a state relative to the distance
/// between states, squared.
const RIDGE: f64 = 1e-10;
/// A command farther away than this many times the spread of the states is not extrapolated to.
const REACH: f64 = 3.0;

#[derive(Debug, Clone)]
struct PastEquilibrium {
    /// Stroke of every cable [m].
    strokes: Vec<f64>,
    /// Free unknowns, then tensions.
    point: Vec<f64>,
}

/// Prescribed value of a cable in the next state.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Prescribed {
    /// Its stroke [m].
    Stroke(f64),
    /// Its tension [N], and the weight of a newton [m/N].
    Tension(f64, f64),
}

/// The last equilibria.
#[derive(Debug, Clone)]
pub(crate) struct EquilibriumPredictor {
    isa: Isa,
    /// Free unknowns of a point; its tensions follow.
    n_unknowns: usize,
    entries: Vec<PastEquilibrium>,
    n_entries: usize,
    newest: usize,
    /// How far each of the other states, and then the next one, is from the newest, by cable [m]; scratch.
    apart: Vec<Vec<f64>>,
}

impl EquilibriumPredictor {
    /// For `n` free unknowns and `m` cables.
    pub fn new(isa: Isa, n: usize, m: usize) -> Self {
        let blank = PastEquilibrium { strokes: vec![0.0; m], point: vec![0.0; n + m] };
        let apart = vec![vec![0.0; m]; CAPACITY];
        Self { isa, n_unknowns: n, entries: vec![blank; CAPACITY], n_entries: 0, newest: 0, apart }
    }

    /// Drops all states.
    pub fn clear(&mut self) {
        self.n_entries = 0;
    }

    /// Adds the newest equilibrium; `write` fills in (strokes, point).
    pub fn push(&mut self, write: impl FnOnce(&mut [f64], &mut [f64])) {
        self.newest = if self.n_entries == 0 { 0 } else { (self.newest + 1) % CAPACITY };
        self.n_entries = (self.n_entries + 1).min(CAPACITY);
        let entry = &mut self.entries[self.newest];
        write(&mut entry.strokes, &mut entry.point);
    }

    /// Adds to `change` (zeroed by the caller) the predicted change of the point from the newest state to where the
    /// cables are `prescribed` to be. Leaves zero where there is no history.
    pub fn predict(&mut self, prescribed: &[Prescribed], change: &mut [f64]) {
        let n = self.n_entries.saturating_sub(1);
        if n == 0 {
            return;
        }
        let (entries, newest, n_unknowns) = (&self.entries, self.newest, self.n_unknowns);
        let base = &entries[newest];
        let other = |i: usize| &entries[(newest + CAPACITY - 1 - i) % CAPACITY];
        for (j, prescribed) in prescribed.iter().enumerate() {
            match *prescribed {
                Prescribed::Stroke(stroke) => {
                    for (i, apart) in self.apart[..n].iter_mut().enumerate() {
                        apart[j] = other(i).strokes[j] - base.strokes[j];
                    }
                    self.apart[n][j] = stroke - base.strokes[j];
                }
                Prescribed::Tension(tension, scale) => {
                    let from = base.point[n_unknowns + j];
                    for (i, apart) in self.apart[..n].iter_mut().enumerate() {
                        apart[j] = scale * (other(i).point[n_unknowns + j] - from);
                    }
                    self.apart[n][j] = scale * (tension - from);
                }
            }
        }
        let m = prescribed.len();
        let inner = |i: usize, k: usize| dot(self.isa, &self.apart[i][..m], &self.apart[k][..m]);
        let spread = (0..n).map(|i| inner(i, i)).fold(0.0, f64::max);
        if spread == 0.0 || inner(n, n) > REACH * REACH * spread {
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
                matrix[i][j] = kernel(inner(i, j));
            }
            matrix[i][i] += RIDGE;
            factors[i] = kernel(inner(i, n));
        }
        if !solve_positive_definite(&mut matrix, &mut factors, n) {
            return;
        }
        let points: [&[f64]; CAPACITY] =
            std::array::from_fn(|i| if i < n { &other(i).point[..] } else { &base.point });
        factors[n] = -factors[..n].iter().sum::<f64>();
        combine_into(self.isa, &factors[..=n], &points[..=n], change);
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
