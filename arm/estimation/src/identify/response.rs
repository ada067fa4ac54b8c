//! How measured torques follow those of the rigid arm: they may lead or lag, and grow or shrink with the frequency.
//!
//! Sensors and encoders have filters and latencies of their own, and joints with springs are not rigid: τ + a τ̇ + b τ̈ is the beginning of
//! any linear response between both. Bodies are identified first and do not change.

use hysteron_base::BadInput;

use super::bodies::BodyFit;
use super::motion::{JointMotion, rms_left};

/// Motions have one rate if theirs differ by no more than this [-].
const SAME_RATE: f64 = 1e-3;

/// The torque that is measured where the rigid arm has τ: τ + a τ̇ + b τ̈, joint by joint.
#[derive(Debug, Clone, PartialEq)]
pub struct TorqueResponse {
    /// a: by how much what is measured is ahead (n_joints) [s].
    pub lead: Vec<f64>,
    /// b (n_joints) [s²].
    pub second: Vec<f64>,
    period: f64,
}

impl TorqueResponse {
    /// The response that leaves least of the torques of `motions`.
    ///
    /// # Errors
    /// `BadInput` for no motion, or motions of different rates.
    pub fn identify(fit: &BodyFit, motions: &[&JointMotion]) -> Result<Self, BadInput> {
        let Some(period) = motions.first().map(|motion| motion.period) else {
            return Err(BadInput::new("recordings", "one or more", "none"));
        };
        if let Some(other) = motions.iter().find(|motion| (motion.period / period - 1.0).abs() > SAME_RATE) {
            let found = format!("{:.1} and {:.1} samples per second", 1.0 / period, 1.0 / other.period);
            return Err(BadInput::new("recordings", "one rate, for the response of measured torques", found)
                .hint("`hysteron import --rate HZ` resamples a file"));
        }
        let rigid: Vec<Vec<f64>> = motions.iter().map(|motion| fit.torques(motion)).collect();
        let parts = rigid.iter().zip(motions).map(|(rigid, motion)| [&rigid[..], &motion.tau[..]]);
        Ok(Self::of_rows(parts, fit.model.n_joints(), period))
    }

    /// The response that leaves least of measured torques; of each motion the torques of the rigid arm and those measured, row by row
    /// of `n` joints [N m].
    pub fn of_rows<'a>(motions: impl Iterator<Item = [&'a [f64]; 2]>, n: usize, period: f64) -> Self {
        // Σ of squares and products of the two changes, and of their products with what the rigid arm leaves.
        let mut sums = vec![[0.0; 5]; n];
        for [rigid, measured] in motions {
            for (k, measured) in measured.iter().enumerate() {
                let [first, second] = changes(rigid, n, k);
                let left = measured - rigid[k];
                let products = [first * first, first * second, second * second, first * left, second * left];
                sums[k % n].iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
            }
        }
        let solved = sums.iter().map(|[a, b, c, x, y]| {
            let determinant = a * c - b * b;
            // A torque that does not change has no response.
            let is_determined = determinant > f64::EPSILON * a * c;
            if is_determined {
                [(c * x - b * y) / determinant, (a * y - b * x) / determinant]
            } else {
                [0.0; 2]
            }
        });
        let (lead, second) = solved.map(|[a, b]| (a * period, b * period * period)).unzip();
        Self { lead, second, period }
    }

    /// The torques that are measured in a motion, row by row [N m].
    pub fn torques(&self, fit: &BodyFit, motion: &JointMotion) -> Vec<f64> {
        self.applied(&fit.torques(motion))
    }

    /// The torques that are measured where the rigid arm has `rigid`, row by row of one motion [N m].
    pub fn applied(&self, rigid: &[f64]) -> Vec<f64> {
        let n = self.lead.len();
        let at = |k: usize| {
            let [first, second] = changes(rigid, n, k);
            let [lead, curve] = [self.lead[k % n] / self.period, self.second[k % n] / self.period.powi(2)];
            rigid[k] + lead * first + curve * second
        };
        (0..rigid.len()).map(at).collect()
    }

    /// Root mean square of what is left of every joint's torque in these motions [N m].
    pub fn rms_on(&self, fit: &BodyFit, motions: &[&JointMotion]) -> Vec<f64> {
        rms_left(motions.iter().copied(), self.lead.len(), |motion| self.torques(fit, motion))
    }
}

/// First and second central difference of every `n`-th of `rows` at `k`; none at the ends.
fn changes(rows: &[f64], n: usize, k: usize) -> [f64; 2] {
    match (k.checked_sub(n).map(|before| rows[before]), rows.get(k + n)) {
        (Some(before), Some(after)) => [0.5 * (after - before), after - 2.0 * rows[k] + before],
        _ => [0.0; 2],
    }
}
