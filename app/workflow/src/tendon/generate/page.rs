//! The card of a synthetic data set: its tip positions compared with those of the robot.

use std::collections::BTreeMap;

use hysteron_control::inverse::{Axes, TipWorkspace};
use hysteron_report::folder::ReportFolder;
use hysteron_report::heat_map::HeatMap;
use hysteron_report::page::Page;
use hysteron_report::plane::PlanePath;

use super::outcome::{Outcome, SyntheticTrajectory, tip_of};
use crate::shared::inputs::Input;

/// Writes the figure, `report.html` and `metrics.json` to `folder`; an empty set has no figure.
pub(super) fn write(folder: &ReportFolder, card: &Outcome, real: &[Input]) -> anyhow::Result<()> {
    folder.write_metrics(card)?;
    let about = "Synthetic data: trajectories of a plan, simulated by the twin. They are training data and were not measured \
                 on a robot.";
    let area = |k: usize| format!("{:.1}", 1e4 * card.areas_m2[k]);
    let title = format!("Synthetic data, plan {}", card.plan);
    let conclusion = format!("{} trajectories, {} samples, over {} cm².", card.made, card.samples, area(0));
    let mut page = Page::concluded(&title, &conclusion, about, &card.command);
    let percent = |part: f64| format!("{:.1}", 100.0 * part);
    page.heading("Results");
    let mut rows = vec![
        ("Trajectories", card.made.to_string()),
        ("Left out", card.dropped.to_string()),
        ("Samples", card.samples.to_string()),
        ("Network outside its training range [% of samples]", percent(card.extrapolating)),
        ("Area covered by the tip (convex hull) [cm²]", area(0)),
    ];
    if card.outside_validation > 0.0 {
        rows.push(("Chain bent further than validated [% of samples]", percent(card.outside_validation)));
    }
    if card.samples_real > 0 {
        rows.extend([
            ("Samples of the robot", card.samples_real.to_string()),
            ("Area covered by the robot's tip (convex hull) [cm²]", area(1)),
            ("Outside the robot's area [% of samples]", percent(card.outside)),
        ]);
    }
    page.list(rows);
    match card.why_empty() {
        Some(why) => page.paragraph(&format!("No figure: {why}.")),
        None => folder.add(&mut page, &coverage(card, real))?,
    }
    page.heading("Trajectories");
    page.table(&SyntheticTrajectory::HEADINGS, card.rows.iter().map(SyntheticTrajectory::cells));
    page.small(&format!("Scene {}.", card.scene_sha256));
    folder.write_page(page, &card.commit)
}

/// Where samples of the tip are, from above: a tile for every family, and one for the robot.
fn coverage(card: &Outcome, real: &[Input]) -> HeatMap {
    let mm = |tip: &[[f64; 2]]| -> PlanePath { tip.iter().map(|[x, y]| (1e3 * x, 1e3 * y)).collect() };
    let mut tips: BTreeMap<&str, (usize, PlanePath)> = BTreeMap::new();
    for row in card.rows.iter().filter(|row| !row.tip.is_empty()) {
        let (n, points) = tips.entry(&row.family).or_default();
        *n += 1;
        points.extend(mm(&row.tip));
    }
    let of_robot: Vec<Vec<[f64; 2]>> =
        real.iter().filter_map(|input| tip_of(&input.recording).ok()).collect();
    let robot = of_robot.concat();
    let hull = TipWorkspace::new(Axes::Planar, robot.iter().map(|[x, y]| [*x, *y, 0.0]).collect());
    let mut groups: Vec<(String, PlanePath)> = tips
        .into_iter()
        .map(|(family, (n, points))| (format!("{family}: {n} trajectories"), points))
        .collect();
    if !robot.is_empty() {
        groups.push((format!("robot: {} recordings", of_robot.len()), mm(&robot)));
    }
    let hull = mm(hull.corners());
    let line = if hull.is_empty() { "" } else { " The line is the convex hull of the robot's own samples." };
    let outline = ("convex hull of the robot's samples", hull);
    let mut map = HeatMap::new("coverage", "Coverage", groups, outline);
    map.caption = format!(
        "Samples of the tip in cells of {:.2} mm, from above [mm], by family of trajectories; the colour scale is \
         logarithmic, all axes have one scale.{line}",
        map.cell()
    );
    map
}
