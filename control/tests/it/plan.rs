//! Facts that hold for any plan: bounds, rest, and no text that makes the reader panic.

use hysteron_control::{Error, MotionPlan, Trajectory};
use proptest::prelude::*;

/// Text of a valid plan of one trajectory whose limits never bind.
fn plan() -> impl Strategy<Value = String> {
    let family = prop_oneof![
        (-180.0..180.0_f64).prop_map(|o| format!("family = \"sinusoid\"\norientation_deg = {o:?}")),
        Just("family = \"circle\"\ndirection = \"clockwise\"".to_owned()),
        (-180.0..180.0_f64).prop_map(|o| format!("family = \"square\"\norientation_deg = {o:?}")),
        (-180.0..180.0_f64, 0.01..1.0_f64).prop_map(|(o, aspect)| format!(
            "family = \"ellipse\"\norientation_deg = {o:?}\naspect = {aspect:?}"
        )),
    ];
    let numbers = (0.1..20.0_f64, 0.01..5.0_f64, -400.0..400.0_f64, 0.1..2.0_f64);
    let times = (0.01..3.0_f64, 0.0..3.0_f64, 0.01..3.0_f64, 0.01..2.0_f64, 0.01..2.0_f64);
    let tendons = (prop::collection::vec(-360.0..360.0_f64, 2..6), 0.0..1.5_f64, 0.0..2.0_f64);
    let rates = (20.0..300.0_f64, any::<u64>(), 0.0..0.5_f64);
    (family, numbers, times, tendons, rates).prop_map(|(family, numbers, times, tendons, rates)| {
        let (amplitude, frequency, phase, scale) = numbers;
        let (attack, sustain, decay, before, after) = times;
        let (angles, release, common) = tendons;
        let (rate, seed, vary) = rates;
        format!(
            "format = \"hysteron-plan\"\nversion = 1\nname = \"any\"\nseed = {}\nrate_hz = {rate:?}\n\
             scale = {scale:?}\nvary = {vary:?}\ntendon_angles_deg = {angles:?}\nrelease = {release:?}\n\
             co_contraction_mm = {common:?}\nrest_before_s = {before:?}\nrest_after_s = {after:?}\n\
             stroke_max_mm = 1e5\nstroke_rate_max_mm_s = 1e5\n\n[[trajectory]]\nname = \"one\"\n\
             role = \"training\"\n{family}\namplitude_mm = {amplitude:?}\nfrequency_hz = {frequency:?}\n\
             phase_deg = {phase:?}\nattack_s = {attack:?}\nsustain_s = {sustain:?}\ndecay_s = {decay:?}\n",
            seed >> 1, // TOML has signed numbers
        )
    })
}

fn one(text: &str) -> Trajectory {
    MotionPlan::from_toml(text, "any").unwrap().trajectories()[0].clone()
}

proptest! {
    #[test]
    fn strokes_stay_within_amplitude_and_common_pull_and_end_at_rest(text in plan()) {
        let trajectory = one(&text);
        let commands = trajectory.commands().unwrap();
        let (amplitude, tendons) = (trajectory.motion.amplitude, &trajectory.tendons);
        prop_assert!(commands.time()[commands.n_samples() - 1] >= trajectory.duration() - 1e-6);
        for strokes in commands.strokes() {
            prop_assert_eq!((strokes[0], strokes[strokes.len() - 1]), (0.0, 0.0));
            for stroke in strokes {
                prop_assert!(*stroke <= amplitude * (1.0 + 1e-12) + tendons.co_contraction);
                prop_assert!(*stroke >= -tendons.release * amplitude * (1.0 + 1e-12));
            }
        }
    }

    #[test]
    fn no_change_between_samples_passes_the_bound(text in plan()) {
        let trajectory = one(&text);
        let commands = trajectory.commands().unwrap();
        let bound = trajectory.stroke_rate_bound();
        for strokes in commands.strokes() {
            for pair in strokes.windows(2) {
                let rate = (pair[1] - pair[0]).abs() * trajectory.rate_hz;
                prop_assert!(rate <= bound * (1.0 + 1e-9), "{rate} {bound}");
            }
        }
    }

    #[test]
    fn the_check_finds_what_the_samples_show(text in plan()) {
        let plan = MotionPlan::from_toml(&text, "any").unwrap();
        let trajectory = &plan.trajectories()[0];
        let commands = trajectory.commands().unwrap();
        let strokes = commands.strokes();
        let largest = strokes.iter().flat_map(|s| s.iter()).fold(0.0_f64, |a, b| a.max(b.abs()));
        let steps = strokes.iter().flat_map(|s| s.windows(2)).map(|pair| (pair[1] - pair[0]).abs());
        let fastest = steps.fold(0.0, f64::max) * trajectory.rate_hz;
        let mut limits = plan.limits;
        let mut check = |stroke: f64, rate: f64| {
            (limits.stroke.min, limits.stroke.max, limits.stroke_rate) = (-stroke, stroke, rate);
            plan.check(&limits)
        };
        prop_assert!(check(largest, fastest).is_ok());
        let is_stroke = matches!(check(0.999 * largest, fastest), Err(Error::Stroke(_)));
        prop_assert!(largest == 0.0 || is_stroke);
        let is_rate = matches!(check(largest, 0.999 * fastest), Err(Error::StrokeRate(_)));
        prop_assert!(fastest == 0.0 || is_rate);
    }

    #[test]
    fn equal_text_gives_equal_commands(text in plan()) {
        prop_assert_eq!(one(&text).commands().unwrap(), one(&text).commands().unwrap());
    }

    #[test]
    fn no_damage_to_a_plan_makes_the_reader_panic(
        text in plan(),
        damage in prop::collection::vec(
            (any::<prop::sample::Index>(), 0..12_usize, "[-+=\\[\\]\"\n.0-9a-z#µ]{0,3}|inf|nan|-|e9|e308|e-320"),
            1..4,
        ),
    ) {
        let mut text: Vec<char> = text.chars().collect();
        for (at, length, new) in damage {
            let at = at.index(text.len() + 1);
            let end = (at + length).min(text.len());
            text.splice(at..end, new.chars());
        }
        let text: String = text.into_iter().collect();
        match MotionPlan::from_toml(&text, "any.toml") {
            Ok(plan) => prop_assert!(plan.trajectories()[0].n_samples() > 0),
            Err(error) => prop_assert!(error.bad_input().unwrap().place.starts_with("any.toml")),
        }
    }

    #[test]
    fn no_text_makes_the_reader_panic(
        text in "(\\[\\[trajectory\\]\\]|name|seed|rate_hz|=|\"|\n|[0-9]|\\.|,|#|µ|\\{|\\}|\\[|\\]){0,40}",
    ) {
        let error = MotionPlan::from_toml(&text, "any.toml").unwrap_err();
        prop_assert!(error.bad_input().unwrap().place.starts_with("any.toml"));
    }
}
