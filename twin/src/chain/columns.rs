//! Response of the body to the cables: J, the columns of K⁻¹ Jᵀ with the factor at hand, and W + C.
//!
//! A cable whose tension is prescribed, as auxiliary ones are, needs no column: it moves the body through its row alone. So
//! columns are made for the cables that a step or a derivative asks for, and W is known where one of a pair has its column.

use hysteron_fem::vectors::{combine_into, dot};

use super::balance::{ChainBalance, Multiply};
use super::band::{BlockSkyline, BlockVector, PanelBlock};
use super::{BLOCK, Chain};

/// Loads on the tip: forces and moments along three axes.
pub(super) const TIP_LOADS: usize = 6;

/// Rows, columns and W; scratch.
#[derive(Debug, Clone)]
pub(super) struct CableColumns {
    /// Rows of J when the factor was made [-].
    rows: Vec<Vec<BlockVector>>,
    /// Columns of K⁻¹ Jᵀ [m/N], where there are any.
    columns: Vec<Vec<BlockVector>>,
    is_solved: Vec<bool>,
    /// W + C, row-major [m/N]: of pairs of which one has its column, and on the diagonal the last that was known.
    pub delassus: Vec<f64>,
    /// The cables that get their column now; scratch.
    new: Vec<usize>,
    /// Pulls of all cables at the parts within sections; scratch.
    pulls: Vec<f64>,
    /// Moves of these parts under one of the pulls; scratch.
    sunk: Vec<f64>,
    pub panel: Vec<PanelBlock>,
    /// A displacement; scratch.
    moved: Vec<BlockVector>,
}

impl CableColumns {
    pub fn new(chain: &Chain) -> Self {
        let (zeros, m) = (vec![[0.0; BLOCK]; chain.n_sections()], chain.cables.len());
        Self {
            rows: vec![zeros.clone(); m],
            columns: vec![zeros.clone(); m],
            is_solved: vec![false; m],
            delassus: vec![0.0; m * m],
            new: Vec::with_capacity(m),
            pulls: Vec::new(),
            sunk: Vec::new(),
            panel: Vec::new(),
            moved: zeros,
        }
    }

    /// Rows at the configuration placed last; the columns of another factor are forgotten.
    pub fn restart(&mut self, chain: &Chain, balance: &mut ChainBalance) {
        for (j, row) in self.rows.iter_mut().enumerate() {
            balance.row_into(chain, j, row);
        }
        self.is_solved.fill(false);
        let m = self.rows.len();
        for (k, entry) in self.delassus.iter_mut().enumerate() {
            if k % (m + 1) != 0 {
                *entry = 0.0;
            }
        }
        balance.local_pulls_into(chain, &mut self.pulls);
    }

    /// True where every cable of `which` has its column.
    pub fn covers(&self, which: impl Fn(usize) -> bool) -> bool {
        self.is_solved.iter().enumerate().all(|(j, is_solved)| *is_solved || !which(j))
    }

    /// Columns of the cables `which`, and their rows of W + C.
    pub fn solve(&mut self, chain: &Chain, factor: &BlockSkyline, which: impl Fn(usize) -> bool) {
        let Self { rows, columns, is_solved, delassus, new, panel, .. } = self;
        let m = rows.len();
        new.clear();
        // Where W_jj is not known yet, it is made so: it scales tensions.
        new.extend((0..m).filter(|&j| !is_solved[j] && (which(j) || delassus[j * (m + 1)] == 0.0)));
        for &j in &*new {
            columns[j].copy_from_slice(&rows[j]);
            is_solved[j] = true;
        }
        factor.solve_many(columns, new, panel);
        for &i in &*new {
            for j in 0..m {
                let w = row_times(chain, rows, j, &columns[i]);
                delassus[i * m + j] = w;
                delassus[j * m + i] = w;
            }
        }
        let is_new = |j: usize| new.binary_search(&j).is_ok();
        for (i, row) in chain.cables.compliance.iter().enumerate() {
            for &(j, compliance) in row.iter().filter(|(j, _)| is_new(i) || is_new(*j)) {
                delassus[i * m + j] += compliance;
            }
        }
        self.add_sinks(chain);
    }

    /// Adds what cable points sink in per tension to the pairs of which one is new.
    fn add_sinks(&mut self, chain: &Chain) {
        let Self { delassus, new, pulls, sunk, rows, .. } = self;
        let m = rows.len();
        let is_new = |j: &usize| new.binary_search(j).is_ok();
        for sink in &chain.sinks {
            let n = 3 * sink.parts.len();
            sunk.resize(n, 0.0);
            for &(i, at) in sink.cables.iter().filter(|(i, _)| is_new(i)) {
                chain.isa.run(Multiply { matrix: &sink.compliance, x: &pulls[at..][..n], y: sunk });
                for &(j, at) in &sink.cables {
                    let w = dot(chain.isa, sunk, &pulls[at..][..n]);
                    delassus[i * m + j] += w;
                    if !is_new(&j) {
                        delassus[j * m + i] += w;
                    }
                }
            }
        }
    }

    /// Row j of J times a displacement [m].
    pub fn row_times(&self, chain: &Chain, j: usize, displacement: &[BlockVector]) -> f64 {
        row_times(chain, &self.rows, j, displacement)
    }

    /// Adds K⁻¹ Jᵀ times tension increments [N] to `step` [m].
    pub fn move_by(&mut self, chain: &Chain, factor: &BlockSkyline, increments: &[f64], step: &mut [f64]) {
        let mut is_free = true;
        for (j, increment) in increments.iter().enumerate().filter(|(_, increment)| **increment != 0.0) {
            if self.is_solved[j] {
                combine_into(chain.isa, &[*increment], &[self.columns[j].as_flattened()], step);
                continue;
            }
            if std::mem::take(&mut is_free) {
                self.moved.fill([0.0; BLOCK]);
            }
            let blocks = chain.reach[j].blocks.clone();
            let (row, moved) = (&self.rows[j][blocks.clone()], &mut self.moved[blocks]);
            combine_into(chain.isa, &[*increment], &[row.as_flattened()], moved.as_flattened_mut());
        }
        if !is_free {
            factor.solve(&mut self.moved);
            combine_into(chain.isa, &[1.0], &[self.moved.as_flattened()], step);
        }
    }
}

/// Row j of J times a displacement; its entries are zero beyond the interfaces of the cable.
fn row_times(chain: &Chain, rows: &[Vec<BlockVector>], j: usize, displacement: &[BlockVector]) -> f64 {
    let blocks = chain.reach[j].blocks.clone();
    dot(chain.isa, rows[j][blocks.clone()].as_flattened(), displacement[blocks].as_flattened())
}
