//! Missing samples: linear interpolation between neighbours, with the gaps marked (CoReAct paper, section V-A f).
//!
//! Orientations are interpolated along the shorter way and brought back to unit length.

use super::{Channel, Check, ColumnMemory, Metadata, Recording, check_room};
use crate::BadInput;
use crate::statistics::nearest_quantile;

const ORIENTATION: [&str; 4] = ["tip_qw", "tip_qx", "tip_qy", "tip_qz"];
/// A hole in time wider than this many steps counts as a gap [-].
const WIDEST: f64 = 1.5;
/// More samples than any recording has; keeps a slip of the hand from filling the memory.
const MAX_SAMPLES: f64 = 1e8;

/// Puts together a recording in which values are missing (NaN): each is interpolated in time between its
/// neighbours, before the first and after the last it is held, and its row is marked as a gap. All channels have
/// one value per time.
///
/// # Errors
/// `BadInput` for a channel without any value, and as [`Recording::new`].
pub(super) fn filled(time: Vec<f64>, mut channels: Vec<Channel>, meta: Metadata) -> Check<Recording> {
    let mut gap = vec![false; time.len()];
    let groups = groups(&channels);
    for group in groups {
        // A group is known where all its members are.
        let known: Vec<usize> =
            (0..time.len()).filter(|&i| group.iter().all(|&c| !channels[c].values[i].is_nan())).collect();
        let (Some(&first), Some(&last)) = (known.first(), known.last()) else {
            return Err(BadInput::new(&channels[group[0]].name, "at least one value", "none"));
        };
        let mut fill = |row: usize, from: usize, to: usize| {
            gap[row] = true;
            let part = if from == to { 0.0 } else { (time[row] - time[from]) / (time[to] - time[from]) };
            for (&c, value) in group.iter().zip(between(&channels, &group, from, to, part)) {
                channels[c].values[row] = value;
            }
        };
        (0..first).for_each(|row| fill(row, first, first));
        (last + 1..time.len()).for_each(|row| fill(row, last, last));
        for pair in known.windows(2) {
            (pair[0] + 1..pair[1]).for_each(|row| fill(row, pair[0], pair[1]));
        }
    }
    Recording::new(time, channels, gap, meta)
}

/// Channels that are interpolated together, by index: the four of an orientation, any other alone.
fn groups(channels: &[Channel]) -> Vec<Vec<usize>> {
    let orientation: Vec<usize> = ORIENTATION
        .iter()
        .filter_map(|name| channels.iter().position(|channel| channel.name == *name))
        .collect();
    let is_whole = orientation.len() == ORIENTATION.len();
    let mut groups: Vec<Vec<usize>> =
        (0..channels.len()).filter(|c| !(is_whole && orientation.contains(c))).map(|c| vec![c]).collect();
    if is_whole {
        groups.push(orientation);
    }
    groups
}

/// Values of a group at `part` of the way from row `from` to row `to`.
fn between(channels: &[Channel], group: &[usize], from: usize, to: usize, part: f64) -> Vec<f64> {
    let a: Vec<f64> = group.iter().map(|&c| channels[c].values[from]).collect();
    if part == 0.0 {
        return a;
    }
    let mut b: Vec<f64> = group.iter().map(|&c| channels[c].values[to]).collect();
    let is_orientation = group.len() == ORIENTATION.len();
    if is_orientation && a.iter().zip(&b).map(|(a, b)| a * b).sum::<f64>() < 0.0 {
        b.iter_mut().for_each(|b| *b = -*b); // the same orientation, the shorter way
    }
    // Not a + part (b - a), which overflows where a and b are far apart.
    let mut values: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a * (1.0 - part) + b * part).collect();
    let length = values.iter().map(|x| x * x).sum::<f64>().sqrt();
    if is_orientation && length > 0.0 && length.is_finite() {
        values.iter_mut().for_each(|x| *x /= length);
    }
    values
}

impl Recording {
    /// The recording at a fixed rate, from its first time on, each value interpolated in time between its
    /// neighbours. A sample is a gap where a neighbour it uses is one, or where the neighbours are further apart
    /// than one and a half steps, the longer of the old (their median) and the new.
    ///
    /// # Errors
    /// `BadInput` for a rate that is not positive, or that would give more than 10⁸ samples.
    pub fn resampled(&self, rate_hz: f64) -> Check<Self> {
        let (time, n) = (&self.time, self.time.len());
        let span = (time[n - 1] - time[0]) * rate_hz;
        if !(rate_hz.is_finite() && rate_hz > 0.0 && span < MAX_SAMPLES) {
            let expected = format!("a rate > 0 that gives fewer than {MAX_SAMPLES:e} samples");
            return Err(BadInput::new("rate", expected, format!("{rate_hz:?} Hz")));
        }
        let mut steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let step = nearest_quantile(&mut steps, 0.5).map_or(0.0, |median| median.max(1.0 / rate_hz));
        let n_new = (span * (1.0 + 1e-12) + 1e-9) as usize + 1; // the last one despite rounding
        check_room(self.channels.len() + 2, n_new as u64, ColumnMemory::Reserved)
            .map_err(|bad| bad.within("rate"))?;
        let new_time: Vec<f64> = (0..n_new).map(|k| time[0] + k as f64 / rate_hz).collect();
        let groups = groups(&self.channels);
        let mut channels: Vec<Channel> =
            self.channels.iter().map(|c| Channel::new(&c.name, Vec::with_capacity(n_new))).collect();
        let mut gap = Vec::with_capacity(n_new);
        let mut next = 0;
        for t in &new_time {
            while next < n && time[next] < *t {
                next += 1;
            }
            let (from, to) = (next.saturating_sub(1), next.min(n - 1));
            let width = time[to] - time[from];
            let mut part = if from == to { 0.0 } else { (t - time[from]) / width };
            // A hair from a sample is that sample.
            if part > 1.0 - 1e-6 {
                part = 1.0;
            } else if part < 1e-6 {
                part = 0.0;
            }
            gap.push(match part {
                0.0 => self.gap[from],
                1.0 => self.gap[to],
                _ => self.gap[from] || self.gap[to] || width > WIDEST * step,
            });
            for group in &groups {
                let values = match part {
                    1.0 => between(&self.channels, group, to, to, 0.0),
                    _ => between(&self.channels, group, from, to, part),
                };
                for (&c, value) in group.iter().zip(values) {
                    channels[c].values.push(value);
                }
            }
        }
        Self::new(new_time, channels, gap, self.meta.clone())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    const NAN: f64 = f64::NAN;

    fn fill(time: &[f64], channels: &[(&str, &[f64])]) -> Check<Recording> {
        let channels = channels.iter().map(|(name, values)| Channel::new(*name, values.to_vec())).collect();
        filled(time.to_vec(), channels, Metadata::default())
    }

    #[test]
    fn missing_values_lie_on_the_line_between_their_neighbours() {
        let recording = fill(
            &[0.0, 1.0, 2.0, 4.0, 5.0],
            &[("tip_x_m", &[NAN, 1.0, NAN, 7.0, NAN]), ("load_1", &[1.0, 2.0, 3.0, 4.0, 5.0])],
        );
        let recording = recording.unwrap();
        assert_eq!(recording.channel("tip_x_m").unwrap(), [1.0, 1.0, 3.0, 7.0, 7.0]);
        assert_eq!(recording.channel("load_1").unwrap(), [1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(recording.gap(), [true, false, true, false, true]);
    }

    #[test]
    fn a_channel_without_values_is_refused() {
        let bad = fill(&[0.0, 1.0], &[("tip_x_m", &[NAN, NAN])]).unwrap_err();
        assert_eq!((bad.place.as_str(), bad.found.as_str()), ("tip_x_m", "none"));
    }

    #[test]
    fn an_orientation_turns_the_shorter_way_at_unit_length() {
        // A quarter turn about x, written with the other sign: halfway is an eighth.
        let half = 0.5_f64.sqrt();
        let recording = fill(
            &[0.0, 1.0, 2.0],
            &[
                ("tip_qw", &[1.0, NAN, -half]),
                ("tip_qx", &[0.0, NAN, -half]),
                ("tip_qy", &[0.0, 5.0, 0.0]),
                ("tip_qz", &[0.0, NAN, 0.0]),
            ],
        );
        let [w, x, y, z] = recording.unwrap().tip_orientation().unwrap().map(|values| values[1]);
        let angle = std::f64::consts::FRAC_PI_8;
        assert!((w - angle.cos()).abs() < 1e-15 && (x - angle.sin()).abs() < 1e-15, "{w} {x}");
        assert_eq!((y, z), (0.0, 0.0));
    }

    #[test]
    fn resampling_marks_holes_and_keeps_what_is_there() {
        // 10 Hz with the samples at 0.3 and 0.4 s missing, and the one at 0.1 s a gap.
        let time = vec![0.0, 0.1, 0.2, 0.5, 0.6];
        let values: Vec<f64> = time.iter().map(|t| 3.0 * t).collect();
        let gap = vec![false, true, false, false, false];
        let channels = vec![Channel::new("tip_x_m", values)];
        let recording = Recording::new(time, channels, gap, Metadata::default()).unwrap();
        let ten = recording.resampled(10.0).unwrap();
        assert_eq!(ten.gap(), [false, true, false, true, true, false, false]);
        for (t, x) in ten.time().iter().zip(ten.channel("tip_x_m").unwrap()) {
            assert!((x - 3.0 * t).abs() < 1e-15);
        }
        assert_eq!(ten.rate_hz().unwrap().round(), 10.0);
        let twenty = recording.resampled(20.0).unwrap();
        let marks: String = twenty.gap().iter().map(|gap| if *gap { 'x' } else { '.' }).collect();
        assert_eq!(marks, ".xxx.xxxxx...");
        for rate in [0.0, -1.0, NAN, f64::INFINITY, 1e9] {
            assert_eq!(recording.resampled(rate).unwrap_err().place, "rate");
        }
        // Few enough samples, too many numbers: refused by the rows, before any is made.
        let bad = recording.resampled(1e8 / 0.6 * 0.9).unwrap_err();
        let numbers = "at most 50000000 numbers";
        assert_eq!((bad.place.as_str(), bad.expected.as_str()), ("rate: rows", numbers), "{bad}");
    }

    #[test]
    fn one_sample_stays_one() {
        let recording = fill(&[2.0], &[("tip_x_m", &[1.0])]).unwrap();
        assert_eq!(recording.resampled(100.0).unwrap(), recording);
    }
}
