//! The parts of a layer that are no products of matrices: normalisation, activations, attention; forward and backward.
//!
//! Loops over plain arrays, compiled for each instruction set where they are called from ([`super::tape`]).

use crate::Real;

/// Partial sums that a register holds side by side.
const WIDE: usize = 16;
/// Keeps the division by a token's spread finite.
const EPSILON: f64 = 1e-5;

/// Σ a b, in sixteen partial sums.
#[inline(always)]
pub(super) fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    let (a, a_rest) = a.as_chunks::<WIDE>();
    let (b, b_rest) = b.as_chunks::<WIDE>();
    let mut sums = [T::default(); WIDE];
    for (a, b) in a.iter().zip(b) {
        for l in 0..WIDE {
            sums[l] += a[l] * b[l];
        }
    }
    sums.into_iter().sum::<T>() + a_rest.iter().zip(b_rest).map(|(a, b)| *a * *b).sum::<T>()
}

/// y += s x.
#[inline(always)]
pub(super) fn add_scaled<T: Real>(y: &mut [T], s: T, x: &[T]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += s * *x;
    }
}

#[inline(always)]
pub(super) fn sigmoid<T: Real>(x: T) -> T {
    T::of(1.0) / (T::of(1.0) + (-x).exponential())
}

/// Normalised tokens, each over its own spread, into `unit`; scaled and shifted into `y`; 1/spread of each into `rate`.
///
/// # Reference
/// Ba, Kiros, Hinton (2016), Layer normalization.
#[inline(always)]
pub(super) fn norm<T: Real>(x: &[T], [weight, bias]: [&[T]; 2], unit: &mut [T], rate: &mut [T], y: &mut [T]) {
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
fn sum<T: Real>(x: &[T]) -> T {
    let (x, rest) = x.as_chunks::<WIDE>();
    let mut sums = [T::default(); WIDE];
    for x in x {
        for l in 0..WIDE {
            sums[l] += x[l];
        }
    }
    sums.into_iter().sum::<T>() + rest.iter().copied().sum::<T>()
}

/// Adds to `dx` what `dy` gives through [`norm`], and to the gradients of its weight and bias.
#[inline(always)]
pub(super) fn norm_back<T: Real>(
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
        let mean = (sums[0].into_iter().sum::<T>() + rest[0]) * per;
        let along = (sums[1].into_iter().sum::<T>() + rest[1]) * per;
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
pub(super) fn gelu<T: Real>(x: T) -> [T; 2] {
    let [a, b] = GELU.map(T::of);
    let square = x * x;
    let s = sigmoid(a * (x + b * x * square));
    let slope = a * (T::of(1.0) + T::of(3.0) * b * square);
    [x * s, s + x * s * (T::of(1.0) - s) * slope]
}

/// x σ(x) with its derivative.
#[inline(always)]
pub(super) fn silu<T: Real>(x: T) -> [T; 2] {
    let s = sigmoid(x);
    [x * s, s + x * s * (T::of(1.0) - s)]
}

/// Where a token's query, gate, key and value stand among its projections, and which tokens it attends to.
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

impl<T: Real> Attention<'_, T> {
    fn keys_at(&self) -> usize {
        self.projected - 2 * self.width
    }

    /// What token `query` of sequence `r` sees in `head`, from the tokens `seen`: `weights` (as many as `seen`) and `out` (a head's part).
    #[inline(always)]
    pub fn look(
        &self,
        projections: &[T],
        (query, r, head): (usize, usize, usize),
        seen: std::ops::Range<usize>,
        weights: &mut [T],
        out: &mut [T],
    ) {
        let n = self.width / self.heads;
        let scale = T::of(1.0 / (n as f64).sqrt());
        let row = |s: usize| (s * self.rows + r) * self.projected + head * n;
        let q = &projections[row(query)..][..n];
        let mut most = T::of(f64::NEG_INFINITY);
        for (s, weight) in seen.clone().zip(weights.iter_mut()) {
            let key = &projections[row(s) + self.keys_at()..][..n];
            let lag = self.lags.map_or(T::default(), |lags| lags[head * self.window + query - s]);
            *weight = dot(q, key) * scale + lag;
            most = most.larger(*weight);
        }
        let weights = &mut weights[..seen.len()];
        let mut total = T::default();
        for weight in weights.iter_mut() {
            *weight = (*weight - most).exponential();
            total += *weight;
        }
        let per = T::of(1.0) / total;
        out.fill(T::default());
        for (s, weight) in seen.zip(weights) {
            *weight *= per;
            add_scaled(out, *weight, &projections[row(s) + self.keys_at() + self.width..][..n]);
        }
    }

    /// Pulls `d_out` back through [`Self::look`]: adds to the gradients by query, keys and values, and by lag.
    #[inline(always)]
    pub fn look_back(
        &self,
        [projections, weights, d_out]: [&[T]; 3],
        (query, r, head): (usize, usize, usize),
        seen: std::ops::Range<usize>,
        d_projections: &mut [T],
        d_lags: Option<&mut [T]>,
        d_weights: &mut [T],
    ) {
        let n = self.width / self.heads;
        let scale = T::of(1.0 / (n as f64).sqrt());
        let row = |s: usize| (s * self.rows + r) * self.projected + head * n;
        let (keys, values) = (self.keys_at(), self.keys_at() + self.width);
        let mut along = T::default();
        for (k, s) in seen.clone().enumerate() {
            d_weights[k] = dot(d_out, &projections[row(s) + values..][..n]);
            along += d_weights[k] * weights[k];
            add_scaled(&mut d_projections[row(s) + values..][..n], weights[k], d_out);
        }
        for (k, s) in seen.clone().enumerate() {
            d_weights[k] = weights[k] * (d_weights[k] - along);
            let d = d_weights[k] * scale;
            for c in 0..n {
                d_projections[row(query) + c] += d * projections[row(s) + keys + c];
                d_projections[row(s) + keys + c] += d * projections[row(query) + c];
            }
        }
        if let Some(d_lags) = d_lags {
            for (k, s) in seen.enumerate() {
                d_lags[head * self.window + query - s] += d_weights[k];
            }
        }
    }
}
