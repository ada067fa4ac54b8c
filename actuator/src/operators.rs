//! The operators that hysteresis is made of, for several signals at once: play, which friction and backlash make
//! (Prandtl-Ishlinskii), and first-order filters, which viscous material makes (Maxwell elements).

use crate::Play;

/// Plays and first-order filters of several signals, sample by sample.
#[derive(Debug, Clone)]
pub struct OperatorBank {
    widths: Vec<f64>,
    /// Part of the way that each filter goes in a sample.
    parts: Vec<f64>,
    /// For each signal, its plays; none before the first sample.
    plays: Vec<Play>,
    /// For each signal, the outputs of its filters.
    filtered: Vec<f64>,
}

impl OperatorBank {
    /// Plays of these widths, in the unit of the signals, and filters of these time constants [s], for samples of `step` [s].
    pub fn new(widths: &[f64], time_constants: &[f64], step: f64) -> Self {
        Self {
            widths: widths.to_vec(),
            parts: time_constants.iter().map(|time| 1.0 - (-step / time).exp()).collect(),
            plays: Vec::new(),
            filtered: Vec::new(),
        }
    }

    /// Begins with these values, at which everything rests.
    pub fn begin(&mut self, values: &[f64]) {
        self.plays.clear();
        self.filtered.clear();
        for &value in values {
            self.plays.extend(self.widths.iter().map(|&width| Play::new(width, value)));
            self.filtered.extend(self.parts.iter().map(|_| value));
        }
    }

    /// Goes on with the next value of signal `k` and appends how far each of its plays, then each of its filters is from it.
    ///
    /// # Panics
    /// If it did not begin with so many signals.
    pub fn append(&mut self, k: usize, value: f64, out: &mut Vec<f64>) {
        let (n_plays, n_filters) = (self.widths.len(), self.parts.len());
        for play in &mut self.plays[k * n_plays..(k + 1) * n_plays] {
            out.push(play.follow(value) - value);
        }
        // Exact for a value that is constant over the sample.
        for (filtered, part) in self.filtered[k * n_filters..(k + 1) * n_filters].iter_mut().zip(&self.parts)
        {
            *filtered += part * (value - *filtered);
            out.push(*filtered - value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_passes_the_play_at_once_and_the_filter_with_its_time_constant() {
        let (mut bank, mut out) = (OperatorBank::new(&[0.5], &[0.1], 0.01), Vec::new());
        bank.begin(&[3.0, 0.0]);
        for _ in 0..10 {
            out.clear();
            bank.append(0, 3.0, &mut out);
            bank.append(1, 2.0, &mut out);
        }
        // The first signal rests. After one time constant a filter is 1/e from its input, a play half its width behind or as
        // its definition requires.
        assert_eq!(out[..2], [0.0, 0.0]);
        assert_eq!(out[2], Play::new(0.5, 0.0).follow(2.0) - 2.0);
        assert!((out[3] + 2.0 * (-1.0f64).exp()).abs() < 1e-12, "{out:?}");
    }
}
