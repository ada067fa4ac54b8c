//! Samples from recordings of arms.

use hysteron_base::{BadInput, Recording};

use super::ArmSamples;
use crate::datasets::{check_rate, differentiate, low_pass};
use hysteron_arm_estimation::{ArmRecording, JointQuantityKind};

/// Positions, velocities, accelerations and torques of a recording, in trajectories parted where samples are
/// missing. Accelerations that are not recorded are central differences of velocities below `cutoff` [Hz].
///
/// # Errors
/// `BadInput` for channels that are missing, a part too short for the filter, and a rate that positions and velocities
/// contradict.
pub fn samples_of(recording: &Recording, cutoff: f64) -> Result<ArmSamples, BadInput> {
    let recorded = ArmRecording::of(recording)?;
    let n = recorded.joints.len();
    let mut samples = ArmSamples::of_joints(recorded.joints.iter().map(|joint| joint.kind).collect());
    let [q, dq, tau] = [JointQuantityKind::Position, JointQuantityKind::Velocity, JointQuantityKind::Torque]
        .map(|of| recorded.require(of));
    let (q, dq, tau) = (q?, dq?, tau?);
    let ddq = recorded.joints[0]
        .acceleration
        .map(|_| recorded.require(JointQuantityKind::Acceleration))
        .transpose()?;
    let mut start = 0;
    while start < recorded.time.len() {
        let is_gap = |i: &usize| recorded.gap.get(*i).copied().unwrap_or(false);
        let end = (start..recorded.time.len()).find(is_gap).unwrap_or(recorded.time.len());
        if end > start {
            let time = &recorded.time[start..end];
            let part = |series: &[&[f64]]| -> Vec<f64> {
                (start..end).flat_map(|i| series.iter().map(move |values| values[i])).collect()
            };
            let rate = (time.len() - 1) as f64 / (time[time.len() - 1] - time[0]);
            check_rate([&part(&q), &part(&dq)], n, rate)?;
            let accelerations = match &ddq {
                Some(ddq) => part(ddq),
                None => {
                    let columns: Vec<Vec<f64>> = dq
                        .iter()
                        .map(|values| Ok(differentiate(&low_pass(&values[start..end], cutoff, rate)?, time)))
                        .collect::<Result<_, BadInput>>()?;
                    (0..time.len()).flat_map(|i| columns.iter().map(move |values| values[i])).collect()
                }
            };
            samples.push([&part(&q), &part(&dq), &accelerations, &part(&tau)], [&[], &[]])?;
        }
        start = end + 1;
    }
    if samples.is_empty() {
        return Err(BadInput::new("recording", "samples", "none"));
    }
    Ok(samples)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may stop where it stands
mod tests {
    use hysteron_base::{Channel, Metadata};

    use super::*;

    /// Half a minute of a joint at 50 Hz; the time of sample i is `time(i)`.
    fn recording(n: usize, time: impl Fn(f64) -> f64, gaps: &[usize]) -> Recording {
        let times: Vec<f64> = (0..n).map(|i| time(i as f64 / 50.0)).collect();
        let of = |name: &str, f: &dyn Fn(f64) -> f64| {
            Channel::new(name, (0..n).map(|i| f(i as f64 / 50.0)).collect())
        };
        let channels = vec![
            of("q_1_rad", &f64::sin),
            of("dq_1_rad_s", &f64::cos),
            of("tau_1_n_m", &|t| (2.0 * t).sin()),
        ];
        let gap = (0..n).map(|i| gaps.contains(&i)).collect();
        Recording::new(times, channels, gap, Metadata::default()).unwrap()
    }

    #[test]
    fn accelerations_are_those_of_the_motion_and_gaps_part_trajectories() {
        let samples = samples_of(&recording(1500, |t| t, &[700]), 10.0).unwrap();
        assert_eq!(samples.trajectories, vec![0..700, 700..1499]);
        for i in 100..600 {
            // Central differences of a wave of 1 rad/s at 50 Hz err by h²/6; the filter takes (0.16/10)⁴ of it.
            assert!((samples.ddq[i] + (i as f64 / 50.0).sin()).abs() < 1e-4);
        }
    }

    #[test]
    fn recordings_that_cannot_be_are_refused() {
        let bad = samples_of(&recording(15, |t| t, &[]), 10.0).unwrap_err();
        assert!(bad.to_string().contains("more than 18 samples for the low-pass filter, got 15"), "{bad}");
        // Twice the rate by positions and velocities.
        let bad = samples_of(&recording(1500, |t| 0.5 * t, &[]), 10.0).unwrap_err();
        assert_eq!((&bad.place[..], &bad.expected[..]), ("rate", "100 Hz"));
        let bad = samples_of(&recording(1500, |t| t, &[]), 30.0).unwrap_err();
        assert_eq!(bad.place, "cut-off");
    }
}
