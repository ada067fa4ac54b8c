//! `JointHealth`: the condition of the watched joint from its torques, sample by sample.
//!
//! The external torque of a joint which no force on the tip explains, e = r − Jᵀ f̂ with f̂ of the other joints alone, is friction beyond the
//! identified one, a spring, or an error of the bodies. It is a line over what these would be:
//! ```text
//! e = φ(q, q̇, τ_m) · θ + noise,   φ = (−s, −|τ_m| s, −q̇, 1, q, (q − k₁)⁺, (q − k₂)⁺),   s = tanh(q̇/w)
//! ```
//! through the observer's low pass on both sides. Two Kalman filters follow the constant θ along a trajectory: one with the scatter of the
//! healthy trajectories of this arm as its prior, one with the scatter of a fault in addition. The logarithm of the ratio of their
//! likelihoods is the evidence for a healthy joint. No recording of a fault is needed for it.

use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

use hysteron_arm_dynamics::dense;

/// Coefficients of what a fault does: dry friction, its share of the motor's torque, viscous friction, a torque, a spring, and its rise
/// beyond either knot.
pub(super) const P: usize = 7;
/// Standard deviation that a fault adds to each: 0.1 N m, a tenth, 0.1 N m s/rad, 0.3 N m, and 0.5 N m/rad of
/// each spring.
const FAULT: [f64; P] = [0.1, 0.1, 0.1, 0.3, 0.5, 0.5, 0.5];
/// Least spreads of healthy coefficients, a tenth of that.
const FLOOR: f64 = 0.1;
/// Speed over which friction turns its sign [rad/s].
const WIDTH: f64 = 0.05;
/// Below this speed friction may be anything up to its dry part, and a sample has no information [rad/s].
const STANDSTILL_SPEED: f64 = 0.05;
/// Samples in a row that count as one: errors of friction last about as long as a motion of the joint in one direction.
pub(super) const ALIKE: f64 = 16.0;
/// Shares of the samples below either knot.
const KNOTS: [f64; 2] = [1.0 / 3.0, 2.0 / 3.0];

/// Scatter of the coefficients over healthy trajectories of an arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HealthModel {
    /// Angles beyond which the spring may be another [rad].
    knots: [f64; 2],
    /// Of the coefficients.
    mean: [f64; P],
    /// Row by row (P × P).
    covariance: Vec<f64>,
    /// Standard deviation of e about the line [N m].
    noise: f64,
}

/// A sample of the watched joint.
#[derive(Debug, Clone, Copy)]
pub(super) struct HealthSample {
    /// Angle [rad].
    pub position: f64,
    /// [rad/s].
    pub velocity: f64,
    /// Torque of its motor [N m].
    pub motor: f64,
    /// External torque that no force on the tip explains, through the low pass of the observer [N m].
    pub torque: f64,
    /// Its variance by that of the force [N² m²].
    pub variance: f64,
}

/// A Gaussian belief of the coefficients, and how well it has foretold.
#[derive(Debug, Clone)]
struct CoefficientPosterior {
    mean: [f64; P],
    covariance: Vec<f64>,
    /// Logarithm of its likelihood, but for a constant.
    evidence: f64,
}

impl CoefficientPosterior {
    fn new(mean: [f64; P], covariance: Vec<f64>) -> Self {
        Self { mean, covariance, evidence: 0.0 }
    }

    /// Takes e of a sample with its variance.
    fn update(&mut self, regressor: &[f64; P], torque: f64, variance: f64) {
        let row = |i: usize| &self.covariance[P * i..][..P];
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let spread: [f64; P] = std::array::from_fn(|i| dot(row(i), regressor));
        let total = dot(&spread, regressor) + variance;
        let off = torque - dot(&self.mean, regressor);
        self.evidence -= 0.5 * (total.ln() + off * off / total);
        for i in 0..P {
            self.mean[i] += spread[i] / total * off;
            for j in 0..P {
                self.covariance[P * i + j] -= spread[i] * spread[j] / total;
            }
        }
    }
}

/// The watched joint of one arm, sample by sample.
#[derive(Debug, Clone)]
pub(super) struct JointHealth {
    model: HealthModel,
    /// Part of the way to a new value in a sample, as that of the observer.
    share: f64,
    regressor: [f64; P],
    /// As healthy joints are, and as others may be.
    beliefs: [CoefficientPosterior; 2],
}

/// φ before the low pass.
fn regressor(sample: &HealthSample, knots: [f64; 2]) -> [f64; P] {
    let HealthSample { position: q, velocity, motor, .. } = *sample;
    let sign = (velocity / WIDTH).tanh();
    [-sign, -motor.abs() * sign, -velocity, 1.0, q, (q - knots[0]).max(0.0), (q - knots[1]).max(0.0)]
}

/// A matrix with these on its diagonal.
fn diagonal(values: [f64; P]) -> Vec<f64> {
    let mut matrix = vec![0.0; P * P];
    values.into_iter().enumerate().for_each(|(i, value)| matrix[(P + 1) * i] = value);
    matrix
}

impl JointHealth {
    /// Numbers that [`Self::channels`] writes.
    pub const CHANNELS: usize = P + 1;

    /// For samples every `period` [s], seen through an observer of this gain [1/s].
    pub fn new(model: &HealthModel, (period, gain): (f64, f64)) -> Self {
        let wide: Vec<f64> = model
            .covariance
            .iter()
            .zip(diagonal(FAULT.map(|s| s * s)))
            .map(|(own, more)| own + more)
            .collect();
        let beliefs = [model.covariance.clone(), wide]
            .map(|covariance| CoefficientPosterior::new(model.mean, covariance));
        let share = gain * period / (1.0 + gain * period);
        Self { model: model.clone(), share, regressor: [0.0; P], beliefs }
    }

    /// Takes a sample.
    pub fn update(&mut self, sample: &HealthSample) {
        for (slow, now) in self.regressor.iter_mut().zip(regressor(sample, self.model.knots)) {
            *slow += self.share * (now - *slow);
        }
        if sample.velocity.abs() > STANDSTILL_SPEED {
            let variance = ALIKE * (self.model.noise * self.model.noise + sample.variance);
            for belief in &mut self.beliefs {
                belief.update(&self.regressor, sample.torque, variance);
            }
        }
    }

    /// Logarithm of the likelihood of what was seen if the joint is healthy, over that if it is not.
    pub fn evidence(&self) -> f64 {
        self.beliefs[0].evidence - self.beliefs[1].evidence
    }

    /// Coefficients less those of healthy joints, over the spread of both, and the evidence, compressed.
    pub fn channels(&self) -> impl Iterator<Item = f64> + '_ {
        let [_, found] = &self.beliefs;
        let off = move |i: usize| {
            let variance = found.covariance[(P + 1) * i] + self.model.covariance[(P + 1) * i];
            (found.mean[i] - self.model.mean[i]) / variance.sqrt()
        };
        (0..P).map(off).chain([self.evidence().asinh()])
    }
}

impl HealthModel {
    /// From samples of healthy trajectories, period and gain of the observer as [`JointHealth::new`] has them.
    ///
    /// # Errors
    /// `BadInput` where none of them moves the joint.
    pub(super) fn fit(trajectories: &[Vec<HealthSample>], about: (f64, f64)) -> Result<Self, BadInput> {
        let moves = |sample: &&HealthSample| sample.velocity.abs() > STANDSTILL_SPEED;
        let mut angles: Vec<f64> =
            trajectories.iter().flatten().filter(moves).map(|sample| sample.position).collect();
        if angles.len() < 100 {
            let found = format!("{} of them", angles.len());
            return Err(BadInput::new(
                "training recordings",
                "100 samples in which the watched joint moves",
                found,
            ));
        }
        angles.sort_by(f64::total_cmp);
        let knots = KNOTS.map(|share| angles[(share * angles.len() as f64) as usize]);
        // Nothing is known before; a first round finds the noise.
        let anything =
            |noise: f64| Self { knots, mean: [0.0; P], covariance: diagonal(FAULT.map(|s| s * s)), noise };
        let squares = |noise: f64| {
            let all = trajectories.iter().map(|samples| anything(noise).left(samples, about));
            all.fold([0.0; 2], |sum, one| [sum[0] + one[0], sum[1] + one[1]])
        };
        let [sum, n] = squares(0.05);
        let noise = (sum / n.max(1.0)).sqrt().max(1e-3);
        let start = anything(noise);
        let found: Vec<[f64; P]> = trajectories
            .iter()
            .filter(|samples| samples.iter().filter(moves).count() > WINDOW)
            .map(|samples| start.along(samples, about).beliefs[1].mean)
            .collect();
        let n = found.len().max(1) as f64;
        let mean: [f64; P] = std::array::from_fn(|i| found.iter().map(|one| one[i]).sum::<f64>() / n);
        let mut covariance = diagonal(FAULT.map(|s| (FLOOR * s).powi(2)));
        for one in &found {
            for i in 0..P {
                for j in 0..P {
                    covariance[P * i + j] += (one[i] - mean[i]) * (one[j] - mean[j]) / n;
                }
            }
        }
        Ok(Self { knots, mean, covariance, noise })
    }

    fn along(&self, samples: &[HealthSample], about: (f64, f64)) -> JointHealth {
        let mut health = JointHealth::new(self, about);
        samples.iter().for_each(|sample| health.update(sample));
        health
    }

    /// Sum of squares about the line that is found last, and samples.
    fn left(&self, samples: &[HealthSample], about: (f64, f64)) -> [f64; 2] {
        let found = self.along(samples, about).beliefs[1].mean;
        let mut again = JointHealth::new(self, about);
        let mut sums = [0.0; 2];
        for sample in samples {
            again.update(sample);
            if sample.velocity.abs() > STANDSTILL_SPEED {
                let line: f64 = found.iter().zip(&again.regressor).map(|(a, b)| a * b).sum();
                sums[0] += (sample.torque - line).powi(2);
                sums[1] += 1.0;
            }
        }
        sums
    }

    /// # Errors
    /// `BadInput` where the covariance is none.
    pub(super) fn check(&self) -> Result<(), BadInput> {
        let bad = |expected: &str| BadInput::new("covariance", expected, "another");
        if self.covariance.len() != P * P {
            return Err(bad(&format!("{P} × {P} numbers")));
        }
        let mut factor = self.covariance.clone();
        dense::factor(P, &mut factor);
        let is_positive = (0..P).all(|i| factor[(P + 1) * i] > 0.0 && factor[(P + 1) * i].is_finite());
        let is_finite = self.mean.iter().chain(&self.knots).all(|x| x.is_finite());
        if !(is_positive && is_finite && self.noise > 0.0 && self.noise.is_finite()) {
            return Err(bad("positive definite, with finite numbers and a noise above zero"));
        }
        Ok(())
    }
}

/// Fewest samples in motion of an informative trajectory.
const WINDOW: usize = 64;

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use hysteron_base::rng;
    use rand::RngExt;

    use super::*;

    /// No low pass: a gain beyond any period.
    const ABOUT: (f64, f64) = (0.017, 1e18);

    /// Waves of a joint with friction of `dry` beyond the identified, a band of `band` [N m/rad] from 0.2 rad on, and scatter.
    fn samples(seed: u64, dry: f64, band: f64) -> Vec<HealthSample> {
        let mut stream = rng(seed, "health");
        let (rate, phase) = (stream.random_range(1.0..2.0), stream.random_range(0.0..6.0));
        (0..400)
            .map(|row| {
                let x = rate * 0.017 * f64::from(row) + phase;
                let (position, velocity) = (0.6 * x.sin(), 0.6 * rate * x.cos());
                let scatter = 0.03 * stream.random_range(-1.0..1.0);
                let torque = scatter - dry * (velocity / WIDTH).tanh() - band * (position - 0.2).max(0.0);
                HealthSample { position, velocity, motor: 0.5, torque, variance: 0.0 }
            })
            .collect()
    }

    fn healthy() -> HealthModel {
        let of = |seed: u64| samples(seed, 0.01 * (seed % 3) as f64, 0.0);
        HealthModel::fit(&(0..9).map(of).collect::<Vec<_>>(), ABOUT).unwrap()
    }

    #[test]
    fn friction_and_bands_speak_against_a_joint_and_nothing_does_for_a_healthy_one() {
        let model = healthy();
        model.check().unwrap();
        let evidence = |dry, band| model.along(&samples(20, dry, band), ABOUT).evidence();
        assert!(evidence(0.01, 0.0) > 1.0, "{}", evidence(0.01, 0.0));
        for (dry, band) in [(0.15, 0.0), (0.01, 0.5)] {
            assert!(evidence(dry, band) < -5.0, "{dry} {band}: {}", evidence(dry, band));
        }
        let off: Vec<f64> = model.along(&samples(20, 0.15, 0.0), ABOUT).channels().collect();
        assert_eq!(off.len(), JointHealth::CHANNELS);
    }

    #[test]
    fn the_evidence_is_the_ratio_of_two_gaussian_densities() {
        let model = healthy();
        let few: Vec<HealthSample> = samples(3, 0.1, 0.2)
            .into_iter()
            .filter(|one| one.velocity.abs() > STANDSTILL_SPEED)
            .take(5)
            .collect();
        let found = model.along(&few, ABOUT);
        let rows: Vec<[f64; P]> = few.iter().map(|one| regressor(one, model.knots)).collect();
        let density = |covariance: &[f64]| {
            let n = few.len();
            let mut whole = vec![0.0; n * n];
            for i in 0..n {
                for j in 0..n {
                    whole[n * i + j] =
                        (0..P * P).map(|k| rows[i][k / P] * covariance[k] * rows[j][k % P]).sum::<f64>();
                }
                whole[n * i + i] += ALIKE * model.noise * model.noise;
            }
            let off: Vec<f64> = few
                .iter()
                .zip(&rows)
                .map(|(one, row)| one.torque - row.iter().zip(&model.mean).map(|(a, b)| a * b).sum::<f64>())
                .collect();
            dense::factor(n, &mut whole);
            let mut solved = off.clone();
            dense::solve_columns(n, &whole, &mut solved);
            // The factor has the reciprocal pivots on its diagonal.
            let log_determinant: f64 = -(0..n).map(|i| whole[n * i + i].ln()).sum::<f64>();
            -0.5 * (log_determinant + off.iter().zip(&solved).map(|(a, b)| a * b).sum::<f64>())
        };
        let wide: Vec<f64> =
            model.covariance.iter().zip(diagonal(FAULT.map(|s| s * s))).map(|(a, b)| a + b).collect();
        let expected = density(&model.covariance) - density(&wide);
        // Five updates of variances that differ by 1e4.
        assert!((found.evidence() - expected).abs() < 1e-9, "{} {expected}", found.evidence());
    }

    #[test]
    fn a_joint_that_never_moves_and_a_covariance_that_is_none_are_refused() {
        let still: Vec<HealthSample> =
            samples(1, 0.0, 0.0).into_iter().map(|one| HealthSample { velocity: 0.0, ..one }).collect();
        let found = HealthModel::fit(&[still], ABOUT).unwrap_err().to_string();
        assert!(found.contains("100 samples in which the watched joint moves"), "{found}");
        let mut model = healthy();
        model.covariance[0] = -1.0;
        assert!(model.check().unwrap_err().to_string().contains("positive definite"));
    }
}
