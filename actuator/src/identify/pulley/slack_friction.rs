//! Friction of a servo in either direction, from loads of a slack tendon: what changes as a gearbox wears.
//!
//! On a slack tendon a load is friction and back EMF alone:
//! ```text
//! l = +d₁ + b ω + c ω̇   (ω > 0)        l = −d₂ + b ω + c ω̇   (ω < 0)
//! ```
//! No data sheet is needed: d₁ and d₂ are parts of the full load.

use hysteron_base::BadInput;
use nalgebra::{Matrix4, Vector4};

use super::slack::find_slack;
use super::steady::SteadySamples;
use crate::load::SteadyMotion;

/// Fewest passes in either direction: their scatter is the error.
const MIN_PASSES: usize = 4;

/// Dry friction of a servo, pulling and releasing, as parts of its full load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlackFriction {
    /// Pulling and releasing [-].
    pub dry: [f64; 2],
    /// Their standard errors [-].
    pub standard_error: [f64; 2],
    /// Back EMF and viscous friction [s/rad].
    pub viscous: f64,
    /// Samples of a slack tendon.
    pub samples: usize,
}

/// Finds the samples of a slack tendon and fits friction to them. Neighbouring samples are alike: standard errors are those of passes, motion
/// one way without a break, as clusters: a jackknife that leaves out one pass after the other, because passes are few and unequal.
/// They hold where passes differ by no more than the noise: of passes that differ by more, the search for slack keeps those that are alike.
///
/// # Errors
/// `BadInput` where the tendon was hardly slack in motion.
///
/// # Reference
/// Cameron, Miller (2015), A practitioner's guide to cluster-robust inference, section VI.B (CR3).
pub fn slack_friction(samples: &SteadySamples) -> Result<SlackFriction, BadInput> {
    let slack = samples.slack(&find_slack(samples));
    let passes = passes(&slack);
    let one_way = |sign: f64| passes.iter().filter(|pass| slack.velocity[pass[0]] * sign > 0.0).count();
    for (n, direction) in [(one_way(1.0), "pulling"), (one_way(-1.0), "releasing")] {
        if n < MIN_PASSES {
            let expected = format!("{MIN_PASSES} passes of a slack tendon in steady motion, {direction}");
            return Err(BadInput::new("friction", expected, n.to_string()));
        }
    }
    let row = |i: usize| {
        let v = slack.velocity[i];
        let [pulls, releases] = [v > 0.0, v < 0.0].map(|is| f64::from(u8::from(is)));
        Vector4::new(pulls, -releases, v, slack.acceleration[i])
    };
    let (mut matrix, mut right) = (Matrix4::zeros(), Vector4::zeros());
    for i in 0..slack.len() {
        let x = row(i);
        matrix += x * x.transpose();
        right += x * slack.load[i];
    }
    let one_speed = || {
        BadInput::new("friction", "speeds that differ on a slack tendon", "one speed")
            .hint("dry and viscous friction look alike at one speed")
    };
    let found = matrix.lu().solve(&right).filter(|found| found.iter().all(|x| x.is_finite()));
    let found = found.ok_or_else(one_speed)?;
    // Change of the result by omitting each pass (jackknife).
    let mut covariance = Matrix4::zeros();
    for pass in &passes {
        let (mut rest, mut of_rest) = (matrix, right);
        for &i in pass {
            let x = row(i);
            rest -= x * x.transpose();
            of_rest -= x * slack.load[i];
        }
        let moved = rest.lu().solve(&of_rest).filter(|rest| rest.iter().all(|x| x.is_finite()));
        let moved = moved.ok_or_else(one_speed)? - found;
        covariance += moved * moved.transpose();
    }
    let n = passes.len() as f64;
    covariance *= (n - 1.0) / n;
    Ok(SlackFriction {
        dry: [found[0], found[1]],
        standard_error: [0, 1].map(|k| covariance[(k, k)].max(0.0).sqrt()),
        viscous: found[2],
        samples: slack.len(),
    })
}

/// Samples of motion one way without a break.
fn passes(samples: &SteadySamples) -> Vec<Vec<usize>> {
    let mut passes: Vec<Vec<usize>> = Vec::new();
    for series in &samples.series {
        let mut last: Option<usize> = None;
        for i in series.clone() {
            let continues = last.is_some_and(|j: usize| {
                samples.velocity[i] * samples.velocity[j] > 0.0
                    && samples.at[i] - samples.at[j] <= SteadyMotion::SPAN
            });
            match passes.last_mut().filter(|_| continues) {
                Some(pass) => pass.push(i),
                None => passes.push(vec![i]),
            }
            last = Some(i);
        }
    }
    passes
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use hysteron_base::rng;
    use rand::RngExt;

    use super::*;

    /// A slack tendon to and fro, whose every pass has an error of its own, as a load's ripple makes it.
    fn samples(dry: [f64; 2], ripple: f64, seed: u64) -> SteadySamples {
        let viscous = 0.16;
        let mut stream = rng(seed, "slack-friction/test");
        let mut samples = SteadySamples::default();
        let (mut own, mut sign) = (0.0, 0.0);
        for i in 0..6000 {
            let t = 0.01 * f64::from(i);
            let v = 0.8 * (1.3 * t).sin() + 0.3 * (0.61 * t).sin();
            if v.signum() != sign {
                (own, sign) = (ripple * stream.random_range(-1.0..1.0), v.signum());
            }
            if v.abs() < 0.15 {
                continue;
            }
            let noise = own + 1e-3 * stream.random_range(-1.0..1.0);
            let dry = if v > 0.0 { dry[0] } else { -dry[1] };
            samples.velocity.push(v);
            samples.acceleration.push(1.04 * (1.3 * t).cos() + 0.183 * (0.61 * t).cos());
            samples.load.push(dry + viscous * v + noise);
            samples.at.push(i as usize);
        }
        samples.series.push(0..samples.velocity.len());
        samples
    }

    #[test]
    fn both_directions_come_back_within_their_standard_errors() {
        let mut distances = Vec::new();
        for seed in 0..40 {
            let found = slack_friction(&samples([0.031, 0.036], 0.7e-3, seed)).unwrap();
            for (k, truth) in [0.031, 0.036].into_iter().enumerate() {
                distances.push((found.dry[k] - truth) / found.standard_error[k]);
                assert!(found.standard_error[k] < 1.5e-3, "{found:?}");
            }
        }
        // Of 80 within two standard errors, 95 % of the normal distribution: 76, give or take 2; clusters are few, so a little fewer.
        let within = distances.iter().filter(|d| d.abs() < 2.0).count();
        assert!((66..=80).contains(&within), "{within}: {distances:.1?}");
        let spread = (distances.iter().map(|d| d * d).sum::<f64>() / 80.0).sqrt();
        assert!((0.7..1.4).contains(&spread), "{spread}: {distances:.1?}");
    }

    #[test]
    fn a_taut_tendon_and_a_rest_are_refused() {
        let refused = slack_friction(&SteadySamples::default()).unwrap_err().to_string();
        assert!(refused.contains("4 passes of a slack tendon in steady motion, pulling, got 0"), "{refused}");
        let all = samples([0.03; 2], 0.7e-3, 1);
        let pulling: Vec<bool> = all.velocity.iter().map(|v| *v > 0.0).collect();
        let refused = slack_friction(&all.selected(&pulling)).unwrap_err().to_string();
        assert!(refused.contains("releasing, got 0"), "{refused}");
    }
}
