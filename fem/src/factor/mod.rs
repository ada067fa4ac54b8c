//! Factorised stiffness: solves K u = f again and again.
//!
//! Symbolic work is done once per pattern, numbers are replaced in place. Two kinds share one
//! interface: the own single-precision block envelope, fastest for slender bodies of a few thousand
//! unknowns and exact enough to precondition, and faer's supernodal Cholesky in double precision, for
//! exact compliances and for bodies whose envelope grows too wide.

mod envelope;
mod supernodal;

use envelope::EnvelopeFactor;
use supernodal::SupernodalFactor;

use crate::Result;
use crate::simd::Isa;
use crate::stiffness::{Stiffness, StiffnessPattern};

/// Which factorisation to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FactorKind {
    /// Block envelope, single precision: an approximate inverse.
    Envelope,
    /// faer's supernodal Cholesky, double precision.
    Supernodal,
}

impl FactorKind {
    /// The faster of the two for repeated approximate solves with this pattern.
    ///
    /// A solve streams the stored numbers; the envelope has more of them, but half as wide and without
    /// indices: on tubes it is three times ahead. Single precision leaves an error that grows with the
    /// condition number, a few per cent at the widest rows accepted here and useless far beyond.
    pub fn fastest(pattern: &StiffnessPattern) -> Self {
        const WIDEST_ROW: f64 = 700.0;
        if EnvelopeFactor::mean_row(pattern) <= WIDEST_ROW { Self::Envelope } else { Self::Supernodal }
    }
}

/// A factor and its scratch.
#[derive(Debug, Clone)]
pub struct StiffnessFactor(FactorStorage);

#[derive(Debug, Clone)]
enum FactorStorage {
    Envelope(EnvelopeFactor),
    Supernodal(SupernodalFactor),
}

impl StiffnessFactor {
    /// Does the symbolic work for matrices of this pattern; holds no numbers yet.
    pub fn new(pattern: &StiffnessPattern, kind: FactorKind, isa: Isa) -> Self {
        Self(match kind {
            FactorKind::Envelope => FactorStorage::Envelope(EnvelopeFactor::new(pattern, isa)),
            FactorKind::Supernodal => FactorStorage::Supernodal(SupernodalFactor::new(pattern)),
        })
    }

    /// The kind in use.
    pub fn kind(&self) -> FactorKind {
        match &self.0 {
            FactorStorage::Envelope(_) => FactorKind::Envelope,
            FactorStorage::Supernodal(_) => FactorKind::Supernodal,
        }
    }

    /// Numbers stored for the factor.
    pub fn n_stored(&self) -> usize {
        match &self.0 {
            FactorStorage::Envelope(factor) => factor.n_stored(),
            FactorStorage::Supernodal(factor) => factor.n_stored(),
        }
    }

    /// Replaces the numbers.
    ///
    /// # Errors
    /// [`crate::Error::NotPositiveDefinite`]; the factor must then not be used.
    pub fn factorize(&mut self, stiffness: &Stiffness) -> Result<()> {
        match &mut self.0 {
            FactorStorage::Envelope(factor) => factor.factorize(stiffness),
            FactorStorage::Supernodal(factor) => factor.factorize(stiffness),
        }
    }

    /// Replaces the numbers by those of a matrix that need not be positive definite, K = L D Lᵀ without
    /// pivoting, and returns how many of its eigenvalues are negative.
    ///
    /// # Errors
    /// [`crate::Error::NotPositiveDefinite`] at a zero pivot; from the envelope at one that is not positive.
    pub fn factorize_signed(&mut self, stiffness: &Stiffness) -> Result<usize> {
        match &mut self.0 {
            FactorStorage::Envelope(factor) => factor.factorize(stiffness).map(|()| 0),
            FactorStorage::Supernodal(factor) => factor.factorize_signed(stiffness),
        }
    }

    /// Replaces the force `x` \[N\] by the displacement K⁻¹ x \[m\] of the free unknowns.
    pub fn solve(&mut self, x: &mut [f64]) {
        match &mut self.0 {
            FactorStorage::Envelope(factor) => factor.solve(x),
            FactorStorage::Supernodal(factor) => factor.solve(x),
        }
    }

    /// As [`Self::solve`] for several right-hand sides at once.
    pub fn solve_many(&mut self, columns: &mut [Vec<f64>]) {
        match &mut self.0 {
            FactorStorage::Envelope(factor) => factor.solve_many(columns),
            FactorStorage::Supernodal(factor) => factor.solve_many(columns),
        }
    }
}

/// The advice for a matrix without a factor.
const HINT: &str = "the body is held in too few points, or compressed until it buckles";
