//! Every report: well-formed, with the figures it promises, the same twice, and fit for a narrow window.

use std::path::Path;

use hysteron_tests::{names_in, root, run};
use roxmltree::{Document, ParsingOptions};

const QUICK: [&str; 7] = ["record", "--rig", "virtual:typical", "--plan", "quick", "--out", "quick"];

fn scene() -> String {
    root().join("meshes/tpu80/scene-typical.toml").display().to_string()
}

/// The report of a folder: its text, after checks that hold for every report.
fn report(folder: &Path) -> String {
    let html = std::fs::read_to_string(folder.join("report.html")).unwrap();
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let page =
        Document::parse_with_options(&html, options).unwrap_or_else(|error| panic!("{folder:?}: {error}"));
    let named = |name: &'static str| page.descendants().filter(move |node| node.has_tag_name(name));
    assert!(
        named("meta")
            .any(|meta| meta.attribute("content").is_some_and(|it| it.contains("width=device-width")))
    );
    // Wide tables scroll in a box of their own, and every figure has a caption.
    assert!(named("table").all(|table| table.parent().unwrap().attribute("class") == Some("scroll")));
    assert!(named("figure").all(|figure| figure.children().any(|it| it.has_tag_name("figcaption"))));
    assert!(!html.contains("NaN") && !html.contains(">inf"), "{folder:?}");
    for name in names_in(folder).iter().filter(|name| name.ends_with(".svg")) {
        let svg = std::fs::read_to_string(folder.join(name)).unwrap();
        Document::parse(&svg).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(!svg.contains("NaN") && !svg.contains("inf\""), "{name}");
    }
    html
}

/// The titles of a report's figures, in order.
fn titles(html: &str) -> Vec<&str> {
    html.split("<h3>").skip(1).map(|rest| rest.split("</h3>").next().unwrap()).collect()
}

fn figures(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let names = names_in(folder).into_iter().filter(|name| name.ends_with(".svg"));
    names.map(|name| (name.clone(), std::fs::read(folder.join(&name)).unwrap())).collect()
}

#[test]
fn a_recording_shows_every_trajectory_with_strokes_loads_and_gaps() {
    let place = tempfile::tempdir().unwrap();
    run(place.path(), &QUICK).succeeded();
    let folder = place.path().join("quick");
    let html = report(&folder);
    assert_eq!(titles(&html), ["Command and tip", "sinusoid", "diagonal", "circle", "square", "ellipse"]);
    for text in ["stroke [mm]", "load [-]", "tip x [mm]", "tip z [mm]", "filled in"] {
        assert!(html.contains(text), "{text}");
    }
    let first = figures(&folder);
    std::fs::remove_dir_all(&folder).unwrap();
    run(place.path(), &QUICK).succeeded();
    assert!(first == figures(&folder));
}

#[test]
fn results_come_first_and_errors_are_shown_over_time() {
    let place = tempfile::tempdir().unwrap();
    let scene = scene();
    run(place.path(), &[&QUICK[..], &["--only", "ellipse"]].concat()).succeeded();
    let simulate = ["simulate", &scene, "--strokes", "quick/ellipse.parquet", "--out", "tip.parquet"];
    run(place.path(), &[&simulate[..], &["--figures", "simulated"]].concat()).succeeded();
    let html = report(&place.path().join("simulated"));
    let at = |text: &str| html.find(text).unwrap_or_else(|| panic!("{text}"));
    assert!(at("RMSE [mm]") < at("<figure>") && at("<figure>") < at("Solver details"));
    let expected = [
        "Displacement of the tip from rest",
        "Error of the tip",
        "Path of the tip",
        "Stroke of every tendon",
        "Tension of every tendon",
        "Command and tip",
    ];
    assert_eq!(titles(&html)[..6], expected);
    // Three labels at least on the strokes of every tendon, not zero alone.
    let svg = std::fs::read_to_string(place.path().join("simulated/strokes.svg")).unwrap();
    assert!(svg.matches(">\n2\n<").count() >= 4, "{svg}");

    let identify = ["identify", &scene, "quick/ellipse.parquet", "--out", "identified"];
    run(place.path(), &identify).succeeded();
    let html = report(&place.path().join("identified"));
    assert_eq!(titles(&html), ["ellipse: tip", "ellipse: error of the tip", "ellipse: auxiliary strokes"]);
    for text in ["measured", "uncorrected twin", "twin with auxiliary tendons", "error [mm]", "auxiliary 1"] {
        assert!(html.contains(text), "{text}");
    }

    let command = ["command", "--scene", &scene, "--target", "circle:20", "--out", "strokes.parquet"];
    run(place.path(), &[&command[..], &["--figures", "commands"]].concat()).succeeded();
    let html = report(&place.path().join("commands"));
    assert_eq!(titles(&html), ["Strokes", "Target over time"]);

    run(
        place.path(),
        &["record", "--rig", "virtual:typical", "--strokes", "strokes.parquet", "--out", "tracked.parquet"],
    )
    .succeeded();
    run(place.path(), &["evaluate", "--target", "circle:20", "tracked.parquet", "--out", "evaluated"])
        .succeeded();
    let html = report(&place.path().join("evaluated"));
    assert_eq!(titles(&html), ["Target and tip", "Target and tip over time"]);
    assert!(html.contains("error [mm]"));
}

#[test]
fn a_tip_that_never_moves_is_drawn() {
    let place = tempfile::tempdir().unwrap();
    let rows: String = (0..20).map(|i| format!("{},0,0,0,0\n", 0.01 * f64::from(i))).collect();
    let strokes = format!("time_s,stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm\n{rows}");
    std::fs::write(place.path().join("still.csv"), strokes).unwrap();
    let simulate =
        ["simulate", &scene(), "--strokes", "still.csv", "--out", "tip.parquet", "--figures", "still"];
    run(place.path(), &simulate).succeeded();
    report(&place.path().join("still"));
}
