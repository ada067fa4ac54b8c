//! The report of `arm study identification`.

use std::path::Path;

use hysteron_base::{Metadata, json};
use hysteron_report::figure::{register_embedded_font, save};
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::page::{Page, write_metrics, write_page};
use hysteron_report::verdict::Verdict;
use hysteron_studies::identification::{FrankaCell, IdentificationStudy, SPEEDS, TARE};
use serde_json::Value;

use crate::shared::verdict::{compared, repeated};

/// Table 2 of Wan et al. (2026): f_c+, f_c-, f_s+, f_s-, f_v by method and joint.
const TABLE_2: [(&str, [[f64; 5]; 2]); 4] = [
    ("anfis", [[6.17, 6.26, 11.15, 10.99, 12.1787], [2.92, 2.83, 4.30, 4.55, 5.0402]]),
    ("fnn", [[6.32, 6.53, 11.65, 10.74, 12.356], [2.97, 2.94, 4.75, 4.85, 5.346]]),
    ("pso", [[6.20, 6.32, 11.32, 11.05, 12.3325], [2.95, 2.78, 4.28, 4.58, 5.052]]),
    ("least-squares-coulomb", [[5.80, 5.92, 10.69, 10.27, 11.56], [2.73, 2.68, 3.97, 4.28, 4.68]]),
];

/// Writes the figures, `report.html` and `metrics.json` to `folder`.
pub fn write(folder: &Path, study: &IdentificationStudy, meta: &Metadata) -> anyhow::Result<Value> {
    register_embedded_font()?;
    let friction = methods(study);
    let verdict = judged(&friction, study.options.seeds as usize);
    let value = write_metrics(
        folder,
        &json!({
            "format": "hysteron-metrics", "version": 1, "study": "identification", "verdict": verdict, "options": study.options,
            "franka": study.franka.as_ref().map(|cell| json!({"rows": cell.rows, "ridge": cell.ridge})),
            "scara": friction.iter().map(Method::json).collect::<Vec<_>>(), "wrist": study.wrist,
            "command": meta.command, "commit": meta.commit,
        }),
    )?;
    let mut page = Page::judged("Identification, method by method", &verdict, &meta.source, &meta.command);
    if let Some(cell) = &study.franka {
        franka(folder, &mut page, cell)?;
    }
    scara(&mut page, &friction, study);
    wrist(&mut page, study);
    write_page(folder, page.finish(&meta.commit))?;
    Ok(value)
}

/// Whether the best method finds the curve of friction better than Coulomb's law by least squares.
fn judged(methods: &[Method], seeds: usize) -> Verdict {
    let of = |joint: usize| -> Vec<(String, f64)> {
        let of_joint = methods.iter().filter(|method| method.joint == joint);
        of_joint.map(|method| (method.name.clone(), method.errors[0])).collect()
    };
    let judged =
        (0..2).fold(Verdict::on("friction can be identified from single trials"), |judged, joint| {
            let what = format!("joint {}, error of the curve", joint + 1);
            compared(judged, (&what, "N m"), &of(joint), "least-squares-coulomb")
        });
    repeated(judged, seeds, "seed").verdict()
}

fn franka(folder: &Path, page: &mut Page, cell: &FrankaCell) -> anyhow::Result<()> {
    page.heading("Franka, joint 2: two speeds fitted, the third predicted; RMSE [N m]");
    let number = |x: Option<f64>| x.map_or_else(|| "diverges".to_owned(), |x| format!("{x:.3}"));
    page.table(
        &["Model", "", "slow", "middle", "high", "slow, zeroed", "middle, zeroed", "high, zeroed"],
        cell.rows.iter().map(|row| {
            let whose = if row.is_published { "published" } else { "fitted here" };
            let zeroed =
                (0..3).map(|k| row.tared_n_m.map_or_else(|| "-".to_owned(), |rms| format!("{:.3}", rms[k])));
            let as_is = row.all_rows_n_m.iter().map(|x| number(*x));
            [vec![row.method.clone(), whose.to_owned()], as_is.collect(), zeroed.collect()].concat()
        }),
    );
    page.paragraph(&format!(
        "Every recording's torques have an offset of their own. \"Zeroed\": the mean error of the first {TARE} s is taken off, and these are left out \
         of the score. What the published models were trained on is not stated; here nothing of the recording that is predicted is used but \
         that offset."
    ));
    page.heading("Figures");
    for (k, speed) in SPEEDS.iter().enumerate() {
        let panel = TimePanel::new(
            "friction [N m]",
            vec![
                Curve::new("measured", 5, cell.measured[k].clone()),
                Curve::new("dahl-map, fitted to the other two", 1, cell.predicted[k].clone()),
            ],
        );
        let chart = TimeChart::over_time(
            format!("franka-{speed}"),
            format!("Franka, joint 2, {speed}"),
            "Torque of friction over time [s], and as predicted from the joint's path by a map that has not seen this recording.",
            &cell.time_s[k],
            vec![panel],
        );
        page.figure(&save(folder, &chart, false)?);
    }
    Ok(())
}

/// One method on one joint of the SCARA, over the seeds.
struct Method {
    joint: usize,
    name: String,
    /// Means over the seeds: root mean square and largest error of the curve from single trials, the same from means of 200.
    errors: [f64; 4],
    /// Of the first seed.
    parameters: Vec<f64>,
    /// Training and test error of the five folds, mean over folds and seeds [N m].
    folds: [f64; 2],
}

impl Method {
    fn json(&self) -> Value {
        let [single_rms, single_max, averaged_rms, averaged_max] = self.errors;
        json!({"joint": self.joint + 1, "method": self.name, "parameters": self.parameters, "single_rms_n_m": single_rms,
            "single_max_n_m": single_max, "averaged_rms_n_m": averaged_rms, "averaged_max_n_m": averaged_max,
            "folds_training_test_n_m": self.folds})
    }
}

fn methods(study: &IdentificationStudy) -> Vec<Method> {
    let of = |joint: usize| {
        let cells: Vec<_> = study.scara.iter().filter(|cell| cell.joint == joint).collect();
        let names = cells.first().map_or(&[][..], |cell| &cell.rows);
        let method = |(m, first): (usize, &hysteron_studies::estimation::scara_friction::FrictionRow)| {
            let n = cells.len() as f64;
            let (mut errors, mut folds) = ([0.0; 4], [0.0; 2]);
            for row in cells.iter().map(|cell| &cell.rows[m]) {
                let own = [row.single_error_n_m, row.averaged_error_n_m].concat();
                errors.iter_mut().zip(own).for_each(|(sum, e)| *sum += e / n);
                for fold in &row.folds_n_m {
                    folds
                        .iter_mut()
                        .zip(fold)
                        .for_each(|(sum, e)| *sum += e / n / row.folds_n_m.len() as f64);
                }
            }
            Method { joint, name: first.method.clone(), errors, parameters: first.parameters.clone(), folds }
        };
        names.iter().enumerate().map(method).collect::<Vec<_>>()
    };
    (0..2).flat_map(of).collect()
}

fn scara(page: &mut Page, methods: &[Method], study: &IdentificationStudy) {
    page.heading("SCARA: table 2 of Wan et al. (2026)");
    page.paragraph(&format!(
        "Simulated, {} seeds: the true curve is the paper's ANFIS column with Stribeck speeds of 0.2 rad/s (printed are 11 and 4 rad/s, at \
         which no motion of the paper would show a Stribeck effect). Parameters of seed 1, published values in brackets. Curve errors are \
         against the true curve; a least squares of the right law cannot be beaten by a network to which the same law is fitted afterwards.",
        study.options.seeds
    ));
    let head = [
        "Joint",
        "Method",
        "f_c+",
        "f_c-",
        "f_s+",
        "f_s-",
        "f_v",
        "v_s+",
        "v_s-",
        "Largest error, single trials [N m]",
        "Largest error, means of 200 [N m]",
        "RMS, single trials",
        "Folds: training",
        "Folds: test",
    ];
    page.table(
        &head,
        methods.iter().map(|method| {
            let known =
                TABLE_2.iter().find(|(name, _)| *name == method.name).map(|(_, joints)| joints[method.joint]);
            let mut cells = vec![(method.joint + 1).to_string(), method.name.clone()];
            let own: Vec<Option<f64>> = match method.parameters[..] {
                [a, b, da, db, va, vb, v] => [a, b, a + da, b + db, v, va, vb].map(Some).to_vec(),
                [c, v] => [Some(c), Some(c), None, None, Some(v), None, None].to_vec(),
                _ => vec![None; 7],
            };
            cells.extend(own.iter().enumerate().map(|(k, own)| {
                let own = own.map_or_else(|| "-".to_owned(), |x| format!("{x:.3}"));
                known
                    .and_then(|known| known.get(k).copied())
                    .map_or(own.clone(), |known| format!("{own} [{known}]"))
            }));
            let [single_rms, single_max, _, averaged_max] = method.errors;
            cells.extend(
                [single_max, averaged_max, single_rms, method.folds[0], method.folds[1]]
                    .map(|x| format!("{x:.3}")),
            );
            cells
        }),
    );
}

fn wrist(page: &mut Page, study: &IdentificationStudy) {
    page.heading("Wrist: bodies from the swept sine of Saadatzi et al. (2019)");
    page.table(
        &[
            "Seed",
            "Method",
            "RMS of joint 1 [N m]",
            "RMS of joint 2 [N m]",
            "Weighed six-fold [N m]",
            "Least eigenvalue of the pseudo-inertias",
            "Time [s]",
            "Evaluations",
        ],
        study.wrist.iter().flat_map(|cell| {
            cell.rows.iter().map(move |row| {
                let least = row.least_pseudo_inertias;
                vec![
                    cell.seed.to_string(),
                    row.method.clone(),
                    format!("{:.5}", row.rms_n_m[0]),
                    format!("{:.5}", row.rms_n_m[1]),
                    format!("{:.5}", row.weighed_n_m),
                    format!("{:.1e}, {:.1e}", least[0], least[1]),
                    format!("{:.2}", row.seconds),
                    row.evaluations.map_or_else(|| "-".to_owned(), |n| n.to_string()),
                ]
            })
        }),
    );
    page.paragraph(
        "Published residuals: 0.2336 and 0.1076 N m with parameters of the CAD model, 0.0760 and 0.0333 N m identified by differential evolution.",
    );
}
