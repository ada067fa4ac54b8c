//! The reduced model fitted to patterns: zeros, turns, compliance and plays of its tendons, its weight and marker, and the frame of
//! the measurement.
//!
//! Nine tendons at one radius cannot lie in three planes, so each segment's tendons may be turned about the axis. The
//! frame is found in closed form at every step of the fit.

use anyhow::Result;
use hysteron_base::{BadInput, Bounds};
use hysteron_twin::alignment;
use hysteron_twin::fit::{Options, Parameter, ParameterScale, TOLERANCE, least_squares};
use nalgebra::{Matrix3, Vector3};

use super::recording::{N_TENDONS, Pattern, Row};
use super::reduced::Reduced;

/// Coordinate error from which on a row counts linearly [m].
const HUBER: f64 = 5e-3;

/// Which parameters of the reduced model are fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParameterSet {
    /// Zeros, turns and compliance of the tendons: a model without memory and weight.
    Tendons,
    /// Plays, weight and marker as well.
    All,
}

/// Parameters, and the frame of the measurement.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// Their values.
    pub values: Vec<f64>,
    /// Why the search ended.
    pub ended: String,
    /// The model with these values.
    pub model: Reduced,
    turn: Matrix3<f64>,
    shift: Vector3<f64>,
}

impl Fitted {
    /// Fits to every `every`-th row of the patterns: a row knows where it comes from, so any rows will do.
    ///
    /// # Errors
    /// Those of the fit.
    pub fn new(training: &[Pattern], every: usize, set: ParameterSet) -> Result<Self> {
        let rows: Vec<&Row> = training.iter().flat_map(|pattern| &pattern.rows).step_by(every).collect();
        Self::search(&parameters(set), &rows, &vec![Vector3::zeros(); rows.len()])
    }

    /// Fits again from here, to `rows` alone, with `further` added to each marker of the reduced model [m]: what
    /// another model with these parameters adds to it. Repeated, this fits the other model (space mapping:
    /// Bandler et al.
    /// 2004, IEEE Trans. Microwave Theory Tech. 52, with the correction of the output alone).
    ///
    /// # Errors
    /// Those of the fit.
    pub fn again(&self, rows: &[&Row], further: &[Vector3<f64>]) -> Result<Self> {
        let mut parameters = parameters(ParameterSet::All);
        parameters.iter_mut().zip(&self.values).for_each(|(parameter, value)| parameter.start = *value);
        Self::search(&parameters, rows, further)
    }

    fn search(parameters: &[Parameter], rows: &[&Row], further: &[Vector3<f64>]) -> Result<Self> {
        let measured: Vec<Vector3<f64>> = rows.iter().map(|row| row.tip.into()).collect();
        let markers = |values: &[f64]| -> Vec<Vector3<f64>> {
            let model = model(values);
            rows.iter().zip(further).map(|(row, further)| model.shape(row).marker + further).collect()
        };
        let residuals = |values: &[f64]| {
            let markers = markers(values);
            let (turn, shift) = alignment(&markers, &measured);
            let error =
                |(from, to): (&Vector3<f64>, &Vector3<f64>)| (turn * from + shift - to).as_slice().to_vec();
            Ok::<_, BadInput>(markers.iter().zip(&measured).map(error).collect())
        };
        let options = Options {
            huber: Some(HUBER),
            smallest_effect: 1e-4,
            n_nuisance: 6,
            tolerance: TOLERANCE,
            watch: &|_, _| true,
        };
        let fit = least_squares(parameters, &options, residuals)?;
        let values = fit.values();
        let (turn, shift) = alignment(&markers(&values), &measured);
        let names = fit.estimates.iter().map(|estimate| estimate.name.clone()).collect();
        Ok(Self { names, model: model(&values), values, ended: fit.ended, turn, shift })
    }

    /// A measured point [m] in the frame of the robot.
    pub fn of_robot(&self, point: Vector3<f64>) -> Vector3<f64> {
        self.turn.transpose() * (point - self.shift)
    }

    /// A point of the robot in the frame of the measurement [mm].
    pub fn measured(&self, point: Vector3<f64>) -> [f64; 3] {
        (1e3 * (self.turn * point + self.shift)).into()
    }
}

fn parameters(set: ParameterSet) -> Vec<Parameter> {
    let parameter = |name: String, start: f64, half: f64| Parameter {
        name,
        start,
        bounds: Bounds { min: start - half, max: start + half },
        scale: ParameterScale::Linear,
        prior: None,
    };
    let mut parameters: Vec<Parameter> =
        (0..N_TENDONS).map(|k| parameter(format!("zero of tendon {} [m]", k + 1), 0.0, 5e-3)).collect();
    // Upstream's angles of the segments lie 0.50 and 1.01 rad beyond the first's. A turn of all is the frame's.
    for (segment, start) in [(2, 0.5), (3, 1.0)] {
        parameters.push(parameter(format!("turn of segment {segment}'s tendons [rad]"), start, 0.8));
    }
    // Steel rope of some 0.3 mm over half a metre: 0.1 mm/N.
    parameters.push(Parameter {
        name: "compliance of the tendons [m/N]".into(),
        start: 1e-4,
        bounds: Bounds { min: 1e-6, max: 1e-2 },
        scale: ParameterScale::Logarithmic,
        prior: None,
    });
    if set == ParameterSet::All {
        parameters
            .extend((1..=N_TENDONS).map(|k| parameter(format!("half play of tendon {k} [m]"), 0.0, 1e-3)));
        parameters.push(parameter("marker beyond the end [m]".into(), MARKER, 8e-3));
        parameters.extend(["x", "y", "z"].map(|axis| parameter(format!("weight, {axis} [N/m]"), 0.0, 3.0)));
    }
    parameters
}

/// Distance of the marker beyond the end where it is not fitted [m]: half of its mount.
const MARKER: f64 = 8e-3;

fn model(values: &[f64]) -> Reduced {
    let further = &values[N_TENDONS + 3..];
    Reduced {
        zeros: std::array::from_fn(|k| values[k]),
        turns: [0.0, values[N_TENDONS], values[N_TENDONS + 1]],
        compliance: values[N_TENDONS + 2],
        plays: std::array::from_fn(|k| further.get(k).copied().unwrap_or(0.0)),
        marker: further.get(N_TENDONS).copied().unwrap_or(MARKER),
        weight: further.get(N_TENDONS + 1..).map_or_else(Vector3::zeros, Vector3::from_column_slice),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;
    use nalgebra::Rotation3;

    /// Rows of a robot with other parameters than the fit begins with, in its own frame.
    fn rows() -> Vec<Row> {
        let mut stream = hysteron_base::rng(1, "fit");
        let mut stroke = || rand::RngExt::random_range(&mut stream, -4e-3..4e-3);
        let strokes: Vec<[f64; N_TENDONS]> = (0..80).map(|_| std::array::from_fn(|_| stroke())).collect();
        let model = model(&[&[0.3e-3; N_TENDONS][..], &[0.4, 1.1, 3e-4]].concat());
        let measured = |row: Row| Row { tip: model.shape(&row).marker.into(), ..row };
        strokes.into_iter().map(|strokes| measured(Row::new(strokes, [0.0; 3]))).collect()
    }

    #[test]
    fn what_another_model_adds_is_no_error() {
        let rows = rows();
        let rows: Vec<&Row> = rows.iter().collect();
        let pattern = Pattern { label: String::new(), rows: rows.iter().map(|row| (*row).clone()).collect() };
        let fitted = Fitted::new(&[pattern], 1, ParameterSet::Tendons).unwrap();
        // The other model bends the tip aside with the square of a stroke: half a millimetre and more.
        let aside = |row: &Row| Vector3::x() * (40.0 * row.strokes[0].powi(2));
        let bent: Vec<Row> = rows
            .iter()
            .map(|row| Row { tip: (Vector3::from(row.tip) + aside(row)).into(), ..(*row).clone() })
            .collect();
        let bent: Vec<&Row> = bent.iter().collect();
        let further: Vec<Vector3<f64>> = bent.iter().map(|row| aside(row)).collect();
        let again = fitted.again(&bent, &further).unwrap();
        for row in &bent {
            let [x, y, z] = again.measured(again.model.shape(row).marker + aside(row));
            let off = (Vector3::new(x, y, z) - 1e3 * Vector3::from(row.tip)).norm();
            // The search ends where the sum of squares falls by less than 1e-5 of it: micrometres.
            assert!(off < 0.02, "{off} mm");
        }
    }

    #[test]
    fn alignment_undoes_a_rigid_motion() {
        let turn = Rotation3::from_scaled_axis(Vector3::new(0.3, -1.2, 0.7)).into_inner();
        let shift = Vector3::new(0.1, -0.2, 0.3);
        let from: Vec<Vector3<f64>> = [[0.1, 0.0, 0.2], [0.0, 0.3, 0.1], [-0.1, 0.1, 0.0], [0.2, 0.2, -0.1]]
            .map(Vector3::from)
            .to_vec();
        let to: Vec<Vector3<f64>> = from.iter().map(|point| turn * point + shift).collect();
        let (found, by) = alignment(&from, &to);
        // Rounding of a singular value decomposition of numbers of order one.
        assert!((found - turn).norm() < 1e-12 && (by - shift).norm() < 1e-12, "{found} {by}");
    }
}
