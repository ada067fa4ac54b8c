//! The built-in plans, and every way in which a plan can be wrong.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::*;
use hysteron_base::Bounds;
use std::f64::consts::FRAC_PI_2;

/// A plan of one trajectory with every key.
const EXAMPLE: &str = r#"
format = "hysteron-plan"
version = 1
name = "example"
seed = 3
rate_hz = 50
scale = 1.0
vary = 0.0
tendon_angles_deg = [0, 90, 180, 270]
release = 0.9
co_contraction_mm = 0.5
rest_before_s = 1
rest_after_s = 2
stroke_max_mm = 6
stroke_rate_max_mm_s = 10

[[trajectory]]
name = "one"
role = "training"
family = "ellipse"
amplitude_mm = 5
frequency_hz = 0.2
phase_deg = 10
orientation_deg = 30
aspect = 0.5
direction = "clockwise"
attack_s = 2
sustain_s = 10
decay_s = 3
"#;

fn example() -> MotionPlan {
    MotionPlan::from_toml(EXAMPLE, "plan.toml").unwrap()
}

/// The example with this line in place of that.
fn changed(from: &str, to: &str) -> String {
    assert_eq!(EXAMPLE.matches(from).count(), 1, "{from}");
    EXAMPLE.replace(from, to)
}

/// The changed example is refused at this place, showing this.
fn reject(from: &str, to: &str, place: &str, found: &str) {
    match MotionPlan::from_toml(&changed(from, to), "plan.toml") {
        Err(Error::BadInput(bad)) => {
            assert_eq!((bad.place, bad.found), (format!("plan.toml: {place}"), found.to_owned()));
        }
        other => panic!("{to}: {other:?}"),
    }
}

#[test]
fn a_plan_is_in_si() {
    let plan = example();
    assert_eq!((plan.name.as_str(), plan.seed, plan.hash.len()), ("example", 3, 64));
    assert_eq!(plan.limits, StrokeLimits { stroke: Bounds { min: -6e-3, max: 6e-3 }, stroke_rate: 10e-3 });
    let [one] = plan.trajectories() else { panic!() };
    assert_eq!(one.tendons.angles[1], FRAC_PI_2);
    assert_eq!((one.motion.amplitude, one.motion.frequency), (5e-3, 0.2));
    assert_eq!(one.motion.direction, Direction::Clockwise);
    assert_eq!(one.duration(), 18.0);
    assert_eq!(plan.duration(), 18.0);
    let period = MotionPlan::from_toml(&changed("frequency_hz = 0.2", "period_s = 5"), "").unwrap();
    assert_eq!(period.trajectories()[0].motion, one.motion);
    let half = MotionPlan::from_toml(&changed("scale = 1.0", "scale = 0.5"), "").unwrap();
    assert_eq!(half.trajectories()[0].motion.amplitude, 2.5e-3);
}

#[test]
fn what_is_no_plan_names_its_key() {
    reject("format = \"hysteron-plan\"", "format = \"other\"", "format", "\"other\"");
    reject("version = 1", "version = 2", "version", "2");
    reject("name = \"example\"", "name = \" \"", "name", "\" \"");
    reject("rate_hz = 50", "rate_hz = 0", "rate_hz", "0.0");
    reject("rate_hz = 50", "rate_hz = nan", "rate_hz", "NaN");
    reject("rate_hz = 50", "rate_hz = 0.3", "trajectory.one.frequency_hz", "0.2");
    reject("rate_hz = 50", "rate_hz = 1e6", "rate_hz", "1000000.0");
    reject("scale = 1.0", "scale = -1.0", "scale", "-1.0");
    reject("scale = 1.0", "scale = 1e-320", "trajectory.one.amplitude_mm", "5.0");
    reject("vary = 0.0", "vary = 1.0", "vary", "1.0");
    reject("vary = 0.0", "vary = -0.1", "vary", "-0.1");
    reject("[0, 90, 180, 270]", "[0]", "tendon_angles_deg", "1 of them");
    reject("[0, 90, 180, 270]", "[0, inf]", "tendon_angles_deg[1]", "inf");
    reject("release = 0.9", "release = -0.5", "release", "-0.5");
    reject("co_contraction_mm = 0.5", "co_contraction_mm = -1.0", "co_contraction_mm", "-1.0");
    reject("rest_before_s = 1", "rest_before_s = -1", "rest_before_s", "-1.0");
    reject("rest_before_s = 1", "rest_before_s = 0", "rest_before_s", "0.0");
    reject("rest_after_s = 2", "rest_after_s = 0", "rest_after_s", "0.0");
    reject("stroke_max_mm = 6", "stroke_max_mm = 0", "stroke_max_mm", "0.0");
    reject("stroke_rate_max_mm_s = 10", "stroke_rate_max_mm_s = nan", "stroke_rate_max_mm_s", "NaN");
    reject("seed = 3", "seed = 3\nspeed = 1", "line 6: speed", "`speed`");
    reject("seed = 3", "", "seed", "nothing");
}

#[test]
fn what_is_no_trajectory_names_its_key() {
    reject("name = \"one\"", "name = \"a/b\"", "trajectory[1].name", "\"a/b\"");
    reject("role = \"training\"", "role = \"test\"", "line 19: trajectory[1].role", "\"test\"");
    reject("\"ellipse\"", "\"star\"", "line 20: trajectory[1].family", "\"star\"");
    reject("\"ellipse\"", "\"square\"", "trajectory.one.aspect", "0.5");
    reject("amplitude_mm = 5", "amplitude_mm = -5", "trajectory.one.amplitude_mm", "-5.0");
    reject("amplitude_mm = 5", "amplitude_mm = nan", "trajectory.one.amplitude_mm", "NaN");
    reject("frequency_hz = 0.2", "frequency_hz = 0", "trajectory.one.frequency_hz", "0.0");
    reject("frequency_hz = 0.2", "", "trajectory.one.frequency_hz", "neither");
    reject("frequency_hz = 0.2", "frequency_hz = 1\nperiod_s = 1", "trajectory.one.frequency_hz", "both");
    reject("frequency_hz = 0.2", "period_s = 1e-310", "trajectory.one.period_s", "1e-310");
    reject("phase_deg = 10", "phase_deg = inf", "trajectory.one.phase_deg", "inf");
    reject("orientation_deg = 30", "orientation_deg = nan", "trajectory.one.orientation_deg", "NaN");
    reject("orientation_deg = 30", "", "trajectory.one.orientation_deg", "nothing");
    reject("aspect = 0.5", "", "trajectory.one.aspect", "nothing");
    reject("\"ellipse\"", "\"rose\"", "trajectory.one.aspect", "0.5");
    reject("aspect = 0.5", "aspect = 0.5\nswings = 2", "trajectory.one.swings", "2.0");
    reject("aspect = 0.5", "aspect = 1.5", "trajectory.one.aspect", "1.5");
    reject("aspect = 0.5", "aspect = 0", "trajectory.one.aspect", "0.0");
    reject("\"clockwise\"", "\"left\"", "line 26: trajectory[1].direction", "\"left\"");
    reject("attack_s = 2", "attack_s = 0", "trajectory.one.attack_s", "0.0");
    reject("sustain_s = 10", "sustain_s = -1", "trajectory.one.sustain_s", "-1.0");
    reject("decay_s = 3", "decay_s = 0", "trajectory.one.decay_s", "0.0");
    let of = |family: &str| format!("family = \"{family}\"\namplitude_mm = 5");
    let both = "family = \"ellipse\"\namplitude_mm = 5";
    let without_aspect = |family: &str| EXAMPLE.replace("aspect = 0.5\n", "").replace(both, &of(family));
    for (family, key) in [("circle", "orientation_deg"), ("sinusoid", "direction")] {
        let error = MotionPlan::from_toml(&without_aspect(family), "").unwrap_err();
        assert_eq!(error.bad_input().unwrap().place, format!(": trajectory.one.{key}"));
    }
    // Half a swing in a sample: 0.2 Hz times 125, at 50 Hz. Of the tip, whose speed no limit of the strokes bounds.
    for swings in ["125", "1e308"] {
        let rose =
            EXAMPLE.replace("\"ellipse\"", "\"rose\"").replace("aspect = 0.5", &format!("swings = {swings}"));
        let error = MotionPlan::from_toml(&rose.replace("co_contraction_mm = 0.5", "space = \"tip\""), "")
            .unwrap_err();
        assert_eq!(error.bad_input().unwrap().place, ": trajectory.one.swings", "{error}");
    }
    let twice = format!("{EXAMPLE}{}", &EXAMPLE[EXAMPLE.find("[[").unwrap()..]);
    let error = MotionPlan::from_toml(&twice, "plan.toml").unwrap_err();
    assert_eq!(error.bad_input().unwrap().found, "\"one\" again");
    let none = &EXAMPLE[..EXAMPLE.find("[[").unwrap()];
    assert_eq!(MotionPlan::from_toml(none, "").unwrap_err().bad_input().unwrap().found, "none");
}

#[test]
fn roles_keep_their_amplitudes() {
    let second = |role: &str, amplitude: &str| {
        let table = &EXAMPLE[EXAMPLE.find("[[").unwrap()..];
        let table = table.replace("\"one\"", "\"two\"").replace("training", role);
        format!("{EXAMPLE}{}", table.replace("amplitude_mm = 5", amplitude))
    };
    for (role, amplitude, is_right) in [
        ("validation", "amplitude_mm = 5", true),
        ("validation", "amplitude_mm = 5.1", false),
        ("out_of_range", "amplitude_mm = 5", false),
        ("out_of_range", "amplitude_mm = 5.1", true),
    ] {
        let plan = MotionPlan::from_toml(&second(role, amplitude), "");
        assert_eq!(plan.is_ok(), is_right, "{role} {amplitude}: {plan:?}");
        if let Err(error) = plan {
            assert_eq!(error.bad_input().unwrap().place, ": trajectory.two.amplitude_mm");
        }
    }
}

#[test]
fn every_limit_rejects_with_its_error() {
    let plan = example();
    let limits =
        |min: f64, max: f64, stroke_rate: f64| StrokeLimits { stroke: Bounds { min, max }, stroke_rate };
    assert!(plan.check(&limits(-4.5e-3, 5.5e-3, 8e-3)).is_ok());
    let place = |error: &Error| error.bad_input().unwrap().place.clone();
    match plan.check(&limits(-4.5e-3, 4e-3, 8e-3)) {
        Err(error @ Error::Stroke(_)) => {
            assert!(place(&error).starts_with("trajectory one: t = "), "{error}");
            assert!(place(&error).ends_with("s: stroke 3"), "{error}");
        }
        other => panic!("{other:?}"),
    }
    assert!(matches!(plan.check(&limits(-1e-3, 6e-3, 8e-3)), Err(Error::Stroke(_))));
    assert!(matches!(plan.check(&limits(-6e-3, 6e-3, 2e-3)), Err(Error::StrokeRate(_))));
    assert!(matches!(plan.check(&limits(f64::NAN, f64::NAN, 8e-3)), Err(Error::Stroke(_))));
    // Its own limits are checked when it is read.
    let refused = |from: &str, to: &str| MotionPlan::from_toml(&changed(from, to), "plan.toml").unwrap_err();
    let error = refused("stroke_max_mm = 6", "stroke_max_mm = 3");
    assert!(matches!(&error, Error::Stroke(bad) if bad.place.starts_with("plan.toml: trajectory one")));
    let error = refused("stroke_rate_max_mm_s = 10", "stroke_rate_max_mm_s = 3");
    assert!(
        matches!(&error, Error::StrokeRate(bad) if bad.expected == "a change of at most 3.0 mm/s"),
        "{error}"
    );
}

/// At full size no change of a stroke passes its bound, so that these samples need no look; and no sample of another time is among them.
#[test]
fn samples_at_full_size_are_within_their_bound() {
    let families = [
        ("ellipse", "aspect = 0.5\ndirection = \"clockwise\"\norientation_deg = 30"),
        ("circle", ""),
        ("square", "orientation_deg = 45"),
        ("rose", "swings = 1.7\norientation_deg = 30"),
        ("sinusoid", "orientation_deg = 30"),
    ];
    for (family, keys) in families {
        let text =
            changed("aspect = 0.5\ndirection = \"clockwise\"", "").replace("orientation_deg = 30", keys);
        let text = text
            .replace("\"ellipse\"", &format!("\"{family}\""))
            .replace("_max_mm_s = 10", "_max_mm_s = 100");
        let plan =
            MotionPlan::from_toml(&text, "plan.toml").unwrap_or_else(|error| panic!("{family}: {error}"));
        let one = &plan.trajectories()[0];
        let (bound, samples) = (one.sustained_rate_bound(), one.sustained());
        assert_eq!((samples.start, samples.end), (151, 650), "{family}");
        // Rounding of both strokes is in their difference.
        let (mut largest, mut rounding): (f64, f64) = (0.0, 0.0);
        for i in samples {
            let t = one.time(i - 1) - one.rest_before;
            assert_eq!(one.motion.envelope.at(t), 1.0, "{family}: {t}");
            for (now, before) in one.strokes_at(one.time(i)).iter().zip(one.strokes_at(one.time(i - 1))) {
                largest = largest.max((now - before).abs() * one.rate_hz);
                rounding = rounding.max(16.0 * f64::EPSILON * now.abs().max(before.abs()) * one.rate_hz);
            }
        }
        assert!(largest <= bound + rounding && largest > 0.4 * bound, "{family}: {largest} of {bound}");
    }
}

/// Ten million samples, the most that a plan may have: those at full size are not looked at one by one.
#[test]
fn a_long_plan_that_needs_a_look_gets_one_where_it_grows() {
    // Turning and growing at once would pass 10 mm/s by their bounds; each alone is far from it.
    let text = changed("sustain_s = 10", "sustain_s = 199000").replace("_max_mm_s = 10", "_max_mm_s = 8.5");
    let plan = MotionPlan::from_toml(&text, "plan.toml").unwrap();
    let one = &plan.trajectories()[0];
    assert!(one.stroke_rate_bound() > plan.limits.stroke_rate);
    assert!(one.n_samples() > 9_900_000 && one.sustained().len() > 9_900_000);
    // Where it grows, too fast is too fast.
    let fast = text.replace("attack_s = 2", "attack_s = 0.5");
    assert!(matches!(MotionPlan::from_toml(&fast, "plan.toml"), Err(Error::StrokeRate(_))));
}

#[test]
fn tendons_follow_with_release_and_common_pull() {
    let plan = example();
    let one = &plan.trajectories()[0];
    // In the middle of the sustained part.
    let [a, b] = one.position_at(8.0);
    let expected = [a, b, -a, -b].map(|pull| (if pull < 0.0 { 0.9 * pull } else { pull }) + 0.5e-3);
    for (stroke, expected) in one.strokes_at(8.0).iter().zip(expected) {
        assert!((stroke - expected).abs() < 1e-17, "{stroke} {expected}");
    }
    assert_eq!(one.strokes_at(0.5), [0.0; 4]);
    assert_eq!(one.strokes_at(1.0), [0.5e-3; 4]);
    assert_eq!(one.strokes_at(18.0), [0.0; 4]);
}

#[test]
fn commands_say_where_they_come_from() {
    let plan = example();
    let commands = plan.trajectories()[0].commands().unwrap();
    assert_eq!(commands.n_samples(), 901);
    assert!((commands.rate_hz().unwrap() - 50.0).abs() < 1e-9);
    assert_eq!(commands.strokes().len(), 4);
    let meta = commands.meta();
    assert_eq!(meta.seed, Some(3));
    assert_eq!(meta.source, "plan example, trajectory one");
    assert_eq!(meta.extra["plan.sha256"], plan.hash);
    assert_eq!(meta.extra["plan.role"], "training");
    assert_eq!(meta.extra["plan.family"], "ellipse");
}

#[test]
fn variation_follows_seed_and_name_alone() {
    let text = changed("vary = 0.0", "vary = 0.1");
    let motion = |text: &str, i: usize| MotionPlan::from_toml(text, "").unwrap().trajectories()[i].motion;
    let (plain, varied) = (example().trajectories()[0].motion, motion(&text, 0));
    assert_eq!(motion(&text, 0), varied);
    for (a, b, most) in [
        (plain.amplitude, varied.amplitude, 0.1 * plain.amplitude),
        (plain.frequency, varied.frequency, 0.1 * plain.frequency),
        (plain.orientation, varied.orientation, 0.1 * FRAC_PI_2),
    ] {
        assert!(a != b && (a - b).abs() <= most, "{a} {b}");
    }
    assert_ne!(motion(&text.replace("seed = 3", "seed = 4"), 0), varied);
    let first = text[text.find("[[").unwrap()..].replace("\"one\"", "\"zero\"");
    let longer = text.replacen("[[trajectory]]", &format!("{first}\n[[trajectory]]"), 1);
    assert_eq!(motion(&longer, 1), varied);
    assert_ne!(motion(&longer, 0), varied);
}

#[test]
fn the_plan_of_the_paper_has_its_data_set() {
    let plan = MotionPlan::named("paper").unwrap();
    let of =
        |role: TrajectoryRole| plan.trajectories().iter().filter(move |trajectory| trajectory.role == role);
    let names = |role| of(role).map(|trajectory| trajectory.motion.family.name()).collect::<Vec<_>>();
    for family in ["sinusoid", "circle", "square"] {
        assert_eq!(names(TrajectoryRole::Training).iter().filter(|name| **name == family).count(), 6);
    }
    assert_eq!(names(TrajectoryRole::Validation), ["ellipse", "ellipse"]);
    assert_eq!(names(TrajectoryRole::OutOfRange), ["circle"]);
    let samples: usize = of(TrajectoryRole::Training).map(Trajectory::n_samples).sum();
    assert!((257_500..258_500).contains(&samples), "{samples}"); // "≈ 258k"
    assert!(plan.trajectories().iter().all(|trajectory| trajectory.rate_hz == 100.0));
}

#[test]
fn the_quick_plan_takes_a_minute() {
    let plan = MotionPlan::named("quick").unwrap();
    assert!((50.0..70.0).contains(&plan.duration()), "{}", plan.duration());
    assert_eq!(MotionPlan::names().collect::<Vec<_>>(), ["paper", "quick", "roses", "synthetic"]);
    let error = MotionPlan::named("slow").unwrap_err();
    assert_eq!(error.bad_input().unwrap().expected, "one of paper, quick, roses, synthetic");
}

#[test]
fn the_synthetic_plan_is_that_of_the_paper_and_goes_farther() {
    let plan = MotionPlan::named("synthetic").unwrap();
    let of = |name: &str| plan.trajectories().iter().filter(|one| one.motion.family.name() == name).count();
    assert_eq!((of("circle"), of("ellipse"), of("square")), (8, 9, 8));
    let samples: usize = plan.trajectories().iter().map(Trajectory::n_samples).sum();
    assert!((386_500..387_500).contains(&samples), "{samples}"); // "387k synthetic"
    let farthest =
        |plan: &MotionPlan| plan.trajectories().iter().map(|one| one.motion.amplitude).fold(0.0, f64::max);
    assert!(farthest(&plan) > 1.5 * farthest(&MotionPlan::named("paper").unwrap()));
}

#[test]
fn roses_keep_their_distance_from_what_closes() {
    let plan = MotionPlan::named("roses").unwrap();
    assert_eq!(plan.trajectories().len(), 8);
    for one in plan.trajectories() {
        let Family::Rose { swings } = one.motion.family else { panic!("{:?}", one.motion.family) };
        // A rose of whole swings runs through the same petals again and again.
        assert!((0.4..=1.6).contains(&swings) && (swings - swings.round()).abs() > 1e-3, "{swings}");
    }
}

#[test]
fn a_plan_file_that_is_not_there_is_bad_input() {
    let error = MotionPlan::read("nowhere.toml").unwrap_err();
    assert!(matches!(&error, Error::File(_)) && error.bad_input().is_some(), "{error}");
}

#[test]
fn a_path_of_the_tip_has_no_strokes() {
    reject("seed = 3", "seed = 3\nspace = \"tip\"", "co_contraction_mm", "0.5");
    // Farther than any stroke may go: only the tip does.
    let text = changed("seed = 3", "seed = 3\nspace = \"tip\"").replace("co_contraction_mm = 0.5\n", "");
    let plan =
        MotionPlan::from_toml(&text.replace("amplitude_mm = 5", "amplitude_mm = 20"), "plan.toml").unwrap();
    assert_eq!(plan.space(), Space::Tip);
    let one = &plan.trajectories()[0];
    assert_eq!(one.position_at(one.time(3)), one.motion.position_at(one.time(3) - one.rest_before));
    for error in [one.commands().unwrap_err(), plan.check(&plan.limits).unwrap_err()] {
        assert!(error.to_string().contains("space: expected tendons, got tip"), "{error}");
    }
}

/// Eight trajectories from ranges.
const DRAWN: &str = r#"
[[draw]]
name = "some"
role = "training"
family = "ellipse"
count = 8
amplitude_mm = [1, 5]
period_s = [6, 9]
aspect = [0.4, 0.8]
attack_s = 2
sustain_s = 1
decay_s = 3
"#;

#[test]
fn drawn_trajectories_fill_their_ranges() {
    let plan = |seed: &str| MotionPlan::from_toml(&(changed("seed = 3", seed) + DRAWN), "plan.toml").unwrap();
    let (first, again, other) = (plan("seed = 3"), plan("seed = 3"), plan("seed = 4"));
    assert_eq!(first, again);
    assert_ne!(first.trajectories()[1].motion, other.trajectories()[1].motion);
    let drawn = &first.trajectories()[1..];
    assert_eq!(drawn.len(), 8);
    for (k, one) in drawn.iter().enumerate() {
        assert_eq!(one.name, format!("some-{}", k + 1));
        // One in every eighth of the range.
        let part = 1e3 * one.motion.amplitude - 1.0;
        assert!((0.5 * k as f64..=0.5 * (k + 1) as f64).contains(&part), "{k} {part}");
        let period = one.motion.frequency.recip();
        assert!((6.0..=9.0 + 1e-9).contains(&period), "{period}");
        let Family::Ellipse { aspect } = one.motion.family else { panic!("{:?}", one.motion.family) };
        assert!((0.4..=0.8).contains(&aspect), "{aspect}");
    }
    assert!(drawn.iter().any(|one| one.motion.direction != drawn[0].motion.direction));
}

#[test]
fn a_draw_is_checked() {
    let reject = |from: &str, to: &str, place: &str, found: &str| {
        assert_eq!(DRAWN.matches(from).count(), 1, "{from}");
        match MotionPlan::from_toml(&(EXAMPLE.to_owned() + &DRAWN.replace(from, to)), "plan.toml") {
            Err(Error::BadInput(bad)) => {
                assert_eq!((bad.place, bad.found), (format!("plan.toml: {place}"), found.to_owned()));
            }
            other => panic!("{to}: {other:?}"),
        }
    };
    reject("count = 8", "count = 0", "draw[1].count", "0");
    reject("[1, 5]", "[5, 1]", "draw[1].amplitude_mm", "[5.0, 1.0]");
    reject("[6, 9]", "[0, 9]", "draw[1].period_s", "[0.0, 9.0]");
    reject("aspect =", "orientation_deg = [9, 8]\naspect =", "draw[1].orientation_deg", "[9.0, 8.0]");
    reject("[0.4, 0.8]", "[0.4, inf]", "draw[1].aspect", "[0.4, inf]");
    reject("[0.4, 0.8]", "[1.5, 1.5]", "trajectory.some-1.aspect", "1.5");
    reject("\"some\"", "\"so me\"", "trajectory[2].name", "\"so me-1\"");
}
