//! Inputs of the estimators: readings of the joints, and the labels that they are compared with.

use hysteron_base::{BadInput, Recording};

use crate::{ArmRecording, JointQuantityKind};

/// A trajectory, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoForceTelemetry {
    /// Number of joints n.
    pub n_joints: usize,
    /// [s].
    pub time: Vec<f64>,
    /// Time before each row [s].
    pub periods: Vec<f64>,
    /// Positions (n_samples × n) [rad].
    pub position: Vec<f64>,
    /// Speeds (n_samples × n) [rad/s].
    pub velocity: Vec<f64>,
    /// Currents (n_samples × n) [A].
    pub current: Vec<f64>,
    /// Voltages on the motors, supply times PWM (n_samples × n) [V].
    pub voltage: Vec<f64>,
    /// Labels of the force at the tip (n_samples), x, y and z [N]; zero where there is none.
    pub force: Vec<[f64; 3]>,
    /// Where the force has a label (n_samples).
    pub is_labelled: Vec<bool>,
}

impl ServoForceTelemetry {
    /// The first `n_joints` joints of a recording with positions, speeds, currents, voltages and PWM.
    ///
    /// # Errors
    /// `BadInput` naming a channel that is missing, or fewer than 100 rows.
    pub fn of(recording: &Recording, n_joints: usize) -> Result<Self, BadInput> {
        let recorded = ArmRecording::of(recording)?;
        let n_samples = recording.n_samples();
        if n_samples < MIN_ROWS {
            return Err(BadInput::new("recording", format!("{MIN_ROWS} rows"), n_samples.to_string()));
        }
        if recorded.joints.len() < n_joints {
            let found = recorded.joints.len().to_string();
            return Err(BadInput::new("recording", format!("{n_joints} joints"), found));
        }
        let rows = |quantity: JointQuantityKind| -> Result<Vec<f64>, BadInput> {
            let columns = recorded.require(quantity)?;
            Ok((0..n_samples).flat_map(|row| columns[..n_joints].iter().map(move |c| c[row])).collect())
        };
        let (supply, pwm) = (rows(JointQuantityKind::Voltage)?, rows(JointQuantityKind::Pwm)?);
        let time = recording.time().to_vec();
        let mean = (time[n_samples - 1] - time[0]) / (n_samples - 1) as f64;
        let periods = std::iter::once(mean).chain(time.windows(2).map(|pair| pair[1] - pair[0])).collect();
        let has_label = |axis: usize, row: usize| match recorded.force[axis] {
            Some(force) => force.labelled.is_none_or(|labelled| labelled[row] == 1.0),
            None => false,
        };
        let label = |axis: usize, row: usize| match recorded.force[axis] {
            Some(force) if has_label(axis, row) => force.values[row],
            _ => 0.0,
        };
        Ok(Self {
            n_joints,
            periods,
            position: rows(JointQuantityKind::Position)?,
            velocity: rows(JointQuantityKind::Velocity)?,
            current: rows(JointQuantityKind::Current)?,
            voltage: supply.iter().zip(&pwm).map(|(volts, duty)| volts * duty).collect(),
            force: (0..n_samples).map(|row| [0, 1, 2].map(|axis| label(axis, row))).collect(),
            is_labelled: (0..n_samples).map(|row| (0..3).any(|axis| has_label(axis, row))).collect(),
            time,
        })
    }

    /// Number of rows.
    pub fn n_samples(&self) -> usize {
        self.periods.len()
    }

    /// A column of rows.
    pub(crate) fn column(&self, rows: &[f64], joint: usize) -> Vec<f64> {
        rows.iter().skip(joint).step_by(self.n_joints).copied().collect()
    }

    /// Mean rate [Hz].
    pub(crate) fn rate(&self) -> f64 {
        self.periods.len() as f64 / self.periods.iter().sum::<f64>()
    }
}

/// Fewest rows of a trajectory: less than two seconds are not enough.
const MIN_ROWS: usize = 100;
