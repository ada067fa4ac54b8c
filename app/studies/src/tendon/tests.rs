//! Reports of studies: whatever was measured has a verdict, tables and figures, and reads back.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use hysteron_base::json;
use hysteron_report::verdict::Usability;
use hysteron_workflow::Context;
use hysteron_workflow::shared::outcome::Outcome as _;

use super::outcome::StudyMetrics;
use super::{Outcome, session};

/// The outcome of a study with these numbers, and its page.
fn reported<M: StudyMetrics>(metrics: &str) -> (Outcome<M>, String) {
    let folder = tempfile::tempdir().unwrap();
    let context = Context::silent("hysteron study");
    let metrics: M = json::from_text(metrics).unwrap();
    let outcome = session::run("name", folder.path(), &context, || Ok(metrics)).unwrap();
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let again: Outcome<M> = json::from_text(read("metrics.json")).unwrap();
    assert_eq!(json::to_text(&again).unwrap(), json::to_text(&outcome).unwrap());
    (outcome, read("report.html"))
}

/// The sentence of the verdict on these numbers, which the page begins with; the tables stand on the page and in the lines.
fn sentence<M: StudyMetrics>(metrics: &str) -> String {
    let (outcome, page) = reported::<M>(metrics);
    let lines = outcome.lines();
    for table in outcome.metrics.tables() {
        assert!(lines.contains(&table.title), "{}", table.title);
        assert!(table.rows.iter().all(|row| row.len() == table.headings.len()), "{table:?}");
    }
    assert!(page.contains("<figure>") && page.contains(M::TITLE) && !page.contains("NaN"), "{page}");
    outcome.verdict.sentence
}

#[test]
fn comparisons_with_other_programs_are_judged_by_their_differences() {
    let row = |name: &str, tip: f64| {
        format!(
            r#"{{"comparison":"{name}","to_stroke_mm":5.0,"worst_tip":{tip},"worst_deflection":0.001,"worst_tension":0.002}}"#
        )
    };
    let sofa = |tip: f64| {
        // Another law may be off by any amount.
        let rows = [row("edges against SOFA polar", tip), row("edges against SOFA large", 0.5)];
        sentence::<Vec<super::sofa::Comparison>>(&format!("[{}]", rows.join(",")))
    };
    assert!(sofa(0.003).starts_with("Usable: "), "{}", sofa(0.003));
    let care = sofa(0.08);
    assert!(care.contains("with care") && care.contains("off by at most 8.00 % of its deflection"), "{care}");

    let mesh = |sides: u32, tip: f64| {
        format!(
            r#"{{"mesh":"tube, {sides} sides","order":2,"law":"Corotational","ring_mm":1.2,"n_unknowns":{sides}000,"stroke_mm":[2.0,7.0,10.0],
               "deflection_mm":[1.0,{tip},null],"tension_n":[1.0,3.0,null],"reached_mm":8.0,"failure":null}}"#
        )
    };
    let found = sentence::<Vec<super::convergence::MeshResolution>>(&format!(
        "[{},{}]",
        mesh(8, 4.0),
        mesh(12, 4.04)
    ));
    assert!(found.starts_with("Usable: "), "{found}");

    let errors = r#"{"median":0.1,"mean":0.1,"p95":0.3,"max":0.5}"#;
    let rod = format!(
        r#"[{{"shapes":20,"sides":6,"layers":64,"n_unknowns":900,"seconds_on_two_threads":1.0,"worst_relative_residual":1e-7,
            "iterations_per_shape":7.0,"error_percent_of_length":{{"mid-length":{errors},"tip":{errors},"all stations but the clamp":{errors}}}}}]"#
    );
    assert!(sentence::<Vec<super::sorosim::RodResolution>>(&rod).starts_with("Usable: "));
}

#[test]
fn recorded_robots_are_compared_with_the_simplest_baseline() {
    let hold = r#"{"hold":1,"session":"B","tensions_n":[1.0,0.0],"marker_error_mm":[1.0,2.0,3.0,4.0],"rmse_mm":2.7}"#;
    let fit = r#"{"set":"stiffness","mean_of_markers_rmse_mm":10.0,"left_out_mean_of_markers_rmse_mm":12.0,"converged":true,
        "parameters":[{"name":"E","start":1.0,"value":2.0,"standard_error":null,"is_fitted":true}]}"#;
    let tentacle = sentence::<super::tentacle::TentacleMetrics>(&format!(
        r#"{{"holds":[{hold},{hold}],"summary":[{{"over":"session B","rmse_mm":30.0,"own_rod_mm":36.4,"published_rod_mm":36.8}}],"fits":[{fit}]}}"#
    ));
    assert!(tentacle.starts_with("Usable: "), "{tentacle}");

    let errors = |first: f64| {
        let error = |(name, error): (&str, f64)| format!(r#"{{"method":"{name}","rmse_mm":{error}}}"#);
        let led = "FE twin, led to the measured tip";
        [("constant curvature without play and weight", first), ("kernel regression", 2.0), (led, 0.1)]
            .map(error)
            .join(",")
    };
    let folds = |first: f64| {
        let fold = format!(
            r#"{{"patterns":["a"],"rows":9,"rows_without_equilibrium":0,"parameters":[{{"name":"c","value":1.0}}],"fit_ended":"converged",
                "twin_parameters":null,"rmse_mm":[{}]}}"#,
            errors(first)
        );
        sentence::<super::ftdcr::FtdcrMetrics>(&format!(
            r#"{{"folds":[{fold},{fold}],"pooled":[{}]}}"#,
            errors(first)
        ))
    };
    assert!(folds(4.0).starts_with("Usable: "), "{}", folds(4.0));
    // The method that is led to the measured tip predicts nothing.
    assert!(
        folds(1.0).starts_with("Not usable: ") && folds(1.0).contains("kernel regression"),
        "{}",
        folds(1.0)
    );

    let inverse = sentence::<super::inverse::InverseMetrics>(
        r#"{"ftdcr":{"methods":["static regression","b","c","d","e","network","f"],"folds_mm":[[4.0,3.0,3.0,3.0,3.0,1.0,3.0],[4.0,3.0,3.0,3.0,3.0,2.0,3.0]]}}"#,
    );
    assert!(inverse.starts_with("Usable: "), "{inverse}");
}

/// Two twins on one test; the second has an error this large, seed by seed [%].
fn ladder(errors: [f64; 2]) -> String {
    let twin = |name: &str, errors: [f64; 2]| {
        format!(
            r#"{{"twin":"{name}","nrmse":[{{"path":"circle","x_percent":{errors:?},"y_percent":{errors:?},"z_percent":{errors:?}}}]}}"#
        )
    };
    format!(
        r#"{{"robot":"typical","twins":[{},{}]}}"#,
        twin("twin", [4.0; 2]),
        twin("twin + CoReAct", errors)
    )
}

#[test]
fn twins_are_compared_with_the_one_that_did_not_learn() {
    let coreact = |ratio: f64| {
        sentence::<super::coreact::CoreactMetrics>(&format!(
            r#"{{"ladders":[{}],"stability":{{"ratio_to_bare":[{ratio},{ratio}],"worse_by_10_percent":[]}}}}"#,
            ladder([1.0, 2.0])
        ))
    };
    assert!(coreact(0.5).starts_with("Usable: "), "{}", coreact(0.5));
    assert!(coreact(1.5).contains("random plans: the error of the tip is 150 %"), "{}", coreact(1.5));
    let robots = format!(r#"{{"ladders":[{}]}}"#, ladder([5.0, 5.0]));
    assert!(sentence::<super::robots::RobotsMetrics>(&robots).starts_with("Not usable: "));
    let layouts = format!(
        r#"{{"layouts":[{{"layout":"a","singular_values":[3.0,2.0,1.0],"left_median_p99_mm":[0.1,0.2]}}],"ladder":{}}}"#,
        ladder([3.0, 3.0])
    );
    assert!(sentence::<super::layouts::LayoutMetrics>(&layouts).starts_with("Usable: "));
}

/// A method or level whose tip followed so closely; null where the rig refused its strokes.
fn followed(key: &str, name: &str, nrmse: Option<f64>) -> String {
    let [nrmse, iou] =
        [nrmse, nrmse.map(|_| 0.9)].map(|value| value.map_or("null".to_owned(), |it| it.to_string()));
    format!(
        r#"{{"{key}":"{name}","nrmse_percent":{nrmse},"iou":{iou},"aligned_rmse_mm":{nrmse},"lag_ms":null}}"#
    )
}

#[test]
fn followed_paths_are_compared_where_all_methods_followed() {
    let names =
        ["twin, no learning", "network, recorded minute", "c", "d", "calibrated twin", "+ adaptation"];
    let level = |k: usize, nrmse: f64| followed("rung", names[k], (k != 2).then_some(nrmse));
    let levels = |better: f64| {
        let all: Vec<String> = (0..6).map(|k| level(k, if k == 5 { better } else { 4.0 })).collect();
        let robot = |name: &str| {
            format!(r#"{{"robot":"{name}","paths":[{{"target":"circle:50","rungs":[{}]}}]}}"#, all.join(","))
        };
        format!(r#"{{"robots":[{},{}]}}"#, robot("mild"), robot("typical/1"))
    };
    let ablation = |better: f64| sentence::<super::ablation::AblationMetrics>(&levels(better));
    assert!(ablation(2.0).starts_with("Usable: "), "{}", ablation(2.0));
    // The other levels do as well as the first.
    assert!(ablation(5.0).starts_with("Usable with care: "), "{}", ablation(5.0));

    let edic = sentence::<super::edic::EdicMetrics>(
        r#"{"paths":[{"path":"circle:40","paper_nrmse_percent":3.4,"paper_iou":0.85,"methods":[
            {"method":"network, recorded data","nrmse_percent":[4.0,5.0],"iou":[0.8,0.8],"aligned_rmse_mm":[1.0,null],"lag_ms":[1.0,null],"seeds_refused":0},
            {"method":"calibrated twin","nrmse_percent":[1.0,2.0],"iou":[0.9,0.9],"aligned_rmse_mm":[0.5,0.5],"lag_ms":[1.0,1.0],"seeds_refused":0}]}]}"#,
    );
    assert!(edic.starts_with("Usable: "), "{edic}");
}

#[test]
fn an_adapted_twin_is_compared_with_the_one_before_on_changed_robots() {
    let row = |change: &str, before: f64, after: f64| {
        let tip = |mm: f64| format!(r#"{{"rmse_mm":1.0,"aligned_rmse_mm":{mm},"nrmse_percent":1.0}}"#);
        format!(
            r#"{{"change":"{change}","target":"circle:40","kept":"both","before":{},"after":{},"gain":0.1,"unchanged_robot_aligned_rmse_mm":1.0}}"#,
            tip(before),
            tip(after)
        )
    };
    let rows = [row("unchanged", 1.0, 9.0), row("load added", 4.0, 2.0), row("play", 4.0, 2.0)].join(",");
    let found = sentence::<super::adaptation::AdaptationMetrics>(&format!(r#"{{"rows":[{rows}]}}"#));
    assert!(found.starts_with("Usable: "), "{found}");
}

#[test]
fn what_is_not_measured_yet_is_reported_with_care() {
    let empty = r#"{"robots":[]}"#;
    let verdicts = [
        reported::<super::population::PopulationMetrics>(empty).0.verdict,
        reported::<super::ablation::AblationMetrics>(empty).0.verdict,
        reported::<super::sensing::SensingMetrics>(empty).0.verdict,
    ];
    assert!(verdicts.iter().all(|verdict| verdict.usability == Usability::UsableWithCare), "{verdicts:?}");
}
