//! The page of `arm identify inertia`.

use hysteron_arm_estimation::identify::JointTerm;
use hysteron_report::folder::ReportFolder;
use hysteron_report::scatter::{Marks, Scatter, ScatterChart};

use super::Outcome;
use crate::arm::identify::motion::TERMS;
use crate::shared::identification::{ESTIMATE_HEADINGS, ParameterEstimate, deviation};
use crate::shared::identification_page::{
    JointSeries, begin, errors_over_speed, errors_over_time, finish, friction_curves, measured_over_predicted,
};

/// Introduction of the page.
const ABOUT: &str = "Ten numbers of every body, feasible together, and armature, friction, offset and spring of every joint, by linear \
                     regression of measured torques. Figures show what was not fitted, where a test is there.";

/// Writes the figures, `report.html` and `metrics.json` to `folder`; `joints` are of the test recording where there is one.
pub(super) fn write(folder: &ReportFolder, joints: &[JointSeries], outcome: &Outcome) -> anyhow::Result<()> {
    let title = format!("Identified bodies of {}", outcome.robot);
    let mut page = begin(folder, outcome, &outcome.verdict, (&title, ABOUT, &outcome.command))?;
    page.heading("Error of the torques, root mean square [N m]");
    let head: Vec<&str> = std::iter::once("").chain(joints.iter().map(|joint| joint.name.as_str())).collect();
    let cells = |name: &str, values: &[f64]| {
        std::iter::once(name.to_owned()).chain(values.iter().map(|x| format!("{x:.4}"))).collect::<Vec<_>>()
    };
    let spread: Vec<f64> = joints.iter().map(|joint| deviation(&joint.measured)).collect();
    let mut table = vec![cells("fitted", &outcome.rms_n_m)];
    table.extend(outcome.test_rms_n_m.as_ref().map(|tested| cells("not fitted", tested)));
    table.push(cells("standard deviation of the torque itself", &spread));
    page.table(&head, table);
    outcome.warnings.iter().for_each(|warning| page.paragraph(warning));
    page.heading("Figures");
    for chart in [
        friction_curves(joints),
        measured_over_predicted(joints),
        errors_over_speed(joints),
        terms(&outcome.estimates, joints.len()),
    ] {
        folder.add(&mut page, &chart)?;
    }
    for chart in errors_over_time(joints) {
        folder.add(&mut page, &chart)?;
    }
    page.heading("Parameters");
    page.table(&ESTIMATE_HEADINGS, outcome.estimates.iter().map(ParameterEstimate::cells));
    finish(folder, page, &outcome.recording_warnings)
}

/// The terms of all joints with their standard errors, a tile for each kind.
fn terms(estimates: &[ParameterEstimate], n_joints: usize) -> ScatterChart {
    let tile = |term: &JointTerm| {
        let bar = |j: usize| {
            let name = term.name(j);
            let found = estimates.iter().find(|estimate| estimate.name == name)?;
            Some([(j + 1) as f64, found.value, found.standard_error.unwrap_or(0.0)])
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
