//! A configuration of a chain as one of the twin that it stands for.

use nalgebra::Vector3;

use super::body::{Chain, ChainState};
use super::stepper::ChainStepper;
use crate::model::Twin;
use crate::state::TwinState;

impl Chain {
    /// Copies tensions and memory of friction into a state of the twin; its nodes stay where they are.
    pub fn copy_tensions(&self, state: &ChainState, out: &mut TwinState) {
        out.tensions.clone_from(&state.tensions);
        out.load = state.load;
        out.slip.clone_from(&state.slip);
        out.backlash.clone_from(&state.backlash);
    }

    /// Moves the nodes of the twin with the frames of the interfaces on both sides, weighted by their distances. For pictures:
    /// warping is left out, so that no forces can be computed from it.
    pub fn move_nodes(&self, twin: &Twin, state: &ChainState, out: &mut TwinState) {
        let free = twin.body.rest.iter().zip(&mut out.positions).take(twin.body.n_free);
        for (rest, position) in free {
            let place = Vector3::new(rest[0], rest[1], rest[2]);
            let (e, part) = self.between(&place);
            let moved = |k: usize| -> Vector3<f64> {
                let arm = place - self.rest[k].center;
                state.interfaces[k].center + state.interfaces[k].rotation * arm
            };
            let at = (1.0 - part) * moved(e) + part * moved(e + 1);
            position[..3].copy_from_slice(at.as_slice());
        }
    }

    /// The section in which a place lies at rest, and how far along it [-].
    fn between(&self, place: &Vector3<f64>) -> (usize, f64) {
        let along = |e: usize| {
            let (from, to) = (self.rest[e].center, self.rest[e + 1].center);
            (place - from).dot(&(to - from)) / (to - from).norm_squared()
        };
        let last = self.n_sections() - 1;
        let e = (0..last).find(|e| along(*e) < 1.0).unwrap_or(last);
        (e, along(e).clamp(0.0, 1.0))
    }
}

impl ChainStepper {
    /// The stroke that a servo shows for every tendon [m], as [`Twin::commands_of`].
    pub fn commands(&self, twin: &Twin) -> Vec<f64> {
        (0..twin.tendons.len()).map(|j| self.pulled(twin, j) - twin.tendons[j].zero).collect()
    }
}

#[cfg(test)]
mod tests {
    use hysteron_base::MaterialLaw;
    use hysteron_fem::Order;

    use super::*;
    use crate::chain::Interface;
    use crate::coreact::distance;
    use crate::{Target, scenes};

    #[test]
    fn nodes_and_commands_are_nearly_those_of_the_finite_elements() {
        let (mut scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, 24);
        scenes::roughen(&mut scene, 1e-4);
        scene.tendons[0].zero = 2e-4;
        let twin = Twin::new(&scene, &mesh).expect("a good scene");
        let chain = Chain::new(&twin).expect("a chain");
        let (mut fine, mut coarse) = (crate::Stepper::new(&twin), ChainStepper::new(&twin, &chain));
        let targets = [3e-3, 0.0, -3e-3, 0.0].map(Target::Stroke);
        for part in [0.25, 0.5, 0.75, 1.0] {
            let targets = targets.map(|target| match target {
                Target::Stroke(stroke) => Target::Stroke(part * stroke),
                other => other,
            });
            fine.step(&twin, &targets).expect("an equilibrium");
            coarse.step(&twin, &chain, &targets).expect("an equilibrium");
        }
        let mut shown = twin.rest();
        chain.copy_tensions(coarse.state(), &mut shown);
        chain.move_nodes(&twin, coarse.state(), &mut shown);
        // The mean of an interface has no warping, which pictures leave out.
        let mean = |positions: &[[f64; 4]], interface: &Interface| -> [f64; 3] {
            let on = |node: &[f64; 4]| (node[2] - interface.center.z).abs() < 1e-9;
            let there = twin.body.rest.iter().zip(positions).filter(|(rest, _)| on(rest)).map(|(_, at)| at);
            let n = there.clone().count() as f64;
            std::array::from_fn(|c| there.clone().map(|at| at[c]).sum::<f64>() / n)
        };
        let far = |a: &[[f64; 4]], b: &[[f64; 4]]| {
            let apart = |interface| distance(mean(a, interface), mean(b, interface));
            chain.rest[1..].iter().map(apart).fold(0.0, f64::max)
        };
        let moved = far(&fine.state().positions, &twin.body.rest);
        let error = far(&fine.state().positions, &shown.positions);
        // As in `validation`: what the chain leaves out is of fourth order.
        assert!(moved > 5e-3 && error < 1e-3 * moved, "{error} of {moved} m");
        for (own, other) in coarse.commands(&twin).iter().zip(twin.commands_of(fine.state())) {
            assert!((own - other).abs() < 1e-2 * 2e-3, "{own} for {other}");
        }
        assert!((coarse.commands(&twin)[0] - 3e-3).abs() < 1e-6);
        assert_eq!(shown.slip.len(), fine.state().slip.len());
    }
}
