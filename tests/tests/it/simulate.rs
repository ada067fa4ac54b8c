//! The main job: a robot follows strokes.

use hysteron_base::{Recording, Scene};
use hysteron_tests::{Workplace, names_in};
use hysteron_twin::{Twin, TwinState};

fn recording(place: &Workplace, name: &str) -> Recording {
    Recording::read(place.path().join(name)).unwrap()
}

/// Largest difference of all channels of two recordings, in SI.
fn difference(a: &Recording, b: &Recording) -> f64 {
    assert_eq!(a.time(), b.time());
    assert_eq!(a.channels().len(), b.channels().len());
    let pairs = a.channels().iter().zip(b.channels());
    pairs.fold(0.0, |largest, (a, b)| {
        assert_eq!(a.name, b.name);
        a.values.iter().zip(&b.values).fold(largest, |largest: f64, (a, b)| largest.max((a - b).abs()))
    })
}

#[test]
fn tip_goes_where_the_tendons_pull() {
    let place = Workplace::new();
    place.write(
        "pull.csv",
        "time_s,stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm\n0,0,0,0,0\n1,3,0,-3,0\n2,0,3,0,-3\n",
    );
    let outcome = place.simulate("pull.csv", "tip.csv").succeeded();
    assert_eq!(outcome.stdout, "tip.csv\n");
    assert!(outcome.stderr.contains("3 steps"), "{}", outcome.stderr);
    let tip = recording(&place, "tip.csv");
    let [x, y, z] = tip.tip().unwrap();
    assert!(x[0].abs() < 1e-6 && y[0].abs() < 1e-6 && (z[0] - 0.08).abs() < 1e-6, "rest");
    // Pulled at +x and then at +y: bent that way by some ten millimetres, and shorter.
    assert!(x[1] > 5e-3 && y[1].abs() < 1e-3 && z[1] < 0.08, "{} {} {}", x[1], y[1], z[1]);
    assert!(y[2] > 5e-3 && x[2].abs() < 1e-3 && z[2] < 0.08, "{} {} {}", x[2], y[2], z[2]);
    // The released tendon is slack.
    assert!(tip.channel("tension_1_n").unwrap()[1] > 1.0);
    assert_eq!(tip.channel("tension_3_n").unwrap()[1], 0.0);
    let meta = tip.meta();
    assert_eq!(meta.scene_hash, Scene::read(place.path().join("scene.toml")).unwrap().hash);
    assert_eq!(meta.seed, Some(1));
    assert_eq!(meta.command, "hysteron simulate scene.toml --strokes pull.csv --out tip.csv");
    assert_eq!(meta.extra["complete"], "true");
    assert!(meta.source.contains("pull.csv"));
}

#[test]
fn tip_of_tendons_that_rub_lags_behind_its_reversal() {
    let place = Workplace::new();
    // Pulled by 4 mm and released again, in steps of 0.1 mm.
    let row = |k: i32| format!("{k},{0},0,-{0},0\n", 0.1 * f64::from(40 - (k - 40).abs()));
    let rows: String = (0..=80).map(row).collect();
    place.write("pull.csv", format!("time_s,stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm\n{rows}"));
    let bend = |scene: &str, out: &str| {
        place.run(&["simulate", scene, "--strokes", "pull.csv", "--out", out]).succeeded();
        recording(&place, out).tip().unwrap()[0].to_vec()
    };
    let (smooth, rubbing) = (bend("scene.toml", "smooth.csv"), bend("scene-friction.toml", "rubbing.csv"));
    let widest = |tip: &[f64]| (0..40).map(|k| tip[80 - k] - tip[k]).fold(0.0, f64::max);
    // Without friction both ways are one, to what 1e-6 of the forces bends.
    assert!(widest(&smooth) < 1e-6, "{}", widest(&smooth));
    assert!(widest(&rubbing) > 1e-4, "{}", widest(&rubbing));
    let tensions = recording(&place, "rubbing.csv");
    assert!(tensions.channel("tension_5_n").is_none(), "jumps are no tendons");
}

#[test]
fn csv_and_parquet_hold_the_same() {
    let place = Workplace::new();
    place.write_circle("circle.csv", 40);
    place.simulate("circle.csv", "tip.csv").succeeded();
    place.simulate("circle.csv", "tip.parquet").succeeded();
    assert_eq!(difference(&recording(&place, "tip.csv"), &recording(&place, "tip.parquet")), 0.0);
    // What was written can be followed again.
    place.simulate("tip.parquet", "again.csv").succeeded();
    assert_eq!(difference(&recording(&place, "tip.csv"), &recording(&place, "again.csv")), 0.0);
}

#[test]
fn repeated_runs_give_the_same_bytes_on_any_number_of_threads() {
    let place = Workplace::new();
    place.write_circle("circle.csv", 60);
    for name in ["tip.csv", "tip.parquet"] {
        place.simulate("circle.csv", name).succeeded();
        let first = place.read(name);
        let arguments = ["simulate", "scene.toml", "--strokes", "circle.csv", "--out", name];
        for threads in ["1", "3"] {
            place.run(&[&arguments[..], &["--threads", threads, "-q"]].concat()).succeeded();
            assert_eq!(place.read(name), first, "{name} with {threads} threads");
        }
    }
}

#[test]
fn a_saved_state_continues_the_run() {
    // Both runs solve to a residual of 1e-6 of the applied forces; the robot is some 10 mm and 30 N.
    const TOLERANCE: f64 = 3e-4;
    let place = Workplace::new();
    place.write_circle("whole.csv", 60);
    let text = String::from_utf8(place.read("whole.csv")).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    place.write("first.csv", lines[..31].join("\n"));
    place.write("second.csv", [&lines[..1], &lines[31..]].concat().join("\n"));
    place.simulate("whole.csv", "whole-tip.csv").succeeded();
    let base = ["simulate", "scene.toml", "--strokes"];
    place.run(&[&base[..], &["first.csv", "--out", "a.csv", "--save-state", "a.state"]].concat()).succeeded();
    place.run(&[&base[..], &["second.csv", "--out", "b.csv", "--from", "a.state"]].concat()).succeeded();
    let (whole, second) = (recording(&place, "whole-tip.csv"), recording(&place, "b.csv"));
    for (a, b) in whole.channels().iter().zip(second.channels()) {
        for (a_k, b_k) in a.values[30..].iter().zip(&b.values) {
            assert!((a_k - b_k).abs() < TOLERANCE, "{}: {a_k} {b_k}", a.name);
        }
    }
    // A state belongs to its scene.
    place.replace("scene.toml", "seed = 1", "seed = 2");
    let outcome = place.run(&[&base[..], &["second.csv", "--out", "c.csv", "--from", "a.state"]].concat());
    assert!(outcome.error(2).contains("a.state: scene_hash"));
}

#[test]
fn an_impossible_stroke_keeps_what_was_done() {
    let place = Workplace::new();
    let mut csv = String::from("time_s,stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm\n");
    for i in 0..10 {
        csv.push_str(&format!("{},{},0,0,0\n", f64::from(i) / 100.0, f64::from(i) / 10.0));
    }
    place.write("pull.csv", format!("{csv}0.1,60,0,0,0\n0.11,0,0,0,0\n"));
    // Within its bounds, but more than the body can follow.
    place.replace("scene.toml", "stroke_max_mm = 20.0", "stroke_max_mm = 80.0");
    let outcome = place.run(&[
        "simulate",
        "scene.toml",
        "--strokes",
        "pull.csv",
        "--out",
        "tip.csv",
        "--figures",
        "figures",
    ]);
    let error = outcome.error(1);
    for part in ["row 11", "t = 0.1 s", "p1 60.000 mm", "10 of 12 samples", "tip.partial.csv", "tip.state"] {
        assert!(error.contains(part), "{part} in {error}");
    }
    assert_eq!(
        names_in(place.path()),
        [
            "pull.csv",
            "scene-coreact.toml",
            "scene-friction.toml",
            "scene.toml",
            "tip.partial.csv",
            "tip.state",
            "tpu80.msh"
        ]
    );
    let partial = recording(&place, "tip.partial.csv");
    assert_eq!(partial.n_samples(), 10);
    assert_eq!(partial.meta().extra["complete"], "false");
    // The state is the equilibrium of the last row.
    let scene = Scene::read(place.path().join("scene.toml")).unwrap();
    let mut scene_here = scene.clone();
    scene_here.mesh_path = place.path().join("tpu80.msh");
    let twin = Twin::from_scene(&scene_here).unwrap();
    let state = TwinState::read(&place.path().join("tip.state"), &twin, &scene.hash).unwrap();
    let tip = twin.tip_of(&state);
    for (axis, values) in partial.tip().unwrap().into_iter().enumerate() {
        assert!((values[9] - tip[axis]).abs() < 1e-9, "axis {axis}");
    }

    // Other strokes are not what was interrupted; the same ones fail in the same place.
    place.write("other.csv", &csv);
    let resume = |strokes: &str| {
        place.run(&["simulate", "scene.toml", "--strokes", strokes, "--out", "tip.csv", "--resume"])
    };
    assert!(resume("other.csv").error(2).contains("strokes_sha256"));
    assert!(resume("pull.csv").error(1).contains("row 11"));
}

#[test]
fn resume_without_an_earlier_run_is_bad_input() {
    let place = Workplace::new();
    place.write_circle("circle.csv", 5);
    let outcome =
        place.run(&["simulate", "scene.toml", "--strokes", "circle.csv", "--out", "tip.csv", "--resume"]);
    assert!(outcome.error(2).contains("tip.partial.csv"));
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_resumes_to_the_same_end() {
    // As for a saved state.
    const TOLERANCE: f64 = 3e-4;
    let place = Workplace::new();
    place.write_circle("circle.csv", 3000);
    let arguments = [
        "simulate",
        "scene.toml",
        "--strokes",
        "circle.csv",
        "--out",
        "tip.csv",
        "--vtu",
        "vtu",
        "--vtu-every",
        "10",
    ];
    // It has begun once the second picture is there.
    let stopped = hysteron_tests::interrupt(place.path(), &arguments, "vtu/body_000010.vtu");
    assert!(stopped.error(1).starts_with("error: interrupted"), "{}", stopped.stderr);
    assert!(!place.path().join("tip.csv").exists());
    let done = recording(&place, "tip.partial.csv").n_samples();
    assert!((10..3000).contains(&done), "{done}");

    place.run(&[&arguments[..], &["--resume"]].concat()).succeeded();
    assert!(!place.path().join("tip.partial.csv").exists() && !place.path().join("tip.state").exists());
    place.simulate("circle.csv", "whole.csv").succeeded();
    let (resumed, whole) = (recording(&place, "tip.csv"), recording(&place, "whole.csv"));
    let difference = difference(&resumed, &whole);
    assert!(difference < TOLERANCE, "{difference}");
    let list = String::from_utf8(place.read("vtu/robot.pvd")).unwrap();
    assert_eq!(list.matches("<DataSet").count(), 600);
}

#[test]
fn pictures_and_report_are_whole() {
    let place = Workplace::new();
    place.write_circle("circle.csv", 30);
    place
        .run(&[
            "simulate",
            "scene.toml",
            "--strokes",
            "circle.csv",
            "--out",
            "tip.csv",
            "--figures",
            "figures",
            "--png",
            "--vtu",
            "vtu",
            "--vtu-every",
            "10",
        ])
        .succeeded();
    let names = names_in(&place.path().join("figures"));
    for stem in ["robot", "command-tip", "strokes", "tensions", "tip-path", "tip-time"] {
        for ending in ["svg", "png"] {
            assert!(names.contains(&format!("{stem}.{ending}")), "{stem}.{ending} in {names:?}");
        }
    }
    let report = String::from_utf8(place.read("figures/report.html")).unwrap();
    assert_eq!(report.matches("<figure>").count(), 6);
    assert!(report.contains("hysteron simulate scene.toml --strokes circle.csv"));
    assert!(!report.contains("NaN") && !report.contains("src="));
    let metrics = String::from_utf8(place.read("figures/metrics.json")).unwrap();
    for key in ["excursion_m", "tip_per_stroke", "diamond_ratio", "return_error"] {
        assert!(metrics.contains(&format!("\"{key}\": ")), "{key} in {metrics}");
    }
    assert!(metrics.contains("\"samples\": 30") && metrics.contains("\"steps\": 30"), "{metrics}");
    assert_eq!(
        names_in(&place.path().join("vtu")),
        [
            "body_000000.vtu",
            "body_000010.vtu",
            "body_000020.vtu",
            "robot.pvd",
            "tendons_000000.vtp",
            "tendons_000010.vtp",
            "tendons_000020.vtp",
        ]
    );
}

#[test]
fn virtual_tendons_rest_unless_the_recording_drives_them() {
    let place = Workplace::new();
    place.write_circle("circle.csv", 10);
    let simulate = |strokes: &str, out: &str| {
        place.run(&["simulate", "scene-coreact.toml", "--strokes", strokes, "--out", out])
    };
    simulate("circle.csv", "resting.csv").succeeded();
    place.simulate("circle.csv", "without.csv").succeeded();
    let resting = recording(&place, "resting.csv");
    assert!(resting.aux().is_empty());
    // Tensions of zero do not bend it; both solve to 1e-6 of the applied forces.
    assert!(difference(&resting, &recording(&place, "without.csv")) < 3e-4);

    let write_aux = |n: usize| {
        let names: String = (1..=n).map(|k| format!(",aux_{k:02}_mm")).collect();
        let zeros = ",0".repeat(n - 1);
        let header = "time_s,stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm";
        place.write("aux.csv", format!("{header}{names}\n0,0,0,0,0,0{zeros}\n0.01,0,0,0,0,0.05{zeros}\n"));
    };
    write_aux(36);
    simulate("aux.csv", "driven.csv").succeeded();
    let driven = recording(&place, "driven.csv");
    assert_eq!(driven.aux().len(), 36);
    assert_eq!(driven.aux()[0], [0.0, 5e-5]);
    assert_eq!(driven.numbered("tension", "n").len(), 40);
    // The first one pulls at +x and bends the body that way.
    assert!(driven.tip().unwrap()[0][1] > 1e-4);

    write_aux(35);
    let outcome = simulate("aux.csv", "none.csv");
    assert!(outcome.error(2).contains("aux columns: expected 36 (aux_01 to aux_36), got 35"));
}
