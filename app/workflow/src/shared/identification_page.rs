//! Charts of identifications: measured and predicted torques, friction with its cloud of data, residuals, parameters.

use hysteron_base::checks::Warning;
use hysteron_report::folder::ReportFolder;
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::page::Page;
use hysteron_report::scatter::{Marks, Scatter, ScatterChart};
use hysteron_report::verdict::Verdict;

use crate::COMMIT;
use crate::shared::identification::ParameterEstimate;
use crate::shared::outcome::Outcome;
use crate::shared::recording_checks;

/// Most joints whose curves over time are drawn.
const MAX_JOINTS: usize = 8;
/// Points of a curve of friction.
const CURVE: usize = 241;

/// One joint as measured and as predicted.
pub struct JointSeries {
    /// Name of the joint.
    pub name: String,
    /// Speeds (n_samples) [rad/s].
    pub velocity: Vec<f64>,
    /// Torque as measured (n_samples) [N m].
    pub measured: Vec<f64>,
    /// The same as predicted.
    pub predicted: Vec<f64>,
    /// Friction as identified, at each of the speeds [N m].
    friction: Vec<f64>,
    /// Speeds and friction of a curve.
    curve: [Vec<f64>; 2],
}

impl JointSeries {
    /// Speeds, measured and predicted torques; `friction` is the part of the prediction that depends on speed alone.
    pub fn new(
        name: String,
        [velocity, measured, predicted]: [Vec<f64>; 3],
        friction: &dyn Fn(f64) -> f64,
    ) -> Self {
        let fastest = velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let half = (CURVE / 2) as f64;
        let speeds: Vec<f64> = (0..CURVE).map(|k| fastest * (k as f64 - half) / half).collect();
        // The jump at standstill is no slope.
        let at = |v: &f64| if *v == 0.0 { f64::NAN } else { friction(*v) };
        let curve = [speeds.clone(), speeds.iter().map(at).collect()];
        let friction = velocity.iter().map(|v| friction(*v)).collect();
        Self { name, velocity, measured, predicted, friction, curve }
    }

    fn errors(&self) -> Vec<f64> {
        self.measured.iter().zip(&self.predicted).map(|(a, b)| a - b).collect()
    }
}

/// Friction over speed: the identified curve over what the torques leave once everything else is taken off.
pub fn friction_curves(joints: &[JointSeries]) -> ScatterChart {
    let tile = |joint: &JointSeries| {
        let cloud: Vec<f64> = joint.errors().iter().zip(&joint.friction).map(|(e, f)| e + f).collect();
        Scatter {
            x_name: format!("{}: speed [rad/s]", joint.name),
            y_name: "friction [N m]".into(),
            marks: vec![
                Marks::dots("measured, less all other terms", 5, &joint.velocity, &cloud),
                Marks::line("identified", 1, &joint.curve[0], &joint.curve[1]),
            ],
        }
    };
    ScatterChart {
        name: "friction".into(),
        title: "Friction".into(),
        caption: "Torque of friction over speed: each dot is a sample, less what all other terms of the fit predict; the line is the \
                  identified friction."
            .into(),
        tiles: joints.iter().map(tile).collect(),
    }
}

/// Measured over predicted torque.
pub fn measured_over_predicted(joints: &[JointSeries]) -> ScatterChart {
    let tile = |joint: &JointSeries| {
        let ends = joint.predicted.iter().fold([f64::MAX, f64::MIN], |[a, b], x| [a.min(*x), b.max(*x)]);
        Scatter {
            x_name: format!("{}: predicted [N m]", joint.name),
            y_name: "measured [N m]".into(),
            marks: vec![
                Marks::dots("samples", 0, &joint.predicted, &joint.measured),
                Marks::line("equal", 6, &ends, &ends),
            ],
        }
    };
    ScatterChart {
        name: "measured-predicted".into(),
        title: "Measured over predicted torque".into(),
        caption: "Measured torque over predicted torque, sample by sample.".into(),
        tiles: joints.iter().map(tile).collect(),
    }
}

/// Residuals over speed.
pub fn errors_over_speed(joints: &[JointSeries]) -> ScatterChart {
    let tile = |joint: &JointSeries| Scatter {
        x_name: format!("{}: speed [rad/s]", joint.name),
        y_name: "measured less predicted [N m]".into(),
        marks: vec![Marks::dots("samples", 3, &joint.velocity, &joint.errors())],
    };
    ScatterChart {
        name: "residuals-speed".into(),
        title: "Residuals over speed".into(),
        caption: "Measured less predicted torque over speed: a shape that is left is friction that the law has not.".into(),
        tiles: joints.iter().map(tile).collect(),
    }
}

/// Torques and what is left over the samples, in the order of the recordings.
pub fn errors_over_time(joints: &[JointSeries]) -> Vec<TimeChart> {
    let n = joints.first().map_or(0, |joint| joint.measured.len());
    let samples: Vec<f64> = (0..n).map(|k| k as f64).collect();
    let panels = |of: &dyn Fn(&JointSeries) -> Vec<Curve>| -> Vec<TimePanel> {
        let panel = |joint: &JointSeries| TimePanel::new(format!("{} [N m]", joint.name), of(joint));
        joints.iter().take(MAX_JOINTS).map(panel).collect()
    };
    let torques = panels(&|joint| {
        vec![
            Curve::new("measured", 5, joint.measured.clone()),
            Curve::new("predicted", 1, joint.predicted.clone()),
        ]
    });
    let errors = panels(&|joint| vec![Curve::new("measured less predicted", 3, joint.errors())]);
    let chart = |name: &str, title: &str, caption: &str, panels: Vec<TimePanel>| {
        let mut chart = TimeChart::over_time(name, title, caption, &samples, panels);
        chart.x_name = "sample [-]";
        chart
    };
    vec![
        chart(
            "torques",
            "Torques",
            "Measured and predicted torque of every joint, sample by sample.",
            torques,
        ),
        chart(
            "residuals",
            "Residuals",
            "Measured less predicted torque, sample by sample; each panel has its own scale.",
            errors,
        ),
    ]
}

/// Standard errors relative to the values, parameter by parameter, of those that have one.
pub fn relative_errors(rows: &[ParameterEstimate]) -> ScatterChart {
    let bar = |(k, row): (usize, &ParameterEstimate)| {
        let error = row.standard_error.filter(|_| row.value != 0.0)?;
        // An error ten times the value is no longer drawn: the parameter is not known.
        Some([(k + 1) as f64, 1.0, (error / row.value.abs()).min(10.0)])
    };
    ScatterChart {
        name: "parameters".into(),
        title: "Parameters and their standard errors".into(),
        caption: "Every parameter over its own value, with one standard error to both sides, in the order of the table; one without a \
                  standard error, or zero, is left out."
            .into(),
        tiles: vec![Scatter {
            x_name: "number of the parameter [-]".into(),
            y_name: "value over itself [-]".into(),
            marks: vec![Marks::bars("± one standard error", 0, rows.iter().enumerate().filter_map(bar).collect())],
        }],
    }
}

/// Writes `metrics.json`, and begins a page with the verdict.
pub(crate) fn begin<T: Outcome>(
    folder: &ReportFolder,
    outcome: &T,
    verdict: &Verdict,
    (title, about, command): (&str, &str, &str),
) -> anyhow::Result<Page> {
    folder.write_metrics(outcome)?;
    Ok(Page::with_verdict(title, verdict, about, command))
}

/// Ends a page with the warnings about the recordings, and writes it.
pub(crate) fn finish(folder: &ReportFolder, mut page: Page, warnings: &[Warning]) -> anyhow::Result<()> {
    recording_checks::show(warnings, &mut page);
    folder.write_page(page, COMMIT)
}
