//! A few samples side by side, as networks see them.

use hysteron_learn::{ByParameters, Float};

/// Form in which a coordinate enters a network.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Coordinate {
    /// sin q, cos q of an angle.
    Angle,
    /// q / scale of a length [m], and a one.
    Length(f64),
}

/// Position features of networks: products of the two numbers of every joint, over some joints.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PositionFeatures {
    coordinates: Vec<Coordinate>,
    /// Of every feature: joints with 0 for the first number (sin q), 1 for the second.
    factors: Vec<Vec<(usize, usize)>>,
    /// Joint and feature of every derivative that is not always zero, feature by feature.
    entries: Vec<(usize, usize)>,
}

impl PositionFeatures {
    /// Products over up to `degree` joints: all first numbers, all second ones, then what has more factors.
    pub fn new(coordinates: Vec<Coordinate>, degree: usize) -> Self {
        let n = coordinates.len();
        let mut factors: Vec<Vec<(usize, usize)>> =
            (0..2).flat_map(|part| (0..n).map(move |j| vec![(j, part)])).collect();
        let mut begin = 0;
        for _ in 1..degree {
            let before = factors[begin..].to_vec();
            begin = factors.len();
            for (product, part) in before.iter().flat_map(|product| [(product, 0), (product, 1)]) {
                let last = product.last().map_or(0, |(joint, _)| joint + 1);
                factors.extend((last..n).map(|j| [&product[..], &[(j, part)]].concat()));
            }
        }
        let of = |(f, product): (usize, &Vec<(usize, usize)>)| -> Vec<(usize, usize)> {
            product.iter().map(|(joint, _)| (*joint, f)).collect()
        };
        let entries = factors.iter().enumerate().flat_map(of).collect();
        Self { coordinates, factors, entries }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.factors.len()
    }

    /// Whether they are the two numbers of every joint and no products of them.
    fn is_plain(&self) -> bool {
        self.factors.len() == 2 * self.coordinates.len()
    }

    /// The two numbers of a joint at `q`.
    fn numbers(&self, joint: usize, q: f64) -> [f64; 2] {
        match self.coordinates[joint] {
            Coordinate::Angle => q.sin_cos().into(),
            Coordinate::Length(scale) => [q / scale, 1.0],
        }
    }

    /// Their derivatives by q.
    fn slopes(&self, joint: usize, [first, second]: [f64; 2]) -> [f64; 2] {
        match self.coordinates[joint] {
            Coordinate::Angle => [second, -first],
            Coordinate::Length(scale) => [1.0 / scale, 0.0],
        }
    }

    /// The two numbers of every joint in every row of `q` ([row][joint]), for [`BlockMotion::numbers`].
    pub fn all_numbers(&self, q: &[f64]) -> Vec<[f64; 2]> {
        let joints = (0..self.coordinates.len()).cycle();
        joints.zip(q).map(|(joint, q)| self.numbers(joint, *q)).collect()
    }
}

/// Input series of a block, one entry per row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockMotion<'a> {
    /// q, q̇, q̈, or of a Hamiltonian q, p, ṗ: each [row][joint].
    pub series: [&'a [f64]; 3],
    /// [`PositionFeatures::all_numbers`] of the positions where they are known: a training that sees its samples again and again takes their
    /// sines once.
    pub numbers: Option<&'a [[f64; 2]]>,
}

impl<'a> From<[&'a [f64]; 3]> for BlockMotion<'a> {
    fn from(series: [&'a [f64]; 3]) -> Self {
        Self { series, numbers: None }
    }
}

/// Samples of one pass; arrays are [row][joint] by default.
#[derive(Debug, Clone)]
pub(crate) struct SampleBlock<T> {
    pub n_joints: usize,
    pub n_rows: usize,
    inputs: PositionFeatures,
    /// q̇, or the momentum p of a Hamiltonian.
    pub v: Vec<T>,
    /// q̈, or ṗ of a Hamiltonian.
    pub a: Vec<T>,
    /// [row][feature].
    pub features: Vec<T>,
    /// [row][entry]: their derivatives by q.
    slopes: Vec<T>,
}

impl<T: Float> SampleBlock<T> {
    pub fn new(inputs: PositionFeatures) -> Self {
        let [v, a, features, slopes] = std::array::from_fn(|_| Vec::new());
        Self { n_joints: inputs.coordinates.len(), n_rows: 0, inputs, v, a, features, slopes }
    }

    /// Features of a row.
    pub fn n_features(&self) -> usize {
        self.inputs.len()
    }

    /// Takes these rows of a motion.
    pub fn gather<'a>(
        &mut self,
        motion: impl Into<BlockMotion<'a>>,
        rows: impl Iterator<Item = usize> + Clone,
    ) {
        let BlockMotion { series, numbers } = motion.into();
        let n = self.n_joints;
        for values in [&mut self.v, &mut self.a, &mut self.features, &mut self.slopes] {
            values.clear();
        }
        self.n_rows = 0;
        let mut of_joints = [[[0.0; 2]; 2]; super::MAX_JOINTS];
        // One series after the other: samples are scattered in memory, and short loops load several of them at a time.
        for (to, from) in [&mut self.v, &mut self.a].into_iter().zip(&series[1..]) {
            for row in rows.clone() {
                to.extend(from[row * n..(row + 1) * n].iter().map(|v| T::of(*v)));
            }
        }
        for row in rows {
            for (j, both) in of_joints.iter_mut().enumerate().take(n) {
                let at = row * n + j;
                let found = numbers.map_or_else(|| self.inputs.numbers(j, series[0][at]), |known| known[at]);
                *both = [found, self.inputs.slopes(j, found)];
            }
            self.add_features(&of_joints[..n]);
            self.n_rows += 1;
        }
    }

    /// Adds a row: of every joint its two numbers, and their derivatives by q.
    fn add_features(&mut self, of_joints: &[[[f64; 2]; 2]]) {
        let Self { inputs, features, slopes, .. } = self;
        if inputs.is_plain() {
            for part in 0..2 {
                features.extend(of_joints.iter().map(|both| T::of(both[0][part])));
                slopes.extend(of_joints.iter().map(|both| T::of(both[1][part])));
            }
            return;
        }
        for product in &inputs.factors {
            let all: f64 = product.iter().map(|(j, part)| of_joints[*j][0][*part]).product();
            features.push(T::of(all));
            for (k, (j, part)) in product.iter().enumerate() {
                let others = product.iter().enumerate().filter(|(other, _)| *other != k);
                let others: f64 = others.map(|(_, (j, part))| of_joints[*j][0][*part]).product();
                slopes.push(T::of(of_joints[*j][1][*part] * others));
            }
        }
    }

    /// Derivatives of the features along `direction` ([row][joint]): [row][feature].
    pub fn features_along(&self, direction: &[T], out: &mut Vec<T>) {
        let (n, width) = (self.n_joints, self.n_features());
        out.clear();
        out.resize(self.n_rows * width, T::default());
        let entries = self.inputs.entries.len();
        let rows =
            self.slopes.chunks_exact(entries).zip(direction.chunks_exact(n)).zip(out.chunks_exact_mut(width));
        for ((slopes, direction), out) in rows {
            if self.inputs.is_plain() {
                for (slopes, out) in slopes.chunks_exact(n).zip(out.chunks_exact_mut(n)) {
                    for j in 0..n {
                        out[j] = slopes[j] * direction[j];
                    }
                }
                continue;
            }
            for (slope, (joint, feature)) in slopes.iter().zip(&self.inputs.entries) {
                out[*feature] += *slope * direction[*joint];
            }
        }
    }

    /// Adds `factor` times the derivatives by q ([row][joint]) of what has these `derivatives` by inputs that begin with
    /// the features ([row][width]).
    pub fn add_by_q(&self, derivatives: &[T], width: usize, factor: T, out: &mut [T]) {
        for (row, out) in out.chunks_exact_mut(self.n_joints).take(self.n_rows).enumerate() {
            self.add_row_by_q(row, &derivatives[row * width..], factor, out);
        }
    }

    /// The same of one row.
    pub fn add_row_by_q(&self, row: usize, derivatives: &[T], factor: T, out: &mut [T]) {
        let entries = self.inputs.entries.len();
        let slopes = &self.slopes[row * entries..][..entries];
        if self.inputs.is_plain() {
            let n = self.n_joints;
            for (derivatives, slopes) in derivatives.chunks_exact(n).zip(slopes.chunks_exact(n)) {
                for j in 0..n {
                    out[j] += factor * derivatives[j] * slopes[j];
                }
            }
            return;
        }
        for (slope, (joint, feature)) in slopes.iter().zip(&self.inputs.entries) {
            out[*joint] += factor * derivatives[*feature] * *slope;
        }
    }
}

/// A part of a model of inverse dynamics: some outputs of every sample, linear in nothing.
pub(crate) trait Term<T>: Send {
    /// From now on all calls are with these parameters: see [`hysteron_learn::MlpTape::prepare`].
    fn prepare(&mut self, parameters: &[T]);

    /// Writes the outputs of every row: torques [row][joint], and for a Hamiltonian [row][torques, then speeds].
    fn outputs(&mut self, parameters: &[T], block: &SampleBlock<T>, out: &mut [T]);

    /// Adds the derivatives of w · outputs of every row by the parameters, w [row][output] taken as constant. Comes after
    /// `outputs` of the same block and parameters, any number of times.
    fn derivatives(&mut self, parameters: &[T], block: &SampleBlock<T>, w: &[T], into: ByParameters<'_, T>);
}
