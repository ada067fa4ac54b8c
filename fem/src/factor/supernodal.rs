//! faer's sparse Cholesky as a stiffness factor. The only module that names faer.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::{LdltError, LdltRegularization};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::prelude::*;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLdltRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat, SymbolicSparseColMatRef};
use faer::{Conj, Mat, Par, Side};

use super::HINT;
use crate::stiffness::{Stiffness, StiffnessPattern};
use crate::{Error, Result};

pub(super) struct SupernodalFactor {
    n: usize,
    /// Upper triangle by columns: the lower triangle by rows.
    pattern: SymbolicSparseColMat<usize>,
    /// Index into the flattened blocks of each entry of `pattern`.
    sources: Vec<u32>,
    values: Vec<f64>,
    symbolic: std::sync::Arc<SymbolicCholesky<usize>>,
    factor: Vec<f64>,
    /// Form of the factorisation in `factor`.
    form: SupernodeForm,
    scratch: MemBuffer,
}

#[derive(Debug, Clone, Copy)]
enum SupernodeForm {
    /// L of L Lᵀ.
    Positive,
    /// L and D of L D Lᵀ.
    Signed,
}

impl std::fmt::Debug for SupernodalFactor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SupernodalFactor").field("n", &self.n).finish_non_exhaustive()
    }
}

impl Clone for SupernodalFactor {
    fn clone(&self) -> Self {
        Self {
            n: self.n,
            pattern: self.pattern.clone(),
            sources: self.sources.clone(),
            values: self.values.clone(),
            symbolic: self.symbolic.clone(),
            factor: self.factor.clone(),
            form: self.form,
            scratch: scratch(&self.symbolic, 1),
        }
    }
}

/// Room for a factorisation, or for a solve with that many right-hand sides.
fn scratch(symbolic: &SymbolicCholesky<usize>, n_sides: usize) -> MemBuffer {
    let factorize = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
    MemBuffer::new(factorize.or(symbolic.solve_in_place_scratch::<f64>(n_sides, Par::Seq)))
}

/// Numbers that the model's own order may store beyond those of minimum degree and still be faster: its
/// supernodes are longer. Measured on tubes, linear and quadratic (`bench`, `factor/faer/…`): 12 % faster
/// with 5 % more numbers, 10 % slower with 30 % more.
const WORTH_KEEPING: f64 = 1.1;

/// Symbolic factor in the model's own order or by approximate minimum degree.
fn cheaper_ordering(pattern: SymbolicSparseColMatRef<'_, usize>) -> SymbolicCholesky<usize> {
    let [own, minimum_degree] = [SymmetricOrdering::Identity, SymmetricOrdering::Amd].map(|ordering| {
        factorize_symbolic_cholesky(pattern, Side::Upper, ordering, CholeskySymbolicParams::default())
            .unwrap_or_else(|error| {
                panic!("no memory for a factor of {} unknowns: {error:?}", pattern.nrows())
            })
    });
    if own.len_val() as f64 <= WORTH_KEEPING * minimum_degree.len_val() as f64 { own } else { minimum_degree }
}

impl SupernodalFactor {
    pub fn new(pattern: &StiffnessPattern) -> Self {
        let n = 3 * pattern.n_free();
        let mut starts = vec![0; n + 1];
        let mut rows = Vec::new();
        let mut sources = Vec::new();
        for (row, column, index) in pattern.scalar_entries() {
            rows.push(column);
            sources.push(index as u32);
            starts[row + 1] = rows.len();
        }
        let pattern = SymbolicSparseColMat::new_checked(n, n, starts, None, rows);
        let symbolic = cheaper_ordering(pattern.rb());
        let factor = vec![0.0; symbolic.len_val()];
        let scratch = scratch(&symbolic, 1);
        let values = vec![0.0; sources.len()];
        Self {
            n,
            pattern,
            sources,
            values,
            symbolic: symbolic.into(),
            factor,
            form: SupernodeForm::Positive,
            scratch,
        }
    }

    pub fn n_stored(&self) -> usize {
        self.factor.len()
    }

    pub fn factorize(&mut self, stiffness: &Stiffness) -> Result<()> {
        self.gather(stiffness);
        self.form = SupernodeForm::Positive;
        let result = self.symbolic.factorize_numeric_llt(
            &mut self.factor,
            SparseColMatRef::new(self.pattern.rb(), &self.values),
            Side::Upper,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Default::default(),
        );
        match result {
            Ok(_) => Ok(()),
            Err(faer::linalg::cholesky::llt::factor::LltError::NonPositivePivot { index }) => {
                // faer counts pivots from one.
                Err(Error::NotPositiveDefinite {
                    unknown: index.saturating_sub(1),
                    n_unknowns: self.n,
                    hint: HINT,
                })
            }
        }
    }

    fn gather(&mut self, stiffness: &Stiffness) {
        let blocks = stiffness.blocks.as_flattened().as_flattened();
        for (value, source) in self.values.iter_mut().zip(&self.sources) {
            *value = blocks[*source as usize];
        }
    }

    /// L D Lᵀ without pivoting; returns the number of negative pivots.
    pub fn factorize_signed(&mut self, stiffness: &Stiffness) -> Result<usize> {
        self.gather(stiffness);
        self.form = SupernodeForm::Signed;
        let request = self.symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default());
        let result = self.symbolic.factorize_numeric_ldlt(
            &mut self.factor,
            SparseColMatRef::new(self.pattern.rb(), &self.values),
            Side::Upper,
            LdltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(request)),
            Default::default(),
        );
        match result {
            Ok(_) => Ok(self.n_negative_pivots()),
            Err(LdltError::ZeroPivot { index }) => {
                // faer counts pivots from one.
                Err(Error::NotPositiveDefinite {
                    unknown: index.saturating_sub(1),
                    n_unknowns: self.n,
                    hint: HINT,
                })
            }
        }
    }

    /// Negative entries of D, which is stored on the diagonal of the unit lower triangle.
    fn n_negative_pivots(&self) -> usize {
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(symbolic) => {
                let starts = symbolic.col_ptr();
                (0..self.n).filter(|&j| self.factor[starts[j]] < 0.0).count()
            }
            SymbolicCholeskyRaw::Supernodal(symbolic) => {
                let factor = SupernodalLdltRef::new(symbolic, &self.factor);
                let negative = |s: usize| {
                    let block = factor.supernode(s).val();
                    (0..block.ncols()).filter(|&k| block[(k, k)] < 0.0).count()
                };
                (0..symbolic.n_supernodes()).map(negative).sum()
            }
        }
    }

    fn solve_in_place(&self, sides: faer::MatMut<'_, f64>, stack: &mut MemStack) {
        match self.form {
            SupernodeForm::Positive => {
                LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
                    Conj::No,
                    sides,
                    Par::Seq,
                    stack,
                );
            }
            SupernodeForm::Signed => {
                LdltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
                    Conj::No,
                    sides,
                    Par::Seq,
                    stack,
                );
            }
        }
    }

    pub fn solve(&mut self, x: &mut [f64]) {
        let mut scratch = std::mem::replace(&mut self.scratch, MemBuffer::new(StackReq::EMPTY));
        let sides = faer::MatMut::from_column_major_slice_mut(x, self.n, 1);
        self.solve_in_place(sides, MemStack::new(&mut scratch));
        self.scratch = scratch;
    }

    pub fn solve_many(&mut self, columns: &mut [Vec<f64>]) {
        let mut sides = Mat::from_fn(self.n, columns.len(), |i, j| columns[j][i]);
        let request = self.symbolic.solve_in_place_scratch::<f64>(columns.len(), Par::Seq);
        self.solve_in_place(sides.as_mut(), MemStack::new(&mut MemBuffer::new(request)));
        for (j, column) in columns.iter_mut().enumerate() {
            for (i, value) in column.iter_mut().enumerate() {
                *value = sides[(i, j)];
            }
        }
    }
}
