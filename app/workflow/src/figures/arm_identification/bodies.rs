//! The report of `arm identify inertia`.

use std::path::Path;

use hysteron_arm::Model;
use hysteron_arm::identify::JointTerm;
use hysteron_report::figure::save;
use hysteron_report::scatter::{Marks, Scatter, ScatterChart};

use super::{JointSeries, errors_over_speed, errors_over_time, friction_curves, measured_over_predicted};
use crate::Context;
use crate::arm::identify::{Row, Summary, TERMS};

/// Content of the report.
pub(crate) struct Shown<'a> {
    /// The robot.
    pub model: &'a Model,
    /// Its joints, on the test recording where there is one.
    pub joints: Vec<JointSeries>,
    /// The numbers that were found.
    pub rows: &'a [Row],
    /// Root mean square errors of the fit, joint by joint [N m].
    pub rms: &'a [f64],
    /// The same on test recordings.
    pub tested: Option<&'a [f64]>,
    /// Terms that can hardly be distinguished.
    pub warnings: &'a [String],
    /// Everything, for `metrics.json`.
    pub summary: &'a Summary,
}

/// Writes the figures, `report.html` and `metrics.json` to `folder`.
pub(crate) fn write(folder: &Path, shown: &Shown, png: bool, context: &Context) -> anyhow::Result<()> {
    let about = "Ten numbers of every body, feasible together, and armature, friction, offset and spring of every joint, by linear \
                 regression of measured torques. Figures show what was not fitted, where a test is there.";
    let mut page = super::page(
        folder,
        &format!("Identified bodies of {}", shown.model.name()),
        shown.summary,
        about,
        context,
    )?;
    page.heading("Error of the torques, root mean square [N m]");
    let head: Vec<&str> =
        std::iter::once("").chain(shown.joints.iter().map(|joint| joint.name.as_str())).collect();
    let cells = |name: &str, values: &[f64]| {
        std::iter::once(name.to_owned()).chain(values.iter().map(|x| format!("{x:.4}"))).collect::<Vec<_>>()
    };
    let spread: Vec<f64> = shown.joints.iter().map(|joint| deviation(&joint.measured)).collect();
    let mut table = vec![cells("fitted", shown.rms)];
    table.extend(shown.tested.map(|tested| cells("not fitted", tested)));
    table.push(cells("standard deviation of the torque itself", &spread));
    page.table(&head, table);
    shown.warnings.iter().for_each(|warning| page.paragraph(warning));
    page.heading("Figures");
    let joints = &shown.joints[..];
    for chart in [
        friction_curves(joints),
        measured_over_predicted(joints),
        errors_over_speed(joints),
        terms(shown.rows, joints.len()),
    ] {
        page.figure(&save(folder, &chart, png)?);
    }
    for chart in errors_over_time(joints) {
        page.figure(&save(folder, &chart, png)?);
    }
    page.heading("Parameters");
    page.table(&["Number", "Value", "Standard error", ""], shown.rows.iter().map(Row::cells));
    super::finish(folder, page, shown.summary)
}

fn deviation(x: &[f64]) -> f64 {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    (x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// The terms of all joints with their standard errors, a tile for each kind.
fn terms(rows: &[Row], n_joints: usize) -> ScatterChart {
    let tile = |term: &JointTerm| {
        let bar = |j: usize| {
            let name = term.name(j);
            let row = rows.iter().find(|row| row.name == name)?;
            Some([(j + 1) as f64, row.value, row.standard_error.unwrap_or(0.0)])
        };
        Scatter {
            x_name: "joint [-]".into(),
            y_name: label(*term).into(),
            marks: vec![Marks::bars("± one standard error", 0, (0..n_joints).filter_map(bar).collect())],
        }
    };
    ScatterChart {
        name: "terms".into(),
        title: "Rotor, friction, offset and spring of every joint".into(),
        caption: "Estimates with one standard error to both sides.".into(),
        tiles: TERMS.iter().map(tile).collect(),
    }
}

fn label(term: JointTerm) -> &'static str {
    match term {
        JointTerm::Armature => "armature [kg m²]",
        JointTerm::Coulomb => "Coulomb friction [N m]",
        JointTerm::Viscous => "viscous friction [N m s/rad]",
        JointTerm::Offset => "offset [N m]",
        JointTerm::Spring => "spring [N m/rad]",
    }
}
