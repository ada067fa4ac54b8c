//! The figures of recordings that followed a target.

use hysteron_control::TargetPath;
use hysteron_control::tracking::{Timed, errors};
use hysteron_report::error_path::{ErrorPath, ErrorPaths};
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::series::millimetres;

use super::table::Row;

/// Recordings that are drawn at most.
const MAX_PANELS: usize = 12;
/// Recordings in a chart over time at most.
const MAX_CURVES: usize = 5;

/// Target and paths over each other, one pair of axes per recording.
pub fn overlay(target: &TargetPath, rows: &[Row]) -> ErrorPaths {
    let path = |row: &Row| ErrorPath {
        name: row.name.clone(),
        path: row.tracked.curve().iter().map(|[x, y]| (1e3 * x, 1e3 * y)).collect(),
        errors: millimetres(&errors(target, &row.tracked)),
    };
    let more = match rows.len().saturating_sub(MAX_PANELS) {
        0 => String::new(),
        n => format!(" {n} more are in the table."),
    };
    ErrorPaths {
        name: "tracking".to_owned(),
        title: "Target and tip".to_owned(),
        caption: format!(
            "Target, dashed, and path of the tip on it, coloured by its distance from the target [mm]; all axes have one \
             scale.{more}"
        ),
        target: target.outline.points().iter().map(|p| (1e3 * p[0], 1e3 * p[1])).collect(),
        paths: rows.iter().take(MAX_PANELS).map(path).collect(),
    }
}

/// Target and tips at the same times, and their distance; `None` where the times do not compare.
pub fn over_time(target: &TargetPath, rows: &[Row]) -> Option<TimeChart> {
    let shown: Vec<&Row> =
        rows.iter().filter(|row| row.score.aligned_rmse_m.is_some()).take(MAX_CURVES).collect();
    if shown.is_empty() {
        return None;
    }
    let samples: Vec<usize> = target.curve().collect();
    let time: Vec<f64> = samples.iter().map(|i| target.time(*i)).collect();
    let goal: Vec<[f64; 3]> = samples.iter().map(|i| target.points()[*i]).collect();
    let tip = |row: &Row| -> Vec<[f64; 2]> {
        let path = Timed { time: &row.tracked.time, points: &row.tracked.points };
        time.iter().map(|t| path.at(*t).unwrap_or([f64::NAN; 2])).collect()
    };
    let tips: Vec<Vec<[f64; 2]>> = shown.iter().map(|row| tip(row)).collect();
    // The first colour is the target's.
    let curves = |of: &dyn Fn(usize, &[f64; 2]) -> f64| -> Vec<Curve> {
        let values = |tip: &Vec<[f64; 2]>| tip.iter().enumerate().map(|(i, p)| 1e3 * of(i, p)).collect();
        shown
            .iter()
            .zip(&tips)
            .enumerate()
            .map(|(k, (row, tip))| Curve::new(&row.name, k + 1, values(tip)))
            .collect()
    };
    let axis = |c: usize| {
        let target_curve = Curve::new("target", 0, goal.iter().map(|p| 1e3 * p[c]).collect());
        let panel = [target_curve].into_iter().chain(curves(&|_, p| p[c])).collect();
        TimePanel::new(["x [mm]", "y [mm]"][c], panel)
    };
    let distance = |i: usize, p: &[f64; 2]| (p[0] - goal[i][0]).hypot(p[1] - goal[i][1]);
    let panels = vec![axis(0), axis(1), TimePanel::new("error [mm]", curves(&distance))];
    let more = match rows.len() - shown.len() {
        0 => String::new(),
        n => format!(" {n} more recordings are in the table."),
    };
    let caption = format!(
        "Target and measured tip at equal times, and the distance between them [mm] over time [s]. A tip that follows late \
         shows a large error here even where its path lies on the target.{more}"
    );
    Some(TimeChart::over_time("tracking-time", "Target and tip over time", caption, &time, panels))
}
