//! A few samples side by side, as networks see them.

use hysteron_learn::Real;

/// What a coordinate enters a network as.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Coordinate {
    /// sin q, cos q of an angle.
    Angle,
    /// q / scale of a length [m], and a one.
    Length(f64),
}

/// Samples of one pass; arrays are [row][joint] unless they say otherwise.
#[derive(Debug, Clone)]
pub(crate) struct Block<T> {
    pub n_joints: usize,
    pub n_rows: usize,
    /// Joint positions [rad or m].
    pub q: Vec<T>,
    /// q̇, or the momentum p of a Hamiltonian.
    pub v: Vec<T>,
    /// q̈, or ṗ of a Hamiltonian.
    pub a: Vec<T>,
    /// [row][2 n_joints]: sines, then cosines.
    pub features: Vec<T>,
    /// Their derivatives by q.
    pub slopes: Vec<T>,
}

impl<T: Real> Block<T> {
    pub fn new(n_joints: usize) -> Self {
        let [q, v, a, features, slopes] = std::array::from_fn(|_| Vec::new());
        Self { n_joints, n_rows: 0, q, v, a, features, slopes }
    }

    /// Takes these rows of `motion` (q, q̇, q̈, each [row][joint]).
    pub fn gather(
        &mut self,
        coordinates: &[Coordinate],
        motion: [&[f64]; 3],
        rows: impl Iterator<Item = usize>,
    ) {
        let n = self.n_joints;
        for values in [&mut self.q, &mut self.v, &mut self.a, &mut self.features, &mut self.slopes] {
            values.clear();
        }
        self.n_rows = 0;
        for row in rows {
            let part = row * n..(row + 1) * n;
            let q = &motion[0][part.clone()];
            self.q.extend(q.iter().map(|v| T::of(*v)));
            self.v.extend(motion[1][part.clone()].iter().map(|v| T::of(*v)));
            self.a.extend(motion[2][part].iter().map(|v| T::of(*v)));
            let features = |(q, kind): (&f64, &Coordinate)| match kind {
                Coordinate::Angle => (q.sin_cos(), (q.cos(), -q.sin())),
                Coordinate::Length(scale) => ((q / scale, 1.0), (1.0 / scale, 0.0)),
            };
            let found: Vec<_> = q.iter().zip(coordinates).map(features).collect();
            self.features.extend(found.iter().map(|f| T::of(f.0.0)));
            self.features.extend(found.iter().map(|f| T::of(f.0.1)));
            self.slopes.extend(found.iter().map(|f| T::of(f.1.0)));
            self.slopes.extend(found.iter().map(|f| T::of(f.1.1)));
            self.n_rows += 1;
        }
    }

    /// Derivatives of the features along `direction` ([row][joint]): [row][2 n_joints].
    pub fn features_along(&self, direction: &[T], out: &mut Vec<T>) {
        let n = self.n_joints;
        out.clear();
        for (slopes, direction) in self.slopes.chunks_exact(2 * n).zip(direction.chunks_exact(n)) {
            out.extend(slopes[..n].iter().zip(direction).map(|(s, d)| *s * *d));
            out.extend(slopes[n..].iter().zip(direction).map(|(s, d)| *s * *d));
        }
    }

    /// Adds `factor` times the derivatives by q ([row][joint]) of what has these `derivatives` by inputs that begin with
    /// the features ([row][width]).
    pub fn add_by_q(&self, derivatives: &[T], width: usize, factor: T, out: &mut [T]) {
        let n = self.n_joints;
        let rows =
            derivatives.chunks_exact(width).zip(self.slopes.chunks_exact(2 * n)).zip(out.chunks_exact_mut(n));
        for ((d, slopes), out) in rows {
            for j in 0..n {
                out[j] += factor * (d[j] * slopes[j] + d[n + j] * slopes[n + j]);
            }
        }
    }
}

/// A part of a model of inverse dynamics: some outputs of every sample, linear in nothing.
pub(crate) trait Term<T>: Send {
    /// Writes the outputs of every row: torques [row][joint], and for a Hamiltonian [row][torques, then speeds].
    fn outputs(&mut self, parameters: &[T], block: &Block<T>, out: &mut [T]);

    /// Adds the gradient of Σ w · outputs by the parameters, w [row][output] taken as constant. Comes after `outputs` of
    /// the same block and parameters.
    fn gradient(&mut self, parameters: &[T], block: &Block<T>, w: &[T], gradient: &mut [T]);
}
