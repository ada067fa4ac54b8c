//! Axes: round ticks, and labels with enough digits to distinguish them.
//!
//! An axis has at least three ticks at multiples of 1, 2 or 5 times a power of ten, for any range. Labels show as
//! many digits as the step has. Where numbers would be long, a power of ten or an offset goes into the axis' name.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;

/// Fewest ticks of an axis.
const MIN_TICKS: usize = 3;
/// Thinnest range over the largest value in it: doubles hold three digits more.
const THINNEST: f64 = 1e-9;
/// Largest and smallest range: their powers of ten are doubles.
const LARGEST: f64 = 1e290;
const SMALLEST: f64 = 1e-290;
/// Widths of the range away from zero beyond which labels count from an offset.
const FAR: f64 = 1e3;
/// Largest and smallest label without a power of ten.
const LARGEST_LABEL: f64 = 1e5;
const SMALLEST_LABEL: f64 = 1e-2;
/// Most characters of a label that fit next to an axis.
const LONGEST_LABEL: usize = 6;
/// Widths of the range away from zero beyond which labels that are too long count from an offset.
const AWAY: f64 = 5.0;

/// A range with its ticks.
#[derive(Clone)]
pub struct Axis {
    coordinate: RangedCoordf64,
    ticks: Vec<f64>,
    /// Value that labels count from.
    offset: f64,
    /// Power of ten that labels are divided by.
    exponent: i32,
    /// Power of ten of the step between ticks.
    power: i32,
}

impl Axis {
    /// An axis over a finite range with about `most` ticks, and at least three.
    pub fn new(range: &Range<f64>, most: usize) -> Self {
        Self::with_step(range, |low, high| step(low, high, most))
    }

    /// The same for what is counted: joints have no halves, and so few ticks there may be.
    pub fn of_counts(range: &Range<f64>, most: usize) -> Self {
        Self::with_step(range, |low, high| match step(low, high, most) {
            (_, power) if power < 0 => (1, 0),
            step => step,
        })
    }

    /// An axis whose ticks are a step apart, a factor 1, 2 or 5 and a power of ten. Its labels are plain numbers where
    /// these are short.
    fn with_step(range: &Range<f64>, step: impl Fn(f64, f64) -> (u8, i32)) -> Self {
        let range = drawable(range);
        let (span, far) = (range.end - range.start, range.start.abs().max(range.end.abs()));
        let round = 10f64.powi(span.log10().ceil() as i32);
        let offset = (range.start / round).floor() * round;
        let plain = (far <= FAR * span).then(|| Self::counted_from(0.0, &range, &step));
        if let Some(plain) = plain.filter(Self::has_short_labels) {
            return plain;
        }
        let counted = Self::counted_from(if far > AWAY * span { offset } else { 0.0 }, &range, &step);
        if counted.has_short_labels() { counted } else { counted.in_powers_of_thousand() }
    }

    fn counted_from(offset: f64, range: &Range<f64>, step: impl Fn(f64, f64) -> (u8, i32)) -> Self {
        let (low, high) = (range.start - offset, range.end - offset);
        let (magnitude, power) = step(low, high);
        let step = f64::from(magnitude) * 10f64.powi(power);
        let first = (low / step).ceil();
        let places = (0..count(low, high, step)).map(|k| (first + k as f64) * step);
        let ticks = places.map(|place| (offset + place).clamp(low + offset, high + offset)).collect();
        Self { coordinate: range.clone().into(), ticks, offset, exponent: 0, power }
    }

    fn in_powers_of_thousand(self) -> Self {
        let exponent = 3 * (self.largest().log10() / 3.0).floor() as i32;
        Self { exponent, ..self }
    }

    /// Largest number that a label counts.
    fn largest(&self) -> f64 {
        self.ticks.iter().fold(0.0, |most: f64, tick| most.max((tick - self.offset).abs()))
    }

    fn has_short_labels(&self) -> bool {
        let is_short = |tick: &f64| self.label(*tick).chars().count() <= LONGEST_LABEL;
        (SMALLEST_LABEL..LARGEST_LABEL).contains(&self.largest()) && self.ticks.iter().all(is_short)
    }

    /// The axis with fewer ticks where their labels, each so many pixels long, have no room on `length` pixels.
    pub(crate) fn thinned(mut self, length: f64, size: impl Fn(&str) -> f64) -> Self {
        let widest = self.ticks.iter().map(|tick| size(&self.label(*tick))).fold(0.0, f64::max);
        let apart = match self.ticks[..] {
            [first, second, ..] => (self.part(second) - self.part(first)) * length,
            _ => return self,
        };
        let every = (widest / apart).ceil() as usize;
        if every < 2 {
            return self;
        }
        // Zero stays, if it leaves another.
        let n = self.ticks.len();
        let zero = self.ticks.iter().position(|tick| (tick - self.offset).abs() < 1e-9 * self.largest());
        let first = zero.map_or(0, |zero| zero % every);
        let first = if first + every < n { first } else { 0 };
        self.ticks = self.ticks.into_iter().skip(first).step_by(every).collect();
        self
    }

    /// Place of a value between the ends, 0 to 1.
    pub(crate) fn part(&self, value: f64) -> f64 {
        let [low, high] = self.ends();
        (value - low) / (high - low)
    }

    /// Values at both ends.
    pub(crate) fn ends(&self) -> [f64; 2] {
        let range = self.coordinate.range();
        [range.start, range.end]
    }

    /// The axis' name, with what its labels are to be multiplied by and added to.
    pub fn named(&self, name: &str) -> String {
        let factor = if self.exponent == 0 { String::new() } else { format!(" \u{d7} 1e{}", self.exponent) };
        let offset = match self.offset {
            0.0 => String::new(),
            offset if offset.abs() < 1e9 => {
                // A multiple of the power of ten above the range: more digits are rounding.
                let [low, high] = self.ends();
                let decimals = usize::try_from(-((high - low).log10().ceil() as i32)).unwrap_or(0);
                format!(" + {offset:.decimals$}")
            }
            offset => format!(" + {offset:e}"),
        };
        let count = format!("{factor}{offset}").replace("+ -", "- ").replace('-', "\u{2212}");
        format!("{name}{count}")
    }

    /// The label of a tick, with a true minus sign.
    pub fn label(&self, tick: f64) -> String {
        let value = (tick - self.offset) / 10f64.powi(self.exponent);
        let decimals = usize::try_from(self.exponent - self.power).unwrap_or(0);
        let text = format!("{value:.decimals$}");
        // Rounded to nothing from below.
        let is_zero = text.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.'));
        if is_zero { text.trim_start_matches('-').to_owned() } else { text.replace('-', "\u{2212}") }
    }
}

/// The range itself, or a wider one around it that has ticks.
fn drawable(range: &Range<f64>) -> Range<f64> {
    let clamped = |value: f64| value.clamp(-LARGEST, LARGEST);
    let (low, high) = (clamped(range.start.min(range.end)), clamped(range.start.max(range.end)));
    let far = low.abs().max(high.abs());
    let thinnest = (THINNEST * far).max(SMALLEST);
    if high - low >= thinnest {
        return low..high;
    }
    let half = if far < SMALLEST { 0.5 } else { 0.5 * thinnest };
    let middle = 0.5 * low + 0.5 * high;
    middle - half..middle + half
}

/// A step as factor 1, 2 or 5 and power of ten: the finest with at most `most` ticks where it has three, or else the
/// coarsest with three.
fn step(low: f64, high: f64, most: usize) -> (u8, i32) {
    let power = (high - low).log10().ceil() as i32;
    // The first has two ticks at most, the last ten or more.
    let all = (0..3).flat_map(|finer| [5, 2, 1].map(|factor| (factor, power - finer)));
    let counted: Vec<((u8, i32), usize)> = all
        .map(|(factor, power)| ((factor, power), count(low, high, f64::from(factor) * 10f64.powi(power))))
        .filter(|(_, n)| *n >= MIN_TICKS)
        .collect();
    let finest = counted.iter().rev().find(|(_, n)| *n <= most);
    finest.or(counted.first()).map_or((1, power - 2), |(step, _)| *step)
}

/// Number of multiples of the step in a range.
fn count(low: f64, high: f64, step: f64) -> usize {
    ((high / step).floor() - (low / step).ceil() + 1.0) as usize
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.coordinate.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.coordinate.range()
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, tick: &f64) -> String {
        self.label(*tick)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(range: Range<f64>, most: usize) -> Vec<String> {
        let axis = Axis::new(&range, most);
        axis.ticks.iter().map(|tick| axis.label(*tick)).collect()
    }

    fn check(range: Range<f64>, most: usize) {
        let axis = Axis::new(&range, most);
        let labels = labels(range.clone(), most);
        assert!(labels.len() >= MIN_TICKS, "{range:?}, at most {most}: {labels:?}");
        // The step before has less than three, so that the range is less than three of it; the next is 2.5 times finer.
        assert!(labels.len() <= most.max(8), "{range:?}, at most {most}: {labels:?}");
        for (k, label) in labels.iter().enumerate() {
            assert!(!labels[..k].contains(label), "{range:?}, at most {most}: {labels:?}");
            assert!(label.chars().count() <= LONGEST_LABEL + 1, "{range:?}, at most {most}: {label}");
            assert!(!label.contains("NaN") && !label.contains("inf"), "{range:?}: {label}");
        }
        let shown = Ranged::range(&axis);
        let inside = |tick: &f64| (shown.start..=shown.end).contains(tick);
        assert!(axis.ticks.iter().all(inside), "{range:?}, {:?} in {shown:?}", axis.ticks);
    }

    #[test]
    fn joints_have_no_halves() {
        let labels = |range: Range<f64>| -> Vec<String> {
            let axis = Axis::of_counts(&range, 8);
            axis.ticks.iter().map(|tick| axis.label(*tick)).collect()
        };
        assert_eq!(labels(0.95..2.05), ["1", "2"]);
        assert_eq!(labels(0.7..7.3), ["1", "2", "3", "4", "5", "6", "7"]);
        assert_eq!(labels(-1.5..31.5), ["0", "5", "10", "15", "20", "25", "30"]);
    }

    #[test]
    fn strokes_of_a_few_millimetres_have_more_labels_than_zero() {
        assert_eq!(labels(-8.3..8.3, 3), ["\u{2212}5", "0", "5"]);
        assert_eq!(labels(0.0..1.0, 5), ["0.0", "0.5", "1.0"]);
        assert_eq!(labels(-0.0123..0.0004, 4), ["\u{2212}0.010", "\u{2212}0.005", "0.000"]);
    }

    #[test]
    fn every_kind_of_range_has_three_labels_that_differ() {
        let constant = [0.0, 1.0, -3.7, 1e-12, 1e12, -1e300, 5e-324, f64::MAX];
        let small = [1e-300, 1e-15, 1e-6, 1e-3, 0.4999, 0.9, 1.0, 9.99, 1e3, 1e6, 1e15, 1e300];
        for most in 1..14 {
            constant.iter().for_each(|value| check(*value..*value, most));
            for width in small {
                for start in [0.0, -width, -0.3 * width, 1.0, -1.0, 1e9, -1e9, 123.456] {
                    check(start..start + width, most);
                }
            }
            check(f64::MIN..f64::MAX, most);
        }
    }

    #[test]
    fn ticks_whose_labels_have_no_room_are_left_out_but_zero() {
        let thinned = |range: Range<f64>, length: f64| -> Vec<String> {
            let axis = Axis::new(&range, 9).thinned(length, |label| 10.0 * label.len() as f64);
            axis.ticks.iter().map(|tick| axis.label(*tick)).collect()
        };
        assert_eq!(thinned(0.0..40.0, 400.0), ["0", "5", "10", "15", "20", "25", "30", "35", "40"]);
        assert_eq!(thinned(0.0..40.0, 150.0), ["0", "10", "20", "30", "40"]);
        assert_eq!(thinned(-5.0..40.0, 150.0), ["0", "10", "20", "30", "40"]);
        assert_eq!(thinned(0.0..40.0, 30.0), ["0", "30"]);
    }

    #[test]
    fn powers_and_offsets_stand_in_the_name() {
        let name = |range: Range<f64>| Axis::new(&range, 5).named("x [mm]");
        assert_eq!(name(0.0..10.0), "x [mm]");
        assert_eq!(Axis::new(&(0.0..1.0), 5).named("load [-]"), "load [-]");
        assert_eq!(name(0.0..3e-6), "x [mm] \u{d7} 1e\u{2212}6");
        assert_eq!(name(0.0..4e6), "x [mm] \u{d7} 1e6");
        assert_eq!(name(1_000_000.0..1_000_003.0), "x [mm] + 1000000");
        assert_eq!(name(123.36..123.44), "x [mm] + 123.3");
    }

    proptest! {
        #[test]
        fn any_range_has_three_labels_that_differ(a in prop::num::f64::NORMAL, b in prop::num::f64::NORMAL, most in 1usize..20) {
            check(a.min(b)..a.max(b), most);
            check(a..a + a.abs() * 1e-4, most);
        }
    }
}
