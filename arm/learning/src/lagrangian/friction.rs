//! Friction with the effect of Stribeck, learned with the energies: (6) with the sign of the motor's side.

use hysteron_learn::{Activation, ByParameters, Float};

use super::block::{SampleBlock, Term};

/// Numbers of every joint: Coulomb, Stribeck, its width before the softplus, viscous.
pub(crate) const PER_JOINT: usize = 4;
/// The least width of the Stribeck term, in squares of a speed of order 1.
const MIN_WIDTH: f64 = 1e-3;
/// Speed of order 1 within which the sign is smooth.
const SMOOTH: f64 = 0.01;

/// τ_f = s [(C + S exp(−u²/v)) tanh(u/0.01) + d u], u = q̇/σ, v > 0.
#[derive(Debug)]
pub(crate) struct StribeckTerm<T> {
    per_speed: Vec<T>,
    /// s of every joint [N m].
    torque: Vec<T>,
}

impl<T: Float> StribeckTerm<T> {
    pub fn new(speeds: &[f64], torques: &[f64]) -> Self {
        Self {
            per_speed: speeds.iter().map(|v| T::of(1.0 / v)).collect(),
            torque: torques.iter().map(|v| T::of(*v)).collect(),
        }
    }

    /// u, its smooth sign, the Stribeck exponential, the width and its derivative.
    fn parts(&self, parameters: &[T], joint: usize, speed: T) -> [T; 5] {
        let u = speed * self.per_speed[joint];
        let [width, by_raw, _] = Activation::Softplus.at(parameters[PER_JOINT * joint + 2]);
        let width = width + T::of(MIN_WIDTH);
        let [sign, ..] = Activation::Tanh.at(u / T::of(SMOOTH));
        [u, sign, (-u * u / width).exponential(), width, by_raw]
    }
}

impl<T: Float> Term<T> for StribeckTerm<T> {
    fn prepare(&mut self, _: &[T]) {}

    fn outputs(&mut self, parameters: &[T], block: &SampleBlock<T>, out: &mut [T]) {
        let n = block.n_joints;
        for (i, out) in out.iter_mut().enumerate() {
            let j = i % n;
            let [u, sign, stribeck, ..] = self.parts(parameters, j, block.v[i]);
            let p = &parameters[PER_JOINT * j..];
            *out = self.torque[j] * ((p[0] + p[1] * stribeck) * sign + p[3] * u);
        }
    }

    fn derivatives(
        &mut self,
        parameters: &[T],
        block: &SampleBlock<T>,
        w: &[T],
        mut into: ByParameters<'_, T>,
    ) {
        let n = block.n_joints;
        into.begin(0..PER_JOINT * n);
        for (i, w) in w.iter().enumerate() {
            let (row, j) = (i / n, i % n);
            let [u, sign, stribeck, width, by_raw] = self.parts(parameters, j, block.v[i]);
            let w = *w * self.torque[j];
            let first = PER_JOINT * j;
            let by_width = parameters[first + 1] * stribeck * sign * u * u / (width * width) * by_raw;
            for (k, d) in [sign, stribeck * sign, by_width, u].into_iter().enumerate() {
                into.add(row, first + k, w * d);
            }
        }
    }
}
