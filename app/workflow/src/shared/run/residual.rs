//! A run with the residual network: it drives the auxiliary tendons, and what it did is recorded.

use hysteron_base::{BadInput, Channel};
use hysteron_twin::residual::CorrectedRollout;
use hysteron_twin::{Plant, PlantStep, Twin, TwinState};

use crate::shared::network::Network;

/// A closed-loop rollout and its trace.
pub struct Residual<'a> {
    rollout: CorrectedRollout<'a>,
    /// Virtual strokes, by tendon [m].
    strokes: Vec<Vec<f64>>,
    /// 1 where the network left its training range.
    extrapolating: Vec<f64>,
}

impl<'a> Residual<'a> {
    /// From rest, for samples `step` [s] apart.
    pub fn new(network: &'a Network, twin: &'a Twin, step: f64) -> Result<Self, BadInput> {
        let strokes = vec![Vec::new(); network.n_aux()];
        Ok(Self { rollout: network.rollout(twin, step)?, strokes, extrapolating: Vec::new() })
    }

    /// Goes on by one sample and leaves the equilibrium in `state`.
    pub fn step(&mut self, primary: &[f64], state: &mut TwinState) -> hysteron_twin::Result<PlantStep> {
        let step = self.rollout.step(primary)?;
        state.clone_from(self.rollout.state());
        for (column, stroke) in self.strokes.iter_mut().zip(self.rollout.strokes()) {
            column.push(*stroke);
        }
        self.extrapolating.push(f64::from(u8::from(step.is_extrapolating)));
        Ok(step)
    }

    /// Part of the samples in which the network left its training range [-].
    pub fn extrapolated(&self) -> f64 {
        self.extrapolating.iter().sum::<f64>() / self.extrapolating.len().max(1) as f64
    }

    /// Channels recorded next to the twin's motion: `aux_kk_m` and `extrapolating`, the first `n` samples.
    pub fn into_channels(self, n: usize) -> Vec<Channel> {
        let first = |mut values: Vec<f64>| {
            values.truncate(n);
            values
        };
        let aux = |(k, values): (usize, Vec<f64>)| Channel::new(format!("aux_{:02}_m", k + 1), first(values));
        let mut channels: Vec<Channel> = self.strokes.into_iter().enumerate().map(aux).collect();
        channels.push(Channel::new("extrapolating", first(self.extrapolating)));
        channels
    }
}
