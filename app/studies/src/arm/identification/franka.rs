//! Recorded friction of a joint of a Franka arm at three speeds: two are fitted, the third is predicted.
//!
//! The torques have another offset in every recording (0.3 N m apart: the sensor's zero, and what the rest of the arm adds), which no
//! model of this joint's motion can know. Every fitted model is therefore scored twice: unchanged, and with its offset from the first
//! seconds of the recording, which are not in the score, as one zeroes a sensor before a run.
//!
//! # Reference
//! Data and the predictions of eight models: github.com/longshike (NNFM); what they were trained on is not stated.

use std::path::Path;

use hysteron_actuator::identify::{DahlMap, FrictionRun, identify_friction};
use hysteron_actuator::law::{JointFriction, Law, Sliding};
use hysteron_base::{BadInput, Metadata, Recording, Table};
use hysteron_learn::Result;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use hysteron_arm_estimation::{ArmRecording, ColumnMap, ImportOptions, JointQuantityKind, import};

/// The recordings.
pub const SPEEDS: [&str; 3] = ["slow", "middle", "high"];
/// Models whose predictions are compared with the data.
pub const PUBLISHED: [&str; 8] =
    ["CV", "Dahl", "Stribeck", "LuGre", "SVM", "Light_Transformer", "PINN", "NNFM"];
/// Beginning of a recording that gives an offset [s].
pub const TARE: f64 = 5.0;
/// Laws of speed that are fitted for comparison.
const LAWS: [&str; 3] = ["coulomb-viscous", "stribeck", "directed-stribeck"];
/// Samples per second that the recordings are brought to [Hz]: most of their own steps.
const RATE: f64 = 500.0;
/// Every so many samples are used for laws of speed alone.
const STRIDE: usize = 10;

/// One model.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FrankaRow {
    /// Name.
    pub method: String,
    /// True for predictions that come with the data.
    pub is_published: bool,
    /// Root mean square error over all rows of each recording; none where a prediction is not finite [N m].
    pub all_rows_n_m: [Option<f64>; 3],
    /// The same after the first seconds, whose mean error is taken off: fitted models alone [N m].
    pub tared_n_m: Option<[f64; 3]>,
}

/// The table, and a figure's curves.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FrankaCell {
    /// The models.
    pub rows: Vec<FrankaRow>,
    /// Times of the figure's rows, by recording [s].
    pub time_s: [Vec<f64>; 3],
    /// Measured at these times [N m].
    pub measured: [Vec<f64>; 3],
    /// Predicted by the map with its offset zeroed [N m].
    pub predicted: [Vec<f64>; 3],
    /// Weight of the ridge that was chosen, by test recording [-].
    pub ridge: [f64; 3],
}

/// One recording: as it is, and at a fixed rate.
struct Run {
    table: Table,
    recording: Recording,
}

/// Rows of a figure: every so many.
const DECIMATION: usize = 25;

/// Reads the three files of `folder`; each is the test set once.
///
/// # Errors
/// A file that is missing or not as expected.
pub fn franka_cell(folder: &Path) -> Result<FrankaCell> {
    let mut runs = Vec::new();
    for speed in SPEEDS {
        let path = folder.join(format!("franka_case3_{speed}.csv"));
        let columns = Some(ColumnMap::named("franka-friction")?);
        let options = ImportOptions { columns, rate_hz: Some(RATE), ..ImportOptions::default() };
        let recording = import(&path, &options, Metadata::default())?.recording;
        runs.push(Run { table: Table::read(&path, None)?, recording });
    }
    let mut rows = Vec::new();
    for name in PUBLISHED {
        let mut all_rows_n_m = [None; 3];
        for (error, run) in all_rows_n_m.iter_mut().zip(&runs) {
            *error = published(run, name)?;
        }
        rows.push(FrankaRow { method: name.to_owned(), is_published: true, all_rows_n_m, tared_n_m: None });
    }
    for name in LAWS {
        let law = Law::named(name)?;
        let predict = |test: usize| -> std::result::Result<Vec<f64>, BadInput> {
            let (mut velocity, mut torque) = (Vec::new(), Vec::new());
            for run in others(&runs, test) {
                velocity.extend(run.series(JointQuantityKind::Velocity)?.iter().step_by(STRIDE));
                torque.extend(run.series(JointQuantityKind::Torque)?.iter().step_by(STRIDE));
            }
            let found = identify_friction(&law, &velocity, &torque, None)?;
            let at = |v: &f64| law.torque(&found.parameters, &Sliding::at(*v)) + found.offset;
            Ok(runs[test].series(JointQuantityKind::Velocity)?.iter().map(at).collect())
        };
        rows.push(fitted(name, &runs, predict)?.0);
    }
    let mut ridge = [0.0; 3];
    let predict = |test: usize| -> std::result::Result<Vec<f64>, BadInput> {
        let training: Vec<&Run> = others(&runs, test).collect();
        let mut offset = 0.0;
        let parts = training
            .iter()
            .map(|run| {
                let (position, torque) =
                    (run.series(JointQuantityKind::Position)?, run.series(JointQuantityKind::Torque)?);
                Ok(FrictionRun { period: 1.0 / RATE, position, torque })
            })
            .collect::<std::result::Result<Vec<_>, BadInput>>()?;
        let map = DahlMap::fit(&parts)?;
        for part in &parts {
            // Unchanged: the mean of the offsets of the recordings that were fitted.
            let own = map.torque(part.position, part.period)?;
            offset += (mean(part.torque) - mean(&own)) / parts.len() as f64;
        }
        ridge[test] = map.ridge;
        let torque = map.torque(runs[test].series(JointQuantityKind::Position)?, 1.0 / RATE)?;
        Ok(torque.into_iter().map(|torque| torque + offset).collect())
    };
    let (row, predicted) = fitted("dahl-map", &runs, predict)?;
    rows.push(row);
    let mut figure = [const { [const { Vec::new() }; 3] }; 3];
    for (test, (run, predicted)) in runs.iter().zip(&predicted).enumerate() {
        let (time, measured) = (run.recording.time(), run.series(JointQuantityKind::Torque)?);
        let shift = tare(time, measured, predicted);
        for k in (0..time.len()).step_by(DECIMATION) {
            for (curve, value) in figure.iter_mut().zip([time[k], measured[k], predicted[k] + shift]) {
                curve[test].push(value);
            }
        }
    }
    let [time_s, measured, predicted] = figure;
    Ok(FrankaCell { rows, time_s, measured, predicted, ridge })
}

impl Run {
    fn series(&self, quantity: JointQuantityKind) -> std::result::Result<&[f64], BadInput> {
        Ok(ArmRecording::of(&self.recording)?.require(quantity)?[0])
    }
}

fn others(runs: &[Run], test: usize) -> impl Iterator<Item = &Run> {
    runs.iter().enumerate().filter(move |(k, _)| *k != test).map(|(_, run)| run)
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

/// Root mean square error of a prediction that comes with the data.
fn published(run: &Run, name: &str) -> std::result::Result<Option<f64>, BadInput> {
    let column = |name: &str| -> std::result::Result<&Vec<f64>, BadInput> {
        let missing = || BadInput::new(name, "this column", "none");
        Ok(&run.table.columns().iter().find(|column| column.name == name).ok_or_else(missing)?.values)
    };
    let (measured, predicted) = (column("q2_tau_J_compensate")?, column(name)?);
    let squares: f64 = measured.iter().zip(predicted).map(|(a, b)| (a - b).powi(2)).sum();
    Ok(Some((squares / measured.len() as f64).sqrt()).filter(|rms| rms.is_finite()))
}

/// Mean error over the first seconds: what is added to a prediction.
fn tare(time: &[f64], measured: &[f64], predicted: &[f64]) -> f64 {
    let n = time.partition_point(|t| *t < time[0] + TARE);
    mean(&measured[..n]) - mean(&predicted[..n])
}

/// A model that is fitted with each recording as test once, and its predictions.
fn fitted(
    name: &str,
    runs: &[Run],
    mut predict: impl FnMut(usize) -> std::result::Result<Vec<f64>, BadInput>,
) -> std::result::Result<(FrankaRow, Vec<Vec<f64>>), BadInput> {
    let (mut all, mut tared, mut predictions) = ([None; 3], [0.0; 3], Vec::new());
    for (test, run) in runs.iter().enumerate() {
        let predicted = predict(test)?;
        let (time, measured) = (run.recording.time(), run.series(JointQuantityKind::Torque)?);
        let gap = run.recording.gap();
        // Rows that were filled in are no measurements.
        let rms = |from: f64, shift: f64| {
            let rows = (0..time.len()).filter(|k| time[*k] >= time[0] + from && !gap[*k]);
            let squares: Vec<f64> = rows.map(|k| (measured[k] - predicted[k] - shift).powi(2)).collect();
            mean(&squares).sqrt()
        };
        all[test] = Some(rms(0.0, 0.0));
        tared[test] = rms(TARE, tare(time, measured, &predicted));
        predictions.push(predicted);
    }
    let row =
        FrankaRow { method: name.to_owned(), is_published: false, all_rows_n_m: all, tared_n_m: Some(tared) };
    Ok((row, predictions))
}
