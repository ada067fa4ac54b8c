//! `study convergence`: one tube, finer and finer. The response of linear and quadratic tetrahedra to the same pull, with tendons that
//! hold on to points, which sink into ever smaller elements, and to rings of a given size, which do not.

mod outcome;
mod page;
mod run;

pub use outcome::MeshResolution;
pub use run::run;
