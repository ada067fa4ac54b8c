//! A summary of a channel that can be merged: count, extremes, moments and a histogram.
//!
//! Mean and squared deviations are merged by the formulas of Chan, Golub and LeVeque (1979), which do not cancel as sums of squares
//! do. The histogram needs no range beforehand: its bins are eighths of an octave of the magnitude, cut from the bits of the number,
//! so that the same numbers fall into the same bins on every machine.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Bits of a double below the three first ones of its fraction.
const SHIFT: u32 = 49;
/// Those three bits and the exponent of 1.
const ONE: i64 = 1023 << 3;
/// A magnitude below this counts as zero: a picometre, or what rounding leaves.
const SMALLEST: f64 = 1e-12;

/// Count, extremes, moments and histogram of the values of a channel [unit of the channel].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ChannelSketch {
    /// Values.
    pub count: u64,
    /// Smallest value; 0 without values.
    pub min: f64,
    /// Largest value; 0 without values.
    pub max: f64,
    /// Mean.
    pub mean: f64,
    /// Sum of the squared deviations from the mean.
    pub squared_deviations: f64,
    /// Values of a magnitude below 1e-12.
    zeros: u64,
    /// Positive values by bin.
    positive: BTreeMap<i64, u64>,
    /// Negative values by the bin of their magnitude.
    negative: BTreeMap<i64, u64>,
}

impl ChannelSketch {
    /// Of these values.
    pub fn of(values: &[f64]) -> Self {
        let mut sketch = Self::default();
        let Some(first) = values.first() else { return sketch };
        (sketch.count, sketch.min, sketch.max) = (values.len() as u64, *first, *first);
        sketch.mean = values.iter().sum::<f64>() / values.len() as f64;
        for x in values {
            sketch.min = sketch.min.min(*x);
            sketch.max = sketch.max.max(*x);
            sketch.squared_deviations += (x - sketch.mean).powi(2);
            match x {
                _ if x.abs() < SMALLEST => sketch.zeros += 1,
                _ if *x > 0.0 => *sketch.positive.entry(bin(*x)).or_default() += 1,
                _ => *sketch.negative.entry(bin(*x)).or_default() += 1,
            }
        }
        sketch
    }

    /// Adds the values of another one.
    pub fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        if self.count == 0 {
            self.clone_from(other);
            return;
        }
        let (n, m) = (self.count as f64, other.count as f64);
        let apart = other.mean - self.mean;
        self.mean += apart * m / (n + m);
        self.squared_deviations += other.squared_deviations + apart * apart * n * m / (n + m);
        self.count += other.count;
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
        self.zeros += other.zeros;
        for (own, others) in [(&mut self.positive, &other.positive), (&mut self.negative, &other.negative)] {
            others.iter().for_each(|(bin, count)| *own.entry(*bin).or_default() += count);
        }
    }

    /// Standard deviation.
    pub fn deviation(&self) -> f64 {
        (self.squared_deviations / self.count.max(1) as f64).sqrt()
    }

    /// The value that a part of all values does not pass, good to a sixteenth of itself.
    pub fn quantile(&self, part: f64) -> f64 {
        let rank = (part * self.count.saturating_sub(1) as f64).round() as u64;
        let negative = self.negative.iter().rev().map(|(bin, count)| (-middle(*bin), *count));
        let positive = self.positive.iter().map(|(bin, count)| (middle(*bin), *count));
        let mut below = 0;
        let mut bins = negative.chain([(0.0, self.zeros)]).chain(positive);
        let found = bins.find(|(_, count)| {
            below += count;
            below > rank
        });
        found.map_or(self.max, |(value, _)| value).clamp(self.min, self.max)
    }
}

/// The eighth of an octave in which a magnitude lies: 0 from 1 to 1.125.
fn bin(x: f64) -> i64 {
    (x.abs().to_bits() >> SHIFT).cast_signed() - ONE
}

/// The middle of a bin.
fn middle(bin: i64) -> f64 {
    let edge = |bin: i64| f64::from_bits((bin + ONE).cast_unsigned() << SHIFT);
    0.5 * (edge(bin) + edge(bin + 1))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;
    use hysteron_base::json;

    fn values() -> Vec<f64> {
        let mut stream = hysteron_base::rng(3, "sketch");
        let mut draw = || 1e-3 * hysteron_base::normal(&mut stream) + 4e-4;
        let mut values: Vec<f64> = (0..10_000).map(|_| draw()).collect();
        values.extend([0.0; 50]);
        values
    }

    #[test]
    fn merged_parts_are_the_whole() {
        let values = values();
        let whole = ChannelSketch::of(&values);
        let mut merged = ChannelSketch::default();
        for part in values.chunks(777) {
            let text = json::to_text(ChannelSketch::of(part)).unwrap();
            merged.merge(&json::from_text(text).unwrap());
        }
        merged.merge(&ChannelSketch::default());
        assert_eq!((merged.count, merged.min, merged.max), (whole.count, whole.min, whole.max));
        assert_eq!(
            (merged.zeros, &merged.positive, &merged.negative),
            (whole.zeros, &whole.positive, &whole.negative)
        );
        // Rounding of sums of 1e4 numbers.
        let is_near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
        assert!(is_near(merged.mean, whole.mean) && is_near(merged.deviation(), whole.deviation()));
    }

    #[test]
    fn quantiles_are_within_a_sixteenth() {
        let mut values = values();
        let sketch = ChannelSketch::of(&values);
        values.sort_by(f64::total_cmp);
        for part in [0.0, 0.01, 0.1, 0.3, 0.5, 0.9, 0.99, 1.0] {
            let exact = values[(part * (values.len() - 1) as f64).round() as usize];
            let found = sketch.quantile(part);
            assert!((found - exact).abs() <= exact.abs() / 16.0 + SMALLEST, "{part}: {found} {exact}");
        }
    }
}
