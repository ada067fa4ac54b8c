//! The inverse: from tip positions to strokes.

use hysteron_base::Recording;
use hysteron_tests::{Outcome, Workplace, names_in};

fn recording(place: &Workplace, name: &str) -> Recording {
    Recording::read(place.path().join(name)).unwrap()
}

fn reach(place: &Workplace, goals: &str, out: &str) -> Outcome {
    place.run(&["reach", "scene.toml", "--goals", goals, "--out", out])
}

/// Largest distance between the tips of two recordings [m].
fn tip_distance(a: &Recording, b: &Recording) -> f64 {
    assert_eq!(a.time(), b.time());
    let (a, b) = (a.tip().unwrap(), b.tip().unwrap());
    let distance = |i: usize| (0..3).map(|c| (a[c][i] - b[c][i]).powi(2)).sum::<f64>().sqrt();
    (0..a[0].len()).map(distance).fold(0.0, f64::max)
}

#[test]
fn strokes_found_for_goals_bring_the_tip_there() {
    const TOLERANCE: f64 = 1e-5;
    // Both solve to a residual of 1e-6 of the applied forces.
    const SAME_TIP: f64 = 1e-6;
    let place = Workplace::new();
    place.write_circle("circle.csv", 100);
    let text = String::from_utf8(place.read("circle.csv")).unwrap();
    let thinned: Vec<&str> = text.lines().take(1).chain(text.lines().skip(1).step_by(4)).collect();
    place.write("strokes.csv", thinned.join("\n"));
    place.simulate("strokes.csv", "goals.csv").succeeded();

    let arguments = ["reach", "scene.toml", "--goals", "goals.csv", "--out", "found.csv"];
    let outcome = place.run(&[&arguments[..], &["--figures", "figures"]].concat()).succeeded();
    assert_eq!(outcome.stdout, "report: figures/report.html\nfound.csv\n");
    assert!(outcome.stderr.contains("25 of 25 goals reached within 0.01 mm"), "{}", outcome.stderr);
    let (goals, found) = (recording(&place, "goals.csv"), recording(&place, "found.csv"));
    let error = found.channel("tip_error_m").unwrap();
    let largest = error.iter().copied().fold(0.0, f64::max);
    assert!(largest <= TOLERANCE, "{largest}");
    assert!((tip_distance(&goals, &found) - largest).abs() < 1e-12);
    assert!(found.meta().source.contains("goals.csv"));
    assert_eq!(found.meta().extra["complete"], "true");
    for tensions in found.numbered("tension", "n") {
        assert!(tensions.iter().all(|tension| (0.0..=200.0).contains(tension)));
    }

    place.simulate("found.csv", "again.csv").succeeded();
    let again = recording(&place, "again.csv");
    let distance = tip_distance(&found, &again);
    assert!(distance < SAME_TIP, "{distance}");
    // The tip moves there, and does not stay at rest.
    assert!(again.tip().unwrap()[0].iter().any(|x| x.abs() > 1e-3));

    let names = names_in(&place.path().join("figures"));
    for name in ["metrics.json", "report.html", "strokes.svg", "tensions.svg", "tip-path.svg"] {
        assert!(names.contains(&name.to_owned()), "{name} in {names:?}");
    }
    assert!(String::from_utf8(place.read("figures/tip-path.svg")).unwrap().contains("goals"));
    let metrics = String::from_utf8(place.read("figures/metrics.json")).unwrap();
    assert!(metrics.contains("\"out_of_reach\": 0"), "{metrics}");
}

#[test]
fn goals_out_of_reach_are_counted_and_the_run_continues() {
    let place = Workplace::new();
    // A soft bound: a light pull on each tendon.
    let text = String::from_utf8(place.read("scene.toml")).unwrap();
    place.write("scene.toml", text.replace("tension_max_n = 200.0", "tension_max_n = 5.0"));
    place
        .write("goals.csv", "time_s,tip_x_mm,tip_y_mm,tip_z_mm\n0,0,0,80\n1,0,0,90\n2,40,0,60\n3,1,0,79.9\n");
    let outcome = reach(&place, "goals.csv", "found.csv").succeeded();
    assert!(outcome.stderr.contains("2 goals out of reach"), "{}", outcome.stderr);
    let found = recording(&place, "found.csv");
    let error = found.channel("tip_error_m").unwrap();
    // The body cannot be stretched; pulled with 5 N, it bends some of the way.
    assert!((error[1] - 0.01).abs() < 1e-3, "{error:?}");
    assert!(error[2] > 1e-2 && found.tip().unwrap()[0][2] > 2e-3, "{error:?}");
    for tensions in found.numbered("tension", "n") {
        assert!(tensions.iter().all(|tension| (0.0..=5.0).contains(tension)), "{tensions:?}");
    }
}

#[test]
fn goals_that_cannot_be_used() {
    let refused = |goals: &str, more: &[&str], parts: &[&str]| {
        let place = Workplace::new();
        place.write("goals.csv", goals);
        let before = names_in(place.path());
        let arguments =
            ["reach", "scene.toml", "--goals", "goals.csv", "--out", "out/found.csv", "--figures", "figures"];
        let outcome = place.run(&[&arguments[..], more].concat());
        let error = outcome.error(2);
        for part in parts {
            assert!(error.contains(part), "{part:?} in {error:?}");
        }
        assert_eq!(outcome.stdout, "");
        assert_eq!(names_in(place.path()), before);
    };
    refused("time_s,tip_x_mm,tip_y_mm\n0,0,0\n", &[], &["goals.csv", "tip_z_m"]);
    refused("time_s,tip_x,tip_y\n0,0,0\n", &[], &["goals.csv", "tip_x", "tip_x_mm"]);
    let header = "time_s,tip_x_mm,tip_y_mm,tip_z_mm\n";
    refused(&format!("{header}0,0,0,80\n1,0,NaN,80\n"), &[], &["goals.csv: line 3: tip_y_mm", "finite"]);
    refused(header, &[], &["goals.csv", "at least one row"]);
    let good = format!("{header}0,0,0,80\n");
    refused(&good, &["--tolerance-mm", "0"], &["--tolerance-mm", "at least 1e-9 mm"]);
    refused(&good, &["--tolerance-mm", "nan"], &["--tolerance-mm", "a number from 1e-9"]);
    refused(&good, &["--resume"], &["found.partial.csv"]);
    refused(&good, &["--out", "goals.csv"], &[]);
}
