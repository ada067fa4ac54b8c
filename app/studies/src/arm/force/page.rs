//! The page of `study force`.

use std::path::Path;

use hysteron_report::figure::{register_embedded_font, save};
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::page::{Page, write_metrics, write_page};

use super::cells::{ForceCell, ForceStudy};
use super::methods::{METHODS, PUBLISHED, TASKS};
use super::outcome::{Outcome, Shown, over_arms, row};
use super::score::Trace;
use crate::arm::estimation::page::ours_and_published;

/// Errors: heading, value.
const ERRORS: [(&str, Shown); 4] = [
    ("Table VI: mean of three axes over all rows, rows without a label as 0 N", |row| row.mean_n),
    ("Mean of three axes over rows with a label", |row| row.labelled_n),
    ("Along z over rows with a label", |row| row.z_n),
    ("Norm of the error over rows with a label", |row| row.norm_n),
];

/// Writes `report.html` and `metrics.json`.
pub(super) fn write(folder: &Path, study: &ForceStudy, outcome: &Outcome) -> anyhow::Result<()> {
    register_embedded_font()?;
    write_metrics(folder, outcome)?;
    let (title, source) = ("Force at the tip without a sensor", "study of forces without a sensor");
    let mut page = Page::with_verdict(title, &outcome.verdict, source, &outcome.command);
    page.paragraph(&outcome.about);
    page.paragraph(
        "Motors, friction, noise and thresholds are identified on contact-free training trajectories of the same arm; the bodies are the \
         manufacturer's. Mean over the arms ± standard deviation; values of Dou et al. (NeuralActuator, table VI), measured on a real arm, in \
         brackets. Their GMO is GMO-linear here. \"no force\" is 0 N everywhere.",
    );
    let tasks = TASKS.map(|task| {
        task.replace("go_up_and_stay_still", "stay").replace("pick_place_object", "place").replace('_', " ")
    });
    let mut head = vec!["Method"];
    head.extend(tasks.iter().map(String::as_str));
    head.push("mean");
    for (k, (title, shown)) in ERRORS.into_iter().enumerate() {
        page.heading(&format!("{title} [N]"));
        let mut rows: Vec<Vec<String>> =
            (0..METHODS.len()).map(|method| cells(study, method, shown, k == 0)).collect();
        if k == 0 {
            let [_, _, _, (name, known)] = PUBLISHED;
            let network = known.map(|x| format!("({x})"));
            rows.push([vec![format!("{name}, published")], network.to_vec()].concat());
        }
        page.table(&head, rows);
    }
    free(&mut page, study);
    page.heading("Estimates");
    if let Some(cell) = study.cells.first() {
        for trace in &cell.traces {
            page.figure(&save(folder, &chart(trace), false)?);
        }
    }
    write_page(folder, page.finish(&outcome.commit))
}

fn cells(study: &ForceStudy, method: usize, shown: Shown, with_published: bool) -> Vec<String> {
    let known = PUBLISHED.iter().find(|(name, _)| with_published && *name == METHODS[method]);
    let cell = |(k, found): (usize, Option<[f64; 2]>)| match (found, known) {
        (None, _) => "-".to_owned(),
        (Some([mean, deviation]), Some((_, known))) => {
            format!("{} ± {deviation:.2}", ours_and_published(mean, known[k], 2))
        }
        (Some([mean, deviation]), None) => format!("{mean:.2} ± {deviation:.2}"),
    };
    let values = row(study, method, shown).into_iter().enumerate().map(cell);
    [METHODS[method].to_owned()].into_iter().chain(values).collect()
}

/// False contacts.
fn free(page: &mut Page, study: &ForceStudy) {
    page.heading("Contact-free trajectories");
    page.paragraph(
        "Part of the rows in which a contact is seen that is none: above 0.5 N, the paper's noise floor, and above what 99 % of the training \
         rows stay below. The paper gives 33 to 59 % for its classical methods, without its threshold.",
    );
    let head = [
        "Method",
        "Mean norm [N]",
        "Above 0.5 N [%]",
        "Above the learned threshold [%]",
        "Learned threshold [N]",
    ];
    let text = |found: Option<[f64; 2]>, digits: usize| {
        found.map_or_else(
            || "-".to_owned(),
            |[mean, deviation]| format!("{mean:.digits$} ± {deviation:.digits$}"),
        )
    };
    let rows = METHODS.iter().enumerate().map(|(method, name)| {
        let over = |of: &dyn Fn(&ForceCell) -> f64| over_arms(&study.cells, &|cell| Some(of(cell)));
        vec![
            (*name).to_owned(),
            text(over(&|cell| cell.free[method].norm_n), 2),
            text(over(&|cell| 100.0 * cell.free[method].contacts.above_half_n), 1),
            text(over(&|cell| 100.0 * cell.free[method].contacts.above_learned), 1),
            text(over(&|cell| cell.free[method].contacts.learned_n), 2),
        ]
    });
    page.table(&head, rows);
}

fn chart(trace: &Trace) -> TimeChart {
    let mut curves = vec![Curve::new("label", 0, trace.label_n.clone())];
    let estimates = METHODS.iter().zip(&trace.estimates_n).enumerate().skip(1);
    curves.extend(estimates.map(|(k, (name, values))| Curve::new(*name, k, values.clone())));
    let title = format!("Force along z: {}", trace.task.replace('_', " "));
    let caption = "Label and estimates over time; the label is 0 where there is none. First arm.";
    TimeChart::over_time(
        &trace.task,
        &title,
        caption,
        &trace.time_s,
        vec![TimePanel::new("force [N]", curves)],
    )
}
