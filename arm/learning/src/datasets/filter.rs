//! Zero-phase low-pass filtering and differentiation of recorded channels.

use hysteron_actuator::filter::LowPass;
use hysteron_base::BadInput;

/// Samples that a filter needs beyond both ends, by reflection.
const PADDING: usize = 9;

/// Butterworth low-pass of second order, forward and backward: fourth order without phase. `cutoff` and `rate` in Hz.
///
/// The signal is continued beyond its ends by point reflection and the filter begins at rest there.
///
/// # Errors
/// `BadInput` where the signal is too short, or the cut-off is not below half the rate.
/// # Reference
/// Gustafsson (1996), Determining the initial states in forward-backward filtering; the initial state here is that of a
/// constant input.
pub fn low_pass(signal: &[f64], cutoff: f64, rate: f64) -> Result<Vec<f64>, BadInput> {
    if signal.len() <= 2 * PADDING {
        let expected = format!("more than {} samples for the low-pass filter", 2 * PADDING);
        return Err(BadInput::new("recording", expected, signal.len().to_string()));
    }
    if !(cutoff > 0.0 && cutoff < 0.5 * rate) {
        let expected =
            format!("above 0 and below half of the rate, {} Hz", hysteron_base::number::shown(0.5 * rate));
        return Err(BadInput::new("cut-off", expected, format!("{cutoff} Hz")));
    }
    Ok(LowPass::new(2, cutoff, rate)?.zero_phase(signal))
}

/// Derivative by central differences, one-sided at the ends, of values at these times [s].
pub fn differentiate(values: &[f64], times: &[f64]) -> Vec<f64> {
    let last = values.len() - 1;
    (0..=last)
        .map(|i| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
            (values[b] - values[a]) / (times[b] - times[a])
        })
        .collect()
}

/// Largest relative error of the rate, compared with that from positions and velocities.
const WORST_RATE: f64 = 0.2;

/// # Errors
/// `BadInput` where positions ([sample][joint]) do not change by velocities and rate [Hz].
pub(crate) fn check_rate([q, dq]: [&[f64]; 2], n_joints: usize, rate: f64) -> Result<(), BadInput> {
    let (mut products, mut squares) = (0.0, 0.0);
    for (q, dq) in q.windows(n_joints + 1).zip(dq) {
        products += (q[n_joints] - q[0]) * dq;
        squares += dq * dq;
    }
    let found = squares / products;
    let is_off = (found / rate - 1.0).abs() >= WORST_RATE || !found.is_finite();
    if squares > 0.0 && is_off {
        return Err(BadInput::new("rate", format!("{rate:.0} Hz"), format!("{found:.1} Hz"))
            .hint("positions and velocities determine the rate: are the units rad and rad/s?"));
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may stop where it stands
mod tests {
    use super::*;

    #[test]
    fn slow_waves_pass_without_lag_and_fast_ones_do_not() {
        let wave = |hz: f64| {
            (0..1000).map(|i| (std::f64::consts::TAU * hz * f64::from(i) / 100.0).sin()).collect::<Vec<_>>()
        };
        // |H|² of second order, twice: 1/(1 + (tan πf/tan πf_c)⁴).
        let gain = |hz: f64| {
            let ratio =
                (std::f64::consts::PI * hz / 100.0).tan() / (std::f64::consts::PI * 5.0 / 100.0).tan();
            1.0 / (1.0 + ratio.powi(4))
        };
        for hz in [1.0, 5.0, 20.0] {
            let (before, after) = (wave(hz), low_pass(&wave(hz), 5.0, 100.0).unwrap());
            for i in 300..700 {
                assert!(
                    (after[i] - gain(hz) * before[i]).abs() < 1e-6,
                    "{hz} Hz: {} {}",
                    after[i],
                    before[i]
                );
            }
        }
    }

    #[test]
    fn lines_stay_lines() {
        let line: Vec<f64> = (0..50).map(|i| 3.0 - 0.1 * f64::from(i)).collect();
        let times: Vec<f64> = (0..50).map(|i| 0.01 * f64::from(i)).collect();
        // The reflection of a line is the line; a filter at rest in a constant has forgotten its start inside.
        let found = low_pass(&line, 20.0, 100.0).unwrap();
        assert!((found[25] - line[25]).abs() < 1e-6);
        assert!(differentiate(&line, &times).iter().all(|d| (d + 10.0).abs() < 1e-9));
    }

    #[test]
    fn what_is_too_short_or_too_fast_is_refused() {
        let bad = low_pass(&[0.0; 18], 5.0, 100.0).unwrap_err();
        assert_eq!(
            bad.to_string(),
            "recording: expected more than 18 samples for the low-pass filter, got 18"
        );
        assert_eq!(low_pass(&[0.0; 90], 50.0, 100.0).unwrap_err().place, "cut-off");
    }
}
