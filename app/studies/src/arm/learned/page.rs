//! The page of the studies of learned inverse dynamics: its tables, and errors over speed and amount of data.

use std::path::Path;

use hysteron_arm_dynamics::Model;
use hysteron_arm_learning::lagrangian::{ArmSamples, Decomposition, LearnedDynamics, Sinusoids, Variant};
use hysteron_report::figure::{register_embedded_font, save};
use hysteron_report::lines::{Curve, PanelScale, TimeChart, TimePanel};
use hysteron_report::page::{Page, write_metrics, write_page};
use hysteron_report::sheet::number;

use super::outcome::{Means, Outcome, Recorded, RecordedTable, Simulated, Study};
use super::published::published_parts;
use super::real::{RealRow, shown_samples};
use super::simulated::{SimulatedRow, SimulatedStudy, simulated_test};

/// Torques in the figures of one recorded arm.
pub(super) struct TorqueSeries {
    /// Numbers of the samples.
    samples: Vec<f64>,
    /// Measured torques, [sample][joint] [N m].
    measured: Vec<f64>,
    /// The same of every row where its cell has them.
    of_rows: Vec<Vec<f32>>,
}

impl TorqueSeries {
    /// Takes the torques out of rows.
    pub fn take(test: &ArmSamples, rows: &mut [RealRow]) -> Self {
        let n = test.n_joints;
        Self {
            samples: shown_samples(test).map(|sample| sample as f64).collect(),
            measured: shown_samples(test).flat_map(|sample| &test.tau[n * sample..][..n]).copied().collect(),
            of_rows: rows.iter_mut().map(|row| std::mem::take(&mut row.shown)).collect(),
        }
    }
}

/// Writes `report.html` and `metrics.json`; `series` are of the tables of recorded arms.
pub(super) fn write(folder: &Path, outcome: &Outcome, series: &[TorqueSeries]) -> anyhow::Result<()> {
    register_embedded_font()?;
    write_metrics(folder, outcome)?;
    let (title, source) = ("Learned inverse dynamics", "study of learned inverse dynamics");
    let mut page = Page::with_verdict(title, &outcome.verdict, source, &outcome.command);
    match &outcome.study {
        Study::Simulated(study) => simulated(folder, &mut page, study, &outcome.means)?,
        Study::Recorded(Recorded { tables, left_out, .. }) => {
            for (k, (table, series)) in tables.iter().zip(series).enumerate() {
                real(&mut page, table);
                for chart in real_charts(k + 1, table, series) {
                    page.figure(&save(folder, &chart, false)?);
                }
            }
            if !left_out.is_empty() {
                page.heading("Not among the data");
                page.list(left_out.iter().map(|why| ("Left out", why.clone())));
            }
        }
    }
    write_page(folder, page.finish(&outcome.commit))
}

fn simulated(
    folder: &Path,
    page: &mut Page,
    Simulated { study, rows }: &Simulated,
    means: &[Means],
) -> anyhow::Result<()> {
    page.heading("Sum over the joints of mean squared error over variance (nMSE), mean over the seeds");
    let head =
        ["Model", "Torque", "± (seeds)", "Inertial", "Coriolis", "Gravity", "Parameters", "Training [s]"];
    let own = means.iter().map(|m| {
        let [torque, inertial, coriolis, gravity] = m.nmse[0].map(|v| format!("{v:.2e}"));
        let spread = format!("{:.1e}", m.spread[0]);
        let [parameters, seconds] = [m.parameters.to_string(), number(m.seconds)];
        vec![m.variant.label().to_owned(), torque, spread, inertial, coriolis, gravity, parameters, seconds]
    });
    // The published arm is not described: its figures are compared with those of the built-in one.
    let theirs = means.iter().filter(|_| study.speeds.len() > 1).map(|m| {
        let [torque, inertial, coriolis, gravity] = published_parts(m.variant).map(|v| format!("{v:.2e}"));
        let name = format!("{}, as published", m.variant.label());
        vec![name, torque, "-".into(), inertial, coriolis, gravity, "-".into(), "-".into()]
    });
    page.table(&head, own.chain(theirs));
    page.heading("Mean squared error over all joints [N² m²], and of the power [W²]");
    page.table(
        &["Model", "Torque", "Inertial", "Coriolis", "Gravity", "Power"],
        means.iter().map(|m| {
            let [torque, inertial, coriolis, gravity] = m.mse.map(|v| format!("{v:.2e}"));
            vec![
                m.variant.label().to_owned(),
                torque,
                inertial,
                coriolis,
                gravity,
                format!("{:.2e}", m.power_mse),
            ]
        }),
    );
    page.heading("Figures");
    let mut show = |chart: TimeChart| -> anyhow::Result<()> {
        page.figure(&save(folder, &chart, false)?);
        Ok(())
    };
    decompositions(folder, study, rows)?.into_iter().try_for_each(&mut show)?;
    let [seeds, log] = ["mean over the seeds", "Logarithm to base 10 of the normalised error of the torque"];
    let caption = format!("{log} on the test trajectories, {seeds}.");
    if study.speeds.len() > 1 {
        let of = |m: &Means| m.nmse.iter().map(|v| v[0].log10()).collect();
        let titles = ["speeds", "Faster than in training", &caption];
        show(chart(titles, "speed of the test over that of training [-]", &study.speeds, means, of))?;
    }
    if study.trajectories.len() > 1 {
        let x: Vec<f64> = study.trajectories.iter().map(|n| *n as f64).collect();
        let of = |m: &Means| {
            let at = |n: &usize| {
                let rows = rows.iter().filter(|r| r.variant == m.variant && r.trajectories == *n);
                let values: Vec<f64> = rows.map(|r| r.parts[0].torque).collect();
                (values.iter().sum::<f64>() / values.len() as f64).log10()
            };
            study.trajectories.iter().map(at).collect()
        };
        show(chart(["amounts", "Amount of data", &caption], "trajectories [-]", &x, means, of))?;
    }
    let x: Vec<f64> = (1..=means.first().map_or(0, |m| m.joints.len())).map(|j| j as f64).collect();
    let caption = format!("{log} of every joint on the test trajectories, {seeds}.");
    let of = |m: &Means| m.joints.iter().map(|v| v.log10()).collect();
    show(chart(["joints", "Error over the joints", &caption], "joint [-]", &x, means, of))
}

/// Parts of the torques of every joint along the first test trajectory, true and of every model's first seed; nothing where the arm is not
/// the simulated one.
fn decompositions(
    folder: &Path,
    study: &SimulatedStudy,
    rows: &[SimulatedRow],
) -> anyhow::Result<Vec<TimeChart>> {
    if study.speeds.len() < 2 {
        return Ok(Vec::new());
    }
    let (samples, truth) = simulated_test(&Model::builtin("three-link")?, study.speeds[0]);
    let most = study.trajectories.iter().copied().max().unwrap_or(0);
    let mut models = Vec::new();
    for row in rows.iter().filter(|row| row.seed == 0 && row.trajectories == most) {
        let file = folder.join("cells").join(format!("{}.safetensors", row.name()));
        models.push((row.variant.label(), LearnedDynamics::read(&file)?.decompose(&samples)?));
    }
    let n = samples.n_joints;
    let first = &samples.trajectories[0];
    let time: Vec<f64> = (0..first.len()).map(|i| i as f64 / Sinusoids::published(1).rate).collect();
    let chart = |joint: usize| {
        let column = |values: &[f64]| first.clone().map(|i| values[n * i + joint]).collect::<Vec<f64>>();
        let panel = |name: &str, part: &dyn Fn(&Decomposition) -> Vec<f64>| {
            let learned = models.iter().enumerate();
            let learned = learned.map(|(k, (label, parts))| Curve::new(*label, k + 1, column(&part(parts))));
            let mut curves: Vec<Curve> = learned.collect();
            curves.insert(0, Curve { width: 4.0, ..Curve::new("true", 0, column(&part(&truth))) });
            TimePanel::new(format!("{name} [N m]"), curves)
        };
        let panels = vec![
            panel("torque", &|d| d.torque.clone()),
            panel("inertial", &|d| d.inertial.clone()),
            panel("Coriolis", &|d| d.coriolis.clone()),
            panel("gravity", &|d| d.gravity.clone()),
        ];
        let caption = "Along the first test trajectory; models of the first seed over the true torques (wide line). Each panel has its own scale.";
        let title = format!("Parts of the torque of joint {}", joint + 1);
        TimeChart::over_time(format!("parts-{}", joint + 1), title, caption, &time, panels)
    };
    Ok((0..n).map(chart).collect())
}

fn chart(
    [name, title, caption]: [&str; 3],
    x_name: &'static str,
    x: &[f64],
    means: &[Means],
    of: impl Fn(&Means) -> Vec<f64>,
) -> TimeChart {
    let curves = means.iter().enumerate().map(|(k, m)| Curve::new(m.variant.label(), k, of(m))).collect();
    let mut chart =
        TimeChart::over_time(name, title, caption, x, vec![TimePanel::new("log10 nMSE [-]", curves)]);
    chart.x_name = x_name;
    chart.scale = PanelScale::Own;
    chart
}

fn real(page: &mut Page, table: &RecordedTable) {
    let RecordedTable { set, training: [samples, trajectories], rows, published, .. } = table;
    page.heading(&format!("{set}: mean squared error of every joint [N² m²]"));
    page.paragraph(&format!(
        "Chosen on {samples} samples in {trajectories} trajectories or blocks of time, tested on {} others. A row \"as published\" is the \
         paper's; its models of circles learned from a file more, which is not public.",
        table.test_samples
    ));
    let n = rows.first().map_or(0, |row| row.mse.len());
    let mut head: Vec<String> = vec!["Model".to_owned()];
    head.extend((1..=n).map(|j| format!("Joint {j}")));
    head.extend(["Sum", "Pooled R²", "Mean R² of a joint", "Validation", "Choice"].map(str::to_owned));
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    let errors = |mse: &[f64]| mse.iter().map(|v| format!("{v:.4}")).collect::<Vec<_>>();
    let own = rows.iter().map(|row| {
        let mut cells = vec![row.name.clone()];
        cells.extend(errors(&row.mse));
        cells.extend([
            format!("{:.3}", row.sum_mse),
            format!("{:.4}", row.pooled_r2),
            format!("{:.3}", row.mean_r2),
        ]);
        cells.extend([format!("{:.4}", row.validation), row.choice.clone()]);
        cells
    });
    let theirs = published.iter().map(|row| {
        let mut cells = vec![format!("{}, as published", row.name)];
        cells.extend(errors(&row.mse));
        let sum: f64 = row.mse.iter().sum();
        cells.extend([format!("{sum:.3}"), format!("{:.3}", row.pooled_r2)]);
        cells.extend(["-", "-", "-"].map(str::to_owned));
        cells
    });
    page.table(&head, own.chain(theirs));
    let best = rows.iter().min_by(|a, b| a.sum_mse.total_cmp(&b.sum_mse));
    page.list(best.map(|row| ("Least sum of errors on the test", row.name.clone())));
    let chosen = rows.iter().min_by(|a, b| a.validation.total_cmp(&b.validation));
    page.list(chosen.map(|row| ("Least error in validation", row.name.clone())));
}

/// Rows that figures show: the feasible body, what validation prefers, and the networks alone that papers compare.
fn shown_rows(rows: &[RealRow]) -> Vec<usize> {
    let chosen = (0..rows.len()).min_by(|a, b| rows[*a].validation.total_cmp(&rows[*b].validation));
    let named = [Variant::StructuredLagrangian, Variant::FeedForward].map(Variant::label);
    let networks = named.into_iter().filter_map(|name| rows.iter().position(|row| row.name == name));
    // The second row is the feasible body.
    let mut shown: Vec<usize> = (1..rows.len().min(2)).chain(chosen).chain(networks).collect();
    shown.sort_unstable();
    shown.dedup();
    shown
}

/// Errors over the joints, and torques of every joint along a test trajectory, of table number `k`.
fn real_charts(k: usize, table: &RecordedTable, series: &TorqueSeries) -> Vec<TimeChart> {
    let TorqueSeries { samples, measured, of_rows } = series;
    let shown = shown_rows(&table.rows);
    let n = table.rows.first().map_or(0, |row| row.mse.len());
    let curves = shown.iter().enumerate().map(|(c, row)| {
        let row = &table.rows[*row];
        Curve::new(&row.name, c + 1, row.mse.iter().map(|mse| mse.log10()).collect())
    });
    let joints: Vec<f64> = (1..=n).map(|joint| joint as f64).collect();
    let caption = "Logarithm to base 10 of the mean squared error on the test: the feasible body, the model chosen in validation, and networks alone.";
    let panel = TimePanel::new("log10 of [N² m²]", curves.collect());
    let mut errors = TimeChart::over_time(
        format!("joints-{k}"),
        format!("{}: error over the joints", table.set),
        caption,
        &joints,
        vec![panel],
    );
    errors.x_name = "joint [-]";
    errors.scale = PanelScale::Own;
    let of_joint = |joint: usize| {
        let mut curves = vec![Curve {
            width: 4.0,
            ..Curve::new("measured", 0, measured.iter().skip(joint).step_by(n).copied().collect())
        }];
        for (c, row) in shown.iter().enumerate().filter(|(_, row)| !of_rows[**row].is_empty()) {
            let torques = of_rows[*row].iter().skip(joint).step_by(n).map(|v| f64::from(*v));
            curves.push(Curve::new(&table.rows[*row].name, c + 1, torques.collect()));
        }
        TimePanel::new(format!("joint {} [N m]", joint + 1), curves)
    };
    let mut torques = TimeChart::over_time(
        format!("torques-{k}"),
        format!("{}: torques", table.set),
        "Along the first test trajectory, models over the measured torques (wide line). Each panel has its own scale.",
        samples,
        (0..n).map(of_joint).collect(),
    );
    torques.x_name = "sample of the test [-]";
    vec![errors, torques]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(name: &str, validation: f64, shown: Vec<f32>) -> RealRow {
        let (name, choice, mse) = (name.to_owned(), String::new(), vec![1.0, 0.1]);
        RealRow { name, sum_mse: 1.1, pooled_r2: 0.9, mean_r2: 0.8, mse, validation, choice, shown }
    }

    #[test]
    fn figures_show_the_body_what_validation_prefers_and_networks_alone() {
        let networks = [Variant::StructuredLagrangian, Variant::FeedForward].map(Variant::label);
        let rows = vec![
            row("free", 0.3, vec![0.0; 4]),
            row("feasible", 0.4, vec![0.0; 4]),
            row("kernel", 0.1, vec![0.0; 4]),
            row("another", 0.2, vec![0.0; 4]),
            row(networks[0], 0.5, Vec::new()),
            row(networks[1], 0.6, vec![0.0; 4]),
        ];
        assert_eq!(shown_rows(&rows), [1, 2, 4, 5]);
        let of_rows = rows.iter().map(|row| row.shown.clone()).collect();
        let series = TorqueSeries { samples: vec![0.0, 3.0], measured: vec![1.0, 2.0, 3.0, 4.0], of_rows };
        let table = RecordedTable {
            set: "an arm".to_owned(),
            training: [1, 1],
            test_samples: 2,
            cutoff_hz: 10.0,
            rows,
            published: Vec::new(),
        };
        let [errors, torques] = real_charts(1, &table, &series).try_into().ok().expect("two charts");
        assert_eq!(errors.panels[0].curves.len(), 4);
        // A cell of before has no torques to show.
        let names: Vec<&str> = torques.panels[1].curves.iter().map(|curve| curve.name.as_str()).collect();
        assert_eq!(names, ["measured", "feasible", "kernel", networks[1]]);
        assert_eq!(torques.panels[1].curves[0].values, [2.0, 4.0]);
    }
}
