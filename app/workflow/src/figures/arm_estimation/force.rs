//! The report of `arm study force`.

use std::path::Path;

use hysteron_base::{Metadata, json};
use hysteron_studies::force::{ForceCell, ForceStudy, LoadedRow, METHODS, PUBLISHED, TASKS, Trace};
use serde_json::Value;

use hysteron_report::figure::{register_embedded_font, save};
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::page::{Page, write_metrics, write_page};

use hysteron_report::verdict::Verdict;

use super::beside;
use crate::shared::verdict::{compared, repeated};

/// Value of a row that a table shows.
type Shown = fn(&LoadedRow) -> f64;

/// Errors: key in `metrics.json`, heading.
const ERRORS: [(&str, &str, Shown); 4] = [
    ("mean_n", "Table VI: mean of three axes over all rows, rows without a label as 0 N", |row| row.mean_n),
    ("labelled_n", "Mean of three axes over rows with a label", |row| row.labelled_n),
    ("z_n", "Along z over rows with a label", |row| row.z_n),
    ("norm_n", "Norm of the error over rows with a label", |row| row.norm_n),
];

/// Mean and standard deviation over arms.
fn over_arms(cells: &[ForceCell], of: &dyn Fn(&ForceCell) -> Option<f64>) -> Option<[f64; 2]> {
    let values: Vec<f64> = cells.iter().filter_map(of).collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    (!values.is_empty()).then(|| [mean, (squares / (n - 1.0).max(1.0)).sqrt()])
}

/// A method's error in each task, and their mean.
fn row(study: &ForceStudy, method: usize, shown: Shown) -> Vec<Option<[f64; 2]>> {
    let of = |cell: &ForceCell, task: usize| cell.loaded[method][task].as_ref().map(shown);
    let mean = |cell: &ForceCell| {
        let all: Vec<f64> = (0..TASKS.len()).filter_map(|task| of(cell, task)).collect();
        (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
    };
    let tasks = (0..TASKS.len()).map(|task| over_arms(&study.cells, &|cell| of(cell, task)));
    tasks.chain([over_arms(&study.cells, &mean)]).collect()
}

/// Writes `report.html` and `metrics.json`; `about` says what arms were recorded.
pub fn write(folder: &Path, study: &ForceStudy, about: &str, meta: &Metadata) -> anyhow::Result<Value> {
    register_embedded_font()?;
    let verdict = judged(study);
    let mut metrics = metrics(study, about, meta);
    metrics["verdict"] = json!(verdict);
    let value = write_metrics(folder, &metrics)?;
    let mut page = Page::judged("Force at the tip without a sensor", &verdict, &meta.source, &meta.command);
    page.paragraph(about);
    page.paragraph(
        "Motors, friction, noise and thresholds are identified on contact-free training trajectories of the same arm; the bodies are the \
         manufacturer's. Mean over the arms ± standard deviation; values of Dou et al. (NeuralActuator, table VI), measured on a real arm, in \
         brackets. Their GMO is GMO-linear here. \"no force\" says 0 N everywhere.",
    );
    let tasks = TASKS.map(|task| {
        task.replace("go_up_and_stay_still", "stay").replace("pick_place_object", "place").replace('_', " ")
    });
    let mut head = vec!["Method"];
    head.extend(tasks.iter().map(String::as_str));
    head.push("mean");
    for (k, (_, title, shown)) in ERRORS.into_iter().enumerate() {
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
    write_page(folder, page.finish(&meta.commit))?;
    Ok(value)
}

/// Whether the best estimator says more of the force than that there is none.
fn judged(study: &ForceStudy) -> Verdict {
    let mean = |method: usize| row(study, method, |row| row.norm_n).last().copied().flatten();
    let errors: Vec<(String, f64)> = METHODS
        .iter()
        .enumerate()
        .filter_map(|(method, name)| Some(((*name).to_owned(), mean(method)?[0])))
        .collect();
    let judged = Verdict::on("forces at the tip can be estimated without a sensor");
    let judged = compared(judged, ("error where a force acts", "N"), &errors, METHODS[0]);
    repeated(judged, study.cells.len(), "arm").verdict()
}

fn cells(study: &ForceStudy, method: usize, shown: Shown, with_published: bool) -> Vec<String> {
    let known = PUBLISHED.iter().find(|(name, _)| with_published && *name == METHODS[method]);
    let cell = |(k, found): (usize, Option<[f64; 2]>)| match (found, known) {
        (None, _) => "-".to_owned(),
        (Some([mean, deviation]), Some((_, known))) => {
            format!("{} ± {deviation:.2}", beside(mean, known[k], 2))
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

fn metrics(study: &ForceStudy, about: &str, meta: &Metadata) -> Value {
    let loaded = |method: usize| {
        let errors = ERRORS.map(|(key, _, shown)| {
            let means: Vec<Option<f64>> =
                row(study, method, shown).into_iter().map(|found| found.map(|[mean, _]| mean)).collect();
            (key.to_owned(), json!(means))
        });
        Value::Object(errors.into_iter().collect())
    };
    let methods: Vec<Value> = METHODS
        .iter()
        .enumerate()
        .map(|(k, name)| {
            let free: Vec<_> = study.cells.iter().map(|cell| &cell.free[k]).collect();
            json!({ "name": name, "loaded": loaded(k), "free": free })
        })
        .collect();
    json!({
        "format": "hysteron-metrics", "version": 1, "study": "force", "about": about,
        "tasks": TASKS, "arms": study.cells.len(), "samples": study.cells.iter().map(|cell| cell.samples).collect::<Vec<_>>(),
        "methods": methods, "command": meta.command, "commit": meta.commit,
    })
}
