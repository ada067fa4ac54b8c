//! Learning curve of a fit, and its validation errors next to those of the baselines that it must beat.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Report on a fit: splits, learning curve, validation errors by method and output.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct FitReport {
    /// Names of the training trajectories.
    pub training: Vec<String>,
    /// Names of the validation trajectories: early stopping and errors use these.
    pub validation: Vec<String>,
    /// Of every epoch, the error in training and in validation, in `unit`.
    pub curve: Vec<[f64; 2]>,
    /// Epochs after which the weights were found that are kept.
    pub epochs: usize,
    /// Unit of all errors.
    pub unit: Cow<'static, str>,
    /// Methods evaluated: baselines, and the network last.
    pub methods: Vec<String>,
    /// Root mean square errors in validation.
    pub channels: Vec<ChannelErrors>,
}

/// Errors of an output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChannelErrors {
    /// Which output.
    pub name: String,
    /// By method.
    pub errors: Vec<f64>,
}

impl FitReport {
    /// Where the network, the last method, does no better than a baseline: output, baseline, its error, the network's.
    pub fn losses(&self) -> Vec<(&str, &str, [f64; 2])> {
        let mut losses = Vec::new();
        for ChannelErrors { name, errors } in &self.channels {
            let Some((network, baselines)) = errors.split_last() else { continue };
            let lost = baselines.iter().zip(&self.methods).filter(|(baseline, _)| *baseline <= network);
            losses.extend(lost.map(|(baseline, method)| (&name[..], &method[..], [*baseline, *network])));
        }
        losses
    }

    /// The same with the methods up to and including one; all where there is none of this name.
    pub fn up_to(&self, method: &str) -> Self {
        let n = self.methods.iter().position(|name| name == method).map_or(self.methods.len(), |k| k + 1);
        let mut report = self.clone();
        report.methods.truncate(n);
        report.channels.iter_mut().for_each(|channel| channel.errors.truncate(n));
        report
    }

    /// Root mean square over all outputs, by method.
    pub fn together(&self) -> Vec<f64> {
        let n = self.channels.len().max(1) as f64;
        let of_method = |k: usize| {
            let squares = self.channels.iter().map(|channel| channel.errors[k].powi(2));
            (squares.sum::<f64>() / n).sqrt()
        };
        (0..self.methods.len()).map(of_method).collect()
    }
}

/// The first of some errors, from the simplest method on, that is at most a part `same` above the least; none where no error is a
/// number.
pub fn simplest_within(same: f64, errors: &[f64]) -> Option<usize> {
    let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
    errors.iter().position(|error| *error <= (1.0 + same) * least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_network_that_does_no_better_than_a_baseline_is_named() {
        let channel =
            |name: &str, errors: [f64; 3]| ChannelErrors { name: name.to_owned(), errors: errors.to_vec() };
        let report = FitReport {
            methods: ["none", "linear", "network"].map(str::to_owned).to_vec(),
            channels: vec![channel("stroke 1", [3.0, 1.0, 0.5]), channel("stroke 2", [4.0, 1.0, 1.2])],
            ..FitReport::default()
        };
        assert_eq!(report.losses(), [("stroke 2", "linear", [1.0, 1.2])]);
        assert_eq!(report.together()[..2], [12.5f64.sqrt(), 1.0]);
    }
}
