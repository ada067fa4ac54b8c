//! The page of `study neural` and `study neural-networks`.

use std::path::Path;

use hysteron_arm_learning::neural::{FORCES, METHODS};
use hysteron_base::json;
use hysteron_report::figure::{register_embedded_font, save};
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::page::{Page, write_metrics, write_page};
use serde_json::Value;

use super::outcome::{Outcome, over_seeds};
use super::published::{CONDITION, FREE, GRADIENTS, NETWORKS as TABLE_X, PosesRow, SENSOR, WEIGHT};
use super::{FAULT_SPLITS, KINDS, LEFT_OUT, NETWORKS, NetworkKind, study::NeuralStudy};
use crate::arm::force::{PUBLISHED as TABLE_VI, TASKS};

fn text(found: Option<(f64, Option<f64>)>, digits: usize) -> String {
    match found {
        None => "-".to_owned(),
        // What was fitted once for all seeds does not scatter; sums of equal numbers leave a rounding.
        Some((mean, Some(half))) if half > 1e-9 * mean.abs() => format!("{mean:.digits$} ± {half:.digits$}"),
        Some((mean, _)) => format!("{mean:.digits$}"),
    }
}

/// Writes `report.html` and `metrics.json`.
pub(super) fn write(folder: &Path, study: &NeuralStudy, outcome: &Outcome) -> anyhow::Result<()> {
    register_embedded_font()?;
    write_metrics(folder, outcome)?;
    let (title, source) = ("Actuators learned from telemetry", "study of learned actuators");
    let mut page = Page::judged(title, &outcome.verdict, source, &outcome.command);
    page.paragraph(&outcome.about);
    page.paragraph(
        "Mean over seeds of the networks ± half of the 95 % interval of that mean. In brackets what Dou et al. (NeuralActuator) print, of their \
         real arm. Everything that the network has to beat was fitted to the same training recordings; nothing was chosen on tests. Pure \
         simulation sees goals alone; with recorded currents part of the answer is seen, as published.",
    );
    means(&mut page, study);
    poses(&mut page, study);
    if study.published.iter().any(|cell| !cell["forces"]["force_gmo_drive"].is_null()) {
        forces(&mut page, study);
        table_vi(&mut page, study);
        conditions(&mut page, study);
        faults(&mut page, study);
    }
    networks(&mut page, study);
    gradients(&mut page, study);
    for trace in study.published.first().and_then(|cell| cell["traces"].as_array()).into_iter().flatten() {
        if let Some(chart) = chart(trace) {
            page.figure(&save(folder, &chart, false)?);
        }
    }
    write_page(folder, page.finish(&outcome.commit))
}

/// Errors of joints [deg] and of the aperture [mm], means of all tasks.
fn joints_and_aperture(cells: &[Value], method: &str, steps: &str) -> String {
    let mean = |key: &str| over_seeds(cells, &|cell| cell[key][method][steps].as_f64());
    format!("{} | {}", text(mean("mean_deg"), 3), text(mean("mean_gripper_mm"), 3))
}

/// Splits that have been done, with their cells.
fn splits(study: &NeuralStudy) -> impl Iterator<Item = (&'static str, &Vec<Value>)> {
    let left = LEFT_OUT.iter().zip(&study.left_out).map(|((name, _), cells)| (*name, cells));
    std::iter::once(("published split", &study.published)).chain(left).filter(|(_, cells)| !cells.is_empty())
}

fn means(page: &mut Page, study: &NeuralStudy) {
    page.heading("Mean of tasks over the first steps: joints [deg] | aperture [mm]");
    let mut rows = Vec::new();
    for (split, cells) in splits(study) {
        for method in METHODS {
            let at = |steps: &str| joints_and_aperture(cells, method, steps);
            rows.push(vec![split.to_owned(), method.to_owned(), at("100"), at("300"), at("500"), at("600")]);
        }
    }
    page.table(&["Split", "By", "100 steps", "300", "500", "600"], rows);
}

fn poses(page: &mut Page, study: &NeuralStudy) {
    let tables: [(&str, &str, &[PosesRow], [&str; 3]); 3] = [
        ("III, free motion", "force_unlabeled", &FREE, ["100", "300", "600"]),
        ("IV, pushes and references without contact", "force_sensor", &SENSOR, ["100", "300", "500"]),
        ("V, weights", "weight", &WEIGHT, ["100", "300", "600"]),
    ];
    for (title, subset, rows, horizons) in tables {
        for (k, steps) in horizons.into_iter().enumerate() {
            page.heading(&format!(
                "Table {title}, first {steps} steps: J1 / J2 / J3 / J4 [deg] | gripper [mm]"
            ));
            let head: Vec<&str> = std::iter::once("Task").chain(METHODS).collect();
            let mean = |joint: usize| {
                rows.iter().map(|(_, published)| published[k][joint]).sum::<f64>() / rows.len() as f64
            };
            let row = |name: &str, tasks: &[&str], published: &dyn Fn(usize) -> String| {
                let cell = |(m, method): (usize, &&str)| {
                    let one = |joint: usize| {
                        let of = |cell: &Value| {
                            mean_of(tasks.iter().map(|task| {
                                pose_error(
                                    &task_of(cell, &format!("{subset}/{task}"))?["poses"][*method][steps],
                                    joint,
                                )
                            }))
                        };
                        let ours = over_seeds(&study.published, &of).map(|(mean, _)| (mean, None));
                        // The first method is what the paper has.
                        let brackets =
                            if m == 0 { format!(" ({})", published(joint)) } else { String::new() };
                        format!("{}{brackets}", text(ours, 2))
                    };
                    format!("{} | {}", (0..4).map(one).collect::<Vec<_>>().join(" / "), one(4))
                };
                std::iter::once(name.to_owned())
                    .chain(METHODS.iter().enumerate().map(cell))
                    .collect::<Vec<_>>()
            };
            let of_task =
                |(task, published): &PosesRow| row(task, &[task], &|joint| published[k][joint].to_string());
            let all: Vec<&str> = rows.iter().map(|(task, _)| *task).collect();
            let last = row("mean", &all, &|joint| format!("{:.2}", mean(joint)));
            page.table(&head, rows.iter().map(of_task).chain([last]));
        }
    }
}

/// Mean of these; `None` where one is missing.
fn mean_of(values: impl ExactSizeIterator<Item = Option<f64>>) -> Option<f64> {
    let n = values.len() as f64;
    Some(values.sum::<Option<f64>>()? / n)
}

/// Error of a joint [deg], or beyond the joints of the aperture [mm].
fn pose_error(scores: &Value, joint: usize) -> Option<f64> {
    scores["joints_deg"].get(joint).unwrap_or(&scores["gripper_mm"]).as_f64()
}

fn task_of<'a>(cell: &'a Value, name: &str) -> Option<&'a Value> {
    cell["tasks"].as_array()?.iter().find(|task| task["task"] == name)
}

fn forces(page: &mut Page, study: &NeuralStudy) {
    page.heading("Force on the tip [N]");
    page.paragraph(
        "Mean of three axes over all labelled samples, as published, and under force; the axis with most of the force; the length of the error; \
         contacts where there is none. GMO-linear is the paper's observer, GMO-drive the one that the network's force is added to.",
    );
    let keys = [
        "mean_of_axes_n",
        "loaded_mean_of_axes_n",
        "loaded_axis_n",
        "loaded_norm_n",
        "false_contact",
        "missed_contact",
    ];
    let head = [
        "Split",
        "By",
        "Mean of axes",
        "under force",
        "Loaded axis",
        "Norm",
        "False contact",
        "Missed contact",
    ];
    let mut rows = Vec::new();
    for (split, cells) in splits(study) {
        for (key, name) in FORCES {
            if cells.iter().all(|cell| cell["forces"][key].is_null()) {
                continue;
            }
            let cell = |own: &&str| text(over_seeds(cells, &|cell| cell["forces"][key][*own].as_f64()), 3);
            let names = [split.to_owned(), name.to_owned()];
            rows.push(names.into_iter().chain(keys.iter().map(cell)).collect::<Vec<_>>());
        }
    }
    page.table(&head, rows);
}

fn table_vi(page: &mut Page, study: &NeuralStudy) {
    page.heading("Table VI: mean of three axes over labelled samples | loaded axis [N]");
    let tasks = TASKS;
    let head: Vec<&str> = std::iter::once("By").chain(tasks).collect();
    let names = [("force", "NeuralActuator"), ("force_gmo_linear", "GMO-linear"), ("force_gmo_drive", "")];
    let row = |(key, published): (&str, &str)| {
        let known = TABLE_VI.iter().find(|(name, _)| *name == published);
        let cell = |(k, task): (usize, &&str)| {
            let name = format!("weight/{task}");
            let of = |own: &'static str| {
                over_seeds(&study.published, &|cell| task_of(cell, &name)?["forces"][key][own].as_f64())
            };
            let brackets = known.map_or_else(String::new, |(_, values)| format!(" ({})", values[k]));
            format!("{}{brackets} | {}", text(of("mean_of_axes_n"), 2), text(of("loaded_axis_n"), 2))
        };
        let name = FORCES.iter().find(|(own, _)| *own == key).map_or("", |(_, name)| name);
        std::iter::once(name.to_owned()).chain(tasks.iter().enumerate().map(cell)).collect::<Vec<_>>()
    };
    page.table(&head, names.map(row));
}

fn conditions(page: &mut Page, study: &NeuralStudy) {
    page.heading("Table VII: condition of the third motor, windows of 64 samples");
    let mut rows = Vec::new();
    for (split, cells) in splits(study) {
        let Some(found) = cells.first().and_then(|cell| cell["detectors"].as_array()) else { continue };
        for (k, detector) in found.iter().enumerate() {
            let name = detector["name"].as_str().unwrap_or_default();
            let known = CONDITION.iter().find(|(known, _)| *known == name && split == "published split");
            let cell = |(at, key): (usize, &str)| {
                let ours = over_seeds(cells, &|cell| cell["detectors"][k][key].as_f64());
                let brackets = known.map_or_else(String::new, |(_, values)| format!(" ({})", values[at]));
                format!("{}{brackets}", text(ours, 3))
            };
            let values = ["accuracy", "area"].into_iter().enumerate().map(cell);
            rows.push([split, name].map(str::to_owned).into_iter().chain(values).collect::<Vec<_>>());
        }
    }
    page.table(&["Split", "Detector", "Accuracy", "Area under the curve"], rows);
}

fn faults(page: &mut Page, study: &NeuralStudy) {
    if study.faults.iter().all(Vec::is_empty) {
        return;
    }
    page.heading("Faults of the third motor by kind: area under the curve, windows of 64 samples");
    page.paragraph(
        "The published data set has rubber bands alone. Here pick and place with nothing and with 100 to 500 g, healthy, with a band, with 30 to \
         100 % more dry friction, and with a lost tooth: learned from with all else, or without those with 200 g, which are asked.",
    );
    let mut rows = Vec::new();
    for ((split, _), cells) in FAULT_SPLITS.iter().zip(&study.faults) {
        let Some(found) = cells.first().and_then(|cell| cell["detectors"]["all"].as_array()) else {
            continue;
        };
        for (k, detector) in found.iter().enumerate() {
            let of = |kind: &&str| {
                text(over_seeds(cells, &|cell| cell["detectors"][*kind][k]["area"].as_f64()), 3)
            };
            let name = detector["name"].as_str().unwrap_or_default();
            let values = KINDS.iter().chain(&["all"]).map(of);
            rows.push([*split, name].map(str::to_owned).into_iter().chain(values).collect::<Vec<_>>());
        }
    }
    page.table(&["Split", "Detector", "Band", "Friction", "Lost tooth", "All"], rows);
}

fn networks(page: &mut Page, study: &NeuralStudy) {
    page.heading("Table X: networks in the loop");
    page.paragraph(
        "Mean of tasks over the first 500 steps: joints [deg] | aperture [mm]. Networks of one size, trained with as many updates; those without a servo begin with \
         inverse dynamics. A perceptron with residual layers sees one sample and stands for networks without history.",
    );
    let cells = std::iter::once(&study.published).chain(&study.networks);
    let row = |(network, cells): (&NetworkKind, &Vec<Value>)| {
        let at = |method: usize| joints_and_aperture(cells, METHODS[method], "500");
        let parameters = cells.first().and_then(|cell| cell["parameters"].as_u64()).unwrap_or(0);
        let more = [0, 1].map(|method: usize| difference(cells, &study.published, METHODS[method]));
        [network.name.to_owned(), parameters.to_string(), at(0), at(1)]
            .into_iter()
            .chain(more)
            .collect::<Vec<_>>()
    };
    // Baselines have no seed.
    let once = study.published.get(..1).unwrap_or_default();
    let baselines = [2, 3, 4].map(|method: usize| {
        let cell = joints_and_aperture(once, METHODS[method], "500");
        [METHODS[method], "-", "-", &cell, "-", "-"].map(str::to_owned).to_vec()
    });
    let head = [
        "Network",
        "Parameters",
        "Recorded currents",
        "Pure simulation",
        "Joints less those of the first, recorded currents [deg]",
        "Pure simulation [deg]",
    ];
    page.table(&head, NETWORKS.iter().zip(cells).map(row).chain(baselines));
    page.paragraph(
        "As printed, contact and no contact together, J1 / J2 / J3 / J4 [deg] | gripper [mm] | force [N]:",
    );
    let published = TABLE_X.iter().map(|(name, v)| {
        let text = format!("{} / {} / {} / {} | {} | {}", v[0], v[1], v[2], v[3], v[4], v[5]);
        vec![(*name).to_owned(), text]
    });
    page.table(&["Network", "Published"], published);
}

/// Error of the joints [deg] less that of the first network with the same seed.
fn difference(cells: &[Value], first: &[Value], method: &str) -> String {
    let of = |cell: &Value| cell["mean_deg"][method]["500"].as_f64();
    let pairs = cells.iter().zip(first).map(|(own, first)| json!(of(own).zip(of(first)).map(|(a, b)| a - b)));
    let pairs: Vec<Value> = pairs.collect();
    text(over_seeds(&pairs, &Value::as_f64), 3)
}

fn gradients(page: &mut Page, study: &NeuralStudy) {
    let Some(rows) = study.published.first().and_then(|cell| cell["gradients"].as_array()) else { return };
    page.heading("Table II: gradients by horizon");
    let row = |own: &Value| {
        let steps = own["steps"].as_u64().unwrap_or(0);
        let known = GRADIENTS.iter().find(|(known, _)| *known as u64 == steps).map(|(_, values)| values);
        let cell = |(k, key): (usize, &str)| {
            let published = known.map_or_else(String::new, |values| format!(" ({})", values[k]));
            format!("{:.3e}{published}", own[key].as_f64().unwrap_or(f64::NAN))
        };
        let values = ["by_torque", "by_weights", "cosine"].into_iter().enumerate().map(cell);
        std::iter::once(steps.to_string()).chain(values).collect::<Vec<_>>()
    };
    page.table(&["Steps", "By torque", "By weights", "Cosine with 128 steps"], rows.iter().map(row));
}

/// How far a rollout is from what was measured, joint by joint, and the force.
fn chart(trace: &Value) -> Option<TimeChart> {
    let numbers = |value: &Value| -> Option<Vec<f64>> {
        value.as_array()?.iter().map(|x| Some(x.as_f64().unwrap_or(f64::NAN))).collect()
    };
    let time = numbers(&trace["time_s"])?;
    let joints = trace["measured_rad"].as_array()?;
    let mut panels = Vec::new();
    for (j, measured) in joints.iter().enumerate() {
        let (measured, mut curves) = (numbers(measured)?, Vec::new());
        for (k, method) in [(0, "network"), (1, "network, pure"), (4, "servo")] {
            let values = numbers(&trace["methods_rad"][k][j])?;
            let off = values.iter().zip(&measured).map(|(x, measured)| (x - measured).to_degrees());
            curves.push(Curve::new(method, curves.len() + 1, off.collect()));
        }
        panels.push(TimePanel::new(format!("joint {} [deg]", j + 1), curves));
    }
    let mut curves = vec![Curve::new("label", 0, numbers(&trace["label_n"])?)];
    for (k, (_, name)) in FORCES.iter().enumerate() {
        if let Some(values) = numbers(&trace["forces_n"][k]) {
            curves.push(Curve::new(*name, curves.len(), values));
        }
    }
    panels.push(TimePanel::new("force along z [N]".to_owned(), curves));
    let task = trace["task"].as_str()?;
    let name = task.replace('/', "-");
    let title = format!("Errors of a rollout, and force: {}", task.replace('_', " "));
    let caption = "Simulated less measured angles of a test trajectory from its recorded initial state, and the force along z, whose label is 0 where there is \
                   none: also while a table carries an object that is held.";
    Some(TimeChart::over_time(&name, &title, caption, &time, panels))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;

    /// The comparison of one seed: every number has a place of its own behind the point, and the seed before it.
    fn cell(seed: f64) -> Value {
        let by_method = |value: &dyn Fn(usize) -> Value| -> Value {
            METHODS.iter().enumerate().map(|(m, name)| ((*name).to_owned(), value(m))).collect()
        };
        let steps = |value: Value| json!({ "100": value, "300": value, "500": value, "600": value });
        let pose = |m: usize| {
            let joints: Vec<f64> = (0..4).map(|j| seed + 0.1 * m as f64 + 0.01 * f64::from(j)).collect();
            steps(json!({ "joints_deg": joints, "gripper_mm": seed + 0.09 }))
        };
        let force = json!({ "mean_of_axes_n": seed + 0.1, "loaded_mean_of_axes_n": seed + 0.2, "loaded_axis_n": seed + 0.3,
            "loaded_norm_n": seed + 0.4, "false_contact": seed + 0.5, "missed_contact": seed + 0.6 });
        let forces: Value = FORCES.iter().map(|(key, _)| ((*key).to_owned(), force.clone())).collect();
        let subsets: [(&str, &[PosesRow]); 3] =
            [("force_unlabeled", &FREE), ("force_sensor", &SENSOR), ("weight", &WEIGHT)];
        let tasks = subsets
            .iter()
            .flat_map(|(subset, rows)| rows.iter().map(move |(task, _)| format!("{subset}/{task}")));
        let task = |task| json!({ "task": task, "poses": by_method(&pose), "forces": forces });
        let detectors = json!([{ "name": CONDITION[0].0, "accuracy": seed + 0.7, "area": seed + 0.8 }]);
        json!({
            "mean_deg": by_method(&|m| steps(json!(seed + 0.1 * m as f64))),
            "mean_gripper_mm": by_method(&|m| steps(json!(seed + 0.01 * m as f64))),
            "tasks": tasks.map(task).collect::<Vec<_>>(), "forces": forces, "detectors": detectors, "parameters": 1234,
            "gradients": [{ "steps": 64, "by_torque": 1e-3, "by_weights": 2e-3, "cosine": 0.5 }],
        })
    }

    fn page_of(study: &NeuralStudy) -> String {
        let folder = tempfile::tempdir().unwrap();
        let context = hysteron_workflow::Context::silent("a test");
        write(folder.path(), study, &Outcome::new(study, "about".to_owned(), &context)).unwrap();
        std::fs::read_to_string(folder.path().join("report.html")).unwrap()
    }

    /// Tables, each with the heading that it stands below: rows of cells.
    fn tables(page: &str) -> Vec<(String, Vec<Vec<String>>)> {
        let texts = |row: &str, tag: &str| -> Vec<String> {
            let begin = format!("<{tag}");
            let pieces = row.split(&begin).skip(1);
            let text = |it: &str| {
                let cell = it.split_once('>').unwrap().1;
                cell.trim_start_matches("<span>").split('<').next().unwrap().to_owned()
            };
            pieces.map(text).collect()
        };
        let mut heading = String::new();
        let mut found = Vec::new();
        for (k, piece) in page.split("<table").enumerate() {
            if k > 0 {
                let rows = piece.split("</table>").next().unwrap().split("<tr>").skip(1);
                let cells = rows.map(|row| [texts(row, "th"), texts(row, "td")].concat()).collect();
                found.push((heading.clone(), cells));
            }
            if let Some((before, _)) = piece.rsplit_once("</h2>") {
                heading = before.rsplit('>').next().unwrap().to_owned();
            }
        }
        found
    }

    #[test]
    fn every_cell_stands_below_its_heading_with_the_interval_of_its_mean() {
        let seeds = vec![cell(1.0), cell(2.0)];
        let detectors: Value = KINDS
            .iter()
            .chain(&["all"])
            .map(|kind| ((*kind).to_owned(), json!([{ "name": "a", "area": 0.9 }])))
            .collect();
        let study = NeuralStudy {
            published: seeds.clone(),
            left_out: vec![seeds.clone(); LEFT_OUT.len()],
            networks: vec![seeds; NETWORKS.len() - 1],
            faults: vec![vec![json!({ "detectors": detectors })]; FAULT_SPLITS.len()],
        };
        let tables = tables(&page_of(&study));
        for (heading, rows) in &tables {
            let is_full = |row: &Vec<String>| row.len() == rows[0].len();
            assert!(rows.len() > 1 && rows.iter().all(is_full), "{heading}: {rows:?}");
        }
        let row = |heading: &str, of: &[&str]| -> Vec<String> {
            let (_, rows) = tables.iter().find(|(it, _)| it.starts_with(heading)).unwrap();
            rows.iter().find(|row| row.iter().zip(of).all(|(cell, of)| cell == of)).unwrap().clone()
        };
        // The half interval of the mean of two that differ by one: 12.71 times the half of one.
        let own = row("Mean of tasks", &["published split", METHODS[1]]);
        assert_eq!(own[2..], ["1.600 ± 6.355 | 1.510 ± 6.355"; 4]);
        let own = row("Force on the tip", &["published split", FORCES[0].1]);
        assert_eq!(
            own[2..],
            ["1.600", "1.700", "1.800", "1.900", "2.000", "2.100"].map(|it| format!("{it} ± 6.355"))
        );
        let own = row("Table V,", &["mean"]);
        assert!(own[2].starts_with("1.60 / 1.61 / 1.62 / 1.63 | 1.59"), "{own:?}");
        let own = row("Table VII", &["published split", CONDITION[0].0]);
        assert!(own[2].starts_with("2.200 ± 6.355 (") && own[3].starts_with("2.300 ± 6.355 ("), "{own:?}");
        let own = row("Table X", &[NETWORKS[1].name]);
        assert_eq!(own[1..3], ["1234", "1.500 ± 6.355 | 1.500 ± 6.355"]);
    }

    #[test]
    fn what_was_not_done_is_a_dash() {
        let study = NeuralStudy {
            published: Vec::new(),
            left_out: vec![Vec::new(); LEFT_OUT.len()],
            networks: vec![Vec::new(); NETWORKS.len() - 1],
            faults: Vec::new(),
        };
        let page = page_of(&study);
        assert!(page.contains("- | -") && !page.contains("NaN"), "{page}");
    }
}
