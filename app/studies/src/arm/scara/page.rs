//! The page of `study scara`.

use std::path::Path;

use hysteron_report::figure::{register_embedded_font, save};
use hysteron_report::lines::{Curve, PanelScale, TimeChart, TimePanel};
use hysteron_report::page::{Page, write_metrics, write_page};

use super::cells::ScaraStudy;
use super::outcome::Outcome;
use crate::arm::estimation::page::{joints, ours_and_published};
use crate::arm::estimation::scara_friction::{FrictionCell, TRUE, compensated, torque};

/// Methods that the paper has, with the names of its columns; its order of tables 4 and 5.
const PUBLISHED: [&str; 4] = ["anfis", "pso", "fnn", "least-squares-coulomb"];
/// Table 4 by joint: RMSE, maximum, R², minimum, mean of the four.
const TABLE_4: [[[f64; 5]; 4]; 2] = [
    [
        [0.3089, 1.0496, 0.9863, 0.0062, 0.2436],
        [0.7932, 2.5495, 0.9093, 0.0482, 0.6398],
        [0.5786, 1.7548, 0.9517, 0.0023, 0.4582],
        [1.1845, 4.1450, 0.7978, 0.0370, 0.9122],
    ],
    [
        [0.2927, 1.2348, 0.9882, 0.0041, 0.2333],
        [0.6534, 2.4135, 0.9411, 0.0256, 0.5170],
        [0.5231, 1.9412, 0.9622, 0.0336, 0.4392],
        [1.0278, 4.4776, 0.8542, 0.0271, 0.8479],
    ],
];
/// Table 3 by joint: delay (printed as ms), peak error, RMSE, maximum.
const TABLE_3: [[[f64; 4]; 4]; 2] = [
    [
        [0.2146, 0.2353, 0.2556, 0.8964],
        [0.3786, 0.2862, 0.3431, 2.3421],
        [0.3209, 1.9034, 0.9824, 2.9240],
        [0.4673, 1.0384, 1.2463, 4.3040],
    ],
    [
        [0.236, 0.0488, 0.2077, 0.8909],
        [0.3466, 0.1231, 0.2505, 1.8791],
        [0.2896, 0.5452, 0.5833, 2.7101],
        [0.4362, 0.8236, 0.7594, 3.1971],
    ],
];

fn place(method: &str) -> Option<usize> {
    PUBLISHED.iter().position(|name| *name == method)
}

fn cell(ours: f64, published: Option<f64>, digits: usize) -> String {
    published.map_or_else(|| format!("{ours:.digits$}"), |known| ours_and_published(ours, known, digits))
}

/// Writes `report.html` and `metrics.json`.
pub(super) fn write(folder: &Path, study: &ScaraStudy, outcome: &Outcome) -> anyhow::Result<()> {
    register_embedded_font()?;
    write_metrics(folder, outcome)?;
    let title = "External torques and collisions of a SCARA";
    let mut page = Page::with_verdict(title, &outcome.verdict, "study of external torques", &outcome.command);
    page.paragraph(
        "Simulated: Wan et al. (2026) publish neither geometry nor data. True friction is their table 2, ANFIS, with Stribeck speeds of 0.2 rad/s, \
         as bristles; torques have 0.43 N m of noise; the estimators believe masses 2 % too large. Published values are in brackets. \
         \"least-squares-coulomb\" is the counterpart of the paper's LS: least squares of the right law cannot be beaten by the others.",
    );
    signals(folder, &mut page, study)?;
    friction(folder, &mut page, study)?;
    teaching(folder, &mut page, study)?;
    collisions(folder, &mut page, study)?;
    write_page(folder, page.finish(&outcome.commit))
}

fn friction(folder: &Path, page: &mut Page, study: &ScaraStudy) -> anyhow::Result<()> {
    page.heading("Friction: error of the identified curve, and parameters (table 2)");
    let head = [
        "Joint",
        "Method",
        "RMS, single trials [N m]",
        "Largest",
        "RMS, means of 200",
        "Largest",
        "Folds: training",
        "Folds: test",
        "Parameters",
    ];
    let rows = study.friction.iter().flat_map(|joint| {
        joint.rows.iter().map(|row| {
            let [rms, largest] = row.single_error_n_m;
            let [averaged, most] = row.averaged_error_n_m;
            let fold =
                |k: usize| row.folds_n_m.iter().map(|fold| fold[k]).sum::<f64>() / row.folds_n_m.len() as f64;
            let parameters: Vec<String> = row.parameters.iter().map(|p| format!("{p:.3}")).collect();
            let numbers = [rms, largest, averaged, most, fold(0), fold(1)].map(|x| format!("{x:.3}"));
            let words = vec![(joint.joint + 1).to_string(), row.method.clone()];
            [words, numbers.to_vec(), vec![parameters.join(", ")]].concat()
        })
    });
    page.table(&head, rows);
    page.paragraph(
        "Parameters: f_c+, f_c-, f_s+ - f_c+, f_s- - f_c-, v_s+, v_s-, f_v; of Coulomb's law f_c, f_v. Published largest errors after \
         compensation, ANFIS: 0.263 and 0.184 N m; folds 0.43 and 0.44 N m.",
    );
    let speeds: Vec<f64> = (1..=100).map(|k| 0.01 * f64::from(k)).collect();
    for joint in &study.friction {
        let curves = |sign: f64| {
            let mut curves: Vec<Curve> = joint
                .rows
                .iter()
                .enumerate()
                .map(|(k, row)| {
                    let at = |v: &f64| sign * torque(row, sign * v);
                    Curve::new(&row.method, k, speeds.iter().map(at).collect())
                })
                .collect();
            let truth = speeds.iter().map(|v| TRUE[joint.joint].size(sign * v)).collect();
            curves.push(Curve::new("true", joint.rows.len(), truth));
            curves
        };
        let panels =
            vec![TimePanel::new("forward [N m]", curves(1.0)), TimePanel::new("reverse [N m]", curves(-1.0))];
        let title = format!("Friction of joint {} (figure 11)", joint.joint + 1);
        let mut chart = TimeChart::over_time(
            format!("friction-{}", joint.joint + 1),
            title,
            "Size of friction over the size of the speed [rad/s].",
            &speeds,
            panels,
        );
        chart.x_name = "speed [rad/s]";
        page.figure(&save(folder, &chart, false)?);
    }
    for joint in &study.friction {
        page.figure(&save(folder, &compensation(joint), false)?);
    }
    page.figure(&save(folder, &progress(study), false)?);
    page.figure(&save(folder, &folds(study), false)?);
    Ok(())
}

/// Figure 14.
fn compensation(joint: &FrictionCell) -> TimeChart {
    let (speeds, recorded, left) = compensated(joint);
    let left = joint.rows.iter().zip(left).enumerate();
    let panels = vec![
        TimePanel::new("without [N m]", vec![Curve::new("recorded", joint.rows.len(), recorded)]),
        TimePanel::new(
            "compensated [N m]",
            left.map(|(k, (row, values))| Curve::new(&row.method, k, values)).collect(),
        ),
    ];
    let name = format!("compensation-{}", joint.joint + 1);
    let title = format!("Friction of joint {} compensated (figure 14)", joint.joint + 1);
    let caption = "Torques of single trials over speed, and the residual of each method; after a median of five and a low pass.";
    let mut chart = TimeChart::over_time(name, title, caption, &speeds, panels);
    chart.x_name = "speed [rad/s]";
    chart
}

/// Figures 5 to 7 and 17.
fn signals(folder: &Path, page: &mut Page, study: &ScaraStudy) -> anyhow::Result<()> {
    page.heading("Gain, noise and filter of the observer");
    let signals = &study.signals;
    for (name, title, caption, curves) in [
        (
            "gains",
            "Observers of four gains (figure 5a)",
            "A force from 1 to 2 s, torques with 1 N m of noise.",
            &signals.gains,
        ),
        ("noise", "Three sizes of noise (figure 5b)", "The same force, K = 50 1/s.", &signals.noise),
        (
            "filtered",
            "Before and after the filter (figures 6 and 7)",
            "Led by the hand: median of five, then a Butterworth low pass forwards and backwards, which no estimator in a loop can have.",
            &signals.filtered,
        ),
        ("collision", "A collision (figure 17)", "A force of 25 N from 4 to 4.25 s.", &signals.collision),
    ] {
        let chart = joints(name, [title, caption, "N m"], &curves.time_s, &curves.curves);
        page.figure(&save(folder, &chart, false)?);
    }
    Ok(())
}

/// Figure 10.
fn progress(study: &ScaraStudy) -> TimeChart {
    let longest =
        study.friction.iter().flat_map(|j| &j.rows).map(|row| row.progress_n_m.len()).max().unwrap_or(0);
    let steps: Vec<f64> = (1..=longest).map(|k| k as f64).collect();
    let panels = study.friction.iter().map(|joint| {
        let curves = joint.rows.iter().enumerate().map(|(k, row)| {
            let mut values = row.progress_n_m.clone();
            values.resize(longest, f64::NAN);
            Curve::new(&row.method, k, values)
        });
        TimePanel::new(format!("joint {} [N m]", joint.joint + 1), curves.collect())
    });
    let caption = "Root mean square error in training over passes, generations or evaluations.";
    let mut chart =
        TimeChart::over_time("progress", "Error in training (figure 10)", caption, &steps, panels.collect());
    chart.x_name = "step [-]";
    chart
}

/// Figure 12.
fn folds(study: &ScaraStudy) -> TimeChart {
    let steps: Vec<f64> = (1..=5).map(f64::from).collect();
    let panels = study.friction.iter().map(|joint| {
        let row = &joint.rows[0];
        let curve = |k: usize, name: &str| Curve::new(name, k, row.folds_n_m.iter().map(|f| f[k]).collect());
        TimePanel::new(
            format!("joint {} [N m]", joint.joint + 1),
            vec![curve(0, "training"), curve(1, "test")],
        )
    });
    let caption = "Root mean square error of ANFIS, then Stribeck's law, in five folds.";
    let mut chart =
        TimeChart::over_time("folds", "Five-fold validation (figure 12)", caption, &steps, panels.collect());
    chart.x_name = "fold [-]";
    chart.scale = PanelScale::Common;
    chart
}

fn teaching(folder: &Path, page: &mut Page, study: &ScaraStudy) -> anyhow::Result<()> {
    let teaching = &study.teaching;
    page.heading("Led by the hand (table 4)");
    let head = ["Joint", "Method", "RMSE [N m]", "Largest [N m]", "R² [-]", "Least [N m]", "Mean [N m]"];
    let rows = [0, 1].into_iter().flat_map(|j| {
        teaching.rows.iter().map(move |row| {
            let known = place(&row.method).map(|p| TABLE_4[j][p]);
            let ours = [row.rmse_n_m[j], row.max_n_m[j], row.r2[j], row.min_n_m[j], row.mean_n_m[j]];
            let cells = (0..5).map(|k| cell(ours[k], known.map(|known| known[k]), 4));
            [vec![(j + 1).to_string(), row.method.clone()], cells.collect()].concat()
        })
    });
    page.table(&head, rows);
    page.heading("Improvement over least-squares-coulomb [%] (table 5; a worsening is negative)");
    let base = teaching.rows.iter().find(|row| row.method == "least-squares-coulomb");
    let head = ["Joint", "Method", "RMSE", "Largest", "R²", "Mean"];
    let rows = [0, 1].into_iter().flat_map(|j| {
        teaching.rows.iter().filter_map(move |row| {
            let base = base?;
            // Adding zero makes minus zero plus zero.
            let better = |ours: f64, theirs: f64| 100.0 * (theirs - ours) / theirs + 0.0;
            let improvement = [
                better(row.rmse_n_m[j], base.rmse_n_m[j]),
                better(row.max_n_m[j], base.max_n_m[j]),
                0.0 - better(row.r2[j], base.r2[j]),
                better(row.mean_n_m[j], base.mean_n_m[j]),
            ];
            let known = place(&row.method).map(|p| {
                let (ours, theirs) = (TABLE_4[j][p], TABLE_4[j][3]);
                [0, 1, 2, 4].map(|k| {
                    let value = better(ours[k], theirs[k]) * if k == 2 { -1.0 } else { 1.0 };
                    (10.0 * value).round() / 10.0 + 0.0
                })
            });
            let cells = (0..4).map(|k| cell(improvement[k], known.map(|known| known[k]), 1));
            Some([vec![(j + 1).to_string(), row.method.clone()], cells.collect()].concat())
        })
    });
    page.table(&head, rows);
    for (name, title, methods) in [
        ("teaching-compensation", "With and without friction (figures 15 and 16)", ["anfis", "none"]),
        ("teaching", "Estimated external torque (figures 18 and 19)", ["anfis", "least-squares-coulomb"]),
    ] {
        let mut curves = vec![("force sensor".to_owned(), teaching.truth.clone())];
        curves.extend(methods.iter().filter_map(|name| {
            let row = teaching.rows.iter().find(|row| row.method == *name)?;
            Some(((*name).to_owned(), row.estimate.clone()))
        }));
        let chart = joints(name, [title, "Over time [s].", "N m"], &teaching.time_s, &curves);
        page.figure(&save(folder, &chart, false)?);
    }
    Ok(())
}

fn collisions(folder: &Path, page: &mut Page, study: &ScaraStudy) -> anyhow::Result<()> {
    let collisions = &study.collisions;
    page.heading(&format!(
        "Collisions (table 3): {} of them, {:.2} h without",
        collisions.n_contacts, collisions.free_hours
    ));
    let head = ["Joint", "Method", "Peak error [N m]", "RMSE [N m]", "Largest [N m]"];
    let rows = [0, 1].into_iter().flat_map(|j| {
        collisions.rows.iter().map(move |row| {
            let known = place(&row.method).map(|p| TABLE_3[j][p]);
            let ours = [row.peak_error_n_m[j], row.rmse_n_m[j], row.max_n_m[j]];
            let cells = (0..3).map(|k| cell(ours[k], known.map(|known| known[k + 1]), 4));
            [vec![(j + 1).to_string(), row.method.clone()], cells.collect()].concat()
        })
    });
    page.table(&head, rows);
    page.paragraph(
        "Published delays of 0.21 to 0.47 \"ms\" are below one sample of 2.5 ms and cannot be compared. Below: delays in samples at the \
         lowest threshold with at most one false alarm an hour; \"late\" is against an observer with a perfect model.",
    );
    let head = [
        "Method",
        "Delay [samples]",
        "Late, mean",
        "Late, most",
        "False alarms [1/h], band",
        "Recall, band",
        "False alarms [1/h], CUSUM",
        "Recall, CUSUM",
        "False alarms [1/h], as learned",
        "Recall, as learned",
        "Right joint [%]",
    ];
    let rows = collisions.rows.iter().map(|row| {
        let numbers = [
            row.delay_samples,
            row.excess_delay_samples[0],
            row.excess_delay_samples[1],
            row.band.false_alarms_per_hour,
            row.band.recall,
            row.cusum.false_alarms_per_hour,
            row.cusum.recall,
            row.learned.false_alarms_per_hour,
            row.learned.recall,
            100.0 * row.right_joint,
        ];
        [vec![row.method.clone()], numbers.map(|x| format!("{x:.2}")).to_vec()].concat()
    });
    page.table(&head, rows);
    page.figure(&save(folder, &characteristic(study), false)?);
    Ok(())
}

/// Recall that a method reaches with at most so many false alarms an hour.
fn characteristic(study: &ScaraStudy) -> TimeChart {
    let limits: Vec<f64> = (0..=40).map(|k| -0.5 + 0.1 * f64::from(k)).collect();
    let curves = study.collisions.rows.iter().enumerate().map(|(k, row)| {
        let recall = |log: &f64| {
            let within = row.roc.iter().filter(|at| at.false_alarms_per_hour <= 10f64.powf(*log));
            within.map(|at| at.recall).fold(f64::NAN, f64::max)
        };
        Curve::new(&row.method, k, limits.iter().map(recall).collect())
    });
    let caption = "Share of the collisions found, over the logarithm of the false alarms an hour.";
    let panels = vec![TimePanel::new("recall [-]", curves.collect())];
    let mut chart =
        TimeChart::over_time("roc", "Receiver operating characteristic", caption, &limits, panels);
    chart.x_name = "log10 of false alarms [1/h]";
    chart
}
