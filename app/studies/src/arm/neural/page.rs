//! The page of `study neural` and `study neural-networks`.

use std::path::Path;

use hysteron_arm_learning::neural::{
    ByHorizon, ByMethod, DetectorScores, FORCES, ForceScores, HORIZONS, METHODS, PoseScores, TaskTrace,
};
use hysteron_report::figure::{register_embedded_font, save};
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::page::{Page, write_metrics, write_page};

use super::comparison::{FaultCell, HorizonGradient, NeuralCell};
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
    let mut page = Page::with_verdict(title, &outcome.verdict, source, &outcome.command);
    page.paragraph(&outcome.about);
    page.paragraph(
        "Mean over seeds of the networks ± half of the 95 % interval of that mean. In brackets what Dou et al. (NeuralActuator) print, of their \
         real arm. Everything that the network has to beat was fitted to the same training recordings; nothing was chosen on tests. Pure \
         simulation sees goals alone; with recorded currents part of the answer is seen, as published.",
    );
    means(&mut page, study);
    poses(&mut page, study);
    if study.published.iter().any(|cell| cell.forces.force_gmo_drive.is_some()) {
        forces(&mut page, study);
        table_vi(&mut page, study);
        conditions(&mut page, study);
        faults(&mut page, study);
    }
    networks(&mut page, study);
    gradients(&mut page, study);
    for trace in study.published.first().and_then(|cell| cell.traces.as_ref()).into_iter().flatten().flatten()
    {
        page.figure(&save(folder, &chart(trace), false)?);
    }
    write_page(folder, page.finish(&outcome.commit))
}

/// Means of all tasks by every method, of one seed.
type TaskMeans = fn(&NeuralCell) -> &ByMethod<ByHorizon<Option<f64>>>;

/// Errors of joints [deg] and of the aperture [mm] by a method of [`METHODS`], means of all tasks.
fn joints_and_aperture(cells: &[NeuralCell], method: usize, steps: usize) -> String {
    let mean = |of: TaskMeans| over_seeds(cells, &|cell| *of(cell).values()[method].over(steps)?);
    let [joints, aperture]: [TaskMeans; 2] = [|cell| &cell.mean_deg, |cell| &cell.mean_gripper_mm];
    format!("{} | {}", text(mean(joints), 3), text(mean(aperture), 3))
}

/// Splits that have been done, with their cells.
fn splits(study: &NeuralStudy) -> impl Iterator<Item = (&'static str, &Vec<NeuralCell>)> {
    let left = LEFT_OUT.iter().zip(&study.left_out).map(|((name, _), cells)| (*name, cells));
    std::iter::once(("published split", &study.published)).chain(left).filter(|(_, cells)| !cells.is_empty())
}

fn means(page: &mut Page, study: &NeuralStudy) {
    page.heading("Mean of tasks over the first steps: joints [deg] | aperture [mm]");
    let mut rows = Vec::new();
    for (split, cells) in splits(study) {
        for (k, method) in METHODS.iter().enumerate() {
            let cells = HORIZONS.map(|steps| joints_and_aperture(cells, k, steps));
            rows.push([split, *method].map(str::to_owned).into_iter().chain(cells).collect());
        }
    }
    page.table(&["Split", "By", "100 steps", "300", "500", "600"], rows);
}

fn poses(page: &mut Page, study: &NeuralStudy) {
    let tables: [(&str, &str, &[PosesRow], [usize; 3]); 3] = [
        ("III, free motion", "force_unlabeled", &FREE, [100, 300, 600]),
        ("IV, pushes and references without contact", "force_sensor", &SENSOR, [100, 300, 500]),
        ("V, weights", "weight", &WEIGHT, [100, 300, 600]),
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
                let cell = |m: usize| {
                    let one = |joint: usize| {
                        let of = |cell: &NeuralCell| {
                            mean_of(tasks.iter().map(|task| {
                                let found = cell.task(&format!("{subset}/{task}"))?;
                                pose_error(found.poses.values()[m].over(steps)?, joint)
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
                std::iter::once(name.to_owned()).chain((0..METHODS.len()).map(cell)).collect::<Vec<_>>()
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
fn pose_error(scores: &PoseScores, joint: usize) -> Option<f64> {
    scores.joints_deg.get(joint).copied().or(scores.gripper_mm)
}

/// A number of a source of force.
type ScoreOfForces = fn(&ForceScores) -> f64;

fn forces(page: &mut Page, study: &NeuralStudy) {
    page.heading("Force on the tip [N]");
    page.paragraph(
        "Mean of three axes over all labelled samples, as published, and under force; the axis with most of the force; the length of the error; \
         contacts where there is none. GMO-linear is the paper's observer, GMO-drive the one that the network's force is added to.",
    );
    let scores: [ScoreOfForces; 6] = [
        |own| own.mean_of_axes_n,
        |own| own.loaded_mean_of_axes_n,
        |own| own.loaded_axis_n,
        |own| own.loaded_norm_n,
        |own| own.false_contact,
        |own| own.missed_contact,
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
        for (k, (_, name)) in FORCES.into_iter().enumerate() {
            if cells.iter().all(|cell| cell.forces.values()[k].is_none()) {
                continue;
            }
            let cell =
                |own: ScoreOfForces| text(over_seeds(cells, &|cell| cell.forces.values()[k].map(own)), 3);
            let names = [split.to_owned(), name.to_owned()];
            rows.push(names.into_iter().chain(scores.map(cell)).collect::<Vec<_>>());
        }
    }
    page.table(&head, rows);
}

fn table_vi(page: &mut Page, study: &NeuralStudy) {
    page.heading("Table VI: mean of three axes over labelled samples | loaded axis [N]");
    let tasks = TASKS;
    let head: Vec<&str> = std::iter::once("By").chain(tasks).collect();
    let names = ["NeuralActuator", "GMO-linear", ""];
    let row = |((at, (_, name)), published): ((usize, &(&str, &str)), &str)| {
        let known = TABLE_VI.iter().find(|(name, _)| *name == published);
        let cell = |(k, task): (usize, &&str)| {
            let task = format!("weight/{task}");
            let of = |own: ScoreOfForces| {
                over_seeds(&study.published, &|cell| cell.task(&task)?.forces.values()[at].map(own))
            };
            let brackets = known.map_or_else(String::new, |(_, values)| format!(" ({})", values[k]));
            format!(
                "{}{brackets} | {}",
                text(of(|own| own.mean_of_axes_n), 2),
                text(of(|own| own.loaded_axis_n), 2)
            )
        };
        std::iter::once((*name).to_owned()).chain(tasks.iter().enumerate().map(cell)).collect::<Vec<_>>()
    };
    page.table(&head, FORCES.iter().enumerate().zip(names).map(row));
}

fn conditions(page: &mut Page, study: &NeuralStudy) {
    page.heading("Table VII: condition of the third motor, windows of 64 samples");
    let mut rows = Vec::new();
    for (split, cells) in splits(study) {
        let Some(found) = cells.first().and_then(|cell| cell.detectors.as_ref()) else { continue };
        for (k, detector) in found.iter().enumerate() {
            let name = &detector.name[..];
            let known = CONDITION.iter().find(|(known, _)| *known == name && split == "published split");
            let cell = |(at, score): (usize, fn(&DetectorScores) -> f64)| {
                let ours = over_seeds(cells, &|cell| cell.detectors.as_ref()?.get(k).map(score));
                let brackets = known.map_or_else(String::new, |(_, values)| format!(" ({})", values[at]));
                format!("{}{brackets}", text(ours, 3))
            };
            let scores: [fn(&DetectorScores) -> f64; 2] = [|one| one.accuracy, |one| one.area];
            let values = scores.into_iter().enumerate().map(cell);
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
         100 % more dry friction, and with a lost tooth: learned from with all else, or without those with 200 g, which are the test set.",
    );
    let mut rows = Vec::new();
    for ((split, _), cells) in FAULT_SPLITS.iter().zip(&study.faults) {
        let Some(first) = cells.first() else { continue };
        for (k, detector) in first.detectors.all.iter().enumerate() {
            let area = |cell: &FaultCell, kind: usize| Some(cell.detectors.values()[kind].get(k)?.area);
            let values = (0..=KINDS.len()).map(|kind| text(over_seeds(cells, &|cell| area(cell, kind)), 3));
            rows.push(
                [*split, &detector.name].map(str::to_owned).into_iter().chain(values).collect::<Vec<_>>(),
            );
        }
    }
    page.table(&["Split", "Detector", "Band", "Friction", "Lost tooth", "All"], rows);
}

fn networks(page: &mut Page, study: &NeuralStudy) {
    page.heading("Table X: networks in the loop");
    page.paragraph(
        "Mean of tasks over the first 500 steps: joints [deg] | aperture [mm]. Networks of one size, trained with as many updates; those without a servo begin with \
         inverse dynamics. A perceptron with residual layers sees one sample and represents networks without history.",
    );
    let cells = std::iter::once(&study.published).chain(&study.networks);
    let row = |(network, cells): (&NetworkKind, &Vec<NeuralCell>)| {
        let at = |method: usize| joints_and_aperture(cells, method, 500);
        let parameters = cells.first().map_or(0, |cell| cell.parameters);
        let more = [0, 1].map(|method: usize| difference(cells, &study.published, method));
        [network.name.to_owned(), parameters.to_string(), at(0), at(1)]
            .into_iter()
            .chain(more)
            .collect::<Vec<_>>()
    };
    // Baselines have no seed.
    let once = study.published.get(..1).unwrap_or_default();
    let baselines = [2, 3, 4].map(|method: usize| {
        let cell = joints_and_aperture(once, method, 500);
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
fn difference(cells: &[NeuralCell], first: &[NeuralCell], method: usize) -> String {
    let of = |cell: &NeuralCell| cell.mean_deg.values()[method].steps_500;
    let pairs: Vec<(&NeuralCell, &NeuralCell)> = cells.iter().zip(first).collect();
    text(over_seeds(&pairs, &|(own, first)| Some(of(own)? - of(first)?)), 3)
}

fn gradients(page: &mut Page, study: &NeuralStudy) {
    let Some(rows) = study.published.first().and_then(|cell| cell.gradients.as_ref()) else { return };
    page.heading("Table II: gradients by horizon");
    let row = |own: &HorizonGradient| {
        let known = GRADIENTS.iter().find(|(known, _)| *known == own.steps).map(|(_, values)| values);
        let cell = |(k, value): (usize, f64)| {
            let published = known.map_or_else(String::new, |values| format!(" ({})", values[k]));
            format!("{value:.3e}{published}")
        };
        let values = [own.by_torque, own.by_weights, own.cosine].into_iter().enumerate().map(cell);
        std::iter::once(own.steps.to_string()).chain(values).collect::<Vec<_>>()
    };
    page.table(&["Steps", "By torque", "By weights", "Cosine with 128 steps"], rows.iter().map(row));
}

/// How far a rollout is from what was measured, joint by joint, and the force.
fn chart(trace: &TaskTrace) -> TimeChart {
    let mut panels = Vec::new();
    for (j, measured) in trace.measured_rad.iter().enumerate() {
        let mut curves = Vec::new();
        for (k, method) in [(0, "network"), (1, "network, pure"), (4, "servo")] {
            let values = trace.methods_rad.get(k).and_then(|joints| joints.get(j)).into_iter().flatten();
            let off = values.zip(measured).map(|(x, measured)| (x - measured).to_degrees());
            curves.push(Curve::new(method, curves.len() + 1, off.collect()));
        }
        panels.push(TimePanel::new(format!("joint {} [deg]", j + 1), curves));
    }
    let mut curves = vec![Curve::new("label", 0, trace.label_n.clone())];
    for ((_, name), values) in FORCES.iter().zip(&trace.forces_n) {
        if let Some(values) = values {
            curves.push(Curve::new(*name, curves.len(), values.clone()));
        }
    }
    panels.push(TimePanel::new("force along z [N]".to_owned(), curves));
    let name = trace.task.replace('/', "-");
    let title = format!("Errors of a rollout, and force: {}", trace.task.replace('_', " "));
    let caption = "Simulated less measured angles of a test trajectory from its recorded initial state, and the force along z, whose label is 0 where there is \
                   none: also while a table carries an object that is held.";
    TimeChart::over_time(&name, &title, caption, &trace.time_s, panels)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use hysteron_arm_learning::neural::{
        ActuatorComparison, ComparisonFormat, ForceSource, ForcesBySource, TaskScores,
    };

    use super::super::comparison::FaultDetectors;
    use super::*;

    /// The comparison of one seed: every number has a place of its own behind the point, and the seed before it.
    fn cell(seed: f64) -> NeuralCell {
        let pose = |m: usize| {
            let joints = (0..4).map(|j| seed + 0.1 * m as f64 + 0.01 * f64::from(j)).collect();
            let (gripper_mm, trajectories) = (Some(seed + 0.09), 1);
            ByHorizon::from_fn(|_| PoseScores { joints_deg: Vec::clone(&joints), gripper_mm, trajectories })
        };
        let force = ForceScores {
            mean_of_axes_n: seed + 0.1,
            loaded_mean_of_axes_n: seed + 0.2,
            loaded_axis_n: seed + 0.3,
            loaded_norm_n: seed + 0.4,
            false_contact: seed + 0.5,
            missed_contact: seed + 0.6,
            samples: [2, 1],
        };
        let forces = ForcesBySource::from_fn(|_| Some(force.clone()));
        let subsets: [(&str, &[PosesRow]); 3] =
            [("force_unlabeled", &FREE), ("force_sensor", &SENSOR), ("weight", &WEIGHT)];
        let tasks = subsets
            .iter()
            .flat_map(|(subset, rows)| rows.iter().map(move |(task, _)| format!("{subset}/{task}")));
        let task = |task| TaskScores {
            task,
            trajectories: 1,
            poses: ByMethod::from_fn(pose),
            forces: forces.clone(),
        };
        let mean = |step: f64| ByMethod::from_fn(|m| ByHorizon::from_fn(|_| Some(seed + step * m as f64)));
        let numbers = ActuatorComparison {
            format: ComparisonFormat::Evaluation,
            version: 2,
            mean_deg: mean(0.1),
            mean_gripper_mm: mean(0.01),
            forces: forces.clone(),
            force_from: ForceSource::Observer,
            condition_accuracy_auc: None,
            tasks: tasks.map(task).collect(),
            left_out: None,
            trained_on: 1,
        };
        let gradient = HorizonGradient { steps: 64, by_torque: 1e-3, by_weights: 2e-3, cosine: 0.5 };
        NeuralCell {
            detectors: Some(vec![detector(CONDITION[0].0, seed + 0.7, seed + 0.8)]),
            gradients: Some(vec![gradient]),
            ..NeuralCell::new(numbers, 1.0, [1234, 1])
        }
    }

    fn detector(name: &str, accuracy: f64, area: f64) -> DetectorScores {
        DetectorScores { name: name.to_owned(), accuracy, area }
    }

    fn page_of(study: &NeuralStudy) -> String {
        let folder = tempfile::tempdir().unwrap();
        let context = hysteron_workflow::Context::silent("a test");
        write(folder.path(), study, &Outcome::new(study, "about".to_owned(), &context)).unwrap();
        std::fs::read_to_string(folder.path().join("report.html")).unwrap()
    }

    /// Tables, each with the heading above it: rows of cells.
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
        let [band, friction, lost_tooth, all] =
            [0.6, 0.7, 0.8, 0.9].map(|area| vec![detector("a", 0.5, area)]);
        let detectors = FaultDetectors { band, friction, lost_tooth, all };
        let study = NeuralStudy {
            published: seeds.clone(),
            left_out: vec![seeds.clone(); LEFT_OUT.len()],
            networks: vec![seeds; NETWORKS.len() - 1],
            faults: vec![vec![FaultCell { trained_on: 1, tests: 1, detectors }]; FAULT_SPLITS.len()],
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
        let own = row("Faults", &[FAULT_SPLITS[0].0]);
        assert_eq!(own[1..], ["a", "0.600", "0.700", "0.800", "0.900"]);
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
