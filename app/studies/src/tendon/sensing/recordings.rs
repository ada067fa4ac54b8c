//! Strokes and pushes of the recordings.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use anyhow::Result;
use hysteron_base::{file, rng};
use rand::RngExt;

/// Samples per second of all recordings [Hz].
const RATE: f64 = 100.0;
/// Largest stroke [mm]; speeds of moves [mm/s]; holds [s].
const REACH: f64 = 5.5;
const SPEEDS: [f64; 2] = [1.5, 5.0];
const HOLDS: [f64; 2] = [0.2, 2.5];
/// Forces of pushes [N], how long they last and how long there is none [s].
const FORCES: [f64; 2] = [0.05, 0.5];
const LASTS: [f64; 2] = [1.0, 3.0];
const PAUSES: [f64; 2] = [2.0, 4.0];

/// A smooth way from 0 to 1 that starts and ends at rest (minimum jerk).
fn smooth(part: f64) -> f64 {
    part.powi(3) * (10.0 - 15.0 * part + 6.0 * part * part)
}

/// Moves between places within reach, with holds, from rest to rest [mm]; gives the number of samples.
pub(super) fn write_strokes(path: &str, seed: u64, seconds: f64) -> Result<usize> {
    let mut draw = rng(seed, "sensing/strokes");
    let mut between = |[low, high]: [f64; 2]| draw.random_range(low..high);
    let (mut places, mut now) = (vec![[0.0; 2]; 60], [0.0f64; 2]);
    let mut go = |places: &mut Vec<[f64; 2]>, to: [f64; 2], speed: f64, hold: f64| {
        // The fastest moment of the way is 1.9 times its mean.
        let way = (to[0] - now[0]).hypot(to[1] - now[1]);
        let n = ((way * 1.9 / speed * RATE) as usize).max(20);
        places.extend((1..=n).map(|i| {
            let part = smooth(i as f64 / n as f64);
            [0, 1].map(|c| now[c] + part * (to[c] - now[c]))
        }));
        now = to;
        places.extend(std::iter::repeat_n(now, (hold * RATE) as usize));
    };
    while (places.len() as f64) < (seconds - 4.0) * RATE {
        let (radius, angle) = (REACH * between([0.0, 1.0]).sqrt(), between([0.0, TAU]));
        go(&mut places, [radius * angle.cos(), radius * angle.sin()], between(SPEEDS), between(HOLDS));
    }
    go(&mut places, [0.0; 2], SPEEDS[1], 0.6);
    let mut text = "time_s,stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm\n".to_owned();
    for (i, [a, b]) in places.iter().enumerate() {
        writeln!(text, "{},{a},{b},{},{}", i as f64 / RATE, -a, -b)?;
    }
    file::write_bytes(Path::new(path), text)?;
    Ok(places.len())
}

/// Pushes across the axis in any direction, growing within 50 ms; none between pushes.
pub(super) fn write_pushes(path: &str, seed: u64, n: usize, pushed: bool) -> Result<()> {
    let mut draw = rng(seed, "sensing/pushes");
    let mut between = |[low, high]: [f64; 2]| draw.random_range(low..high);
    let mut forces = vec![[0.0; 2]; n];
    let mut begin = (3.0 * RATE) as usize;
    while pushed && begin + (4.0 * RATE) as usize <= n {
        let (size, angle) = (between(FORCES.map(f64::ln)).exp(), between([0.0, TAU]));
        let lasts = (between(LASTS) * RATE) as usize;
        for (i, force) in forces[begin..begin + lasts].iter_mut().enumerate() {
            let part = ((i + 1) as f64 / (0.05 * RATE)).min(1.0);
            *force = [part * size * angle.cos(), part * size * angle.sin()];
        }
        begin += lasts + (between(PAUSES) * RATE) as usize;
    }
    let mut text = "time_s,tip_force_x_n,tip_force_y_n,tip_force_z_n\n".to_owned();
    for (i, [x, y]) in forces.iter().enumerate() {
        writeln!(text, "{},{x},{y},0", i as f64 / RATE)?;
    }
    Ok(file::write_bytes(Path::new(path), text)?)
}
