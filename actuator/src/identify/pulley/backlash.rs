//! Backlash between a pulley and its tendon, from tensions at reversals.
//!
//! When a pulley that has pulled turns back, nothing happens to the tendon until the gap is crossed; then the tension falls along the
//! tendon's stiffness. Where that corner lies is the width of the gap. While the pulley rests before it turns, other tendons may change
//! the tension: that drift is taken to go on.

use std::f64::consts::TAU;

use hysteron_base::BadInput;

use super::steady::PulleyRecord;
use crate::servo::TICKS_PER_TURN;

/// Samples before a reversal in which the pulley was nowhere further on.
const BEFORE: usize = 20;
/// Share of the tension at the reversal down to which it is followed: further on other guides of the tendon slip.
const FOLLOWED: f64 = 0.7;
/// Share of the largest tension that a tendon must have at a reversal.
const TAUT: f64 = 0.1;
/// Fewest and most samples of rest before a reversal from which a drift is estimated.
const REST: [usize; 2] = [4, 10];
/// Standard errors that a drift must be away from none.
const SURE: f64 = 4.0;
/// Fewest samples beyond the corner.
const MIN_SAMPLES: usize = 3;
/// Places at which the corner is tried.
const PLACES: usize = 400;
/// Fewest reversals from which a width is estimated.
pub const MIN_REVERSALS: usize = 4;

/// A reversal of a pulley on a taut tendon.
#[derive(Debug, Clone, PartialEq)]
pub struct Reversal {
    /// Number of the recording.
    pub record: usize,
    /// Sample of the recording in which it turned.
    pub at: usize,
    /// How far it turned back until the tension fell [rad].
    pub width: f64,
    /// How the tension fell from there on [N/rad].
    pub stiffness: f64,
    /// Angles turned back [rad] and tensions without drift [N], sample by sample.
    pub course: Vec<[f64; 2]>,
}

/// A gap between a pulley and its tendon.
#[derive(Debug, Clone, PartialEq)]
pub struct Backlash {
    /// Its width [rad].
    pub width: f64,
    /// Standard error: spread of the reversals about their median, and rounding to ticks [rad].
    pub standard_error: f64,
    /// Reversals that it was estimated from.
    pub reversals: Vec<Reversal>,
}

/// Finds the width of the gap as the median over the reversals in `records`.
///
/// # Errors
/// `BadInput` saying what to record, where no tensions were measured or hardly a reversal was on a taut tendon.
pub fn identify_backlash(records: &[PulleyRecord]) -> Result<Backlash, BadInput> {
    let refused = |expected: &str, found: String| Err(BadInput::new("backlash", expected, found));
    if records.iter().all(|record| record.tension.is_none()) {
        return refused("tensions at the pulley", "none".into()).map_err(|bad| {
            bad.hint("record tension_1_n, .. with load cells; or fit the play to tips with `hysteron adapt`")
        });
    }
    let tensions = records.iter().filter_map(|record| record.tension).flatten();
    let largest = tensions.fold(0.0, |most: f64, tension| most.max(*tension));
    let of = |(k, record): (usize, &PulleyRecord)| {
        record.tension.map_or_else(Vec::new, |tension| reversals(k, record.angle, tension, TAUT * largest))
    };
    let found: Vec<Reversal> = records.iter().enumerate().flat_map(of).collect();
    if found.len() < MIN_REVERSALS {
        let expected = format!("{MIN_REVERSALS} reversals or more on a taut tendon");
        return refused(&expected, found.len().to_string()).map_err(|bad| {
            bad.hint("record motion to and fro in which the tendon stays taut where it turns")
        });
    }
    let mut widths: Vec<f64> = found.iter().map(|reversal| reversal.width).collect();
    let width = median(&mut widths);
    let mut apart: Vec<f64> = found.iter().map(|reversal| (reversal.width - width).abs()).collect();
    // Of a normal distribution: 1.4826 medians of the distance are a deviation; a median errs √(π/2) times as much as a mean.
    let spread = 1.4826 * median(&mut apart) * (0.5 * std::f64::consts::PI / found.len() as f64).sqrt();
    // Evenly within a tick, where the pulley turns and at the corner, and alike in all reversals that are alike.
    let rounding = TAU / TICKS_PER_TURN / 6f64.sqrt();
    Ok(Backlash { width, standard_error: spread.hypot(rounding), reversals: found })
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    0.5 * (values[(n - 1) / 2] + values[n / 2])
}

fn reversals(record: usize, angle: &[f64], tension: &[f64], taut: f64) -> Vec<Reversal> {
    let mut found = Vec::new();
    let mut i = 0;
    while i + 1 < angle.len() {
        let is_furthest = angle[i.saturating_sub(BEFORE)..=i].iter().all(|a| *a <= angle[i]);
        if !(angle[i + 1] < angle[i] && is_furthest) {
            i += 1;
            continue;
        }
        let continues = |j: &usize| angle[*j] <= angle[*j - 1] && tension[*j] > FOLLOWED * tension[i];
        let end = (i + 1..angle.len()).find(|j| !continues(j)).unwrap_or(angle.len() - 1);
        if tension[i] > taut && angle[end] <= angle[end - 1] {
            let drift = drift(&angle[..=i], &tension[..=i]);
            let at = |j: usize| [angle[i] - angle[j], tension[j] - drift * (j - i) as f64];
            let course: Vec<[f64; 2]> = (i..=end).map(at).collect();
            found.extend(corner(&course).map(|(width, stiffness)| Reversal {
                record,
                at: i,
                width,
                stiffness,
                course,
            }));
        }
        i = end.max(i + 1);
    }
    found
}

/// Change of the tension from sample to sample while the pulley rested at the end of these [N]; zero where it hardly did, or where noise hides it.
fn drift(angle: &[f64], tension: &[f64]) -> f64 {
    let last = angle.len() - 1;
    let n_rest = angle.iter().rev().take(REST[1]).take_while(|a| **a == angle[last]).count();
    if n_rest < REST[0] {
        return 0.0;
    }
    let rested = &tension[angle.len() - n_rest..];
    let n = n_rest as f64;
    let (middle, mean) = (0.5 * (n - 1.0), rested.iter().sum::<f64>() / n);
    let sum = |of: &dyn Fn(f64, f64) -> f64| {
        rested.iter().enumerate().map(|(j, t)| of(j as f64 - middle, t - mean)).sum::<f64>()
    };
    let square = sum(&|j, _| j * j);
    let slope = sum(&|j, t| j * t) / square;
    let left = sum(&|j, t| (t - slope * j).powi(2)) / (n - 2.0);
    if slope.abs() > SURE * (left / square).sqrt() { slope } else { 0.0 }
}

/// Where the tension begins to fall, and how it falls: T = c - k max(0, u - b), by least squares.
fn corner(course: &[[f64; 2]]) -> Option<(f64, f64)> {
    let way = course.last()?[0];
    let fit = |width: f64| {
        let n = course.len() as f64;
        let bent = |u: f64| (u - width).max(0.0);
        let mean = |of: &dyn Fn(&[f64; 2]) -> f64| course.iter().map(of).sum::<f64>() / n;
        let (u, t) = (mean(&|[u, _]| bent(*u)), mean(&|[_, t]| *t));
        let across = mean(&|[x, y]| (bent(*x) - u) * (y - t));
        let stiffness = -across / mean(&|[x, _]| (bent(*x) - u).powi(2));
        (mean(&|[x, y]| (y - t + stiffness * (bent(*x) - u)).powi(2)), stiffness)
    };
    let beyond = |width: f64| course.iter().filter(|[u, _]| *u > width).count();
    let places = (0..PLACES).map(|k| way * k as f64 / PLACES as f64);
    let places = places.filter(|b| beyond(*b) >= MIN_SAMPLES);
    let tried = places.map(|b| (fit(b), b));
    let ((_, stiffness), width) = tried.min_by(|a, b| a.0.0.total_cmp(&b.0.0))?;
    (stiffness > 0.0).then_some((width, stiffness))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;
    use crate::backlash::Play;

    /// A pulley to and fro behind a play, on a spring, measured by an encoder.
    fn record(play: f64, noise: f64) -> (Vec<f64>, Vec<f64>) {
        let tick = TAU / TICKS_PER_TURN;
        let mut gap = Play::new(play, 0.0);
        let samples = (0..6000).map(|i| {
            let t = 0.01 * f64::from(i);
            let angle = 0.5 + 0.4 * (1.1 * t).sin() + 0.1 * (0.37 * t).sin();
            let noise = noise * ((917.3 * t).sin() + (533.1 * t).sin() + (311.7 * t).sin()) / 1.2;
            ((angle / tick).round() * tick, 30.0 + 25.0 * gap.follow(angle) + noise)
        });
        samples.unzip()
    }

    #[test]
    fn the_width_of_a_play_comes_back_within_its_standard_error() {
        for play in [0.0, 0.005, 0.01, 0.03] {
            let (angle, tension) = record(play, 0.01);
            let record = PulleyRecord { angle: &angle, load: &angle, tension: Some(&tension) };
            let found = identify_backlash(&[record]).unwrap();
            assert!(found.reversals.len() >= 8, "{}", found.reversals.len());
            assert!(
                (found.width - play).abs() < 2.0 * found.standard_error,
                "{play}: {} {}",
                found.width,
                found.standard_error
            );
            assert!(found.standard_error < 0.002, "{}", found.standard_error);
        }
    }

    #[test]
    fn uninformative_recordings_name_what_to_record() {
        let (angle, tension) = record(0.01, 0.0);
        let record = PulleyRecord { angle: &angle, load: &angle, tension: None };
        let refused = identify_backlash(&[record]).unwrap_err().to_string();
        assert!(refused.contains("expected tensions at the pulley, got none"), "{refused}");
        let record =
            PulleyRecord { angle: &angle[..300], load: &angle[..300], tension: Some(&tension[..300]) };
        let refused = identify_backlash(&[record]).unwrap_err().to_string();
        assert!(refused.contains("expected 4 reversals or more on a taut tendon"), "{refused}");
    }
}
