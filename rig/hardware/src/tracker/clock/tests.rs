#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::*;
use hysteron_base::rng;
use rand::RngExt;

/// Rounding of time stamps of this century [s].
const ROUNDING: f64 = 1e-6;

/// Times of a message: measured at (host), stamped (device), arrived (host), jitter [s].
#[derive(Clone, Copy)]
struct Sample {
    measured: f64,
    stamp: f64,
    arrival: f64,
    jitter: f64,
}

/// A tracker at 40 Hz, `latency` late plus exponential jitter of 3 ms, its clock `offset` ahead and fast by
/// `drift`; TCP keeps the order.
fn tracker(name: &str, n: usize, offset: f64, drift: f64, latency: f64) -> Vec<Sample> {
    let mut random = rng(1, name);
    let mut last = 0.0_f64;
    let sample = |k: usize| {
        let measured = 0.025 * k as f64;
        let u: f64 = random.random();
        let arrival = (measured + latency - 3e-3 * (1.0 - u).ln()).max(last);
        last = arrival;
        Sample {
            measured,
            stamp: offset + (1.0 + drift) * measured,
            arrival,
            jitter: arrival - measured - latency,
        }
    };
    (0..n).map(sample).collect()
}

/// The bound of the module: min over the window of j + (D + ρ) · age, where ρ is the drift of host over device.
fn bound(samples: &[Sample], k: usize, drift: f64) -> f64 {
    let now = samples[k].arrival;
    let window = samples[..=k].iter().rev().take_while(|sample| sample.arrival >= now - WINDOW);
    window.map(|s| s.jitter + (MAX_DRIFT + drift.abs()) * (now - s.arrival)).fold(f64::INFINITY, f64::min)
}

#[test]
fn error_stays_within_the_derived_bound_for_any_drift() {
    for drift in [0.0, 50e-6, -50e-6, MAX_DRIFT, -MAX_DRIFT] {
        let samples = tracker("clock", 24_000, 1.7e9, drift, 8e-3);
        let mut map = ClockMap::new(8e-3);
        let (mut worst, mut total) = (0.0_f64, 0.0);
        for (k, sample) in samples.iter().enumerate() {
            let error = map.map(sample.stamp, sample.arrival).unwrap() - sample.measured;
            // A message's own delay is time in which the clocks drift, too.
            let early = MAX_DRIFT * (8e-3 + sample.jitter) + ROUNDING;
            assert!(error >= -early && error <= bound(&samples, k, drift) + early, "{k}: {error}");
            if k >= 200 {
                worst = worst.max(error.abs());
                total += error.abs();
            }
        }
        let mean = total / (samples.len() - 200) as f64;
        // With exponential jitter of mean µ every Δ, P(error > x) = Π over ages kΔ of exp(-(x - ckΔ)/µ), c = D + ρ:
        // at most Rayleigh's exp(-x²/2σ²) with σ² = c Δ µ. About 11 samples share a minimum: the mean is known to
        // 1.2 %, of which five are allowed; exp(-5.7²/2) is 1e-7 per sample.
        let sigma = ((MAX_DRIFT + drift.abs()) * 0.025 * 3e-3).sqrt();
        let (mean_bound, worst_bound) = (1.06 * sigma * std::f64::consts::FRAC_PI_2.sqrt(), 5.7 * sigma);
        assert!(mean < mean_bound && worst < worst_bound, "drift {drift}: mean {mean} s, worst {worst} s");
    }
}

#[test]
fn a_reset_clock_is_followed_and_no_pose_is_misplaced_meanwhile() {
    for jump in [3600.0, -3600.0, -1.7e9, 1.5, -1.5] {
        let mut samples = tracker("jump", 800, 1.7e9, 50e-6, 8e-3);
        samples[400..].iter_mut().for_each(|sample| sample.stamp += jump);
        let mut map = ClockMap::new(8e-3);
        let mut n_unplaced = 0;
        for (k, sample) in samples.iter().enumerate() {
            match map.map(sample.stamp, sample.arrival) {
                // After the jump the window restarts with the jitter of the first message.
                Some(time) => assert!((time - sample.measured).abs() < 30e-3, "{jump} {k}"),
                None => n_unplaced += 1,
            }
        }
        // Five that agree, and 0.1 s: the fifth or sixth is placed.
        assert!((4..=6).contains(&n_unplaced), "{jump}: {n_unplaced}");
    }
}

#[test]
fn small_step_back_is_followed_after_the_window() {
    let mut samples = tracker("step", 800, 100.0, 0.0, 0.0);
    samples[400..].iter_mut().for_each(|sample| sample.stamp -= 0.3);
    let mut map = ClockMap::new(0.0);
    let after = samples[400].arrival + WINDOW;
    for sample in &samples {
        let error = map.map(sample.stamp, sample.arrival).unwrap() - sample.measured;
        assert!(error.abs() < if sample.measured >= 10.0 && sample.arrival <= after { 0.31 } else { 30e-3 });
    }
}

#[test]
fn damaged_stamps_are_left_out_and_change_nothing() {
    let samples = tracker("outliers", 2000, 1.7e9, 50e-6, 8e-3);
    let (mut clean, mut dirty) = (ClockMap::new(8e-3), ClockMap::new(8e-3));
    let mut random = rng(1, "outliers/which");
    for sample in &samples {
        let expected = clean.map(sample.stamp, sample.arrival).unwrap();
        if sample.measured > 0.0 && random.random::<f64>() < 0.2 {
            let wrong: f64 = random.random_range(-1e9..1e9);
            assert_eq!(dirty.map(sample.stamp + wrong, sample.arrival), None);
        }
        assert_eq!(dirty.map(sample.stamp, sample.arrival), Some(expected));
    }
}

#[test]
fn stall_of_the_network_delays_no_pose() {
    let mut samples = tracker("stall", 800, 1.7e9, 0.0, 8e-3);
    // For 0.9 s and for 4 s nothing arrives, then all at once.
    for (begin, end) in [(8.0, 8.9), (12.0, 16.0)] {
        for sample in samples.iter_mut().filter(|s| (begin..end).contains(&s.arrival)) {
            sample.arrival = end;
        }
    }
    let mut map = ClockMap::new(8e-3);
    let mut n_unplaced = 0;
    for sample in &samples[..] {
        match map.map(sample.stamp, sample.arrival) {
            Some(time) if sample.measured > 2.0 => assert!((time - sample.measured).abs() < 6e-3),
            Some(_) => {}
            None => n_unplaced += 1,
        }
    }
    // Of 4 s the first 3 are too late to be distinguished from a clock that was reset.
    assert!((118..=122).contains(&n_unplaced), "{n_unplaced}");
}

#[test]
fn memory_is_bounded() {
    let mut map = ClockMap::new(0.0);
    for k in 0..100_000 {
        // Ever later: the worst case, each is below all that follow.
        let now = 1e-5 * f64::from(k);
        map.map(-now, now);
        assert!(map.lowest.len() <= MAX_MESSAGES);
    }
}
