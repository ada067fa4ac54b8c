//! From physical values to those that a network likes, and back.

use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

/// The range of a channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChannelRange {
    /// Its name, as in recordings.
    pub name: String,
    /// Smallest value, in the unit of the channel.
    pub min: f64,
    /// Largest value.
    pub max: f64,
}

/// Maps channels to [-1, 1] by their training ranges, and back; a constant channel maps to 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Normaliser {
    /// The channels, in order.
    pub channels: Vec<ChannelRange>,
}

impl Normaliser {
    /// Channels with given ranges.
    ///
    /// # Errors
    /// `BadInput` if a range is not finite or upside down, or a name comes twice.
    pub fn new(channels: Vec<ChannelRange>) -> Result<Self, BadInput> {
        for (k, channel) in channels.iter().enumerate() {
            let ChannelRange { name, min, max } = channel;
            // Also false for NaN, and for a width beyond the largest number.
            if !(min <= max && (max - min).is_finite()) {
                return Err(BadInput::new(name, "finite min <= max", format!("{min} to {max}")));
            }
            if channels[..k].iter().any(|other| other.name == *name) {
                return Err(BadInput::new(name, "every channel once", "twice"));
            }
        }
        Ok(Self { channels })
    }

    /// Ranges of samples, each with a value for each name.
    ///
    /// # Errors
    /// `BadInput` if there are none, one has another number of values, or a value is not finite.
    pub fn from_samples<'a>(
        names: &[&str],
        samples: impl IntoIterator<Item = &'a [f64]>,
    ) -> Result<Self, BadInput> {
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        let mut ranges = vec![none; names.len()];
        for (k, sample) in samples.into_iter().enumerate() {
            if sample.len() != names.len() {
                let expected = format!("{} values", names.len());
                return Err(BadInput::new(format!("sample {k}"), expected, sample.len().to_string()));
            }
            for ((range, value), name) in ranges.iter_mut().zip(sample).zip(names) {
                if !value.is_finite() {
                    let place = format!("sample {k}: {name}");
                    return Err(BadInput::new(place, "a finite value", value.to_string()));
                }
                *range = (range.0.min(*value), range.1.max(*value));
            }
        }
        if ranges.contains(&none) {
            return Err(BadInput::new("samples", "at least one", "none"));
        }
        let channels = names.iter().zip(ranges);
        Self::new(
            channels.map(|(name, (min, max))| ChannelRange { name: (*name).to_owned(), min, max }).collect(),
        )
    }

    /// The same ranges, but none narrower than `least`, so that a channel that is constant in the samples can
    /// still be fitted.
    ///
    /// # Errors
    /// As [`Normaliser::new`].
    pub fn widened(self, least: f64) -> Result<Self, BadInput> {
        let widened = |channel: ChannelRange| {
            let wider = (0.5 * least - 0.5 * (channel.max - channel.min)).max(0.0);
            ChannelRange { min: channel.min - wider, max: channel.max + wider, ..channel }
        };
        Self::new(self.channels.into_iter().map(widened).collect())
    }

    /// For each channel the scale a and shift b with which a value x that `other` has normalised is a x + b here.
    ///
    /// # Panics
    /// If the two have another number of channels.
    pub fn from_normalised(&self, other: &Self) -> Vec<[f64; 2]> {
        assert_eq!(self.channels.len(), other.channels.len(), "channels");
        let map = |(own, other): (&ChannelRange, &ChannelRange)| {
            let [width, of_other] = [own, other].map(|channel| channel.max - channel.min);
            if width > 0.0 {
                [of_other / width, (2.0 * (other.min - own.min) + of_other) / width - 1.0]
            } else {
                // A constant channel maps to 0.
                [0.0, 0.0]
            }
        };
        self.channels.iter().zip(&other.channels).map(map).collect()
    }

    /// Ranges that hold those of all `parts`, which have the same channels.
    ///
    /// # Errors
    /// `BadInput` if there is none.
    pub fn union(parts: &[&Self]) -> Result<Self, BadInput> {
        let first =
            parts.first().ok_or_else(|| BadInput::new("ranges", "at least one set of them", "none"))?;
        let channel = |k: usize| {
            let all = parts.iter().map(|part| &part.channels[k]);
            let ends = (f64::INFINITY, f64::NEG_INFINITY);
            let (min, max) = all.fold(ends, |(min, max), one| (min.min(one.min), max.max(one.max)));
            ChannelRange { name: first.channels[k].name.clone(), min, max }
        };
        Self::new((0..first.channels.len()).map(channel).collect())
    }

    /// Writes `values`, one for each channel, mapped to [-1, 1]; beyond where they are outside the ranges.
    ///
    /// # Panics
    /// If either has another number of channels.
    pub fn normalise_into(&self, values: &[f64], out: &mut [f32]) {
        assert_eq!([values.len(), out.len()], [self.channels.len(); 2], "channels");
        for ((channel, value), out) in self.channels.iter().zip(values).zip(out) {
            let width = channel.max - channel.min;
            *out = if width > 0.0 { (2.0 * (value - channel.min) / width - 1.0) as f32 } else { 0.0 };
        }
    }

    /// Writes the physical values of normalised ones; a constant channel is its constant.
    ///
    /// # Panics
    /// If either has another number of channels.
    pub fn restore_into(&self, values: &[f32], out: &mut [f64]) {
        assert_eq!([values.len(), out.len()], [self.channels.len(); 2], "channels");
        for ((channel, value), out) in self.channels.iter().zip(values).zip(out) {
            *out = channel.min + 0.5 * (f64::from(*value) + 1.0) * (channel.max - channel.min);
        }
    }

    /// Whether a value lies further outside its range than this fraction of the range's width; NaN does.
    ///
    /// # Panics
    /// If there is another number of channels.
    pub fn is_outside(&self, values: &[f64], margin_fraction: f64) -> bool {
        assert_eq!(values.len(), self.channels.len(), "channels");
        self.channels.iter().zip(values).any(|(channel, value)| {
            let margin = margin_fraction * (channel.max - channel.min);
            !(channel.min - margin..=channel.max + margin).contains(value)
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;

    fn range(name: &str, min: f64, max: f64) -> ChannelRange {
        ChannelRange { name: name.to_owned(), min, max }
    }

    #[test]
    fn ends_map_to_ones_and_back() {
        let samples = [[2.0, 7.0], [-1.0, 7.0], [0.5, 7.0]];
        let rows = samples.iter().map(|sample| &sample[..]);
        let normaliser = Normaliser::from_samples(&["a", "constant"], rows).unwrap();
        assert_eq!(normaliser.channels, [range("a", -1.0, 2.0), range("constant", 7.0, 7.0)]);
        for (values, expected) in
            [([2.0, 7.0], [1.0, 0.0]), ([-1.0, 7.0], [-1.0, 0.0]), ([0.5, 7.0], [0.0, 0.0])]
        {
            let (mut normal, mut back) = ([9.0; 2], [9.0; 2]);
            normaliser.normalise_into(&values, &mut normal);
            normaliser.restore_into(&normal, &mut back);
            assert_eq!((normal, back), (expected, values));
        }
    }

    #[test]
    fn outside_begins_beyond_the_margin() {
        let normaliser = Normaliser::new(vec![range("a", -1.0, 1.0), range("constant", 7.0, 7.0)]).unwrap();
        assert!(!normaliser.is_outside(&[1.0, 7.0], 0.0));
        assert!(normaliser.is_outside(&[1.01, 7.0], 0.0));
        assert!(!normaliser.is_outside(&[-1.49, 7.0], 0.25));
        assert!(normaliser.is_outside(&[-1.51, 7.0], 0.25));
        assert!(normaliser.is_outside(&[0.0, 7.01], 0.25));
        assert!(normaliser.is_outside(&[f64::NAN, 7.0], 0.25));
    }

    #[test]
    fn ranges_that_cannot_be_are_refused() {
        for (min, max) in [(1.0, 0.0), (f64::NAN, 0.0), (0.0, f64::INFINITY), (f64::MIN, f64::MAX)] {
            let bad = Normaliser::new(vec![range("a", min, max)]).unwrap_err();
            assert_eq!(bad.expected, "finite min <= max", "{min} {max}");
        }
        let bad = Normaliser::new(vec![range("a", 0.0, 1.0), range("a", 0.0, 1.0)]).unwrap_err();
        assert_eq!(bad.expected, "every channel once");
        let refused: [(&[&[f64]], &str); 3] =
            [(&[], "samples"), (&[&[1.0]], "sample 0"), (&[&[1.0, f64::NAN]], "sample 0: b")];
        for (samples, place) in refused {
            let bad = Normaliser::from_samples(&["a", "b"], samples.iter().copied()).unwrap_err();
            assert_eq!(bad.place, place, "{samples:?}");
        }
    }
}
