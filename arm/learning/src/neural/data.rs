//! Trajectories as the network learns from them.

use std::ops::Range;

use hysteron_base::{BadInput, Recording};

use super::features::{FeatureLayout, GripperAxis};
use hysteron_arm_estimation::position_gain;
use hysteron_arm_estimation::{ArmRecording, JointQuantityKind};
use hysteron_base::import::MAX_LEFT_OUT;
use hysteron_base::sampling::{STEP_SCATTER, SampleSteps};

/// One recorded trajectory at a fixed rate. Rows are samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// Where it comes from.
    pub name: String,
    /// Inputs of the network (rows × inputs), SI.
    pub inputs: Vec<f64>,
    /// Positions and speeds of all motors (rows × 2m) [rad, rad/s].
    pub states: Vec<f64>,
    /// Voltages on the joints' motors, supply times PWM (rows × n) [V]; `None` without PWM.
    pub voltage: Option<Vec<f64>>,
    /// Force on the tip (rows) [N]; `None` where there is no label.
    pub force: Vec<Option<[f64; 3]>>,
    /// Whether the motors are as they should be, where that is known.
    pub is_healthy: Option<bool>,
    /// Gain of the motors' position loops, as the register has it; `None` where the recording has none.
    pub position_gain: Option<f64>,
    /// True where a sample was filled in.
    pub gap: Vec<bool>,
}

impl Trajectory {
    /// Samples.
    pub fn len(&self) -> usize {
        self.gap.len()
    }

    /// Whether it holds no sample.
    pub fn is_empty(&self) -> bool {
        self.gap.is_empty()
    }

    /// Inputs of row `row`; before the first, those of the first.
    pub fn inputs_at(&self, row: isize) -> &[f64] {
        let width = self.inputs.len() / self.len();
        &self.inputs[row.max(0) as usize * width..][..width]
    }

    /// Voltages on the joints' motors (rows × n) [V].
    ///
    /// # Errors
    /// `BadInput` where PWM was not recorded.
    pub fn motor_voltage(&self) -> Result<&[f64], BadInput> {
        let missing = || {
            BadInput::new(&self.name, "channels pwm_k_ratio of all joints", "none")
                .hint("without PWM, --sensing loop takes force and condition from the network in the loop")
        };
        self.voltage.as_deref().ok_or_else(missing)
    }

    /// Gain of its position loops over another; 1 where either is not known.
    pub fn gain_over(&self, other: Option<f64>) -> f64 {
        gain_ratio(self.position_gain, other)
    }

    /// Some of its samples, as a trajectory of their own.
    ///
    /// # Panics
    /// If there are no such samples.
    pub fn rows(&self, rows: Range<usize>) -> Self {
        let of = |values: &[f64]| {
            let width = values.len() / self.len();
            values[rows.start * width..rows.end * width].to_vec()
        };
        Self {
            name: self.name.clone(),
            inputs: of(&self.inputs),
            states: of(&self.states),
            voltage: self.voltage.as_deref().map(of),
            force: self.force[rows.clone()].to_vec(),
            is_healthy: self.is_healthy,
            position_gain: self.position_gain,
            gap: self.gap[rows.clone()].to_vec(),
        }
    }

    /// State at `row`.
    pub fn state_at(&self, row: usize) -> &[f64] {
        let width = self.states.len() / self.len();
        &self.states[row * width..][..width]
    }
}

/// Meaning of a sample without a label of force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unlabelled {
    /// Nothing: something may be carried, as in most of NAD where it reads −999.
    Unknown,
    /// That no force acts: free motion.
    Free,
}

/// Times between samples may differ from the period by this part, as the median over the recording.
const MAX_PERIOD_OFF: f64 = 0.1;
/// Samples that may be further apart than one and a half periods, as a part of all.
const MAX_LATE: f64 = 0.05;
/// Most scatter of the other steps [-]. Times that are wrong by a fifth of 17 ms shift a joint at 0.5 rad/s by 0.1 deg, as much as a
/// trained actuator errs.
const MAX_SCATTER: f64 = 0.2;
/// Fewest samples of a trajectory.
pub const MIN_ROWS: usize = 32;

/// Gripper of recordings: `None` without `aperture_m`; else how its motor's angle opens the jaws, by least
/// squares.
///
/// # Errors
/// `BadInput` where the last motor does not move the jaws as a line.
pub fn gripper_of(recordings: &[Recording]) -> Result<Option<GripperAxis>, BadInput> {
    let (mut sums, mut n) = ([0.0; 5], 0.0);
    for recording in recordings {
        let Some(aperture) = recording.channel("aperture_m") else { continue };
        let joints = ArmRecording::of(recording)?.joints;
        let Some(angle) = joints.last().and_then(|joint| joint.position) else { continue };
        for (x, y) in angle.iter().zip(aperture) {
            for (sum, part) in sums.iter_mut().zip([*x, *y, x * x, x * y, y * y]) {
                *sum += part;
            }
            n += 1.0;
        }
    }
    if n == 0.0 {
        return Ok(None);
    }
    let [x, y, xx, xy, yy] = sums.map(|sum| sum / n);
    let (variance, spread) = (xx - x * x, yy - y * y);
    // Jaws that never move do not determine the slope; then the angle is used directly, in the usual 22.8 mm/rad of the OpenManipulator-X.
    let slope = if variance > 1e-8 { (xy - x * y) / variance } else { 0.0228 };
    let left = spread - slope * slope * variance;
    if variance > 1e-8 && left > 0.1 * spread && spread > 1e-8 {
        let found = format!("{:.0} % of its variance left over", 100.0 * left / spread);
        return Err(BadInput::new("aperture_m", "a line over the angle of the last motor", found));
    }
    Ok(Some(GripperAxis { slope, offset: y - slope * x }))
}

/// A gain of position loops over another; 1 where either is not known.
pub(super) fn gain_ratio(own: Option<f64>, other: Option<f64>) -> f64 {
    own.zip(other).map_or(1.0, |(own, other)| own / other)
}

/// Mean gain of the position loops; none where no recording has one.
///
/// # Errors
/// `BadInput` where some have it and others do not.
pub(super) fn usual_gain(trajectories: &[Trajectory]) -> Result<Option<f64>, BadInput> {
    let gains: Vec<f64> = trajectories.iter().filter_map(|one| one.position_gain).collect();
    if !gains.is_empty() && gains.len() < trajectories.len() {
        let found = format!("{} of {}", gains.len(), trajectories.len());
        return Err(BadInput::new("recordings", "position_gain in all recordings or in none", found));
    }
    Ok((!gains.is_empty()).then(|| gains.iter().sum::<f64>() / gains.len() as f64))
}

/// A recording as a trajectory at steps of `period` [s]; a recording at other times is resampled.
///
/// `unlabelled` is the meaning of a row without label of force.
///
/// # Errors
/// `BadInput` naming what is missing, has another number of joints, comes at another rate, or too unevenly, or where a motor's torque was
/// switched off: it follows no goal there.
pub fn trajectory_of(
    recording: &Recording,
    features: &FeatureLayout,
    period: f64,
    unlabelled: Unlabelled,
) -> Result<Trajectory, BadInput> {
    check_times(recording, period)?;
    let regular = recording.rate_hz().is_some_and(|rate| (rate * period - 1.0).abs() < 1e-3);
    let resampled;
    let recording = if regular {
        recording
    } else {
        resampled = recording.resampled(1.0 / period)?;
        &resampled
    };
    check_gaps(recording.gap())?;
    check_torque_on(recording, features.motors())?;
    let recorded = ArmRecording::of(recording)?;
    let m = features.motors();
    if recorded.joints.len() != m {
        let expected = format!("{m} motors, as the others or the model have");
        return Err(BadInput::new("recording", expected, recorded.joints.len().to_string()));
    }
    let required = [
        JointQuantityKind::Goal,
        JointQuantityKind::Position,
        JointQuantityKind::Velocity,
        JointQuantityKind::Current,
        JointQuantityKind::Voltage,
        JointQuantityKind::Temperature,
    ];
    let mut series = Vec::new();
    for quantity in required {
        series.push(recorded.require(quantity)?);
    }
    let goal_aperture = match features.gripper {
        Some(_) => recording.require("goal_aperture_m")?,
        None => &[],
    };
    let n = recording.n_samples();
    if n < MIN_ROWS {
        return Err(BadInput::new("recording", format!("{MIN_ROWS} samples or more"), n.to_string()));
    }
    let mut inputs = vec![0.0; n * features.len()];
    let mut states = Vec::with_capacity(n * 2 * m);
    for (i, to) in inputs.chunks_exact_mut(features.len()).enumerate() {
        let row = |quantity: usize| -> Vec<f64> { series[quantity].iter().map(|values| values[i]).collect() };
        let [goals, currents, voltages, temperatures] = [0, 3, 4, 5].map(row);
        let state = [row(1), row(2)].concat();
        let aperture_goal = goal_aperture.get(i).copied().unwrap_or(0.0);
        features.gather([&goals, &state, &currents, &voltages, &temperatures], aperture_goal, to);
        states.extend(state);
    }
    let extra = &recording.meta().extra;
    let voltage = recorded.require(JointQuantityKind::Pwm).ok().map(|pwm| {
        let row = |i: usize| (0..features.joints).map(move |k| (i, k));
        (0..n).flat_map(row).map(|(i, k)| series[4][k][i] * pwm[k][i]).collect()
    });
    Ok(Trajectory {
        name: recording.meta().source.clone(),
        inputs,
        states,
        voltage,
        force: forces(&recorded, n, unlabelled),
        is_healthy: extra.get("condition").map(|text| text == "healthy"),
        position_gain: position_gain(recording.meta())?,
        gap: recording.gap().to_vec(),
    })
}

fn check_torque_on(recording: &Recording, motors: usize) -> Result<(), BadInput> {
    for name in (1..=motors).map(|k| format!("torque_on_{k}_ratio")) {
        let Some(flags) = recording.channel(&name) else { continue };
        if let Some(row) = flags.iter().position(|flag| *flag < 1.0) {
            let found = format!("{} at {:.3} s", flags[row], recording.time()[row]);
            return Err(BadInput::new(name, "1 at all times: a motor that is off follows no goal", found)
                .hint("hysteron import --where COLUMN=VALUE takes the rows in which a column has a value"));
        }
    }
    Ok(())
}

fn forces(recorded: &ArmRecording, n: usize, unlabelled: Unlabelled) -> Vec<Option<[f64; 3]>> {
    let label = |axis: usize, i: usize| {
        let series = recorded.force[axis].as_ref()?;
        series.labelled.is_none_or(|labelled| labelled[i] >= 0.5).then_some(series.values[i])
    };
    let at = |i: usize| {
        let all: [Option<f64>; 3] = std::array::from_fn(|axis| label(axis, i));
        // A held weight is labelled along z alone: its other parts are zero.
        all.iter().any(Option::is_some).then(|| all.map(|part| part.unwrap_or(0.0)))
    };
    let otherwise = (unlabelled == Unlabelled::Free).then_some([0.0; 3]);
    (0..n).map(|i| at(i).or(otherwise)).collect()
}

fn check_times(recording: &Recording, period: f64) -> Result<(), BadInput> {
    let Some(steps) = SampleSteps::of(recording.time()) else {
        return Err(BadInput::new("time_s", "two samples or more", recording.n_samples().to_string()));
    };
    let median = steps.median();
    if (median / period - 1.0).abs() > MAX_PERIOD_OFF {
        let expected = format!("steps of {period} s, within {:.0} %", 100.0 * MAX_PERIOD_OFF);
        return Err(BadInput::new("time_s", expected, format!("{median:.5} s in the median"))
            .hint("--period-s sets the step of the simulation"));
    }
    let uneven = |expected: String, found: f64| {
        BadInput::new("time_s", expected, format!("{:.1} %", 100.0 * found))
            .hint("jitter this large hides the response of the actuator between samples")
    };
    let late = steps.longer_than(1.5 * period);
    if late > MAX_LATE {
        let expected = format!("at most {:.0} % of the steps longer than 1.5 periods", 100.0 * MAX_LATE);
        return Err(uneven(expected, late));
    }
    // A file that was resampled on import holds the scatter of its original steps.
    let noted = recording.meta().extra.get(STEP_SCATTER).and_then(|text| text.parse().ok());
    let scatter = steps.scatter().max(noted.unwrap_or(0.0));
    if scatter > MAX_SCATTER {
        let expected =
            format!("steps that scatter by at most {:.0} % about their median", 100.0 * MAX_SCATTER);
        return Err(uneven(expected, scatter));
    }
    Ok(())
}

fn check_gaps(gap: &[bool]) -> Result<(), BadInput> {
    let filled = gap.iter().filter(|gap| **gap).count() as f64 / gap.len() as f64;
    if filled > MAX_LEFT_OUT {
        let expected = format!("at most {:.0} % of the samples filled in", 100.0 * MAX_LEFT_OUT);
        return Err(BadInput::new("gap", expected, format!("{:.1} %", 100.0 * filled))
            .hint("cut the recording at its gaps, or record it again"));
    }
    Ok(())
}
