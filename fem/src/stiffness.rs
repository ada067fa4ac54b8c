//! The stiffness matrix: 3×3 blocks of the lower triangle in a fixed sparsity pattern.

use std::sync::Arc;

use sprs::CsMatI;

use crate::elements::{ElementBatch, PairMap};
use crate::ordering::adjacency;

/// Which node pairs of a model couple, and where each element adds its blocks. Never changes.
#[derive(Debug, Clone)]
pub struct StiffnessPattern {
    /// Lower triangle of the free nodes, one entry per 3×3 block, rows sorted by column.
    pub(crate) lower: CsMatI<u8, u32, u32>,
    pub(crate) pairs: PairMap,
}

impl StiffnessPattern {
    pub(crate) fn new<const N: usize, const Q: usize>(
        n_free: usize,
        elements: &ElementBatch<N, Q>,
        cliques: &[Vec<u32>],
    ) -> Self {
        let free = |nodes: Vec<u32>| nodes.into_iter().filter(|&node| (node as usize) < n_free).collect();
        let of_elements = elements.nodes.iter().flat_map(|batch| {
            (0..crate::simd::LANES).map(|lane| free(batch.iter().map(|nodes| nodes[lane]).collect()))
        });
        let graph = adjacency(n_free, of_elements.chain(cliques.iter().cloned().map(free)));
        let lower = lower_triangle(&graph);
        let mut pattern = Self { lower, pairs: PairMap { slots: Vec::new() } };
        for batch in &elements.nodes {
            for a in 0..N {
                for b in 0..=a {
                    let slots = std::array::from_fn(|lane| {
                        let (a, b) = (batch[a][lane], batch[b][lane]);
                        let transposed = if a < b { PairMap::TRANSPOSED } else { 0 };
                        pattern
                            .slot(a.max(b) as usize, a.min(b) as usize)
                            .map_or(PairMap::SKIP, |slot| slot as u32 | transposed)
                    });
                    pattern.pairs.slots.push(slots);
                }
            }
        }
        pattern
    }

    /// Number of free nodes.
    pub fn n_free(&self) -> usize {
        self.lower.rows()
    }

    /// Number of stored 3×3 blocks.
    pub fn n_blocks(&self) -> usize {
        self.lower.nnz()
    }

    /// Index of the block of free nodes (row, column), row >= column; `None` where the pattern has none.
    pub fn slot(&self, row: usize, column: usize) -> Option<usize> {
        if row >= self.n_free() {
            return None;
        }
        self.lower.nnz_index(row, column).map(|index| index.0)
    }

    /// First column of every row of the scalar matrix's lower triangle.
    pub(crate) fn first_columns(&self) -> Vec<usize> {
        let rows = self.lower.outer_iterator();
        rows.flat_map(|row| [3 * row.indices()[0] as usize; 3]).collect()
    }

    /// Scalar entries of the lower triangle, row by row: (row, column, index into the flattened blocks).
    pub(crate) fn scalar_entries(&self) -> impl Iterator<Item = (usize, usize, usize)> + '_ {
        (0..3 * self.n_free()).flat_map(move |row| {
            let (node, i) = (row / 3, row % 3);
            let slots = self.lower.indptr().outer_inds_sz(node);
            slots.flat_map(move |slot| {
                let column = self.lower.indices()[slot] as usize;
                (0..3)
                    .filter(move |&j| column < node || j <= i)
                    .map(move |j| (row, 3 * column + j, 12 * slot + 4 * i + j))
            })
        })
    }
}

fn lower_triangle(graph: &CsMatI<u8, u32, u32>) -> CsMatI<u8, u32, u32> {
    let mut starts = vec![0];
    let mut columns = Vec::new();
    for (row, neighbours) in graph.outer_iterator().enumerate() {
        columns.extend(neighbours.indices().iter().copied().filter(|&column| column as usize <= row));
        starts.push(columns.len() as u32);
    }
    let values = vec![0; columns.len()];
    CsMatI::new((graph.rows(), graph.cols()), starts, columns, values)
}

/// Values of a stiffness matrix.
#[derive(Debug, Clone)]
pub struct Stiffness {
    /// Positions of the blocks.
    pub pattern: Arc<StiffnessPattern>,
    /// One 3×3 block \[N/m\] per entry of the pattern; rows are padded to four numbers.
    pub blocks: Vec<[[f64; 4]; 3]>,
}

impl Stiffness {
    /// Zeros in the given pattern.
    pub fn zeros(pattern: Arc<StiffnessPattern>) -> Self {
        let blocks = vec![[[0.0; 4]; 3]; pattern.n_blocks()];
        Self { pattern, blocks }
    }

    /// Becomes (1 - share) `a` + share `b`; all three have the same pattern.
    pub fn set_mixture(&mut self, a: &Self, b: &Self, share: f64) {
        let parts = a.blocks.as_flattened().iter().zip(b.blocks.as_flattened());
        for (mixed, (a, b)) in self.blocks.as_flattened_mut().iter_mut().zip(parts) {
            for c in 0..4 {
                mixed[c] = a[c] + share * (b[c] - a[c]);
            }
        }
    }

    /// y = K x for vectors of the free unknowns.
    pub fn multiply_into(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        let values = self.blocks.as_flattened().as_flattened();
        for (row, column, index) in self.pattern.scalar_entries() {
            y[row] += values[index] * x[column];
            if row != column {
                y[column] += values[index] * x[row];
            }
        }
    }
}
