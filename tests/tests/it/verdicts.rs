//! Every fit ends with a verdict: on screen, in `metrics.json`, and first on its page. All levels, from fits of the program.

use std::fmt::Write;

use hysteron_base::Recording;
use hysteron_tests::{Workplace, run};
use serde_json::Value;

/// The verdict of `arm identify friction` on a recording of one joint whose torque is this of speed and sample: its usability and its
/// sentence, the same on screen, in `metrics.json` and on the page.
fn of_friction(
    law: &str,
    speed: impl Fn(usize) -> f64,
    torque: impl Fn(f64, usize) -> f64,
) -> (String, String) {
    let place = tempfile::tempdir().unwrap();
    let mut text = String::from("time_s,dq_1_rad_s,tau_1_n_m\n");
    for k in 0..1500 {
        let v = speed(k);
        writeln!(text, "{},{v},{}", 0.01 * k as f64, torque(v, k)).unwrap();
    }
    std::fs::write(place.path().join("rec.csv"), text).unwrap();
    let words = ["arm", "identify", "friction", "rec.csv", "--law", law, "--out", "f.json", "--figures", "f"];
    let done = run(place.path(), &words).succeeded();
    let metrics: Value =
        serde_json::from_slice(&std::fs::read(place.path().join("f/metrics.json")).unwrap()).unwrap();
    let page = std::fs::read_to_string(place.path().join("f/report.html")).unwrap();
    let text = |key: &str| metrics["verdict"][key].as_str().unwrap().to_owned();
    let sentence = text("sentence");
    assert!(done.stdout.contains(&format!("verdict: {sentence}\n")), "{}", done.stdout);
    assert!(page.split("</h1>").nth(1).unwrap().trim_start().starts_with("<p class=\"verdict"), "{page}");
    (text("usability"), sentence)
}

/// Up and down through rest [rad/s].
fn up_and_down(k: usize) -> f64 {
    1.2 * (0.021 * k as f64).sin()
}

/// Stands for noise: no multiple of the path's period.
fn ripple(k: usize) -> f64 {
    0.02 * (1.7 * k as f64).sin()
}

#[test]
fn friction_that_is_seen_is_usable_and_one_that_is_not_there_is_not() {
    let (usability, sentence) =
        of_friction("coulomb-viscous", up_and_down, |v, k| 0.4 * v.signum() + 0.25 * v + ripple(k));
    assert_eq!(usability, "usable", "{sentence}");
    assert!(sentence.starts_with("Usable: the law gives the torque within 0.01"), "{sentence}");
    // A torque that does not depend on the speed.
    let (usability, sentence) =
        of_friction("coulomb-viscous", up_and_down, |v, k| 1e-3 * v.signum() + 0.3 * (0.37 * k as f64).sin());
    assert_eq!(usability, "not_usable", "{sentence}");
    assert!(sentence.starts_with("Not usable: the error is 0.2"), "{sentence}");
}

#[test]
fn a_parameter_on_its_bound_is_named() {
    // Friction that falls with the speed is not viscous: the law can only give zero.
    let (usability, sentence) =
        of_friction("coulomb-viscous", up_and_down, |v, k| 0.6 * v.signum() - 0.1 * v + ripple(k));
    assert_eq!(usability, "usable_with_care", "{sentence}");
    assert!(sentence.contains("viscous_n_m_s_per_rad ended on a bound"), "{sentence}");
}

#[test]
fn friction_that_the_motion_does_not_show_is_named_with_what_follows() {
    // Every speed is far above the one at which breakaway ends, so that the data does not show it.
    let fast = |k: usize| {
        let s = (0.021 * k as f64 + 0.01).sin();
        20.0 * (s.signum() + s)
    };
    let (usability, sentence) = of_friction("stribeck", fast, |v, k| 0.4 * v.signum() + 0.01 * v + ripple(k));
    assert_eq!(usability, "usable_with_care", "{sentence}");
    assert!(
        sentence.contains("the data do not determine") && sentence.contains("friction there is assumed"),
        "{sentence}"
    );
}

/// A robot whose first tendon is pulled by 0.3 mm before its recording begins.
fn recorded() -> Workplace {
    let place = Workplace::new();
    place.write_circle("strokes.csv", 60);
    let nominal = place.read("scene.toml");
    place.replace("scene.toml", "drive = \"stroke\"", "drive = \"stroke\"\nzero_mm = 0.3");
    place.simulate("strokes.csv", "rec.csv").succeeded();
    place.write("scene.toml", nominal);
    place
}

fn fit(place: &Workplace, zero_mm: &str) -> Value {
    place.write("fit.toml", format!("format = \"hysteron-fit\"\nversion = 1\n[fit]\nzero_mm = {zero_mm}\n"));
    let words = ["fit-material", "scene.toml", "rec.csv", "--out", "new.toml", "--every-mm", "0.5"];
    place.run(&[&words[..], &["--fit-file", "fit.toml", "--figures", "out"]].concat()).succeeded();
    serde_json::from_slice(&place.read("out/metrics.json")).unwrap()
}

#[test]
fn a_fit_at_a_bound_is_reported_and_a_scene_that_follows_nothing_is_not_usable() {
    let place = recorded();
    let metrics = fit(&place, "[-0.1, 0.1]");
    let zero = &metrics["parameters"][0];
    assert_eq!((&zero["is_at_bound"], &zero["standard_error"]), (&Value::Bool(true), &Value::Null), "{zero}");
    assert_eq!(zero["value"], zero["upper_bound"]);
    let sentence = metrics["verdict"]["sentence"].as_str().unwrap();
    assert_eq!(metrics["verdict"]["usability"], "usable_with_care", "{sentence}");
    assert!(sentence.contains("zero of p1") && sentence.contains("on a bound"), "{sentence}");

    // A tip that moves the other way than the tendons pull it.
    let recording = Recording::read(place.path().join("rec.csv")).unwrap();
    let [x, y, z] = recording.tip().unwrap();
    let strokes = recording.strokes();
    let mut text =
        String::from("time_s,stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm,tip_x_mm,tip_y_mm,tip_z_mm\n");
    for (i, time) in recording.time().iter().enumerate() {
        let strokes: Vec<String> = strokes.iter().map(|stroke| (1e3 * stroke[i]).to_string()).collect();
        let [x, y, z] = [-1e3 * x[i], -1e3 * y[i], 1e3 * z[i]];
        writeln!(text, "{time},{},{x},{y},{z}", strokes.join(",")).unwrap();
    }
    place.write("rec.csv", text);
    std::fs::remove_file(place.path().join("new.toml")).unwrap();
    std::fs::remove_dir_all(place.path().join("out")).unwrap();
    let metrics = fit(&place, "[-1.0, 1.0]");
    assert_eq!(metrics["verdict"]["usability"], "not_usable", "{}", metrics["verdict"]["sentence"]);
}
