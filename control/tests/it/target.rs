//! Facts that hold for any target: where it begins and ends, how fast it runs, and no text that makes a reader
//! panic.

use hysteron_control::TargetPath;
use proptest::prelude::*;
use std::path::Path;

/// Text of a target whose curve is short enough for its rate.
fn target() -> impl Strategy<Value = String> {
    let curve = prop_oneof![
        Just("family = \"circle\"".to_owned()),
        Just("family = \"diamond\"".to_owned()),
        Just("family = \"square\"".to_owned()),
        Just("family = \"figure_eight\"".to_owned()),
        (0.5..4.0_f64).prop_map(|turns| format!("family = \"spiral\"\nturns = {turns:?}")),
        (1..6u32, 5.0..50.0_f64, -180.0..180.0_f64).prop_map(|(n, width, phase)| format!(
            "family = \"lissajous\"\nwidth_mm = {width:?}\ncycles = [{n}, {}]\nphase_deg = {phase:?}",
            n + 1
        )),
    ];
    let times = (50.0..200.0_f64, 1.0..15.0_f64, 0.1..1.0_f64, 0.0..2.0_f64, 0.2..3.0_f64);
    let place = (-30.0..30.0_f64, -30.0..30.0_f64, -180.0..180.0_f64, prop::bool::ANY);
    (curve, 20.0..90.0_f64, times, place).prop_map(|(curve, size, times, place)| {
        let (rate, speed, ramp, rest, lead) = times;
        let (x, y, rotation, is_clockwise) = place;
        let direction = if is_clockwise { "clockwise" } else { "counter_clockwise" };
        format!(
            "format = \"hysteron-target\"\nversion = 1\nname = \"any\"\nrate_hz = {rate:?}\nspeed_mm_s = {speed:?}\n\
             ramp_s = {ramp:?}\nrest_s = {rest:?}\nlead_in_s = {lead:?}\ncentre_mm = [{x:?}, {y:?}]\n\
             rotation_deg = {rotation:?}\ndirection = \"{direction}\"\n\n[curve]\n{curve}\nsize_mm = {size:?}\n"
        )
    })
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}

/// The number after a key.
fn number(text: &str, key: &str) -> f64 {
    let line = text.lines().find_map(|line| line.strip_prefix(&format!("{key} = "))).unwrap();
    line.parse().unwrap()
}

proptest! {
    #[test]
    fn a_target_begins_and_ends_at_rest_and_never_passes_its_speed(text in target()) {
        let target = TargetPath::from_toml(&text, Path::new("")).unwrap();
        let points = target.points();
        prop_assert_eq!((points[0], points[points.len() - 1]), ([0.0; 3], [0.0; 3]));
        let (curve, ends) = (target.curve(), target.outline.length());
        prop_assert!(distance(points[*curve.start()], target.outline.at(0.0)) < 1e-12);
        prop_assert!(distance(points[*curve.end()], target.outline.at(ends)) < 1e-12);
        // A chord is not longer than its curve, up to rounding of the lengths.
        let most = 1e-3 * number(&text, "speed_mm_s") / target.rate_hz;
        let mut length = 0.0;
        for i in *curve.start()..*curve.end() {
            let step = distance(points[i], points[i + 1]);
            prop_assert!(step <= most * (1.0 + 1e-9), "{i}: {step} over {most}");
            length += step;
        }
        prop_assert!(length <= target.outline.length() * (1.0 + 1e-9));
        // Corners are cut by less than a step each, and there are four at most; a sharp turn of a Lissajous curve
        // or a spiral's centre loses less than that.
        prop_assert!(length >= target.outline.length() - 8.0 * most, "{length}");
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in target(), at in any::<prop::sample::Index>(), with in "[\\PC\n]{0,4}") {
        let at = text.char_indices().nth(at.index(text.chars().count())).unwrap().0;
        let _ = TargetPath::from_toml(&format!("{}{with}{}", &text[..at], &text[at..]), Path::new(""));
        let _ = TargetPath::named(&text);
    }

    #[test]
    fn no_drawing_makes_the_reader_panic(d in "[MLHVCSQTAZmlhvcsqtaz0-9 .,-]{0,40}") {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("any.svg");
        std::fs::write(&path, format!("<svg width=\"9mm\" viewBox=\"0 0 9 9\"><path d=\"M1 2 {d}\"/></svg>")).unwrap();
        let _ = TargetPath::open(path.to_str().unwrap());
    }
}
