//! Accuracy asked of a step; its cost and convergence.

/// Accuracy of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// Largest force residual, relative to the forces applied by cables and loads [-].
    pub relative_residual: f64,
    /// Largest stroke error [m].
    pub stroke: f64,
}

/// Cost and convergence of a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepReport {
    /// Corrections with the lagged factor.
    pub iterations: usize,
    /// Times the lagged factor was replaced.
    pub refactorisations: usize,
    /// Newton iterations with the exact tangent; zero in the common case.
    pub newton_iterations: usize,
    /// Parts the step was divided into; zero in the common case.
    pub sub_steps: usize,
    /// QPs that the active set did not certify.
    pub clarabel_solves: usize,
    /// Norm of the force residual over that of the applied forces [-].
    pub relative_residual: f64,
    /// Largest stroke error [m].
    pub stroke_error: f64,
    /// Of a chain of condensed sections: how far the largest strain of a section lies beyond those that were validated, over
    /// the largest of these [-]; zero within, and for a mesh.
    pub outside: f64,
}

impl StepReport {
    /// Both steps: the costs of the two, the accuracy of the later one.
    pub(crate) fn followed_by(&self, next: &Self) -> Self {
        Self {
            iterations: self.iterations + next.iterations,
            refactorisations: self.refactorisations + next.refactorisations,
            newton_iterations: self.newton_iterations + next.newton_iterations,
            sub_steps: self.sub_steps + next.sub_steps,
            clarabel_solves: self.clarabel_solves + next.clarabel_solves,
            ..*next
        }
    }
}
