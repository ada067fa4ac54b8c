//! Finite Fourier series that begin and end at rest.
//!
//! q(t) = q₀ + Σ a_l sin(ω l t)/(ω l) − b_l (cos(ω l t) − 1)/(ω l), so that a and b are amplitudes of speed. a₁ and b₁ follow from speed and
//! acceleration at the start, which are zero: Σ a_l = 0, Σ l b_l = 0.
//!
//! # Reference
//! Swevers, Ganseman, Tükel, De Schutter, Van Brussel (1997), Optimal robot excitation and identification.

use super::{Motion, MotionLimits};

/// Samples for one cycle of the highest harmonic.
const PER_CYCLE: usize = 20;

/// A periodic motion of all joints.
#[derive(Debug, Clone, PartialEq)]
pub struct Fourier {
    /// [s].
    period: f64,
    harmonics: usize,
    /// Coordinates at the start [rad or m].
    start: Vec<f64>,
    /// Joint by joint the amplitudes of speed a₁ … a_L, b₁ … b_L [rad/s or m/s].
    amplitudes: Vec<f64>,
}

impl Fourier {
    /// Free numbers of each joint: its middle, a₂ … a_L, b₂ … b_L.
    pub(crate) fn numbers_of_joint(harmonics: usize) -> usize {
        1 + 2 * (harmonics - 1)
    }

    /// The series of these free numbers, joint by joint: the middle of its motion between the ends of its range (0 to 1), and
    /// amplitudes relative to its limit of speed (−1 to 1). The amplitudes of a joint that breaks a limit are reduced together until
    /// it keeps them.
    pub(crate) fn within(numbers: &[f64], (period, harmonics): (f64, usize), limits: &MotionLimits) -> Self {
        let (n, width) = (limits.range.len(), Self::numbers_of_joint(harmonics));
        let mut series =
            Self { period, harmonics, start: vec![0.0; n], amplitudes: vec![0.0; 2 * harmonics * n] };
        for joint in 0..n {
            let own = &numbers[width * joint..width * (joint + 1)];
            let (a, b) =
                series.amplitudes[2 * harmonics * joint..2 * harmonics * (joint + 1)].split_at_mut(harmonics);
            for l in 2..=harmonics {
                a[l - 1] = limits.speed[joint] * own[l - 1];
                b[l - 1] = limits.speed[joint] * own[harmonics + l - 2];
            }
            a[0] = -a[1..].iter().sum::<f64>();
            b[0] = -b.iter().enumerate().skip(1).map(|(l, b)| (l + 1) as f64 * b).sum::<f64>();
            let (mut low, mut high, mut speed, mut acceleration) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
            for s in 0..series.n_samples() {
                let [q, dq, ddq] = series.at(joint, period * s as f64 / series.n_samples() as f64);
                (low, high) = (low.min(q), high.max(q));
                (speed, acceleration) = (speed.max(dq.abs()), acceleration.max(ddq.abs()));
            }
            let [from, to] = limits.range[joint];
            let share = [
                (high - low) / (to - from),
                speed / limits.speed[joint],
                acceleration / limits.acceleration[joint],
            ];
            let most = share.into_iter().fold(1.0, f64::max);
            let own_amplitudes = &mut series.amplitudes[2 * harmonics * joint..2 * harmonics * (joint + 1)];
            own_amplitudes.iter_mut().for_each(|x| *x /= most);
            // The motion takes its part of the range; what is left is shared out before and behind it.
            let (low, high) = (low / most, high / most);
            series.start[joint] = from - low + own[0] * ((to - from) - (high - low));
        }
        series
    }

    /// The same with smaller amplitudes, about the same starts.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self { amplitudes: self.amplitudes.iter().map(|x| factor * x).collect(), ..self.clone() }
    }

    /// Samples on which limits are checked: enough for the highest harmonic.
    pub(crate) fn n_samples(&self) -> usize {
        PER_CYCLE * self.harmonics
    }
}

impl Motion for Fourier {
    fn at(&self, joint: usize, t: f64) -> [f64; 3] {
        let own = &self.amplitudes[2 * self.harmonics * joint..2 * self.harmonics * (joint + 1)];
        let (a, b) = own.split_at(self.harmonics);
        let (mut q, mut dq, mut ddq) = (self.start[joint], 0.0, 0.0);
        for l in 1..=self.harmonics {
            let w = 2.0 * std::f64::consts::PI * l as f64 / self.period;
            let (sin, cos) = (w * t).sin_cos();
            let (a, b) = (a[l - 1], b[l - 1]);
            q += (a * sin - b * (cos - 1.0)) / w;
            dq += a * cos + b * sin;
            ddq += w * (b * cos - a * sin);
        }
        [q, dq, ddq]
    }

    fn duration(&self) -> f64 {
        self.period
    }
}
