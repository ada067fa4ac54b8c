//! `study sorosim`: five hundred static shapes of a loaded rod, compared with the rod solver SoRoSim.
//!
//! The rod has a circular section and hangs from a clamp: gravity, a wrench at mid-length and one at the tip, all
//! fixed in space. Its body here is a solid prism of quadratic tetrahedra whose polygonal section has the second
//! moment of area of the circle; the density makes up for the area. Wrenches are spread over the sections as uniform
//! tractions and as couples that keep their direction in space. Only the centre line is compared: the reference
//! has no torsion.

mod outcome;
mod page;
mod run;

pub use outcome::{ErrorStatistics, RodResolution, StationErrors};
pub use run::run;
