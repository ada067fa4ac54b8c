//! Gaussian radial basis functions around samples, and a line: kernel ridge regression with as many terms as are worth their time.
//!
//! Inputs are in units of their spread; the functions see some of them, the line some. Weights are least squares with a penalty
//! ([`NormalEquations`]); width and penalty are those that err least on groups of samples, whole recordings, that were left out.

use std::ops::Range;

use hysteron_base::BadInput;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::ridge::{NormalEquations, predict};

/// How far outputs may leave the range of those that were fitted, as a part of it.
const BEYOND: f64 = 0.25;

/// A regression that is evaluated sample by sample.
///
/// # Reference
/// Rasmussen, Williams (2006), Gaussian processes for machine learning, section 8.3.1 (subset of regressors).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RadialBasis {
    /// Inputs of the functions, by number.
    seen: Vec<usize>,
    /// Inputs of the line, by number.
    line: Vec<usize>,
    /// Mean of every input.
    mean: Vec<f64>,
    /// 1 over the spread of every input; 0 of one that does not change.
    per_spread: Vec<f64>,
    /// Width of the functions, in spreads.
    width: f64,
    /// Middles of the functions ([function][input], in spreads).
    centres: Vec<f64>,
    /// Weights of the constant, the line and the functions ([term][output]).
    weights: Vec<f64>,
    /// Smallest and largest value of every output.
    range: Vec<[f64; 2]>,
}

/// Samples of recordings to fit.
#[derive(Debug, Clone, Copy)]
pub struct RadialSamples<'a> {
    /// Numbers of a sample.
    pub n_inputs: usize,
    /// Numbers to find for it.
    pub n_outputs: usize,
    /// Inputs ([sample][input]).
    pub inputs: &'a [f64],
    /// Outputs ([sample][output]).
    pub outputs: &'a [f64],
    /// Samples of each recording, which stay together.
    pub groups: &'a [Range<usize>],
}

/// Inputs and numbers of a fit beside its data.
#[derive(Debug, Clone, PartialEq)]
pub struct RadialSetting {
    /// Inputs of the functions, by number.
    pub seen: Vec<usize>,
    /// Inputs of the line, by number.
    pub line: Vec<usize>,
    /// How many functions at most.
    pub n_centres: usize,
    /// Width of the functions, in spreads of an input times the root of their number.
    pub width: f64,
    /// Penalty of [`NormalEquations::solve`].
    pub penalty: f64,
}

impl RadialSamples<'_> {
    fn inputs_of(&self, group: usize) -> &[f64] {
        let Range { start, end } = self.groups[group];
        &self.inputs[start * self.n_inputs..end * self.n_inputs]
    }

    fn outputs_of(&self, group: usize) -> &[f64] {
        let Range { start, end } = self.groups[group];
        &self.outputs[start * self.n_outputs..end * self.n_outputs]
    }
}

impl RadialBasis {
    /// Fits the groups of these numbers.
    pub fn fit(samples: &RadialSamples<'_>, setting: &RadialSetting, groups: &[usize]) -> Self {
        let mut empty = Self::without_weights(samples, setting, groups);
        let mut sums = NormalEquations::new(empty.n_terms(), samples.n_outputs);
        for &group in groups {
            sums.add(&empty.terms_of(samples.inputs_of(group)), samples.outputs_of(group));
        }
        empty.weights = sums.solve(setting.penalty);
        empty
    }

    /// The width and the penalty, of those given, that err least on the groups left out in turn, and the root mean square error
    /// of all outputs there. The functions stand where samples of all groups are.
    ///
    /// # Errors
    /// `BadInput` if there is nothing to choose from.
    pub fn choose(
        samples: &RadialSamples<'_>,
        settings: &RadialSetting,
        (widths, penalties): (&[f64], &[f64]),
        left_out: &[Vec<usize>],
    ) -> Result<(RadialSetting, f64), BadInput> {
        let all: Vec<usize> = (0..samples.groups.len()).collect();
        let of_width = |width: &f64| {
            let setting = RadialSetting { width: *width, ..settings.clone() };
            let basis = Self::without_weights(samples, &setting, &all);
            let terms: Vec<Vec<f64>> =
                all.iter().map(|&group| basis.terms_of(samples.inputs_of(group))).collect();
            let sums: Vec<NormalEquations> = all
                .iter()
                .map(|&group| {
                    let mut sums = NormalEquations::new(basis.n_terms(), samples.n_outputs);
                    sums.add(&terms[group], samples.outputs_of(group));
                    sums
                })
                .collect();
            let errors = |penalty: &f64| {
                let (square, count) = left_out.iter().fold((0.0, 0.0), |sum, groups| {
                    let one = basis.left_out_squares(samples, (&terms, &sums), groups, *penalty);
                    (sum.0 + one.0, sum.1 + one.1)
                });
                (
                    RadialSetting { penalty: *penalty, ..setting.clone() },
                    (square / f64::max(count, 1.0)).sqrt(),
                )
            };
            penalties.iter().map(errors).collect::<Vec<_>>()
        };
        let tried: Vec<(RadialSetting, f64)> = widths.par_iter().flat_map_iter(of_width).collect();
        let best = tried.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
        best.ok_or_else(|| BadInput::new("widths and penalties", "at least one of each", "none"))
    }

    /// Sum of the squared errors on some groups, by weights fitted to all others, and the number of outputs.
    fn left_out_squares(
        &self,
        samples: &RadialSamples<'_>,
        (terms, sums): (&[Vec<f64>], &[NormalEquations]),
        groups: &[usize],
        penalty: f64,
    ) -> (f64, f64) {
        let mut known = NormalEquations::new(self.n_terms(), samples.n_outputs);
        (0..sums.len()).filter(|k| !groups.contains(k)).for_each(|k| known.add_scaled(&sums[k], 1.0));
        let weights = known.solve(penalty);
        let (mut square, mut count) = (0.0, 0.0);
        for &group in groups {
            let outputs = samples.outputs_of(group);
            let mut found = vec![0.0; outputs.len()];
            predict(&terms[group], &weights, self.n_terms(), &mut found);
            square += found.iter().zip(outputs).map(|(found, exact)| (found - exact).powi(2)).sum::<f64>();
            count += outputs.len() as f64;
        }
        (square, count)
    }

    fn without_weights(samples: &RadialSamples<'_>, setting: &RadialSetting, groups: &[usize]) -> Self {
        let n = samples.n_inputs;
        let rows = || groups.iter().flat_map(|&group| samples.inputs_of(group).chunks_exact(n));
        let count = rows().count().max(1) as f64;
        let mut mean = vec![0.0; n];
        rows().for_each(|row| mean.iter_mut().zip(row).for_each(|(mean, x)| *mean += x / count));
        let mut square = vec![0.0; n];
        for row in rows() {
            square
                .iter_mut()
                .zip(row)
                .zip(&mean)
                .for_each(|((sum, x), mean)| *sum += (x - mean).powi(2) / count);
        }
        let per_spread = square.iter().map(|v| if *v > 0.0 { v.sqrt().recip() } else { 0.0 }).collect();
        let mut range = vec![[f64::INFINITY, f64::NEG_INFINITY]; samples.n_outputs];
        for row in groups.iter().flat_map(|&group| samples.outputs_of(group).chunks_exact(samples.n_outputs))
        {
            range.iter_mut().zip(row).for_each(|([min, max], y)| (*min, *max) = (min.min(*y), max.max(*y)));
        }
        let (seen, line) = (setting.seen.clone(), setting.line.clone());
        let width = setting.width * (seen.len() as f64).sqrt();
        let mut basis =
            Self { seen, line, mean, per_spread, width, centres: Vec::new(), weights: Vec::new(), range };
        let scaled: Vec<f64> = rows().flat_map(|row| basis.seen_of(row)).collect();
        basis.centres = spread_out(&scaled, basis.seen.len(), setting.n_centres);
        basis
    }

    /// Inputs of the functions, in spreads.
    fn seen_of<'a>(&'a self, inputs: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.seen.iter().map(|&k| (inputs[k] - self.mean[k]) * self.per_spread[k])
    }

    /// Terms of samples ([sample][term]).
    fn terms_of(&self, inputs: &[f64]) -> Vec<f64> {
        let mut terms = Vec::with_capacity(inputs.len() / self.mean.len() * self.n_terms());
        inputs.chunks_exact(self.mean.len()).for_each(|row| self.append_terms(row, &mut terms));
        terms
    }

    fn append_terms(&self, inputs: &[f64], terms: &mut Vec<f64>) {
        terms.push(1.0);
        terms.extend(self.line.iter().map(|&k| (inputs[k] - self.mean[k]) * self.per_spread[k]));
        let per = -0.5 / (self.width * self.width);
        terms.extend(self.centres.chunks_exact(self.seen.len().max(1)).map(|centre| {
            let square: f64 = self.seen_of(inputs).zip(centre).map(|(x, c)| (x - c) * (x - c)).sum();
            (per * square).exp()
        }));
    }

    /// Terms of a sample: the constant, the line and the functions.
    pub fn n_terms(&self) -> usize {
        1 + self.line.len() + self.centres.len() / self.seen.len().max(1)
    }

    /// Numbers of a sample.
    pub fn n_inputs(&self) -> usize {
        self.mean.len()
    }

    /// Numbers that are found for it.
    pub fn n_outputs(&self) -> usize {
        self.range.len()
    }

    /// Adds what it finds for a sample to `outputs`, each at most a quarter of its range beyond what was fitted. `terms` is scratch;
    /// does not allocate once that is long enough.
    pub fn add_to(&self, inputs: &[f64], terms: &mut Vec<f64>, outputs: &mut [f64]) {
        terms.clear();
        self.append_terms(inputs, terms);
        let n = outputs.len();
        for (k, (output, [min, max])) in outputs.iter_mut().zip(&self.range).enumerate() {
            let found: f64 = terms.iter().zip(self.weights[k..].iter().step_by(n)).map(|(t, w)| t * w).sum();
            let beyond = BEYOND * (max - min);
            *output += found.clamp(min - beyond, max + beyond);
        }
    }

    /// Refuses parts that do not fit one another, as a file may have them.
    ///
    /// # Errors
    /// `BadInput` naming the part.
    pub fn check(&self) -> Result<(), BadInput> {
        let n = self.mean.len();
        let finite = |values: &[f64]| values.iter().all(|v| v.is_finite());
        let checks = [
            ("mean", finite(&self.mean), "finite numbers"),
            ("per_spread", self.per_spread.len() == n && finite(&self.per_spread), "one for every mean"),
            ("seen", self.seen.iter().all(|k| *k < n), "numbers of inputs"),
            ("line", self.line.iter().all(|k| *k < n), "numbers of inputs"),
            ("width", self.width > 0.0 || self.seen.is_empty(), "a width > 0"),
            (
                "centres",
                self.centres.len().is_multiple_of(self.seen.len().max(1)) && finite(&self.centres),
                "whole points",
            ),
            (
                "range",
                self.range.iter().all(|[min, max]| min <= max && (max - min).is_finite()),
                "min <= max",
            ),
            (
                "weights",
                self.weights.len() == self.n_terms() * self.range.len() && finite(&self.weights),
                "one for every term and output",
            ),
        ];
        match checks.into_iter().find(|(_, fits, _)| !fits) {
            Some((part, _, expected)) => Err(BadInput::new(format!("kernel: {part}"), expected, "others")),
            None => Ok(()),
        }
    }
}

/// At most `count` of some points ([point][coordinate]), each the one farthest from those before it.
///
/// # Reference
/// Gonzalez (1985), Clustering to minimize the maximum intercluster distance.
fn spread_out(points: &[f64], n: usize, count: usize) -> Vec<f64> {
    let mut chosen = Vec::new();
    if n == 0 {
        return chosen;
    }
    let mut distance = vec![f64::INFINITY; points.len() / n];
    let mut next = distance.len() / 2;
    while chosen.len() < count * n && distance.get(next).is_some_and(|d| *d > 0.0) {
        let centre = points[next * n..(next + 1) * n].to_vec();
        for (point, distance) in points.chunks_exact(n).zip(&mut distance) {
            let square: f64 = point.iter().zip(&centre).map(|(x, c)| (x - c) * (x - c)).sum();
            *distance = distance.min(square);
        }
        chosen.extend(centre);
        next = (0..distance.len()).max_by(|&a, &b| distance[a].total_cmp(&distance[b])).unwrap_or(0);
    }
    chosen
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;

    /// Four recordings of y = sin 3x + z, with an input that says nothing.
    fn data() -> (Vec<f64>, Vec<f64>, Vec<Range<usize>>) {
        let at = |i: usize| {
            let t = i as f64;
            [(0.37 * t).sin(), (0.11 * t).cos(), (1.7 * t * t).sin()]
        };
        let inputs: Vec<f64> = (0..800).flat_map(at).collect();
        let outputs = inputs.chunks(3).map(|x| (3.0 * x[0]).sin() + x[1]).collect();
        (inputs, outputs, (0..4).map(|k| 200 * k..200 * (k + 1)).collect())
    }

    fn setting() -> RadialSetting {
        RadialSetting { seen: vec![0], line: vec![1], n_centres: 30, width: 1.0, penalty: 1e-9 }
    }

    #[test]
    fn a_curve_and_a_line_come_back_on_recordings_that_were_left_out() {
        let (inputs, outputs, groups) = data();
        let samples =
            RadialSamples { n_inputs: 3, n_outputs: 1, inputs: &inputs, outputs: &outputs, groups: &groups };
        let left_out: Vec<Vec<usize>> = (0..4).map(|k| vec![k]).collect();
        let (widths, penalties) = ([0.03, 0.3, 3.0], [1e-9, 1.0]);
        let (best, error) =
            RadialBasis::choose(&samples, &setting(), (&widths, &penalties), &left_out).unwrap();
        assert!(best.width == 0.3 && best.penalty == 1e-9 && error < 1e-3, "{best:?} {error}");
        let basis = RadialBasis::fit(&samples, &best, &[0, 1, 2]);
        basis.check().unwrap();
        // What `choose` says of a part left out is what a fit without it does there.
        let mut square = 0.0;
        for i in groups[3].clone() {
            let mut found = [0.0];
            basis.add_to(&inputs[3 * i..3 * i + 3], &mut Vec::new(), &mut found);
            square += (found[0] - outputs[i]).powi(2);
        }
        let here = (square / 200.0).sqrt();
        let (_, alone) =
            RadialBasis::choose(&samples, &best, (&[best.width], &[best.penalty]), &[vec![3]]).unwrap();
        // The middles of the functions differ: those of all recordings there, of three here.
        assert!(here < 1e-3 && alone < 1e-3, "{here} {alone}");
    }

    #[test]
    fn far_from_its_samples_it_stays_near_their_range() {
        let (inputs, outputs, groups) = data();
        let samples =
            RadialSamples { n_inputs: 3, n_outputs: 1, inputs: &inputs, outputs: &outputs, groups: &groups };
        let basis = RadialBasis::fit(&samples, &setting(), &[0, 1, 2, 3]);
        let mut found = [0.0];
        basis.add_to(&[0.0, 1e3, 0.0], &mut Vec::new(), &mut found);
        let [min, max] = basis.range[0];
        assert!((found[0] - (max + BEYOND * (max - min))).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn a_file_with_parts_that_do_not_fit_is_refused() {
        let (inputs, outputs, groups) = data();
        let samples =
            RadialSamples { n_inputs: 3, n_outputs: 1, inputs: &inputs, outputs: &outputs, groups: &groups };
        let basis = RadialBasis::fit(&samples, &setting(), &[0]);
        type Damage = fn(&mut RadialBasis);
        let wrong: [(&str, Damage); 5] = [
            ("seen", |basis| basis.seen.push(9)),
            ("weights", |basis| basis.weights.truncate(3)),
            ("weights", |basis| basis.weights[0] = f64::NAN),
            ("per_spread", |basis| basis.per_spread.truncate(1)),
            ("range", |basis| basis.range[0] = [1.0, 0.0]),
        ];
        for (part, damage) in wrong {
            let mut damaged = basis.clone();
            damage(&mut damaged);
            assert!(damaged.check().unwrap_err().to_string().contains(part), "{part}");
        }
    }
}
