//! The page of a target: its curve, the way to it, and where a robot does not reach it.

use hysteron_control::TargetPath;
use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::target_map::{TargetMap, TargetPoint};
use hysteron_twin::Reach;

use super::outcome::Outcome;

/// Writes the figure, `report.html` and `metrics.json` to `folder`.
pub(super) fn write(
    folder: &ReportFolder,
    target: &TargetPath,
    reach: Option<&Reach>,
    outcome: &Outcome,
) -> anyhow::Result<()> {
    folder.write_metrics(outcome)?;
    let about = "Where the tip should go, from where it rests.";
    let title = format!("Target {}", target.name);
    let mut page = Page::concluded(&title, &conclusion(reach), about, &outcome.command);
    page.list([
        ("Family", target.family.clone()),
        ("Length of a lap [mm]", format!("{:.2}", 1e3 * outcome.length_m)),
        ("Laps", outcome.laps.to_string()),
        ("Curve [s]", format!("{:.2} to {:.2}", outcome.curve_s[0], outcome.curve_s[1])),
        ("Duration [s]", format!("{:.2}", outcome.duration_s)),
        ("Samples", format!("{}, {} a second", outcome.samples, target.rate_hz)),
    ]);
    if let Some(reach) = reach {
        page.list([
            ("Robot", reach.scene.clone()),
            ("Points out of reach", format!("{} of {}", reach.out_of_reach, reach.goals)),
            ("Tolerance [mm]", (1e3 * reach.tolerance_m).to_string()),
            ("Largest distance [mm]", format!("{:.3}", 1e3 * reach.largest_distance_m)),
            ("Largest tension [N]", format!("{:.2}", reach.tension_max_n)),
        ]);
        page.small(&format!("Scene {}.", reach.scene_sha256));
    }
    folder.add(&mut page, &map(target, reach))?;
    page.small(&format!("Target {}.", target.hash));
    folder.write_page(page, &outcome.commit)
}

/// The result in a sentence.
fn conclusion(reach: Option<&Reach>) -> String {
    match reach {
        Some(reach) => format!(
            "The robot reaches {} of {} points of the target within {} mm.",
            reach.goals - reach.out_of_reach,
            reach.goals,
            1e3 * reach.tolerance_m
        ),
        None => "A path for the tip; whether a robot reaches it was not checked.".to_owned(),
    }
}

/// The target from above.
fn map(target: &TargetPath, reach: Option<&Reach>) -> TargetMap {
    let mm = |p: &[f64; 3]| (1e3 * p[0], 1e3 * p[1]);
    let all: Vec<(f64, f64)> = target.points().iter().map(mm).collect();
    let (begins, ends) = (*target.curve().start(), *target.curve().end());
    let goals = |reach: &Reach| {
        let goal = |(goal, distance, tip): &([f64; 3], f64, [f64; 3])| TargetPoint {
            at: mm(goal),
            missed_at: (*distance > reach.tolerance_m).then(|| mm(tip)),
        };
        reach.places.iter().map(goal).collect()
    };
    let caption = "The target's curve, dashed, and the way to it from rest, at (0, 0).".to_owned()
        + match reach {
            None => "",
            Some(reach) if reach.out_of_reach == 0 => " Dots: points, which the twin reaches.",
            Some(_) => {
                " Dots: points that the twin reaches, and those that it does not, with a line to its tip."
            }
        };
    TargetMap {
        name: "target".to_owned(),
        title: "Target".to_owned(),
        caption,
        curve: target.outline.points().iter().map(mm).collect(),
        transits: vec![all[..=begins].to_vec(), all[ends..].to_vec()],
        goals: reach.map(goals),
    }
}
