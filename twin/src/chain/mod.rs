//! The twin of a slender body as a chain of condensed sections.
//!
//! The body is cut across its axis by interfaces. An interface has a frame and [`WARPINGS`] amplitudes of displacements that no
//! rigid motion makes; between two interfaces lies a section, whose elastic energy is a quadratic and cubic function of an
//! objective strain of [`STRAIN`] numbers: a geometrically exact rod whose section law, warping included, is condensed from the
//! finite elements. Nothing is trained: the law is the third-order expansion of the finite-element energy about rest.
//!
//! Files in reading order: `rotation`, `section` (strain, its variations), `cubic`, `band` (the factor), `cut` and `warping` (where
//! interfaces lie and how they deform), `condense` (the law of a section), `body` and `make` (the whole chain), `balance` and `tangent`
//! (residual of an equilibrium and its derivative), `solver`
//! and `response` (of tip and cables), `shape` (as the twin sees it), `errors` and `validation` (against the finite elements), `file`.
//!
//! # References
//! Simo, Vu-Quoc (1986), A three-dimensional finite-strain rod model, part II; Craig, Bampton (1968), Coupling of
//! substructures for dynamic analyses (condensation onto interfaces); Wigner (1935), the 2n + 1 rule of perturbation
//! theory: first-order inner displacements give an energy that is exact to third order.

mod balance;
mod band;
mod body;
mod condense;
mod continuation;
mod cubic;
mod cut;
mod errors;
mod file;
mod make;
mod response;
mod rotation;
mod section;
mod shape;
mod solver;
mod tangent;
mod validation;
mod warping;

pub use body::Chain;
pub use errors::{ErrorSpread, Validation};
pub use section::Interface;
pub(crate) use solver::ChainSolver;
pub use validation::{Equilibrium, ValidationOptions};

#[cfg(test)]
mod tests;

/// Amplitudes of warping of an interface.
pub const WARPINGS: usize = 10;
/// Numbers of a rigid motion.
const POSE: usize = 6;
/// Unknowns of an interface: displacement, rotation, warping.
const BLOCK: usize = POSE + WARPINGS;
/// Numbers of a section's strain: stretch and shear, curvature, the warping of both interfaces.
pub const STRAIN: usize = POSE + 2 * WARPINGS;
/// The same, padded to whole registers.
const PADDED: usize = STRAIN.next_multiple_of(hysteron_base::lanes::LANES);

/// A strain or a stress of a section; the numbers from [`STRAIN`] on are zero.
type Strain = [f64; PADDED];
