//! Charts of the motion of an arm: its joints over time, and the arm at several times.

use hysteron_arm_dynamics::{Data, JointKind, Model, skeleton};
use hysteron_arm_estimation::{JointQuantityKind, channel_name, joint_rows};
use hysteron_base::Recording;
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::stick_figure::StickFigure;

/// Times at which the arm is drawn.
const POSES: usize = 7;

/// These quantities of every joint over time, a panel for each quantity and kind of joint.
pub(super) fn joints_over_time(
    model: &Model,
    motion: &Recording,
    quantities: &[JointQuantityKind],
    caption: &str,
) -> anyhow::Result<TimeChart> {
    let mut panels = Vec::new();
    for (kind, unit) in [(JointKind::Revolute, "rad"), (JointKind::Prismatic, "m")] {
        let joints = || model.joints().iter().enumerate().filter(|(_, joint)| joint.kind == kind);
        for quantity in quantities {
            let curve = |(i, (k, joint)): (usize, (usize, &hysteron_arm_dynamics::Joint))| {
                let values = motion.require(&channel_name(model, *quantity, k))?.to_vec();
                Ok(Curve::new(&*joint.name, i, values))
            };
            let curves = joints().enumerate().map(curve).collect::<anyhow::Result<_>>()?;
            panels.push(TimePanel::new(label(*quantity, unit), curves));
        }
    }
    panels.retain(|panel| !panel.curves.is_empty());
    Ok(TimeChart::over_time("joints", "Joints", caption, motion.time(), panels))
}

/// Symbol of a quantity with its unit.
fn label(quantity: JointQuantityKind, unit: &str) -> String {
    match quantity {
        JointQuantityKind::Velocity => format!("q' [{unit}/s]"),
        JointQuantityKind::Acceleration => format!("q'' [{unit}/s²]"),
        _ => format!("q [{unit}]"),
    }
}

/// The arm as lines between its joints, at several times.
pub(super) fn arm_at_several_times(model: &Model, motion: &Recording) -> anyhow::Result<StickFigure> {
    let (n, time) = (model.n_joints(), motion.time());
    let rows = joint_rows(model, motion, JointQuantityKind::Position)?.unwrap_or_default();
    let mut data = Data::new(model, 0.0);
    let last = time.len() - 1;
    let mut at: Vec<usize> = (0..POSES).map(|k| k * last / (POSES - 1)).collect();
    at.dedup();
    let pose = |i: usize| (time[i], skeleton(model, &mut data, &rows[n * i..n * (i + 1)]));
    let poses: Vec<_> = at.into_iter().map(pose).collect();
    let caption = format!(
        "Lines between the joints and to the frames of the arm [m], from the front and from the right, at {} times; the \
         colours are those of the time [s].",
        poses.len()
    );
    Ok(StickFigure { name: "arm".to_owned(), title: "The arm".to_owned(), caption, poses })
}
