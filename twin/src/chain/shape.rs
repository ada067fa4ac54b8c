//! A configuration of a chain as one of the twin that it stands for.

use hysteron_fem::FemModel;
use nalgebra::Vector3;

use super::balance::ChainBalance;
use super::body::Chain;
use super::section::StrainedPose;
use crate::cable::CableShape;
use crate::state::TwinState;

impl Chain {
    /// Position of the tip, in the frame of the scene [m].
    pub(crate) fn tip_of(&self, state: &TwinState) -> [f64; 3] {
        let mut at = self.tip.offset;
        for &(part, weight) in &self.tip.parts {
            let part = &self.parts[part as usize];
            let e = part.site.section();
            let pose = StrainedPose::new(&state.interfaces[e], &state.interfaces[e + 1], &self.laws[e].rest);
            let deformed = |c: usize| part.shape[c].iter().zip(&pose.strain).map(|(a, b)| a * b).sum::<f64>();
            let lever = part.arm + Vector3::from_fn(|c, _| deformed(c));
            at += weight * part.at(&pose, &state.interfaces, &lever);
        }
        at.into()
    }

    /// Largest strain of a section [-], as validations measure it.
    pub(crate) fn strain_of(&self, state: &TwinState) -> f64 {
        let pairs = state.interfaces.windows(2).zip(&self.laws);
        let strains = pairs.map(|(pair, law)| {
            let strain = StrainedPose::new(&pair[0], &pair[1], &law.rest).strain;
            law.stress(self.isa, &strain).size
        });
        strains.fold(0.0, f64::max)
    }

    /// Points and strokes of the cables.
    pub(crate) fn shape_of(&self, state: &TwinState) -> CableShape {
        let mut balance = ChainBalance::new(self);
        balance.settle(self, &state.interfaces, &state.tensions);
        balance.shape
    }

    /// Nodes of the finite elements, moved with the frames of the interfaces on both sides, weighted by their distances. For
    /// pictures: warping is left out, so that no forces can be computed from them.
    pub(crate) fn nodes_of(&self, body: &FemModel, state: &TwinState) -> Vec<[f64; 4]> {
        let mut nodes = body.rest.clone();
        for position in &mut nodes[..body.n_free] {
            let place = Vector3::new(position[0], position[1], position[2]);
            let (e, part) = self.between(&place);
            let moved = |k: usize| -> Vector3<f64> {
                let arm = place - self.rest[k].center;
                state.interfaces[k].center + state.interfaces[k].rotation * arm
            };
            let at = (1.0 - part) * moved(e) + part * moved(e + 1);
            position[..3].copy_from_slice(at.as_slice());
        }
        nodes
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

#[cfg(test)]
mod tests {
    use hysteron_base::MaterialLaw;
    use hysteron_fem::Order;

    use super::*;
    use crate::chain::Interface;
    use crate::coreact::distance;
    use crate::{Stepper, Target, Twin, scenes};

    #[test]
    fn nodes_and_commands_are_nearly_those_of_the_finite_elements() {
        let (mut scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, 24);
        scenes::roughen(&mut scene, 1e-4);
        scene.tendons[0].zero = 2e-4;
        let twin = Twin::new(&scene, &mesh).expect("a good scene");
        let chain = Chain::new(&twin).expect("a chain");
        let reduced = twin.clone().with_chain(chain.clone());
        let (mut fine, mut coarse) = (Stepper::new(&twin), Stepper::new(&reduced));
        let targets = [3e-3, 0.0, -3e-3, 0.0].map(Target::Stroke);
        for part in [0.25, 0.5, 0.75, 1.0] {
            let targets = targets.map(|target| match target {
                Target::Stroke(stroke) => Target::Stroke(part * stroke),
                other => other,
            });
            fine.step(&twin, &targets).expect("an equilibrium");
            coarse.step(&reduced, &targets).expect("an equilibrium");
        }
        let shown = reduced.nodes_of(coarse.state());
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
        let error = far(&fine.state().positions, &shown);
        // As in `validation`: what the chain leaves out is of fourth order.
        assert!(moved > 5e-3 && error < 1e-3 * moved, "{error} of {moved} m");
        for (own, other) in coarse.commands(&reduced).iter().zip(twin.commands_of(fine.state())) {
            assert!((own - other).abs() < 1e-2 * 2e-3, "{own} for {other}");
        }
        for (own, other) in coarse.commands(&reduced).iter().zip(reduced.commands_of(coarse.state())) {
            // Points sink in up to a twentieth of the accuracy of strokes.
            assert!((own - other).abs() < twin.accuracy.stroke, "{own} for {other}");
        }
        assert!((coarse.commands(&reduced)[0] - 3e-3).abs() < 1e-6);
        let strain = chain.strain_of(coarse.state());
        // A bend by some 30 degrees in 40 mm: 6 mm times the curvature is a strain of a twelfth at the surface.
        assert!((0.01..0.1).contains(&strain), "{strain}");
    }
}
