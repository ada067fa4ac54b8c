//! One arm in time, with dry friction that holds exactly, joint limits, and joints that follow others.

use crate::{ArmStepper, EndStops, ExternalForce, Integrator, Model};

/// Advances the state of an arm by a fixed time, with friction and stops: [`Integrator::WithFriction`] without a way back.
#[derive(Debug, Clone)]
pub struct Simulator<'m> {
    model: &'m Model,
    stepper: ArmStepper<f64>,
    tape: Vec<f64>,
}

impl<'m> Simulator<'m> {
    /// Steps of `period` [s], each in `substeps` equal parts.
    pub fn new(model: &'m Model, period: f64, substeps: usize, stops: EndStops) -> Self {
        let stepper = ArmStepper::new(model, Integrator::WithFriction(stops), (period, substeps), 0, 0.0);
        Self { model, stepper, tape: Vec::with_capacity(2 * substeps * model.n_joints()) }
    }

    /// Advances `q`, `dq` by one period under constant torques and external forces. Joints that follow others are put where these
    /// lead them.
    pub fn step(&mut self, state: [&mut [f64]; 2], tau: &[f64], external: &[ExternalForce<f64>]) {
        self.stepper.step(self.model, state, tau, external, &mut self.tape);
        self.tape.clear();
    }
}
