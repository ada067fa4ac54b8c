//! Recording of a run, sample by sample.
//!
//! Columns: `stroke_k_m` as commanded (as measured for a tendon without a commanded stroke), `measured_stroke_k_m`
//! and `tension_k_n` of every primary tendon, `tip_x_m tip_y_m tip_z_m`. Auxiliary tendons appear (`aux_kk_m`, and
//! their tensions numbered after the primary ones) only where the recording drove them: a passive one recorded as
//! a stroke would be driven when the file is simulated again. With goals, `tip_error_m` is what remained to them.

use hysteron_base::{BadInput, Channel, Metadata, Recording};
use hysteron_twin::command::Command;
use hysteron_twin::{Twin, TwinState};

/// Everything recorded so far.
#[derive(Debug, Clone)]
pub struct Trace {
    tip: [Vec<f64>; 3],
    /// By tendon, then by sample.
    tensions: Vec<Vec<f64>>,
    strokes: Vec<Vec<f64>>,
}

impl Trace {
    /// An empty trace with room for `n_samples`.
    pub fn new(twin: &Twin, n_samples: usize) -> Self {
        let column = || Vec::with_capacity(n_samples);
        Self {
            tip: std::array::from_fn(|_| column()),
            tensions: (0..twin.tendons.len()).map(|_| column()).collect(),
            strokes: (0..twin.n_primary).map(|_| column()).collect(),
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.tip[0].len()
    }

    /// Adds a sample.
    pub fn push(&mut self, state: &TwinState, strokes: &[f64], tip: [f64; 3]) {
        for (column, value) in self.tip.iter_mut().zip(tip) {
            column.push(value);
        }
        for (column, value) in self.tensions.iter_mut().zip(&state.tensions) {
            column.push(*value);
        }
        for (column, value) in self.strokes.iter_mut().zip(strokes) {
            column.push(*value);
        }
    }

    /// Adds all samples of a recording written by [`Self::into_recording`].
    pub fn extend(&mut self, earlier: &Recording) -> Result<(), BadInput> {
        for (column, axis) in self.tip.iter_mut().zip(["x", "y", "z"]) {
            column.extend(earlier.require(&format!("tip_{axis}_m"))?);
        }
        for (k, column) in self.strokes.iter_mut().enumerate() {
            column.extend(earlier.require(&format!("measured_stroke_{}_m", k + 1))?);
        }
        let n_primary = self.strokes.len();
        for (k, column) in self.tensions.iter_mut().enumerate() {
            match earlier.channel(&format!("tension_{}_n", k + 1)) {
                Some(values) => column.extend(values),
                // Resting auxiliary tendons are not recorded, and not needed.
                None if k >= n_primary => column.resize(self.tip[0].len(), 0.0),
                None => column.extend(earlier.require(&format!("tension_{}_n", k + 1))?),
            }
        }
        Ok(())
    }

    /// The recording, with the commanded strokes and `further` channels.
    pub fn into_recording(
        self,
        twin: &Twin,
        command: &Command,
        further: Vec<Channel>,
        meta: Metadata,
    ) -> Result<Recording, BadInput> {
        let n = self.len();
        let n_tensions = if command.drives_auxiliary { twin.tendons.len() } else { twin.n_primary };
        let mut channels = Vec::new();
        for (k, measured) in self.strokes.iter().enumerate() {
            let commanded = command.strokes_of(k).map_or(measured.as_slice(), |values| &values[..n]);
            channels.push(Channel::new(format!("stroke_{}_m", k + 1), commanded.to_vec()));
        }
        for j in twin.n_primary..n_tensions {
            let commanded = command.strokes_of(j).map_or(Vec::new(), |values| values[..n].to_vec());
            channels.push(Channel::new(format!("aux_{:02}_m", j + 1 - twin.n_primary), commanded));
        }
        let tip_error =
            command.goals.as_ref().map(|goals| goals.errors(self.tip.each_ref().map(Vec::as_slice)));
        for (axis, values) in ["x", "y", "z"].into_iter().zip(self.tip) {
            channels.push(Channel::new(format!("tip_{axis}_m"), values));
        }
        channels.extend(tip_error.map(|values| Channel::new("tip_error_m", values)));
        for (k, values) in self.tensions.into_iter().take(n_tensions).enumerate() {
            channels.push(Channel::new(format!("tension_{}_n", k + 1), values));
        }
        for (k, values) in self.strokes.into_iter().enumerate() {
            channels.push(Channel::new(format!("measured_stroke_{}_m", k + 1), values));
        }
        channels.extend(further);
        Recording::new(command.time[..n].to_vec(), channels, Vec::new(), meta)
    }
}
