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

    /// Several fits of the same methods, each validated on other recordings, as one: mean curves, over as many epochs as all
    /// have, and root mean square errors.
    pub fn pooled(all: &[Self]) -> Self {
        let Some(first) = all.first() else { return Self::default() };
        let n = all.len() as f64;
        let names = |of: fn(&Self) -> &Vec<String>| {
            let mut names: Vec<String> = all.iter().flat_map(|one| of(one).clone()).collect();
            names.sort();
            names.dedup();
            names
        };
        let n_epochs = all.iter().map(|one| one.curve.len()).min().unwrap_or(0);
        let at = |epoch: usize| [0, 1].map(|k| all.iter().map(|one| one.curve[epoch][k]).sum::<f64>() / n);
        let root = |c: usize, k: usize| {
            (all.iter().map(|one| one.channels[c].errors[k].powi(2)).sum::<f64>() / n).sqrt()
        };
        let channel = |(c, channel): (usize, &ChannelErrors)| ChannelErrors {
            name: channel.name.clone(),
            errors: (0..channel.errors.len()).map(|k| root(c, k)).collect(),
        };
        Self {
            training: names(|one| &one.training),
            validation: names(|one| &one.validation),
            curve: (0..n_epochs).map(at).collect(),
            epochs: (all.iter().map(|one| one.epochs).sum::<usize>() as f64 / n).round() as usize,
            unit: first.unit.clone(),
            methods: first.methods.clone(),
            channels: first.channels.iter().enumerate().map(channel).collect(),
        }
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
    fn of_several_fits_squares_and_curves_are_averaged() {
        let of = |name: &str, epochs: usize, error: f64| FitReport {
            validation: vec![name.to_owned()],
            curve: vec![[error, 2.0 * error]; epochs],
            epochs,
            methods: vec!["network".to_owned()],
            channels: vec![ChannelErrors { name: "stroke 1".to_owned(), errors: vec![error] }],
            ..FitReport::default()
        };
        let pooled = FitReport::pooled(&[of("b", 3, 1.0), of("a", 6, 7.0)]);
        assert_eq!((pooled.validation, pooled.epochs), (vec!["a".to_owned(), "b".to_owned()], 5));
        assert_eq!(pooled.curve, [[4.0, 8.0]; 3]);
        assert_eq!(pooled.channels[0].errors, [5.0]);
        assert_eq!(FitReport::pooled(&[]), FitReport::default());
    }

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
