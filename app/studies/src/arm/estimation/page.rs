//! Blocks that the pages of `study scara`, `study wrist` and `study force` share.

use hysteron_report::lines::{Curve, TimeChart, TimePanel};

/// A measured value with the published one in brackets: "ours (published)".
pub(crate) fn ours_and_published(ours: f64, published: f64, digits: usize) -> String {
    format!("{ours:.digits$} ({published})")
}

/// A panel for each joint with these curves: names, and their values joint by joint.
pub(crate) fn joints(
    name: &str,
    [title, caption, unit]: [&str; 3],
    time: &[f64],
    curves: &[(String, [Vec<f64>; 2])],
) -> TimeChart {
    let panel = |j: usize| {
        let curves = curves.iter().enumerate().map(|(k, (name, rows))| Curve::new(name, k, rows[j].clone()));
        TimePanel::new(format!("joint {} [{unit}]", j + 1), curves.collect())
    };
    TimeChart::over_time(name, title, caption, time, vec![panel(0), panel(1)])
}
