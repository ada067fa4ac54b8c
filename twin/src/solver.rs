//! The body of a step, be it finite elements or a chain of sections that stands for them.

use crate::cable::CableShape;
use crate::equilibrium_residual::StepTargets;
use crate::error::Cause;
use crate::model::Twin;
use crate::report::StepReport;
use crate::state::TwinState;
use crate::{Error, Result};

/// Forces and strokes at the configuration evaluated last.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Balance<'a> {
    pub shape: &'a CableShape,
    /// Missing stroke of each cable, u - s - C T [m]; zero where the tension is prescribed.
    pub stroke_residual: &'a [f64],
    /// Norm of the residual over that of the applied forces [-].
    pub relative: f64,
    /// Largest violated stroke condition [m].
    pub violation: f64,
}

/// Which motion of the tip is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TipMotion {
    /// Its displacement.
    Displacement,
    /// Its rotation too.
    Pose,
}

/// Response of the cables and of the tip to tensions.
#[derive(Debug, Clone)]
pub(crate) struct TensionResponse {
    /// W + C, row-major n_cables × n_cables, symmetric [m/N].
    pub delassus: Vec<f64>,
    /// Displacement of the recorded tip by unit tensions, three rows [m/N], one column per cable.
    pub tip: [Vec<f64>; 3],
    /// Rotation vector of the recorded tip, in space, alike [rad/N]; where it was asked for.
    pub turn: Option<[Vec<f64>; 3]>,
}

/// Derivatives of the recorded tip, one row per coordinate, some cables keeping their strokes and the others their tensions.
#[derive(Debug, Clone)]
pub(crate) struct TipDerivatives {
    /// By the tension of each cable that does not keep its stroke (n_cables) [m/N].
    pub per_tension: [Vec<f64>; 3],
    /// By the stroke of each cable that does (n_held) [-].
    pub per_stroke: [Vec<f64>; 3],
    /// By a force on the tip [m/N].
    pub per_force: [[f64; 3]; 3],
}

/// Where an iteration ended without an equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stuck {
    /// Norm of the residual over that of the applied forces [-].
    pub relative_residual: f64,
    pub cause: Cause,
}

/// Iterations to the equilibrium of a body, and its derivatives there; scratch.
pub(crate) trait BodySolver {
    /// Of the configuration evaluated last.
    fn balance(&self) -> Balance<'_>;

    /// Evaluates forces and strokes at `state`.
    fn evaluate(&mut self, twin: &Twin, control: &StepTargets, state: &TwinState);

    /// Evaluates strokes alone.
    fn measure(&mut self, twin: &Twin, control: &StepTargets, state: &TwinState);

    /// Forgets factor and history: the state has jumped.
    fn reset(&mut self);

    /// The fast iteration, with the factor and history at hand; where it fails, `state` is left anywhere.
    fn iterate(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        state: &mut TwinState,
        report: &mut StepReport,
    ) -> std::result::Result<(), Cause>;

    /// Newton's method, with the exact tangent of every iteration, over `length` of a step [-]; where it fails, `state` is left
    /// anywhere.
    fn newton(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        state: &mut TwinState,
        length: f64,
        report: &mut StepReport,
    ) -> std::result::Result<(), Stuck>;

    /// Response to tensions at `state`, for which strokes were evaluated, with the factor in use or a new one: approximate.
    /// `None` without a factor.
    fn response(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        state: &TwinState,
        tip: TipMotion,
    ) -> Option<TensionResponse>;

    /// W + C of the exact tangent, row-major n_cables × n_cables [m/N], at `state`.
    ///
    /// # Errors
    /// The tangent is singular.
    fn delassus(&mut self, twin: &Twin, control: &StepTargets, state: &TwinState) -> Result<&[f64]>;

    /// Derivatives of the tip at the equilibrium `state` of `control`, cables `held` keeping their strokes. `None` where two of
    /// them pull the same way, or without a solution.
    fn tip_derivatives(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        state: &TwinState,
        held: &[usize],
    ) -> Option<TipDerivatives>;

    /// How far the configuration evaluated last lies beyond those that were validated [-].
    fn outside(&self) -> f64;

    /// Advice where there is no equilibrium.
    fn hint(&self) -> &'static str;
}

/// No tangent at an equilibrium.
pub(crate) fn singular(relative_residual: f64) -> Error {
    let hint = "the body can move without force here".into();
    Error::NoEquilibrium { reached: 1.0, relative_residual, cause: Cause::NoFactor, hint }
}
