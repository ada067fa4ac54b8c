//! Matrices of whole numbers of 16 bits for products with one row: two columns are multiplied and added in one instruction.
//!
//! Entries and inputs are whole numbers of up to ±8191 in the unit of their row and of the vector, so that 32 products fit a sum of 32 bits;
//! sums of these are single precision. Results are the same on every instruction set.

use pulp::{Arch, NullaryFnOnce};
#[cfg(target_arch = "x86_64")]
use pulp::{cast, x86};

use super::PANEL;

/// Largest whole number of an entry or an input.
pub(super) const LARGEST: f32 = 8191.0;
/// Pairs of columns whose products are summed as whole numbers: 2 · 16 · 8191² < 2³¹.
const PAIRS: usize = 16;
/// Pairs of columns that are made whole numbers at a time.
const CHUNK: usize = 256;

/// Entries of two columns for every row of a panel.
type ColumnPair = [[i16; 2]; PANEL];

/// For each panel of [`PANEL`] rows, for each pair of columns, their entries, and the units of the rows.
#[derive(Debug, Clone)]
pub(crate) struct ShortPanels {
    pairs: Vec<ColumnPair>,
    units: Vec<[f32; PANEL]>,
}

/// Unit of some values: their largest size over [`LARGEST`]; above zero for zeros too.
fn unit(values: &[f32]) -> f32 {
    (values.iter().fold(0.0f32, |max, value| max.max(value.abs())) / LARGEST).max(f32::MIN_POSITIVE)
}

/// The whole number nearest to `value` times `per_unit`, of size up to [`LARGEST`]: numbers of this size
/// added to 1.5 · 2²³ have no fraction.
#[inline(always)]
fn whole(value: f32, per_unit: f32) -> i16 {
    const AWAY: f32 = 12_582_912.0;
    (value * per_unit + AWAY).to_bits().wrapping_sub(AWAY.to_bits()) as i16
}

impl ShortPanels {
    /// From a row-major matrix; the last panel and the last pair are filled up with zeros.
    pub fn new(matrix: &[f32], n_columns: usize) -> Self {
        let (mut pairs, mut units) = (Vec::new(), Vec::new());
        for rows in matrix.chunks(PANEL * n_columns) {
            let row = |r: usize| rows.get(r * n_columns..(r + 1) * n_columns).unwrap_or(&[]);
            let of_rows: [f32; PANEL] = std::array::from_fn(|r| unit(row(r)));
            let entry = |r: usize, column: usize| {
                row(r).get(column).map_or(0, |value| whole(*value, 1.0 / of_rows[r]))
            };
            pairs.extend((0..n_columns).step_by(2).map(|column| -> ColumnPair {
                std::array::from_fn(|r| [entry(r, column), entry(r, column + 1)])
            }));
            units.push(of_rows);
        }
        Self { pairs, units }
    }

    /// out += A x. What is not finite in `x` makes all of `out` not a number.
    pub fn multiply_add(&self, x: &[f32], out: &mut [f32]) {
        if !x.iter().all(|value| value.is_finite()) {
            out.fill(f32::NAN);
            return;
        }
        let unit = unit(x);
        let n_pairs = x.len().div_ceil(2);
        let mut inputs = [0; 2 * CHUNK];
        for (first, x) in (0..n_pairs).step_by(CHUNK).zip(x.chunks(2 * CHUNK)) {
            inputs.iter_mut().zip(x).for_each(|(input, x)| *input = whole(*x, 1.0 / unit));
            let n = x.len().next_multiple_of(2);
            inputs[x.len()..n].fill(0);
            let inputs = inputs[..n].as_chunks::<2>().0;
            let panels = self.pairs.chunks_exact(n_pairs).zip(&self.units);
            for ((pairs, units), out) in panels.zip(out.as_chunks_mut::<PANEL>().0) {
                dispatch(&pairs[first..first + inputs.len()], inputs, [units, &[unit; PANEL]], out);
            }
        }
    }
}

/// Adds the products of one panel to `out`, on the widest instruction set there is.
fn dispatch(pairs: &[ColumnPair], x: &[[i16; 2]], units: [&[f32; PANEL]; 2], out: &mut [f32; PANEL]) {
    match Arch::new() {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(simd) => simd.vectorize(Product { pairs, x, units, out, sums: simd }),
        #[cfg(target_arch = "x86_64")]
        Arch::V3(simd) => simd.vectorize(Product { pairs, x, units, out, sums: simd }),
        _ => Product { pairs, x, units, out, sums: Portable }.call(),
    }
}

/// Sums over pairs of columns as whole numbers of 32 bits.
trait PairSums: Copy {
    fn sums(self, pairs: &[ColumnPair], x: &[[i16; 2]]) -> [i32; PANEL];
}

/// One number at a time.
#[derive(Clone, Copy)]
struct Portable;

impl PairSums for Portable {
    #[inline(always)]
    fn sums(self, pairs: &[ColumnPair], x: &[[i16; 2]]) -> [i32; PANEL] {
        let mut sums = [0; PANEL];
        for (pair, x) in pairs.iter().zip(x) {
            for (sum, w) in sums.iter_mut().zip(pair) {
                *sum += i32::from(w[0]) * i32::from(x[0]) + i32::from(w[1]) * i32::from(x[1]);
            }
        }
        sums
    }
}

#[cfg(target_arch = "x86_64")]
impl PairSums for x86::V4 {
    #[inline(always)]
    fn sums(self, pairs: &[ColumnPair], x: &[[i16; 2]]) -> [i32; PANEL] {
        let mut sums = [self.avx512f._mm512_setzero_si512(); PANEL / 16];
        for (pair, x) in pairs.iter().zip(x) {
            let x = self.avx512f._mm512_set1_epi32(cast(*x));
            for (sum, w) in sums.iter_mut().zip(pair.as_chunks::<16>().0) {
                let products = self.avx512bw._mm512_madd_epi16(cast(*w), x);
                *sum = self.avx512f._mm512_add_epi32(*sum, products);
            }
        }
        cast(sums)
    }
}

#[cfg(target_arch = "x86_64")]
impl PairSums for x86::V3 {
    #[inline(always)]
    fn sums(self, pairs: &[ColumnPair], x: &[[i16; 2]]) -> [i32; PANEL] {
        let mut sums = [self.avx._mm256_setzero_si256(); PANEL / 8];
        for (pair, x) in pairs.iter().zip(x) {
            let x = self.avx._mm256_set1_epi32(cast(*x));
            for (sum, w) in sums.iter_mut().zip(pair.as_chunks::<8>().0) {
                let products = self.avx2._mm256_madd_epi16(cast(*w), x);
                *sum = self.avx2._mm256_add_epi32(*sum, products);
            }
        }
        cast(sums)
    }
}

/// One panel times some pairs of inputs.
struct Product<'a, S> {
    pairs: &'a [ColumnPair],
    x: &'a [[i16; 2]],
    /// Of the rows, and of the inputs.
    units: [&'a [f32; PANEL]; 2],
    out: &'a mut [f32; PANEL],
    sums: S,
}

impl<S: PairSums> NullaryFnOnce for Product<'_, S> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let mut all = [0.0; PANEL];
        for (pairs, x) in self.pairs.chunks(PAIRS).zip(self.x.chunks(PAIRS)) {
            let sums = self.sums.sums(pairs, x);
            for l in 0..PANEL {
                all[l] += sums[l] as f32;
            }
        }
        let [rows, inputs] = self.units;
        for l in 0..PANEL {
            self.out[l] += all[l] * (rows[l] * inputs[l]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_instruction_set_has_the_same_sums_and_the_largest_fit() {
        let drawn_number = |k: usize| ((k * 7919) % 16383) as i16 - 8191;
        let drawn: Vec<ColumnPair> = (0..PAIRS)
            .map(|c| std::array::from_fn(|r| [drawn_number(c * PANEL + r), drawn_number(c * 31 + r * 17)]))
            .collect();
        let x: Vec<[i16; 2]> = (0..PAIRS).map(|c| [drawn_number(c + 5), drawn_number(3 * c + 1)]).collect();
        let largest = (vec![[[8191; 2]; PANEL]; PAIRS], vec![[8191; 2]; PAIRS]);
        for (pairs, x) in [(drawn, x), largest] {
            let exact: [i64; PANEL] = std::array::from_fn(|r| {
                pairs
                    .iter()
                    .zip(&x)
                    .map(|(p, x)| (0..2).map(|k| i64::from(p[r][k]) * i64::from(x[k])).sum::<i64>())
                    .sum()
            });
            let units = [&[1.0; PANEL], &[1.0; PANEL]];
            let (mut portable, mut widest) = ([0.0; PANEL], [0.0; PANEL]);
            Product { pairs: &pairs, x: &x, units, out: &mut portable, sums: Portable }.call();
            dispatch(&pairs, &x, units, &mut widest);
            assert_eq!(portable, widest);
            assert_eq!(portable, exact.map(|sum| sum as f32));
            #[cfg(target_arch = "x86_64")]
            if let Some(simd) = x86::V3::try_new() {
                let mut out = [0.0; PANEL];
                simd.vectorize(Product { pairs: &pairs, x: &x, units, out: &mut out, sums: simd });
                assert_eq!(out, portable);
            }
        }
    }

    #[test]
    fn what_is_not_finite_is_not_hidden() {
        let panels = ShortPanels::new(&[1.0, 2.0, 3.0, 4.0], 2);
        for bad in [f32::NAN, f32::INFINITY] {
            let mut out = [0.0; PANEL];
            panels.multiply_add(&[1.0, bad], &mut out);
            assert!(out[0].is_nan() && out[1].is_nan());
        }
    }
}
