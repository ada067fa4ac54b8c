//! Commands: what each step asks of the tendons.

use hysteron_base::rng;
use hysteron_twin::{Stepper, Target, Twin};
use rand::RngExt;

use hysteron_studies::tendon::scenes::N_PRIMARY;

/// Stroke per step of the circular drive [m].
pub const STROKE_PER_STEP: f64 = 0.02e-3;
/// Its amplitude [m].
pub const AMPLITUDE: f64 = 5e-3;
/// Steps until the circle begins.
pub const N_RAMP: usize = 250;
/// Steps of a whole circle.
pub const N_CIRCLE: usize = 1571;

/// Strokes of the four primaries in step `k`: a ramp to the amplitude, then round and round.
pub fn circle(k: usize) -> [f64; N_PRIMARY] {
    let (amplitude, angle) = if k < N_RAMP {
        (k as f64 * STROKE_PER_STEP, 0.0)
    } else {
        (AMPLITUDE, (k - N_RAMP) as f64 * STROKE_PER_STEP / AMPLITUDE)
    };
    std::array::from_fn(|i| amplitude * (angle - i as f64 * std::f64::consts::FRAC_PI_2).cos())
}

/// The circle, with every tendon beyond the primaries held at `tension` [N].
pub fn with_tensions(n_tendons: usize, n_steps: usize, tension: f64) -> Vec<Vec<Target>> {
    let auxiliary = vec![Target::Tension(tension); n_tendons - N_PRIMARY];
    (0..n_steps).map(|k| [circle(k).map(Target::Stroke).to_vec(), auxiliary.clone()].concat()).collect()
}

/// The circle with every tendon commanded by stroke: auxiliary ones at the strokes they take under
/// 0.5 N, plus a slow modulation of ±0.03 mm.
///
/// # Errors
/// A step of the recording run fails.
pub fn with_strokes(twin: &Twin, n_steps: usize) -> hysteron_twin::Result<Vec<Vec<Target>>> {
    let mut stepper = Stepper::new(twin);
    let natural = with_tensions(twin.tendons.len(), n_steps, 0.5);
    natural
        .iter()
        .enumerate()
        .map(|(k, targets)| {
            stepper.step(twin, targets)?;
            let mut strokes = twin.strokes_of(stepper.state());
            strokes[..N_PRIMARY].copy_from_slice(&circle(k));
            for (j, stroke) in strokes.iter_mut().enumerate().skip(N_PRIMARY) {
                *stroke += 0.03e-3 * (0.004 * k as f64 + j as f64).sin();
            }
            Ok(strokes.into_iter().map(Target::Stroke).collect())
        })
        .collect()
}

/// `targets` with uniform noise of ±`width` [m] on the strokes of the first `n_noisy` tendons.
pub fn with_noise(targets: &[Vec<Target>], n_noisy: usize, width: f64) -> Vec<Vec<Target>> {
    let mut rng = rng(1, "bench/noise");
    let mut noisy = targets.to_vec();
    for target in noisy.iter_mut().flat_map(|targets| &mut targets[..n_noisy]) {
        if let Target::Stroke(stroke) = target {
            *stroke += width * rng.random_range(-1.0..=1.0);
        }
    }
    noisy
}
