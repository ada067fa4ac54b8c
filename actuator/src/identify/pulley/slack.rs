//! Which samples of steady motion are of a slack tendon, from loads alone.
//!
//! Tendons only pull: at a speed a load is never less than that of the slack tendon. The samples without tension are therefore the lower
//! edge of the cloud, and a dense one, for tendons go slack for long. A line for each direction is laid along that edge, and
//! what lies within the noise of it, and stays there, is slack.

use nalgebra::{DMatrix, DVector};

use super::steady::SteadySamples;

/// Weight of samples above the edge against those below it, as it is sought.
const ABOVE: f64 = 0.02;
/// Rounds of both searches, in which they have long settled.
const ROUNDS: usize = 40;
/// Widths of the noise that count as the edge.
const WIDTHS: f64 = 3.0;
/// Samples on either side within which none may lie off the edge: a tension that passes through zero is no slack tendon.
const NEAR: usize = 15;
/// Fewest samples whose mode is sought.
const MIN_SAMPLES: usize = 20;
/// Terms of the line: sgn ω, ω, 1, ω̇.
const TERMS: usize = 4;

/// True for samples of a slack tendon.
pub fn find_slack(samples: &SteadySamples) -> Vec<bool> {
    let n = samples.len();
    if n < MIN_SAMPLES {
        return vec![false; n];
    }
    let mut line = line(samples, |_| 1.0);
    for _ in 0..ROUNDS {
        let errors = errors(samples, &line);
        line = self::line(samples, |i| if errors[i] > 0.0 { ABOVE } else { 1.0 });
    }
    let mut is_near = vec![false; n];
    for _ in 0..ROUNDS {
        let errors = errors(samples, &line);
        let (mode, width) = edge(&errors);
        is_near = errors.iter().map(|error| (error - mode).abs() < WIDTHS * width).collect();
        line = self::line(samples, |i| f64::from(u8::from(is_near[i])));
    }
    let mut is_slack = is_near.clone();
    for series in &samples.series {
        let off: Vec<usize> = series.clone().filter(|i| !is_near[*i]).collect();
        for i in series.clone().filter(|i| is_near[*i]) {
            let next = off.partition_point(|o| *o < i);
            let is_close =
                |k: usize| off.get(k).is_some_and(|o| samples.at[*o].abs_diff(samples.at[i]) <= NEAR);
            is_slack[i] = !(is_close(next) || next > 0 && is_close(next - 1));
        }
    }
    is_slack
}

fn terms(samples: &SteadySamples, i: usize) -> [f64; TERMS] {
    let v = samples.velocity[i];
    [v.signum(), v, 1.0, samples.acceleration[i]]
}

/// Loads over the terms by weighted least squares.
fn line(samples: &SteadySamples, weight: impl Fn(usize) -> f64) -> [f64; TERMS] {
    let mut matrix = DMatrix::<f64>::zeros(TERMS, TERMS);
    let mut right = DVector::<f64>::zeros(TERMS);
    for i in 0..samples.len() {
        let (row, w) = (terms(samples, i), weight(i));
        for a in 0..TERMS {
            right[a] += w * row[a] * samples.load[i];
            for b in 0..TERMS {
                matrix[(a, b)] += w * row[a] * row[b];
            }
        }
    }
    // Motion one way, or at one speed, leaves a direction open: that of least size is as good as any.
    let scale = matrix.norm();
    let solution = matrix.svd(true, true).solve(&right, 1e-12 * scale);
    solution.map_or([0.0; TERMS], |x| std::array::from_fn(|k| x[k]))
}

fn errors(samples: &SteadySamples, line: &[f64; TERMS]) -> Vec<f64> {
    let at = |i: usize| terms(samples, i).iter().zip(line).map(|(x, c)| x * c).sum::<f64>();
    (0..samples.len()).map(|i| samples.load[i] - at(i)).collect()
}

/// Mode of the errors, as the half sample that is shortest is halved again and again, and the width of the noise, from what lies
/// below it.
///
/// # Reference
/// Bickel, Frühwirth (2006), On a fast, robust estimator of the mode.
fn edge(errors: &[f64]) -> (f64, f64) {
    let mut sorted = errors.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mut part = &sorted[..];
    while part.len() > MIN_SAMPLES {
        let half = part.len().div_ceil(2);
        let length = |k: &usize| part[k + half - 1] - part[*k];
        let shortest = (0..=part.len() - half).min_by(|a, b| length(a).total_cmp(&length(b))).unwrap_or(0);
        part = &part[shortest..shortest + half];
    }
    let mode = part.iter().sum::<f64>() / part.len() as f64;
    let below = sorted.partition_point(|error| *error < mode);
    // Median of half a normal distribution: 0.6745 of its deviation.
    let width = (mode - sorted[below / 2]) / 0.6745;
    (mode, width)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tendon that is slack half of the time; loads with noise. With the load of the tension alone.
    fn samples(noise: f64, taut: f64) -> (SteadySamples, Vec<f64>) {
        let mut samples = SteadySamples::default();
        let mut truth = Vec::new();
        for i in 0..4000 {
            let t = 0.01 * f64::from(i);
            let v = (1.3 * t).sin();
            let tension = (taut * (0.41 * t).sin()).max(0.0);
            if v.abs() < 0.15 {
                continue;
            }
            // Three sines of incommensurable periods: a noise that is the same every time.
            let noise = noise * ((917.3 * t).sin() + (533.1 * t).sin() + (311.7 * t).sin()) / 1.2;
            samples.velocity.push(v);
            samples.acceleration.push(1.3 * (1.3 * t).cos());
            samples.load.push(0.03 * v.signum() + 0.15 * v + 0.007 * tension + noise);
            samples.at.push(i as usize);
            truth.push(0.007 * tension);
        }
        samples.series.push(0..samples.velocity.len());
        (samples, truth)
    }

    #[test]
    fn samples_of_a_slack_tendon_are_distinguished_from_those_of_a_taut_one() {
        for (noise, taut) in [(1e-3, 30.0), (3e-3, 10.0)] {
            let (samples, truth) = samples(noise, taut);
            let found = find_slack(&samples);
            let n_slack = truth.iter().filter(|load| **load == 0.0).count();
            let chosen: Vec<f64> =
                truth.iter().zip(&found).filter(|(_, f)| **f).map(|(load, _)| *load).collect();
            let n_right = chosen.iter().filter(|load| **load == 0.0).count();
            assert!(5 * n_right > 4 * n_slack, "{n_right} of {n_slack}");
            // What is taken for slack and is not, hides in the noise.
            let (most, mean) = (
                chosen.iter().fold(0.0, |a: f64, b| a.max(*b)),
                chosen.iter().sum::<f64>() / chosen.len() as f64,
            );
            assert!(most < 5.0 * noise && mean < 0.3 * noise, "{most} {mean}");
        }
    }

    #[test]
    fn too_few_samples_are_none() {
        let (samples, _) = samples(1e-3, 10.0);
        let few = samples.slack(&(0..samples.len()).map(|i| i < 5).collect::<Vec<_>>());
        assert_eq!(find_slack(&few), vec![false; 5]);
    }
}
