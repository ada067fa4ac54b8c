//! Quadratic programs, made dimensionless before any solver gets them.
//!
//! That of a step of the twin (CoReAct paper, eq. 4) has bounds only: min ½ xᵀW x - bᵀx with lo <= x <= hi, x the tensions. A small
//! active-set iteration solves it and certifies its own answer; a problem that it cannot certify goes to
//! clarabel, which is also its oracle in the tests. Identification has many variables in boxes and few rows to meet,
//! and solves its dual. The inverse problem has rows as well and is clarabel's alone.

mod active_set;
mod clarabel;
mod dual_newton;

pub use active_set::{Activity, BoxQp};
pub use clarabel::{RowQp, solve_rows};
pub use dual_newton::BoxedRows;

/// Status of a QP after its solve. Only `Solved` may enter a dataset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QpStatus {
    /// The optimality conditions hold.
    Solved,
    /// Clarabel stopped at its reduced accuracy.
    AlmostSolved,
    /// No point satisfies the constraints.
    Infeasible,
    /// No answer.
    Failed,
}

impl std::fmt::Display for QpStatus {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Self::Solved => "solved",
            Self::AlmostSolved => "solved at reduced accuracy only",
            Self::Infeasible => "infeasible",
            Self::Failed => "not solved",
        })
    }
}

/// Which solver answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QpSolver {
    /// The active set, with a verified certificate.
    ActiveSet,
    /// Clarabel.
    Clarabel,
}
