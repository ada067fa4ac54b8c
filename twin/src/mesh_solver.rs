//! Finite elements as the body of a step.

use crate::Result;
use crate::adjoint::tip_adjoints;
use crate::equilibrium_residual::{EquilibriumResidual, StepTargets};
use crate::error::Cause;
use crate::model::Twin;
use crate::newton::{Newton, StepSearch};
use crate::quasi_newton::QuasiNewton;
use crate::report::StepReport;
use crate::solver::{Balance, BodySolver, Stuck, TensionResponse, TipDerivatives, TipMotion};
use crate::state::TwinState;

/// Largest part of a step that is tried with damping: on a larger one, a smaller one is cheaper.
const MAX_DAMPED_STEP_LENGTH: f64 = 1.0 / 16.0;

/// Both iterations of the finite elements; scratch.
#[derive(Debug, Clone)]
pub(crate) struct MeshSolver {
    balance: EquilibriumResidual,
    pub quasi_newton: QuasiNewton,
    /// Made when first needed.
    newton: Option<Box<Newton>>,
    /// Where a damped search begins again.
    before: TwinState,
}

impl MeshSolver {
    pub fn new(twin: &Twin) -> Self {
        Self {
            balance: EquilibriumResidual::new(twin),
            quasi_newton: QuasiNewton::new(twin),
            newton: None,
            before: TwinState::default(),
        }
    }

    /// Displacements of the free unknowns per tension of each cable, K⁻¹ Jᵀ of the exact tangent at `state` [m/N].
    ///
    /// # Errors
    /// The tangent is singular.
    pub fn columns(&mut self, twin: &Twin, control: &StepTargets, state: &TwinState) -> Result<&[Vec<f64>]> {
        self.linearise(twin, control, state).map(|newton| &newton.projection.columns[..])
    }

    /// The exact tangent at `state`.
    fn linearise(&mut self, twin: &Twin, control: &StepTargets, state: &TwinState) -> Result<&Newton> {
        self.evaluate(twin, control, state);
        let newton = self.newton.get_or_insert_with(|| Box::new(Newton::new(twin)));
        newton.linearise(twin, state, &self.balance, StepSearch::Full)?;
        Ok(newton)
    }
}

impl BodySolver for MeshSolver {
    fn balance(&self) -> Balance<'_> {
        let EquilibriumResidual { shape, stroke_residual, relative, violation, .. } = &self.balance;
        Balance { shape, stroke_residual, relative: *relative, violation: *violation }
    }

    fn evaluate(&mut self, twin: &Twin, control: &StepTargets, state: &TwinState) {
        self.balance.evaluate(twin, control, &state.positions, &state.tensions);
    }

    fn measure(&mut self, twin: &Twin, control: &StepTargets, state: &TwinState) {
        self.balance.evaluate_strokes(twin, control, &state.positions, &state.tensions);
    }

    fn reset(&mut self) {
        self.quasi_newton.reset();
    }

    fn iterate(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        state: &mut TwinState,
        report: &mut StepReport,
    ) -> std::result::Result<(), Cause> {
        self.quasi_newton.run(twin, control, state, &mut self.balance, report)
    }

    fn newton(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        state: &mut TwinState,
        length: f64,
        report: &mut StepReport,
    ) -> std::result::Result<(), Stuck> {
        let Self { balance, newton, before, .. } = self;
        let newton = newton.get_or_insert_with(|| Box::new(Newton::new(twin)));
        before.clone_from(state);
        let found = newton.run(twin, control, state, balance, StepSearch::Full, report);
        if found.is_ok() || length > MAX_DAMPED_STEP_LENGTH {
            return found;
        }
        state.clone_from(before);
        newton.run(twin, control, state, balance, StepSearch::Damped, report)
    }

    fn response(
        &mut self,
        twin: &Twin,
        _: &StepTargets,
        state: &TwinState,
        tip: TipMotion,
    ) -> Option<TensionResponse> {
        let projection = self.quasi_newton.projection(twin, state, &self.balance)?;
        Some(TensionResponse {
            delassus: projection.delassus.clone(),
            tip: twin.tip_displacement_rows(projection),
            turn: (tip == TipMotion::Pose).then(|| twin.tip_rotation_rows(projection, state)),
        })
    }

    fn delassus(&mut self, twin: &Twin, control: &StepTargets, state: &TwinState) -> Result<&[f64]> {
        self.linearise(twin, control, state).map(|newton| &newton.projection.delassus[..])
    }

    fn tip_derivatives(
        &mut self,
        twin: &Twin,
        control: &StepTargets,
        state: &TwinState,
        held: &[usize],
    ) -> Option<TipDerivatives> {
        let adjoints = tip_adjoints(twin, control, state, held, &mut self.quasi_newton)?;
        self.measure(twin, control, state);
        let shape = &self.balance.shape;
        let per_force =
            twin.tip_displacements(adjoints.each_ref().map(|adjoint| adjoint.of_force.as_slice()));
        let per_tension = adjoints.each_ref().map(|adjoint| {
            (0..twin.cables.len()).map(|j| twin.cables.row_times(shape, j, &adjoint.of_force)).collect()
        });
        Some(TipDerivatives { per_tension, per_stroke: adjoints.map(|adjoint| adjoint.of_stroke), per_force })
    }

    fn outside(&self) -> f64 {
        0.0
    }

    fn hint(&self) -> &'static str {
        "reduce the stroke, raise the tension bounds, or use a finer or quadratic mesh"
    }
}
