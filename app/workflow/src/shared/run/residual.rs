//! Trace of a residual network along a run, for its recording: auxiliary strokes, where it extrapolated, and the band about the tip.

use hysteron_base::Channel;
use hysteron_twin::command::CommandStep;

use super::band::TIP_BAND;

/// Strokes that a network commanded, sample by sample.
pub struct ResidualTrace {
    /// Virtual strokes, by tendon [m].
    strokes: Vec<Vec<f64>>,
    /// 1 where the network left its training range.
    extrapolating: Vec<f64>,
    /// Radius of the band about the tip [m]; empty without one.
    band: Vec<f64>,
}

impl ResidualTrace {
    /// An empty trace of a network that drives `n_aux` tendons.
    pub fn new(n_aux: usize) -> Self {
        Self { strokes: vec![Vec::new(); n_aux], extrapolating: Vec::new(), band: Vec::new() }
    }

    /// Adds a sample: its auxiliary strokes (n_aux) [m].
    pub fn push(&mut self, strokes: &[f64], step: &CommandStep) {
        for (column, stroke) in self.strokes.iter_mut().zip(strokes) {
            column.push(*stroke);
        }
        self.extrapolating.push(f64::from(u8::from(step.is_extrapolating)));
        self.band.extend(step.tip_band);
    }

    /// Part of the samples in which the network left its training range [-].
    pub fn extrapolated(&self) -> f64 {
        self.extrapolating.iter().sum::<f64>() / self.extrapolating.len().max(1) as f64
    }

    /// Channels recorded next to the twin's motion: `aux_kk_m`, `extrapolating` and where there is a band `tip_band_m`.
    pub fn into_channels(self) -> Vec<Channel> {
        let aux = |(k, values): (usize, Vec<f64>)| Channel::new(format!("aux_{:02}_m", k + 1), values);
        let mut channels: Vec<Channel> = self.strokes.into_iter().enumerate().map(aux).collect();
        channels.push(Channel::new("extrapolating", self.extrapolating));
        if !self.band.is_empty() {
            channels.push(Channel::new(TIP_BAND, self.band));
        }
        channels
    }
}
