//! Chooses by the model: an actuator, or inverse dynamics.

use hysteron_arm_learning::neural::NeuralActuator;
use hysteron_learn::read_parameters_kind;

use super::{Options, Outcome, actuator, inverse_dynamics};
use crate::{Context, WorkflowError, arm};

/// Runs the verb.
///
/// # Errors
/// Bad input; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(evaluate(options, context)?)
}

fn evaluate(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    arm::refuse_robot(&options.model, "a model by hysteron arm fit", "--robot takes the robot")?;
    if read_parameters_kind(&options.model)? == NeuralActuator::KIND {
        Ok(Outcome::Actuator(Box::new(actuator::evaluate(options, context)?)))
    } else {
        Ok(Outcome::InverseDynamics(inverse_dynamics::evaluate(options, context)?))
    }
}
