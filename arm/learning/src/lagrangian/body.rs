//! A learned model as the dynamics that observers and controllers ask for.

use std::ops::Range;

use hysteron_base::BadInput;

use super::LearnedDynamics;
use super::block::{SampleBlock, Term};
use super::network::TermKind;
use super::structured::StructuredLagrangian;
use hysteron_arm_estimation::observer::Dynamics;

/// Learned mass matrix and potential, with what else the model learned of a motion, in double precision.
///
/// Friction (6) belongs to every torque of a motion, and so does the network of (8); where no acceleration is asked for, that one is taken
/// without acceleration. Nothing allocates after the first call.
pub struct LearnedBody {
    parameters: Vec<f64>,
    energies: (Range<usize>, StructuredLagrangian<f64>),
    others: Vec<(Range<usize>, Box<dyn Term<f64>>)>,
    block: SampleBlock<f64>,
    zeros: Vec<f64>,
    unit: Vec<f64>,
    part: Vec<f64>,
}

impl LearnedDynamics {
    /// The model as the dynamics of an observer or a controller.
    ///
    /// # Errors
    /// `BadInput` for models without a mass matrix of their own.
    pub fn body(&self) -> Result<LearnedBody, BadInput> {
        let (shape, layout) = (&self.shape, self.shape.layout());
        let [(TermKind::StructuredLagrangian, range), others @ ..] = &layout[..] else {
            let expected = "a model with a mass matrix of velocities";
            return Err(BadInput::new("model", expected, shape.variant.label())
                .hint("structured-lagrangian, friction and augmented have one"));
        };
        let n = shape.n_joints();
        let mut energies = shape.structured();
        energies.prepare(&self.parameters[range.clone()]);
        let other = |(kind, range): &(TermKind, Range<usize>)| {
            let mut term = shape.term(*kind);
            term.prepare(&self.parameters[range.clone()]);
            (range.clone(), term)
        };
        Ok(LearnedBody {
            parameters: self.parameters.clone(),
            energies: (range.clone(), energies),
            others: others.iter().map(other).collect(),
            block: SampleBlock::new(shape.features()),
            zeros: vec![0.0; n],
            unit: vec![0.0; n],
            part: vec![0.0; n],
        })
    }
}

impl LearnedBody {
    /// Torques of the energies alone, at the block that is set.
    fn of_energies(&mut self, torque: &mut [f64]) {
        let (range, energies) = &mut self.energies;
        energies.outputs(&self.parameters[range.clone()], &self.block, torque);
    }

    /// Adds `sign` times those of the other terms.
    fn add_others(&mut self, sign: f64, torque: &mut [f64]) {
        for (range, term) in &mut self.others {
            term.outputs(&self.parameters[range.clone()], &self.block, &mut self.part);
            torque.iter_mut().zip(&self.part).for_each(|(sum, v)| *sum += sign * v);
        }
    }
}

impl Dynamics for LearnedBody {
    fn n_joints(&self) -> usize {
        self.zeros.len()
    }

    fn gravity(&mut self, q: &[f64], torque: &mut [f64]) {
        self.block.gather([q, &self.zeros, &self.zeros], 0..1);
        self.of_energies(torque);
    }

    fn bias(&mut self, q: &[f64], dq: &[f64], torque: &mut [f64]) {
        self.block.gather([q, dq, &self.zeros], 0..1);
        self.of_energies(torque);
        self.add_others(1.0, torque);
    }

    fn inverse(&mut self, q: &[f64], dq: &[f64], ddq: &[f64], torque: &mut [f64]) {
        self.block.gather([q, dq, ddq], 0..1);
        self.of_energies(torque);
        self.add_others(1.0, torque);
    }

    fn mass(&mut self, q: &[f64], mass: &mut [f64]) {
        let n = self.n_joints();
        for j in 0..n {
            // M is symmetric: a column is a row.
            self.unit.fill(0.0);
            self.unit[j] = 1.0;
            self.block.gather([q, &self.unit, &self.zeros], 0..1);
            let (range, energies) = &mut self.energies;
            let parameters = &self.parameters[range.clone()];
            energies.momentum(parameters, &self.block, &mut mass[n * j..n * (j + 1)], &mut self.part);
        }
    }

    fn momentum(&mut self, q: &[f64], dq: &[f64], momentum: &mut [f64], rate: &mut [f64]) {
        self.block.gather([q, dq, &self.zeros], 0..1);
        let (range, energies) = &mut self.energies;
        energies.momentum(&self.parameters[range.clone()], &self.block, momentum, rate);
        self.add_others(-1.0, rate);
    }
}
