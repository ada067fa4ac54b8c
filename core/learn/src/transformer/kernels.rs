//! The parts of a layer that are no products of matrices: normalisation, activations, attention; forward and backward.
//!
//! Loops over plain arrays, compiled for each instruction set where they are called from ([`super::tape`]).

use std::ops::Range;

use crate::Float;

/// Partial sums that a register holds side by side.
const WIDE: usize = 16;
/// Keeps the division by a token's spread finite.
const EPSILON: f64 = 1e-5;

/// Σ a b, in sixteen partial sums.
#[inline(always)]
pub(super) fn dot<T: Float>(a: &[T], b: &[T]) -> T {
    let (a, a_rest) = a.as_chunks::<WIDE>();
    let (b, b_rest) = b.as_chunks::<WIDE>();
    let mut sums = [T::default(); WIDE];
    for (a, b) in a.iter().zip(b) {
        for l in 0..WIDE {
            sums[l] += a[l] * b[l];
        }
    }
    folded(sums) + a_rest.iter().zip(b_rest).map(|(a, b)| *a * *b).sum::<T>()
}

/// The sum of partial sums, half onto half: one after the other each addition would wait for the one before.
#[inline(always)]
fn folded<T: Float>(mut sums: [T; WIDE]) -> T {
    let mut n = WIDE / 2;
    while n > 0 {
        for l in 0..n {
            sums[l] += sums[n + l];
        }
        n /= 2;
    }
    sums[0]
}

/// y += s x.
#[inline(always)]
pub(super) fn add_scaled<T: Float>(y: &mut [T], s: T, x: &[T]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += s * *x;
    }
}

#[inline(always)]
pub(super) fn sigmoid<T: Float>(x: T) -> T {
    T::of(1.0) / (T::of(1.0) + (-x).exponential())
}

/// Normalised tokens, each over its own spread, into `unit`; scaled and shifted into `y`; 1/spread of each into `rate`.
///
/// # Reference
/// Ba, Kiros, Hinton (2016), Layer normalization.
#[inline(always)]
pub(super) fn norm<T: Float>(
    x: &[T],
    [weight, bias]: [&[T]; 2],
    unit: &mut [T],
    rate: &mut [T],
    y: &mut [T],
) {
    let d = weight.len();
    let per = T::of(1.0 / d as f64);
    let rows = x.chunks_exact(d).zip(unit.chunks_exact_mut(d)).zip(y.chunks_exact_mut(d));
    for (((x, unit), y), rate) in rows.zip(rate) {
        let mean = sum(x) * per;
        for (unit, x) in unit.iter_mut().zip(x) {
            *unit = *x - mean;
        }
        *rate = T::of(1.0) / (dot(unit, unit) * per + T::of(EPSILON)).root();
        for (k, (unit, y)) in unit.iter_mut().zip(y).enumerate() {
            *unit *= *rate;
            *y = *unit * weight[k] + bias[k];
        }
    }
}

#[inline(always)]
fn sum<T: Float>(x: &[T]) -> T {
    let (x, rest) = x.as_chunks::<WIDE>();
    let mut sums = [T::default(); WIDE];
    for x in x {
        for l in 0..WIDE {
            sums[l] += x[l];
        }
    }
    folded(sums) + rest.iter().copied().sum::<T>()
}

/// Adds to `dx` what `dy` gives through [`norm`], and to the gradients of its weight and bias.
#[inline(always)]
pub(super) fn norm_back<T: Float>(
    [unit, rate, dy]: [&[T]; 3],
    weight: &[T],
    dx: &mut [T],
    d_parameters: &mut [T],
) {
    let d = weight.len();
    let per = T::of(1.0 / d as f64);
    let (d_weight, d_bias) = d_parameters.split_at_mut(d);
    let rows = unit.chunks_exact(d).zip(dy.chunks_exact(d)).zip(dx.chunks_exact_mut(d));
    for (((unit, dy), dx), rate) in rows.zip(rate) {
        let mut sums = [[T::default(); WIDE]; 2];
        let mut rest = [T::default(); 2];
        let whole = d / WIDE * WIDE;
        for k in (0..whole).step_by(WIDE) {
            for l in 0..WIDE {
                let g = dy[k + l] * weight[k + l];
                sums[0][l] += g;
                sums[1][l] += g * unit[k + l];
            }
        }
        for k in whole..d {
            let g = dy[k] * weight[k];
            rest[0] += g;
            rest[1] += g * unit[k];
        }
        let mean = (folded(sums[0]) + rest[0]) * per;
        let along = (folded(sums[1]) + rest[1]) * per;
        for k in 0..d {
            d_weight[k] += dy[k] * unit[k];
            d_bias[k] += dy[k];
            dx[k] += *rate * (dy[k] * weight[k] - mean - unit[k] * along);
        }
    }
}

/// 2 √(2/π), and the part of the cube.
const GELU: [f64; 2] = [1.595_769_121_605_730_8, 0.044_715];

/// x σ(w(x)) with its derivative: GELU in its tanh form, w = 2√(2/π)(x + 0.044715 x³) (Hendrycks, Gimpel 2016).
#[inline(always)]
pub(super) fn gelu<T: Float>(x: T) -> [T; 2] {
    let [a, b] = GELU.map(T::of);
    let square = x * x;
    let s = sigmoid(a * (x + b * x * square));
    let slope = a * (T::of(1.0) + T::of(3.0) * b * square);
    [x * s, s + x * s * (T::of(1.0) - s) * slope]
}

/// x σ(x) with its derivative.
#[inline(always)]
pub(super) fn silu<T: Float>(x: T) -> [T; 2] {
    let s = sigmoid(x);
    [x * s, s + x * s * (T::of(1.0) - s)]
}

/// Offsets of a token's query, gate, key and value in its projections, and which tokens it attends to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Attention<'a, T> {
    /// Width of a token, and of its projections.
    pub width: usize,
    pub projected: usize,
    pub heads: usize,
    /// Sequences side by side: token `s` of sequence `r` is row `s rows + r`.
    pub rows: usize,
    /// Added to the score by lag (heads × window); none where position does not count.
    pub lags: Option<&'a [T]>,
    /// Longest row of weights: tokens of a window.
    pub window: usize,
}

impl<T: Float> Attention<'_, T> {
    /// Where the projections of token `s` of sequence `r` begin.
    fn row(&self, s: usize, r: usize) -> usize {
        (s * self.rows + r) * self.projected
    }

    fn keys_at(&self) -> usize {
        self.projected - 2 * self.width
    }

    fn values_at(&self) -> usize {
        self.projected - self.width
    }

    /// Attention of token `query` of sequence `r` to the tokens `attended`: `weights` (heads × window) and `out`
    /// (width).
    ///
    /// A token's keys of all heads are contiguous, and so are its values: each is read once, from one end
    /// to the other. Head by head, rows of a few lines at the same place of pages would drive each other out
    /// of the nearest cache.
    #[inline(always)]
    pub fn attend(
        &self,
        projections: &[T],
        (query, r): (usize, usize),
        attended: Range<usize>,
        weights: &mut [T],
        out: &mut [T],
    ) {
        let (n, window) = (self.width / self.heads, self.window);
        let scale = T::of(1.0 / (n as f64).sqrt());
        let queries = &projections[self.row(query, r)..][..self.width];
        for (k, s) in attended.clone().enumerate() {
            let keys = &projections[self.row(s, r) + self.keys_at()..][..self.width];
            for (head, (q, key)) in queries.chunks_exact(n).zip(keys.chunks_exact(n)).enumerate() {
                let lag = self.lags.map_or(T::default(), |lags| lags[head * window + query - s]);
                weights[head * window + k] = dot(q, key) * scale + lag;
            }
        }
        for weights in weights.chunks_exact_mut(window) {
            soft_max(&mut weights[..attended.len()]);
        }
        out.fill(T::default());
        for (k, s) in attended.enumerate() {
            let values = &projections[self.row(s, r) + self.values_at()..][..self.width];
            for (head, (out, value)) in out.chunks_exact_mut(n).zip(values.chunks_exact(n)).enumerate() {
                add_scaled(out, weights[head * window + k], value);
            }
        }
    }

    /// Pulls `d_out` back through [`Self::attend`]: adds to the gradients by queries, keys and values, and by lag. `d_weights` (heads ×
    /// window) is scratch.
    #[inline(always)]
    pub fn attend_backward(
        &self,
        [projections, weights, d_out]: [&[T]; 3],
        (query, r): (usize, usize),
        attended: Range<usize>,
        d_projections: &mut [T],
        d_lags: Option<&mut [T]>,
        d_weights: &mut [T],
    ) {
        let (n, window) = (self.width / self.heads, self.window);
        let scale = T::of(1.0 / (n as f64).sqrt());
        for (k, s) in attended.clone().enumerate() {
            let at = self.row(s, r) + self.values_at();
            let values = projections[at..][..self.width].chunks_exact(n);
            let d_values = d_projections[at..][..self.width].chunks_exact_mut(n);
            for (head, ((d_out, value), d_value)) in
                d_out.chunks_exact(n).zip(values).zip(d_values).enumerate()
            {
                d_weights[head * window + k] = dot(d_out, value);
                add_scaled(d_value, weights[head * window + k], d_out);
            }
        }
        let heads = d_weights.chunks_exact_mut(window).zip(weights.chunks_exact(window));
        for (d_weights, weights) in heads {
            let d_weights = &mut d_weights[..attended.len()];
            let along: T = d_weights.iter().zip(weights).map(|(d, weight)| *d * *weight).sum();
            d_weights.iter_mut().zip(weights).for_each(|(d, weight)| *d = *weight * (*d - along));
        }
        let at = self.row(query, r);
        for (k, s) in attended.clone().enumerate() {
            let of_keys = self.row(s, r) + self.keys_at();
            for head in 0..self.heads {
                let d = d_weights[head * window + k] * scale;
                let [q, key] = [at + head * n, of_keys + head * n];
                add_scaled(&mut d_projections[q..][..n], d, &projections[key..][..n]);
                add_scaled(&mut d_projections[key..][..n], d, &projections[q..][..n]);
            }
        }
        if let Some(d_lags) = d_lags {
            for (d_lags, d_weights) in d_lags.chunks_exact_mut(window).zip(d_weights.chunks_exact(window)) {
                for (s, d) in attended.clone().zip(d_weights) {
                    d_lags[query - s] += *d;
                }
            }
        }
    }
}

/// Scores become weights whose sum is one.
#[inline(always)]
fn soft_max<T: Float>(weights: &mut [T]) {
    let most = weights.iter().fold(T::of(f64::NEG_INFINITY), |most, weight| most.larger(*weight));
    weights.iter_mut().for_each(|weight| *weight = (*weight - most).exponential());
    let per = T::of(1.0) / weights.iter().copied().sum::<T>();
    weights.iter_mut().for_each(|weight| *weight *= per);
}
