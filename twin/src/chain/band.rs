//! Symmetric block skyline matrices and their factor K = L D Lᵀ, in blocks of a fixed size.
//!
//! Blocks of the upper triangle are kept, column by column: block (j, i) of column i is stored by its rows, so that every
//! inner loop runs along a row. No pivoting: the tangent of a loaded chain may be indefinite, and the number of negative
//! pivots is that of its negative eigenvalues.
//!
//! # Reference
//! Golub, Van Loan (2013), Matrix Computations, sec. 4.1 (L D Lᵀ) and 4.3 (band systems).

use hysteron_base::lanes::{Isa, LANES, Lanes, Pack, Packs, Simd, WithSimd};

use super::BLOCK;

/// A block of numbers, by rows.
pub(crate) type Block = [[f64; BLOCK]; BLOCK];
/// A vector over one block.
pub(crate) type BlockVector = [f64; BLOCK];

/// As many vectors over one block as a register holds, side by side.
pub(crate) type PanelBlock = [Pack; BLOCK];

/// Zero block.
pub(crate) const ZERO: Block = [[0.0; BLOCK]; BLOCK];

/// A matrix, or its factor.
#[derive(Debug, Clone)]
pub(crate) struct BlockSkyline {
    isa: Isa,
    /// First block row of each block column.
    first: Vec<usize>,
    /// Where each block column begins in `blocks`.
    starts: Vec<usize>,
    blocks: Vec<Block>,
    /// 1 / D of a factor.
    inverse: Vec<BlockVector>,
}

impl BlockSkyline {
    /// Zeros, with the given first block row of each block column.
    pub fn zeros(isa: Isa, first: Vec<usize>) -> Self {
        let mut starts = Vec::with_capacity(first.len());
        let mut count = 0;
        for (column, first) in first.iter().enumerate() {
            starts.push(count);
            count += column + 1 - first;
        }
        Self { isa, inverse: vec![[0.0; BLOCK]; first.len()], blocks: vec![ZERO; count], first, starts }
    }

    /// Sets all numbers to zero.
    pub fn clear(&mut self) {
        self.blocks.fill(ZERO);
    }

    fn index(&self, row: usize, column: usize) -> usize {
        self.starts[column] + row - self.first[column]
    }

    /// Block (row, column) of the upper triangle, row <= column, within the skyline.
    pub fn block(&mut self, row: usize, column: usize) -> &mut Block {
        let index = self.index(row, column);
        &mut self.blocks[index]
    }

    /// Block rows of a block column within the skyline, down to the diagonal.
    #[cfg(test)]
    pub fn rows_of(&self, column: usize) -> std::ops::RangeInclusive<usize> {
        self.first[column]..=column
    }

    /// Replaces the matrix by its factor; the number of negative pivots, or `None` at one that is zero or no number.
    pub fn factorize(&mut self) -> Option<usize> {
        let mut negative = 0;
        for column in 0..self.first.len() {
            for row in self.first[column]..=column {
                let from = self.first[row].max(self.first[column]);
                for k in from..row {
                    self.eliminate(k, row, column);
                }
                if row < column {
                    self.substitute(row, column);
                }
            }
            negative += self.factorize_diagonal(column)?;
        }
        Some(negative)
    }

    /// Block (row, column) -= Uᵀ D⁻¹ U of block row k.
    fn eliminate(&mut self, k: usize, row: usize, column: usize) {
        let target = self.index(row, column);
        let (left, right) = (self.index(k, row), self.index(k, column));
        let mut sum = self.blocks[target];
        // Off the diagonal the left block is already divided by its pivots, on it the two are the same.
        let scale = if row == column { self.inverse[k] } else { [1.0; BLOCK] };
        self.isa.run(Eliminate {
            left: &self.blocks[left],
            right: &self.blocks[right],
            scale: &scale,
            sum: &mut sum,
        });
        self.blocks[target] = sum;
    }

    /// Block (row, column) of the column in work becomes L⁻¹ times itself, L of the diagonal block of `row`.
    fn substitute(&mut self, row: usize, column: usize) {
        let (diagonal, target) = (self.index(row, row), self.index(row, column));
        let factor = self.blocks[diagonal];
        self.isa.run(Substitute { factor: &factor, block: &mut self.blocks[target] });
    }

    /// Factorises the diagonal block of a column whose other blocks are done, and divides those by their pivots.
    fn factorize_diagonal(&mut self, column: usize) -> Option<usize> {
        let index = self.index(column, column);
        let diagonal = Diagonal { block: &mut self.blocks[index], inverse: &mut self.inverse[column] };
        let negative = self.isa.run(diagonal)?;
        for k in self.first[column]..column {
            let index = self.index(k, column);
            for (line, inverse) in self.blocks[index].iter_mut().zip(&self.inverse[k]) {
                for number in line {
                    *number *= inverse;
                }
            }
        }
        Some(negative)
    }

    /// Replaces `x` by K⁻¹ x; only after [`Self::factorize`].
    pub fn solve(&self, x: &mut [BlockVector]) {
        self.isa.run(BandSolve { factor: self, x });
    }

    /// Replaces each of `columns` by K⁻¹ times itself, as many at a time as a register holds; `panel` is scratch.
    pub fn solve_many(&self, columns: &mut [Vec<BlockVector>], panel: &mut Vec<PanelBlock>) {
        panel.resize(self.first.len(), [Pack([0.0; LANES]); BLOCK]);
        for columns in columns.chunks_mut(LANES) {
            for (lane, column) in columns.iter().enumerate() {
                for (panel, number) in panel.as_flattened_mut().iter_mut().zip(column.as_flattened()) {
                    panel.0[lane] = *number;
                }
            }
            self.isa.run(PanelSolve { factor: self, x: panel });
            for (lane, column) in columns.iter_mut().enumerate() {
                for (panel, number) in panel.as_flattened().iter().zip(column.as_flattened_mut()) {
                    *number = panel.0[lane];
                }
            }
        }
    }

    /// The lanes of one pass of a panel.
    #[inline(always)]
    fn substitute_panel<S: Simd>(&self, packs: Packs<S>, x: &mut [PanelBlock]) {
        for column in 0..x.len() {
            let (before, from) = x.split_at_mut(column);
            for row in self.first[column]..column {
                let block = &self.blocks[self.index(row, column)];
                subtract_product::<S, true>(packs, block, &before[row], &mut from[0]);
            }
            let diagonal = &self.blocks[self.index(column, column)];
            let mut sum = from[0].each_ref().map(|pack| packs.load(pack));
            for s in 0..BLOCK {
                for t in s + 1..BLOCK {
                    sum[t] = sum[s].mul_add(packs.splat(-diagonal[s][t]), sum[t]);
                }
            }
            store(packs, sum, &mut from[0]);
        }
        for (x, inverse) in x.iter_mut().zip(&self.inverse) {
            for (x, inverse) in x.iter_mut().zip(inverse) {
                packs.store(packs.load(x) * packs.splat(*inverse), x);
            }
        }
        for column in (0..x.len()).rev() {
            let (before, from) = x.split_at_mut(column);
            let diagonal = &self.blocks[self.index(column, column)];
            let mut solved = from[0].each_ref().map(|pack| packs.load(pack));
            for t in (0..BLOCK).rev() {
                for s in 0..t {
                    solved[s] = solved[t].mul_add(packs.splat(-diagonal[s][t]), solved[s]);
                }
            }
            store(packs, solved, &mut from[0]);
            for row in self.first[column]..column {
                let block = &self.blocks[self.index(row, column)];
                subtract_product::<S, false>(packs, block, &from[0], &mut before[row]);
            }
        }
    }

    #[inline(always)]
    fn substitute_all(&self, x: &mut [BlockVector]) {
        for column in 0..x.len() {
            let mut sum = x[column];
            for row in self.first[column]..column {
                let block = &self.blocks[self.index(row, column)];
                for t in 0..BLOCK {
                    for r in 0..BLOCK {
                        sum[r] -= block[t][r] * x[row][t];
                    }
                }
            }
            let diagonal = &self.blocks[self.index(column, column)];
            for s in 0..BLOCK {
                for t in s + 1..BLOCK {
                    sum[t] -= diagonal[s][t] * sum[s];
                }
            }
            x[column] = sum;
        }
        for (x, inverse) in x.iter_mut().zip(&self.inverse) {
            for t in 0..BLOCK {
                x[t] *= inverse[t];
            }
        }
        for column in (0..x.len()).rev() {
            let mut solved = x[column];
            let diagonal = &self.blocks[self.index(column, column)];
            for s in (0..BLOCK).rev() {
                let known: f64 = (s + 1..BLOCK).map(|t| diagonal[s][t] * solved[t]).sum();
                solved[s] -= known;
            }
            x[column] = solved;
            for row in self.first[column]..column {
                let block = &self.blocks[self.index(row, column)];
                for t in 0..BLOCK {
                    let mut products = [0.0; BLOCK];
                    for r in 0..BLOCK {
                        products[r] = block[t][r] * solved[r];
                    }
                    x[row][t] -= products.iter().sum::<f64>();
                }
            }
        }
    }
}

// No closures: one that is not inlined is compiled by itself, without the instruction set that the dispatch chose.

struct Eliminate<'a> {
    left: &'a Block,
    right: &'a Block,
    scale: &'a BlockVector,
    sum: &'a mut Block,
}

impl WithSimd for Eliminate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for s in 0..BLOCK {
            let mut line = self.sum[s];
            for t in 0..BLOCK {
                let factor = self.left[t][s] * self.scale[t];
                for r in 0..BLOCK {
                    line[r] -= factor * self.right[t][r];
                }
            }
            self.sum[s] = line;
        }
    }
}

struct Substitute<'a> {
    factor: &'a Block,
    block: &'a mut Block,
}

impl WithSimd for Substitute<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for t in 1..BLOCK {
            let mut line = self.block[t];
            for s in 0..t {
                for r in 0..BLOCK {
                    line[r] -= self.factor[s][t] * self.block[s][r];
                }
            }
            self.block[t] = line;
        }
    }
}

struct Diagonal<'a> {
    block: &'a mut Block,
    inverse: &'a mut BlockVector,
}

impl WithSimd for Diagonal<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Option<usize> {
        let mut negative = 0;
        for s in 0..BLOCK {
            let pivot = self.block[s][s];
            if pivot == 0.0 || !pivot.is_finite() {
                return None;
            }
            negative += usize::from(pivot < 0.0);
            let inverse = 1.0 / pivot;
            self.inverse[s] = inverse;
            let line = self.block[s];
            for t in s + 1..BLOCK {
                let factor = line[t] * inverse;
                // Left of the diagonal are numbers that nothing reads.
                for r in 0..BLOCK {
                    self.block[t][r] -= factor * line[r];
                }
                self.block[s][t] = factor;
            }
        }
        Some(negative)
    }
}

struct BandSolve<'a> {
    factor: &'a BlockSkyline,
    x: &'a mut [BlockVector],
}

impl WithSimd for BandSolve<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        self.factor.substitute_all(self.x);
    }
}

struct PanelSolve<'a> {
    factor: &'a BlockSkyline,
    x: &'a mut [PanelBlock],
}

impl WithSimd for PanelSolve<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for pass in 0..Packs::<S>::PASSES {
            self.factor.substitute_panel(Packs::new(simd, pass), self.x);
        }
    }
}

/// Rows of a product whose sums stay in registers.
const TILE: usize = 8;

/// `sum` -= B `x`, or Bᵀ `x`.
#[inline(always)]
fn subtract_product<S: Simd, const TRANSPOSED: bool>(
    packs: Packs<S>,
    block: &Block,
    x: &PanelBlock,
    sum: &mut PanelBlock,
) {
    for first in (0..BLOCK).step_by(TILE) {
        let mut sums: [Lanes<S>; TILE] = std::array::from_fn(|r| packs.load(&sum[first + r]));
        for t in 0..BLOCK {
            let x = packs.load(&x[t]);
            for r in 0..TILE {
                let entry = if TRANSPOSED { block[t][first + r] } else { block[first + r][t] };
                sums[r] = x.mul_add(packs.splat(-entry), sums[r]);
            }
        }
        for r in 0..TILE {
            packs.store(sums[r], &mut sum[first + r]);
        }
    }
}

#[inline(always)]
fn store<S: Simd>(packs: Packs<S>, lanes: [Lanes<S>; BLOCK], block: &mut PanelBlock) {
    for (lanes, pack) in lanes.into_iter().zip(block) {
        packs.store(lanes, pack);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use rand::RngExt;

    use super::*;

    /// A random symmetric matrix with two negative eigenvalues a block, and the same as a dense one.
    fn indefinite(first: &[usize]) -> (BlockSkyline, DMatrix<f64>) {
        let mut rng = hysteron_base::rng(1, "band");
        let mut matrix = BlockSkyline::zeros(Isa::detect(), first.to_vec());
        let mut dense = DMatrix::zeros(BLOCK * first.len(), BLOCK * first.len());
        for column in 0..first.len() {
            for row in first[column]..=column {
                let mut full: Block =
                    std::array::from_fn(|_| std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
                if row == column {
                    let random = full;
                    for s in 0..BLOCK {
                        for t in 0..BLOCK {
                            full[s][t] = random[s][t] + random[t][s];
                        }
                        // Diagonally dominant.
                        full[s][s] = if s < 2 { -90.0 } else { 90.0 };
                    }
                }
                *matrix.block(row, column) = full;
                for s in 0..BLOCK {
                    for t in 0..BLOCK {
                        dense[(BLOCK * row + s, BLOCK * column + t)] = full[s][t];
                        dense[(BLOCK * column + t, BLOCK * row + s)] = full[s][t];
                    }
                }
            }
        }
        (matrix, dense)
    }

    #[test]
    fn factor_solves_as_a_dense_one_and_counts_negative_eigenvalues() {
        let first = vec![0, 0, 0, 1, 3, 2];
        let (mut matrix, dense) = indefinite(&first);
        let mut rng = hysteron_base::rng(2, "band");
        let mut x: Vec<BlockVector> =
            (0..first.len()).map(|_| std::array::from_fn(|_| rng.random_range(-1.0..1.0))).collect();
        let right = DVector::from_row_slice(x.as_flattened());
        let expected = dense.clone().lu().solve(&right).expect("a regular matrix");
        let negative = dense.symmetric_eigenvalues().iter().filter(|value| **value < 0.0).count();
        assert_eq!((matrix.factorize(), negative), (Some(negative), 2 * first.len()));
        // More than one panel, the last of them not full.
        let mut many: Vec<Vec<BlockVector>> = (0..LANES + 3).map(|_| x.clone()).collect();
        many[LANES + 1][2][5] += 1.0;
        matrix.solve(&mut x);
        for isa in Isa::all() {
            let mut many = many.clone();
            BlockSkyline { isa, ..matrix.clone() }.solve_many(&mut many, &mut Vec::new());
            let difference = |column: &Vec<BlockVector>| {
                let pairs = column.as_flattened().iter().zip(x.as_flattened());
                pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            for (j, column) in many.iter().enumerate() {
                assert_eq!(difference(column) < 1e-15, j != LANES + 1, "{j}");
            }
        }
        for (solved, expected) in x.as_flattened().iter().zip(&expected) {
            // Round-off of a matrix with condition numbers of about three.
            assert!((solved - expected).abs() < 1e-15, "{solved} and {expected}");
        }
        assert!(expected.amax() > 5e-3, "a solution that tests nothing");
        matrix.clear();
        assert_eq!(matrix.factorize(), None);
    }
}
