//! The elementwise part of an LSTM step, fused.
//!
//! Every kernel is written once over registers of any width and dispatched at run time. All instruction sets
//! do the same operations, so they agree bit for bit.

use pulp::{Arch, Simd, WithSimd};

/// Beyond this the nearest `f32` to tanh is 1 to within one unit in the last place.
const SATURATED: f32 = 7.998_811_7;
/// Numerator and denominator of tanh(x) = x p(x²)/q(x²), highest power first: the minimax approximant of Eigen
/// (`generic_fast_tanh_float`), within 5 units in the last place.
const NUMERATOR: [f32; 7] = [
    -2.760_768_5e-16,
    2.000_188e-13,
    -8.604_672e-11,
    5.122_297e-8,
    1.485_722_4e-5,
    6.372_619_3e-4,
    4.893_524_6e-3,
];
const DENOMINATOR: [f32; 4] = [1.198_258_4e-6, 1.185_347_1e-4, 2.268_434_6e-3, 4.893_525e-3];

#[inline(always)]
fn polynomial<S: Simd, const N: usize>(simd: S, coefficients: [f32; N], x: S::f32s) -> S::f32s {
    let mut sum = simd.splat_f32s(coefficients[0]);
    for c in &coefficients[1..] {
        sum = simd.mul_add_f32s(sum, x, simd.splat_f32s(*c));
    }
    sum
}

#[inline(always)]
fn tanh<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let x = simd.max_f32s(simd.splat_f32s(-SATURATED), simd.min_f32s(simd.splat_f32s(SATURATED), x));
    let square = simd.mul_f32s(x, x);
    let numerator = simd.mul_f32s(x, polynomial(simd, NUMERATOR, square));
    simd.div_f32s(numerator, polynomial(simd, DENOMINATOR, square))
}

/// 1/(1 + exp(-x)) = (1 + tanh(x/2))/2.
#[inline(always)]
fn sigmoid<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let half = simd.splat_f32s(0.5);
    simd.mul_add_f32s(half, tanh(simd, simd.mul_f32s(half, x)), half)
}

/// Zero where it is at most `floor`.
#[inline(always)]
fn flush<S: Simd>(simd: S, d: S::f32s, floor: S::f32s) -> S::f32s {
    let is_there = simd.greater_than_f32s(simd.abs_f32s(d), floor);
    simd.select_f32s(is_there, d, simd.splat_f32s(0.0))
}

/// d σ (1 - σ): the derivative by x of what has the derivative d by σ(x).
#[inline(always)]
fn through_sigmoid<S: Simd>(simd: S, sigma: S::f32s, d: S::f32s) -> S::f32s {
    simd.mul_f32s(d, simd.negate_mul_add_f32s(sigma, sigma, sigma))
}

/// Loads registers from a position on.
#[derive(Clone, Copy)]
struct RegisterLoads<S> {
    simd: S,
    k: usize,
}

impl<S: Simd> RegisterLoads<S> {
    /// As many values as there are, up to a register; zeros after them.
    #[inline(always)]
    fn at(self, values: &[f32]) -> S::f32s {
        self.simd.partial_load_f32s(&values[self.k..])
    }
}

/// One step forward for some rows of H units: gates, cells, hidden states.
pub(crate) struct GatesForward<'a> {
    /// In: W_ih x + W_hh h + b. Out: i, f, g, o. [row][gate][unit].
    pub gates: &'a mut [f32],
    /// Cells before the step, [row][unit].
    pub c_before: &'a [f32],
    /// Out: c = f c_before + i g.
    pub c: &'a mut [f32],
    /// Out: h = o tanh c.
    pub h: &'a mut [f32],
    /// H.
    pub hidden: usize,
}

impl GatesForward<'_> {
    pub fn run(self) {
        Arch::new().dispatch(self);
    }
}

/// The four gates of a row.
fn four(gates: &mut [f32], hidden: usize) -> [&mut [f32]; 4] {
    let (i, rest) = gates.split_at_mut(hidden);
    let (f, rest) = rest.split_at_mut(hidden);
    let (g, o) = rest.split_at_mut(hidden);
    [i, f, g, o]
}

impl WithSimd for GatesForward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.hidden;
        let lanes = S::F32_LANES;
        let rows = self.gates.chunks_exact_mut(4 * n).zip(self.c_before.chunks_exact(n));
        let states = self.c.chunks_exact_mut(n).zip(self.h.chunks_exact_mut(n));
        for ((gates, c_before), (c, h)) in rows.zip(states) {
            let [i, f, g, o] = four(gates, n);
            for k in (0..n).step_by(lanes) {
                let load = RegisterLoads { simd, k };
                let vi = sigmoid(simd, load.at(i));
                let vf = sigmoid(simd, load.at(f));
                let vg = tanh(simd, load.at(g));
                let vo = sigmoid(simd, load.at(o));
                let kept = simd.mul_f32s(vf, load.at(c_before));
                let vc = simd.mul_add_f32s(vi, vg, kept);
                simd.partial_store_f32s(&mut i[k..], vi);
                simd.partial_store_f32s(&mut f[k..], vf);
                simd.partial_store_f32s(&mut g[k..], vg);
                simd.partial_store_f32s(&mut o[k..], vo);
                simd.partial_store_f32s(&mut c[k..], vc);
                simd.partial_store_f32s(&mut h[k..], simd.mul_f32s(vo, tanh(simd, vc)));
            }
        }
    }
}

/// One step back for some rows: from ∂L/∂h and ∂L/∂c after the step to those of the gates and of c before.
pub(crate) struct GatesBackward<'a> {
    /// In: i, f, g, o. Out: ∂L/∂z, z what the gates were made from. [row][gate][unit].
    pub gates: &'a mut [f32],
    /// Cells before the step, [row][unit].
    pub c_before: &'a [f32],
    /// Cells after it.
    pub c: &'a [f32],
    /// ∂L/∂h from what comes after this layer.
    pub dh_above: &'a [f32],
    /// ∂L/∂h from the next step.
    pub dh_next: &'a [f32],
    /// In: ∂L/∂c from the next step. Out: for the step before.
    pub dc: &'a mut [f32],
    /// H.
    pub hidden: usize,
    /// Derivatives of at most this size become zero; see [`crate::WindowOptions::gradient_floor`].
    pub floor: f32,
}

impl GatesBackward<'_> {
    pub fn run(self) {
        Arch::new().dispatch(self);
    }
}

impl WithSimd for GatesBackward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.hidden;
        let one = simd.splat_f32s(1.0);
        let floor = simd.splat_f32s(self.floor);
        let rows = self.gates.chunks_exact_mut(4 * n).zip(self.dc.chunks_exact_mut(n));
        for (row, (gates, dc)) in rows.enumerate() {
            let [i, f, g, o] = four(gates, n);
            let [c_before, c, dh_above, dh_next] = [self.c_before, self.c, self.dh_above, self.dh_next].map(
                #[inline(always)]
                |values| &values[row * n..][..n],
            );
            for k in (0..n).step_by(S::F32_LANES) {
                let load = RegisterLoads { simd, k };
                let [vi, vf, vg, vo] = [load.at(i), load.at(f), load.at(g), load.at(o)];
                let tanh_c = tanh(simd, load.at(c));
                let dh = simd.add_f32s(load.at(dh_above), load.at(dh_next));
                // ∂L/∂c = carried + ∂L/∂h o (1 - tanh² c)
                let slope = simd.negate_mul_add_f32s(tanh_c, tanh_c, one);
                let dc_now = simd.mul_add_f32s(simd.mul_f32s(dh, vo), slope, load.at(dc));
                let di = through_sigmoid(simd, vi, simd.mul_f32s(dc_now, vg));
                let df = through_sigmoid(simd, vf, simd.mul_f32s(dc_now, load.at(c_before)));
                let do_ = through_sigmoid(simd, vo, simd.mul_f32s(dh, tanh_c));
                let dg = simd.mul_f32s(simd.mul_f32s(dc_now, vi), simd.negate_mul_add_f32s(vg, vg, one));
                simd.partial_store_f32s(&mut i[k..], flush(simd, di, floor));
                simd.partial_store_f32s(&mut f[k..], flush(simd, df, floor));
                simd.partial_store_f32s(&mut g[k..], flush(simd, dg, floor));
                simd.partial_store_f32s(&mut o[k..], flush(simd, do_, floor));
                simd.partial_store_f32s(&mut dc[k..], flush(simd, simd.mul_f32s(dc_now, vf), floor));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// tanh and the sigmoid of numbers.
    struct Both<'a> {
        x: &'a [f32],
        tanh: &'a mut [f32],
        sigmoid: &'a mut [f32],
    }

    impl WithSimd for Both<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            for k in (0..self.x.len()).step_by(S::F32_LANES) {
                let x = RegisterLoads { simd, k }.at(self.x);
                simd.partial_store_f32s(&mut self.tanh[k..], tanh(simd, x));
                simd.partial_store_f32s(&mut self.sigmoid[k..], sigmoid(simd, x));
            }
        }
    }

    #[test]
    fn tanh_and_sigmoid_are_those_of_the_library() {
        let steps = (-40_000..=40_000).map(|k| k as f32 * 5e-4);
        let tiny = (-120..0).flat_map(|e| [2f32.powi(e), -2f32.powi(e)]);
        let x: Vec<f32> = steps.chain(tiny).chain([1e30, -1e30, f32::MAX]).collect();
        let (mut tanh, mut sigmoid) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        Arch::new().dispatch(Both { x: &x, tanh: &mut tanh, sigmoid: &mut sigmoid });
        for ((x, tanh), sigmoid) in x.iter().map(|x| f64::from(*x)).zip(&tanh).zip(&sigmoid) {
            let expected = x.tanh();
            // Five units in the last place, each at most ε of the value; beyond saturation 1 - tanh < 2⁻²³.
            let tol = 5.0 * f64::from(f32::EPSILON) * expected.abs();
            assert!((f64::from(*tanh) - expected).abs() <= tol, "tanh {x}: {tanh} {expected}");
            // Half of the error of tanh, and its own rounding.
            let expected = 1.0 / (1.0 + (-x).exp());
            let tol = (2.5 + 0.5) * f64::from(f32::EPSILON);
            assert!((f64::from(*sigmoid) - expected).abs() <= tol, "sigmoid {x}: {sigmoid} {expected}");
        }
        // The portable set does the same operations.
        let (mut again, mut unused) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        Arch::Scalar.dispatch(Both { x: &x, tanh: &mut again, sigmoid: &mut unused });
        assert_eq!((again, unused), (tanh, sigmoid));
    }

    #[test]
    fn derivatives_below_the_floor_are_zero_and_the_others_as_they_are() {
        // From 1 to 1e-36: an open cell hands all of it on, and half of it or a quarter goes to each gate.
        for floor in [0.0, 1e-16] {
            derivatives_with(floor);
        }
    }

    fn derivatives_with(floor: f32) {
        let dh: Vec<f32> = (0..37).map(|k| 10f32.powi(-k)).collect();
        let n = dh.len();
        let mut gates = vec![0.5; 4 * n];
        let (zeros, mut dc) = (vec![0.0; n], vec![0.0; n]);
        let [c_before, c] = [vec![1.0; n], vec![1.0; n]];
        GatesBackward {
            gates: &mut gates,
            c_before: &c_before,
            c: &c,
            dh_above: &dh,
            dh_next: &zeros,
            dc: &mut dc,
            hidden: n,
            floor,
        }
        .run();
        let tanh_c = 1f64.tanh();
        let of_cell = 0.5 * (1.0 - tanh_c * tanh_c);
        // By the equations of `docs/learn.md`: i, f, g, o, and the cell before.
        let parts = [0.125 * of_cell, 0.25 * of_cell, 0.375 * of_cell, 0.25 * tanh_c, 0.5 * of_cell];
        for (part, found) in parts.iter().zip(gates.chunks(n).chain([&dc[..]])) {
            for (found, dh) in found.iter().zip(&dh) {
                let expected = part * f64::from(*dh);
                if expected < 0.99 * f64::from(floor) {
                    assert_eq!(*found, 0.0, "{dh}");
                } else {
                    // tanh is within five units in the last place of 0.76, and 1 - tanh² is 0.42.
                    assert!((f64::from(*found) - expected).abs() < 30.0 * f64::from(f32::EPSILON) * expected);
                }
            }
        }
    }
}
