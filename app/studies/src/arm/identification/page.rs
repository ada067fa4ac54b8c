//! The page of `study identification`.

use std::path::Path;

use hysteron_report::figure::{register_embedded_font, save};
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::page::{Page, write_metrics, write_page};

use super::cells::IdentificationStudy;
use super::franka::{FrankaCell, SPEEDS, TARE};
use super::outcome::{Outcome, ScaraMethod};

/// Table 2 of Wan et al. (2026): f_c+, f_c-, f_s+, f_s-, f_v by method and joint.
const TABLE_2: [(&str, [[f64; 5]; 2]); 4] = [
    ("anfis", [[6.17, 6.26, 11.15, 10.99, 12.1787], [2.92, 2.83, 4.30, 4.55, 5.0402]]),
    ("fnn", [[6.32, 6.53, 11.65, 10.74, 12.356], [2.97, 2.94, 4.75, 4.85, 5.346]]),
    ("pso", [[6.20, 6.32, 11.32, 11.05, 12.3325], [2.95, 2.78, 4.28, 4.58, 5.052]]),
    ("least-squares-coulomb", [[5.80, 5.92, 10.69, 10.27, 11.56], [2.73, 2.68, 3.97, 4.28, 4.68]]),
];

/// Writes the figures, `report.html` and `metrics.json` to `folder`.
pub(super) fn write(folder: &Path, study: &IdentificationStudy, outcome: &Outcome) -> anyhow::Result<()> {
    register_embedded_font()?;
    write_metrics(folder, outcome)?;
    let (title, source) = ("Identification, method by method", "study of identification");
    let mut page = Page::with_verdict(title, &outcome.verdict, source, &outcome.command);
    if let Some(cell) = &study.franka {
        franka(folder, &mut page, cell)?;
    }
    scara(&mut page, &outcome.scara, study);
    wrist(&mut page, study);
    write_page(folder, page.finish(&outcome.commit))
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
        "The torques of every recording have their own offset. \"Zeroed\": the mean error of the first {TARE} s is subtracted, and these are excluded \
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
            "Torque of friction over time [s], and as predicted from the joint's path by a map that was not fitted to this recording.",
            &cell.time_s[k],
            vec![panel],
        );
        page.figure(&save(folder, &chart, false)?);
    }
    Ok(())
}

fn scara(page: &mut Page, methods: &[ScaraMethod], study: &IdentificationStudy) {
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
            let known = TABLE_2
                .iter()
                .find(|(name, _)| *name == method.method)
                .map(|(_, joints)| joints[method.joint - 1]);
            let mut cells = vec![method.joint.to_string(), method.method.clone()];
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
            let [training, test] = method.folds_training_test_n_m;
            let errors = [method.single_max_n_m, method.averaged_max_n_m, method.single_rms_n_m];
            cells.extend(errors.into_iter().chain([training, test]).map(|x| format!("{x:.3}")));
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
