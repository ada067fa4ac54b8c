//! Block-envelope Cholesky in single precision: the factor that every step of a slender body reuses.
//!
//! A body much longer than wide, numbered along its length, has a stiffness whose rows fill a narrow
//! envelope left of the diagonal. It is stored as 16×16 blocks (column-major), block rows one after the
//! other, and factorised block by block without any index in the inner loops. Single precision halves
//! the memory traffic that limits a solve; the caller corrects with residuals in double precision.
//! Diagonal blocks keep the *inverse* of their triangular factor, so a triangular solve is a product.
//!
//! # Reference
//! George, Liu (1981), Computer solution of large sparse positive definite systems, ch. 4.

use super::{Isa, Simd, WithSimd};

/// Rows and columns of a block; a row of a block is one AVX-512 register.
pub(crate) const BLOCK: usize = 16;
const AREA: usize = BLOCK * BLOCK;

#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct MatrixBlock([f32; AREA]);

impl MatrixBlock {
    const ZERO: Self = Self([0.0; AREA]);
}

/// A symmetric positive definite matrix, then its Cholesky factor, in a block envelope.
#[derive(Debug, Clone)]
pub(crate) struct BlockEnvelope {
    /// First stored block column of each block row.
    first: Vec<usize>,
    /// Position in `blocks` of each block row's first block; one more entry than block rows.
    start: Vec<usize>,
    /// Last block row that reaches each block column.
    last: Vec<usize>,
    blocks: Vec<MatrixBlock>,
}

/// Sixteen right-hand sides or solutions.
#[derive(Debug, Clone)]
pub(crate) struct SolutionPanel(Vec<MatrixBlock>);

impl SolutionPanel {
    /// Zeros for `n_padded` unknowns.
    pub fn zeros(n_padded: usize) -> Self {
        Self(vec![MatrixBlock::ZERO; n_padded / BLOCK])
    }

    /// Takes over right-hand sides, at most sixteen; the others are zero.
    pub fn load(&mut self, columns: &[Vec<f64>]) {
        self.0.fill(MatrixBlock::ZERO);
        for (side, column) in columns.iter().enumerate() {
            for (block, values) in self.0.iter_mut().zip(column.chunks(BLOCK)) {
                for (r, value) in values.iter().enumerate() {
                    block.0[r * BLOCK + side] = *value as f32;
                }
            }
        }
    }

    /// Writes the solutions over the right-hand sides.
    pub fn store(&self, columns: &mut [Vec<f64>]) {
        for (side, column) in columns.iter_mut().enumerate() {
            for (block, values) in self.0.iter().zip(column.chunks_mut(BLOCK)) {
                for (r, value) in values.iter_mut().enumerate() {
                    *value = f64::from(block.0[r * BLOCK + side]);
                }
            }
        }
    }
}

impl BlockEnvelope {
    /// An empty envelope for the lower triangle whose row `i` begins at column `first_column[i] <= i`.
    pub fn new(first_column: &[usize]) -> Self {
        let n_block_rows = first_column.len().div_ceil(BLOCK);
        let mut first: Vec<usize> = (0..n_block_rows).collect();
        for (i, column) in first_column.iter().enumerate() {
            first[i / BLOCK] = first[i / BLOCK].min(column / BLOCK);
        }
        let mut start = vec![0];
        let mut last = vec![0; n_block_rows];
        for (i, &begin) in first.iter().enumerate() {
            start.push(start[i] + i - begin + 1);
            last[begin..=i].fill(i);
        }
        let blocks = vec![MatrixBlock::ZERO; start[n_block_rows]];
        Self { first, start, last, blocks }
    }

    /// Unknowns including the padding to whole blocks.
    pub fn n_padded(&self) -> usize {
        self.first.len() * BLOCK
    }

    /// Stored numbers.
    pub fn n_stored(&self) -> usize {
        self.blocks.len() * AREA
    }

    /// Multiply-adds of one factorisation, counted in whole blocks.
    pub fn factor_cost(first_column: &[usize]) -> f64 {
        let shape = Self { blocks: Vec::new(), ..Self::new(first_column) };
        let mut cost = 0.0;
        for i in 0..shape.first.len() {
            for j in shape.first[i]..=i {
                cost += (j + 1 - shape.first[i].max(shape.first[j])) as f64;
            }
        }
        cost * (AREA * BLOCK) as f64
    }

    /// Where entry (row, column), row >= column, is stored.
    pub fn position(&self, row: usize, column: usize) -> usize {
        let (i, j) = (row / BLOCK, column / BLOCK);
        (self.start[i] + j - self.first[i]) * AREA + (column % BLOCK) * BLOCK + row % BLOCK
    }

    /// Clears the envelope, puts the entries of each 3×3 block at its `positions` (row-major), and ones
    /// on the diagonal of the padding beyond `n` unknowns.
    pub fn load(&mut self, n: usize, positions: &[[u32; 9]], values: &[[[f64; 4]; 3]]) {
        self.blocks.fill(MatrixBlock::ZERO);
        for (positions, values) in positions.iter().zip(values) {
            for k in 0..9 {
                let position = positions[k] as usize;
                self.blocks[position / AREA].0[position % AREA] = values[k / 3][k % 3] as f32;
            }
        }
        for row in n..self.n_padded() {
            let position = self.position(row, row);
            self.blocks[position / AREA].0[position % AREA] = 1.0;
        }
    }

    /// Turns the loaded matrix into its Cholesky factor.
    ///
    /// # Errors
    /// The unknown whose pivot is not positive.
    pub fn factorize(&mut self, isa: Isa) -> Result<(), usize> {
        isa.run(Factorize(self))
    }

    /// Solves for one right-hand side in place; `x` is padded.
    pub fn solve(&self, isa: Isa, x: &mut [f32]) {
        isa.run(Solve { envelope: self, x });
    }

    /// Solves for sixteen right-hand sides in place.
    pub fn solve_panel(&self, isa: Isa, panel: &mut SolutionPanel) {
        let panel = &mut panel.0[..];
        isa.run(SolvePanel { envelope: self, panel });
    }

    fn row(&self, i: usize) -> &[MatrixBlock] {
        &self.blocks[self.start[i]..self.start[i + 1]]
    }

    fn block(&self, i: usize, j: usize) -> &MatrixBlock {
        &self.blocks[self.start[i] + j - self.first[i]]
    }
}

/// C += Σ A_k B_kᵀ for blocks A_k, B_k; `at(k, c)` is where B keeps the factor of its column k that goes
/// to column c of C.
#[inline(always)]
fn multiply_add<S: Simd>(
    simd: S,
    c: &mut MatrixBlock,
    a: &[MatrixBlock],
    b: &[MatrixBlock],
    at: impl Fn(usize, usize) -> usize + Copy,
) {
    match S::F32_LANES {
        16 => tile::<S, 1, 16>(simd, c, a, b, at),
        8 => tile::<S, 2, 4>(simd, c, a, b, at),
        4 => tile::<S, 4, 2>(simd, c, a, b, at),
        _ => tile::<S, 16, 1>(simd, c, a, b, at),
    }
}

/// [`multiply_add`] with `V` registers a column and `C` columns held in registers at a time.
#[inline(always)]
fn tile<S: Simd, const V: usize, const C: usize>(
    simd: S,
    c: &mut MatrixBlock,
    a: &[MatrixBlock],
    b: &[MatrixBlock],
    at: impl Fn(usize, usize) -> usize + Copy,
) {
    let (c, _) = S::as_mut_simd_f32s(&mut c.0);
    for column in (0..BLOCK).step_by(C) {
        let mut sums = [[simd.splat_f32s(0.0); V]; C];
        for (a, b) in a.iter().zip(b) {
            let (a, _) = S::as_simd_f32s(&a.0);
            for k in 0..BLOCK {
                for l in 0..C {
                    let factor = simd.splat_f32s(b.0[at(k, column + l)]);
                    for v in 0..V {
                        sums[l][v] = simd.mul_add_e_f32s(a[k * V + v], factor, sums[l][v]);
                    }
                }
            }
        }
        for l in 0..C {
            for v in 0..V {
                let target = &mut c[(column + l) * V + v];
                *target = simd.add_f32s(*target, sums[l][v]);
            }
        }
    }
}

/// Where a block keeps B(c, k): B enters transposed.
#[inline(always)]
fn transposed(k: usize, c: usize) -> usize {
    k * BLOCK + c
}

#[inline(always)]
fn negated(block: &MatrixBlock) -> MatrixBlock {
    let mut negated = *block;
    for value in &mut negated.0 {
        *value = -*value;
    }
    negated
}

/// Cholesky factor of the lower triangle of `block`, inverted; its upper triangle is cleared.
///
/// # Errors
/// The column whose pivot is not positive.
#[inline(always)]
fn invert_factor(block: &mut MatrixBlock) -> Result<(), usize> {
    let mut columns = [[0.0f32; BLOCK]; BLOCK];
    columns.as_flattened_mut().copy_from_slice(&block.0);
    let mut per_diagonal = [0.0f32; BLOCK];
    for k in 0..BLOCK {
        let pivot = columns[k][k];
        if pivot <= 0.0 || !pivot.is_finite() {
            return Err(k);
        }
        per_diagonal[k] = 1.0 / pivot.sqrt();
        for value in &mut columns[k] {
            *value *= per_diagonal[k];
        }
        for j in k + 1..BLOCK {
            let factor = columns[k][j];
            for r in 0..BLOCK {
                columns[j][r] -= factor * columns[k][r];
            }
        }
    }
    // Row k of the inverse: (e_k - Σ L_kj row_j) / L_kk.
    let mut rows = [[0.0f32; BLOCK]; BLOCK];
    for k in 0..BLOCK {
        let mut row = [0.0f32; BLOCK];
        row[k] = 1.0;
        for j in 0..k {
            let factor = columns[j][k];
            for c in 0..BLOCK {
                row[c] -= factor * rows[j][c];
            }
        }
        for c in 0..BLOCK {
            rows[k][c] = row[c] * per_diagonal[k];
        }
    }
    for k in 0..BLOCK {
        for c in 0..BLOCK {
            block.0[c * BLOCK + k] = rows[k][c];
        }
    }
    Ok(())
}

struct Factorize<'a>(&'a mut BlockEnvelope);

impl WithSimd for Factorize<'_> {
    type Output = Result<(), usize>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let BlockEnvelope { first, start, blocks, .. } = self.0;
        for i in 0..first.len() {
            let (done, rest) = blocks.split_at_mut(start[i]);
            let row = &mut rest[..=i - first[i]];
            for j in first[i]..i {
                // L_ij = (A_ij - Σ_k L_ik L_jkᵀ) L_jj⁻ᵀ.
                let from = first[i].max(first[j]);
                let (left, here) = row.split_at_mut(j - first[i]);
                let above = &done[start[j] + from - first[j]..start[j + 1]];
                let mut sum = negated(&here[0]);
                multiply_add(simd, &mut sum, &left[from - first[i]..], &above[..j - from], transposed);
                let mut solved = MatrixBlock::ZERO;
                let inverse = &above[j - from..=j - from];
                multiply_add(simd, &mut solved, &[negated(&sum)], inverse, transposed);
                here[0] = solved;
            }
            let (left, diagonal) = row.split_at_mut(i - first[i]);
            let mut sum = negated(&diagonal[0]);
            multiply_add(simd, &mut sum, left, left, transposed);
            diagonal[0] = negated(&sum);
            invert_factor(&mut diagonal[0]).map_err(|k| i * BLOCK + k)?;
        }
        Ok(())
    }
}

struct Solve<'a> {
    envelope: &'a BlockEnvelope,
    x: &'a mut [f32],
}

/// Partial sums of a block row's product: a chain of additions each.
const CHAINS: usize = 4;

/// sums += A x for one block; its columns take turns.
#[inline(always)]
fn multiply_vector<S: Simd, const V: usize>(
    simd: S,
    sums: &mut [[S::f32s; V]; CHAINS],
    a: &MatrixBlock,
    x: &[f32; BLOCK],
) {
    let (a, _) = S::as_simd_f32s(&a.0);
    for k in 0..BLOCK {
        let factor = simd.splat_f32s(x[k]);
        let sum = &mut sums[k % CHAINS];
        for v in 0..V {
            sum[v] = simd.mul_add_e_f32s(a[k * V + v], factor, sum[v]);
        }
    }
}

/// Σ A_iᵀ x_i over blocks of one block column, added to `y`.
#[inline(always)]
fn multiply_transposed<'a, S: Simd, const V: usize, const C: usize>(
    simd: S,
    y: &mut [f32; BLOCK],
    terms: impl Iterator<Item = (&'a MatrixBlock, &'a [f32])> + Clone,
) {
    for column in (0..BLOCK).step_by(C) {
        let mut sums = [[simd.splat_f32s(0.0); V]; C];
        for (a, x) in terms.clone() {
            let (a, _) = S::as_simd_f32s(&a.0);
            let (x, _) = S::as_simd_f32s(x);
            for c in 0..C {
                for v in 0..V {
                    sums[c][v] = simd.mul_add_e_f32s(a[(column + c) * V + v], x[v], sums[c][v]);
                }
            }
        }
        for c in 0..C {
            let mut sum = sums[c][0];
            for v in 1..V {
                sum = simd.add_f32s(sum, sums[c][v]);
            }
            y[column + c] += simd.reduce_sum_f32s(sum);
        }
    }
}

impl Solve<'_> {
    #[inline(always)]
    fn run<S: Simd, const V: usize, const C: usize>(self, simd: S) {
        let Self { envelope, x } = self;
        let n_block_rows = envelope.first.len();
        let store = |sums: [[S::f32s; V]; CHAINS], target: &mut [f32]| {
            let (target, _) = S::as_mut_simd_f32s(target);
            for v in 0..V {
                let [a, b, c, d] = sums.map(|sum| sum[v]);
                target[v] = simd.add_f32s(simd.add_f32s(a, b), simd.add_f32s(c, d));
            }
        };
        let zeros = [[simd.splat_f32s(0.0); V]; CHAINS];
        for i in 0..n_block_rows {
            let (before, here) = x.split_at_mut(i * BLOCK);
            let before = before[envelope.first[i] * BLOCK..].as_chunks::<BLOCK>().0;
            let mut sums = zeros;
            for (block, x) in envelope.row(i).iter().zip(before) {
                multiply_vector(simd, &mut sums, block, x);
            }
            let mut right = [0.0; BLOCK];
            store(sums, &mut right);
            for r in 0..BLOCK {
                right[r] = here[r] - right[r];
            }
            let mut sums = zeros;
            multiply_vector(simd, &mut sums, envelope.block(i, i), &right);
            store(sums, &mut here[..BLOCK]);
        }
        for j in (0..n_block_rows).rev() {
            let (before, after) = x.split_at_mut((j + 1) * BLOCK);
            let terms = (j + 1..=envelope.last[j]).filter(|&i| envelope.first[i] <= j).map(|i| {
                let from = (i - j - 1) * BLOCK;
                (envelope.block(i, j), &after[from..from + BLOCK])
            });
            let mut sum = [0.0; BLOCK];
            multiply_transposed::<S, V, C>(simd, &mut sum, terms);
            let here = &mut before[j * BLOCK..];
            let mut right = [0.0; BLOCK];
            for r in 0..BLOCK {
                right[r] = here[r] - sum[r];
            }
            let mut solved = [0.0; BLOCK];
            let diagonal = std::iter::once((envelope.block(j, j), &right[..]));
            multiply_transposed::<S, V, C>(simd, &mut solved, diagonal);
            here.copy_from_slice(&solved);
        }
    }
}

impl WithSimd for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match S::F32_LANES {
            16 => self.run::<S, 1, 16>(simd),
            8 => self.run::<S, 2, 4>(simd),
            4 => self.run::<S, 4, 2>(simd),
            _ => self.run::<S, 16, 1>(simd),
        }
    }
}

struct SolvePanel<'a> {
    envelope: &'a BlockEnvelope,
    panel: &'a mut [MatrixBlock],
}

impl WithSimd for SolvePanel<'_> {
    type Output = ();

    /// Works on transposed blocks Xᵀ (sides × unknowns): forward X_iᵀ = (B_iᵀ - Σ X_jᵀ L_ijᵀ) L_ii⁻ᵀ,
    /// backward X_jᵀ = (X_jᵀ - Σ X_iᵀ L_ij) L_jj⁻¹.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { envelope, panel } = self;
        let straight = |k: usize, c: usize| c * BLOCK + k;
        for i in 0..panel.len() {
            let (before, here) = panel.split_at_mut(i);
            let mut sum = negated(&here[0]);
            let row = envelope.row(i);
            multiply_add(simd, &mut sum, &before[envelope.first[i]..], &row[..row.len() - 1], transposed);
            here[0] = MatrixBlock::ZERO;
            multiply_add(simd, &mut here[0], &[negated(&sum)], &row[row.len() - 1..], transposed);
        }
        for j in (0..panel.len()).rev() {
            let (before, after) = panel.split_at_mut(j + 1);
            let mut sum = negated(&before[j]);
            for i in j + 1..=envelope.last[j] {
                if envelope.first[i] <= j {
                    let block = std::slice::from_ref(envelope.block(i, j));
                    multiply_add(simd, &mut sum, &after[i - j - 1..i - j], block, straight);
                }
            }
            before[j] = MatrixBlock::ZERO;
            let diagonal = std::slice::from_ref(envelope.block(j, j));
            multiply_add(simd, &mut before[j], &[negated(&sum)], diagonal, straight);
        }
    }
}

#[cfg(test)]
mod tests {
    use hysteron_base::rng;
    use nalgebra::{DMatrix, DVector};
    use rand::RngExt;

    use super::*;

    /// L Lᵀ with L well-conditioned and its rows beginning at random columns: narrow and wide rows follow
    /// each other.
    fn matrix(n: usize) -> (Vec<usize>, DMatrix<f64>) {
        let mut stream = rng(23, &format!("test/envelope/{n}"));
        let first: Vec<usize> = (0..n).map(|i| stream.random_range(0..=i)).collect();
        let mut l = DMatrix::zeros(n, n);
        for (i, &begin) in first.iter().enumerate() {
            for j in begin..i {
                l[(i, j)] = stream.random_range(-0.1..0.1);
            }
            l[(i, i)] = stream.random_range(1.0..2.0);
        }
        (first, &l * l.transpose())
    }

    fn loaded(first: &[usize], a: &DMatrix<f64>) -> BlockEnvelope {
        let mut envelope = BlockEnvelope::new(first);
        let (mut positions, mut values) = (Vec::new(), Vec::new());
        for (i, &begin) in first.iter().enumerate() {
            for j in begin..=i {
                // Nine times the same entry: the load works on whole 3×3 blocks.
                positions.push([envelope.position(i, j) as u32; 9]);
                values.push([[a[(i, j)], a[(i, j)], a[(i, j)], 0.0]; 3]);
            }
        }
        envelope.load(first.len(), &positions, &values);
        envelope
    }

    const SIZES: [usize; 8] = [1, 15, 16, 17, 32, 45, 100, 161];

    #[test]
    fn solutions_match_a_dense_factor() {
        // Condition below 1e2, single precision.
        const TOL: f32 = 1e2 * f32::EPSILON;
        for n in SIZES {
            let (first, a) = matrix(n);
            assert!(n < 15 || first.windows(2).any(|f| f[1] < f[0]), "some row reaches further left");
            let mut stream = rng(29, "test/envelope/sides");
            let sides = DMatrix::from_fn(n, BLOCK, |_, _| stream.random_range(-1.0..1.0));
            let expected = a.clone().cholesky().expect("positive definite").solve(&sides);
            for isa in Isa::all() {
                let mut envelope = loaded(&first, &a);
                assert_eq!(envelope.n_padded(), n.next_multiple_of(BLOCK));
                envelope.factorize(isa).expect("positive definite");
                let mut panel = SolutionPanel::zeros(envelope.n_padded());
                let mut columns: Vec<Vec<f64>> =
                    sides.column_iter().map(|side| side.iter().copied().collect()).collect();
                panel.load(&columns);
                envelope.solve_panel(isa, &mut panel);
                panel.store(&mut columns);
                for side in 0..BLOCK {
                    let mut x: Vec<f32> = sides.column(side).iter().map(|v| *v as f32).collect();
                    x.resize(envelope.n_padded(), 0.0);
                    envelope.solve(isa, &mut x);
                    for row in 0..n {
                        let exact = expected[(row, side)] as f32;
                        assert!((x[row] - exact).abs() < TOL, "{isa:?} n {n}: {} {exact}", x[row]);
                        let of_panel = columns[side][row] as f32;
                        assert!((of_panel - exact).abs() < TOL, "{isa:?} n {n}: {of_panel} {exact}");
                    }
                    assert!(x[n..].iter().all(|v| *v == 0.0));
                }
            }
        }
    }

    #[test]
    fn pivot_that_is_not_positive_is_named() {
        for n in SIZES {
            let (first, a) = matrix(n);
            for bad in [0, n / 2, n - 1] {
                // The leading minors before it stay positive, that with it does not.
                let mut a = a.clone();
                a[(bad, bad)] = -1.0;
                for isa in Isa::all() {
                    assert_eq!(loaded(&first, &a).factorize(isa), Err(bad), "{isa:?} n {n}");
                }
            }
        }
    }

    #[test]
    fn factor_cost_counts_block_products() {
        // Dense, three block rows: (1) + (1 + 2) + (1 + 2 + 3) products of 16³.
        assert_eq!(BlockEnvelope::factor_cost(&[0; 48]), 10.0 * 4096.0);
        // Block diagonal: one each.
        let diagonal: Vec<usize> = (0..48).map(|i| i / 16 * 16).collect();
        assert_eq!(BlockEnvelope::factor_cost(&diagonal), 3.0 * 4096.0);
        let envelope = BlockEnvelope::new(&diagonal);
        assert_eq!(envelope.n_stored(), 3 * 256);
    }

    #[test]
    fn zero_side_stays_zero() {
        let (first, a) = matrix(40);
        let mut envelope = loaded(&first, &a);
        envelope.factorize(Isa::detect()).expect("positive definite");
        let mut x = vec![0.0; envelope.n_padded()];
        envelope.solve(Isa::detect(), &mut x);
        assert_eq!(DVector::from_vec(x).norm(), 0.0);
    }
}
