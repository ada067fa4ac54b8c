//! Steps of a chain made again by the finite elements that it stands for: how far the chain is off, where it is used.

use crate::Result;
use crate::coreact::distance;
use crate::error::Error;
use crate::model::{Target, Twin};
use crate::state::TwinState;
use crate::stepper::Stepper;
use hysteron_base::PrescribedQuantity;

/// The finite elements of a twin that a chain moves.
#[derive(Debug, Clone)]
pub struct ExactSteps {
    twin: Twin,
    stepper: Stepper,
}

/// How far a chain is off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChainError {
    /// Distance of the tips [m].
    pub tip: f64,
    /// Largest difference between the tensions of a tendon [N].
    pub tension: f64,
}

impl ExactSteps {
    /// Of a twin; one without a chain is exact itself.
    pub fn new(twin: &Twin) -> Self {
        let twin = twin.clone().without_chain();
        Self { stepper: Stepper::new(&twin), twin }
    }

    /// Error of the step of `reduced` from the equilibrium `before` to `after`, in which its servos show `commands` [m]: the
    /// finite elements start where the chain has come to, with the friction that it had before. `None` where they find no
    /// equilibrium there.
    ///
    /// # Errors
    /// States of another robot.
    pub fn error_of(
        &mut self,
        reduced: &Twin,
        (before, after): (&TwinState, &TwinState),
        commands: &[f64],
    ) -> Result<Option<ChainError>> {
        let start = TwinState {
            positions: reduced.nodes_of(after).into_owned(),
            interfaces: Vec::new(),
            // Of these are the bounds of friction with which a step begins.
            tensions: before.tensions.clone(),
            load: after.load,
            slip: before.slip.clone(),
            // Servos that are told where the tendons follow them leave the backlash where it is.
            backlash: after.backlash.clone(),
        };
        self.stepper.restore(&self.twin, &start)?;
        let target = |j: usize| {
            let (tendon, tension) = (&reduced.tendons[j], after.tensions[j]);
            let keeps_stroke = j < reduced.n_primary && tendon.drive == PrescribedQuantity::Stroke;
            // A slack tendon shows where it would be taut, not what was commanded.
            if keeps_stroke && tension > tendon.tension.min {
                Target::Stroke(commands[j])
            } else {
                Target::Tension(tension)
            }
        };
        let targets: Vec<Target> = (0..reduced.tendons.len()).map(target).collect();
        match self.stepper.step(&self.twin, &targets) {
            Ok(_) => (),
            Err(Error::NoEquilibrium { .. }) => return Ok(None),
            Err(error) => return Err(error),
        }
        let exact = self.stepper.state();
        let tensions = exact.tensions.iter().zip(&after.tensions).take(reduced.tendons.len());
        Ok(Some(ChainError {
            tip: distance(self.twin.tip_of(exact), reduced.tip_of(after)),
            tension: tensions.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max),
        }))
    }
}

#[cfg(test)]
mod tests {
    use hysteron_base::MaterialLaw;
    use hysteron_fem::Order;

    use super::*;
    use crate::chain::Chain;
    use crate::{Accuracy, scenes};

    /// Errors over the way there and back, and those of the two side by side, over the tip's displacement [-]; tensions in N.
    fn errors(is_rough: bool) -> Vec<(f64, f64, f64)> {
        let (mut scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, 24);
        if is_rough {
            scenes::roughen(&mut scene, 1e-4);
        }
        let mut twin = Twin::new(&scene, &mesh).expect("a good scene");
        twin.accuracy = Accuracy { relative_residual: 1e-8, stroke: 1e-11 };
        let reduced = twin.clone().with_chain(Chain::new(&twin).expect("a chain"));
        let (mut fine, mut coarse) = (Stepper::new(&twin), Stepper::new(&reduced));
        let mut exact = ExactSteps::new(&reduced);
        let error = |k: i32| {
            let part = if k <= 25 { f64::from(k) } else { f64::from(50 - k) };
            let targets = [1e-4, 2e-5, -1e-4, 0.0].map(|stroke| Target::Stroke(part * stroke));
            let before = coarse.state().clone();
            fine.step(&twin, &targets).expect("an equilibrium");
            coarse.step(&reduced, &targets).expect("an equilibrium");
            let commands = coarse.commands(&reduced);
            let states = (&before, coarse.state());
            let error =
                exact.error_of(&reduced, states, &commands).expect("its states").expect("there is one");
            let tip = twin.tip_of(fine.state());
            let moved = distance(tip, twin.tip_of(&twin.rest()));
            let apart = distance(tip, reduced.tip_of(coarse.state()));
            (error.tip / moved, apart / moved, error.tension)
        };
        (1..=40).map(error).collect()
    }

    #[test]
    fn errors_are_those_of_the_finite_elements_beside_the_chain() {
        for (own, apart, tension) in errors(false) {
            // Bending is some hundred times as soft as stretching: of residuals of 1e-8 of the forces, both bodies.
            assert!((own - apart).abs() < 5e-6, "{own} and {apart}");
            assert!(own > 0.0 && own < 1e-3 && tension < 0.05, "{own}, {tension} N");
        }
        for (own, apart, tension) in errors(true) {
            // Bounds of friction lag by up to a tenth; friction takes some percent of the way here.
            assert!((own - apart).abs() < 5e-3, "{own} and {apart}");
            assert!(own > 0.0 && tension < 0.05, "{own}, {tension} N");
        }
    }
}
