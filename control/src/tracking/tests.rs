#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::*;
use hysteron_base::{Channel, Metadata};
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

const N: usize = 720;

fn circle(radius: f64, centre: PlanarPoint) -> Vec<PlanarPoint> {
    let angle = |i: usize| TAU * i as f64 / N as f64;
    (0..=N).map(|i| [centre[0] + radius * angle(i).cos(), centre[1] + radius * angle(i).sin()]).collect()
}

fn square(from: PlanarPoint, side: f64) -> Vec<PlanarPoint> {
    let [x, y] = from;
    vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side], [x, y]]
}

/// A recording of the target's own points, each moved, `late` samples late.
fn followed(
    target: &TargetPath,
    late: usize,
    moved: impl Fn(usize, PlanarPoint) -> PlanarPoint,
) -> Recording {
    let n = target.points().len();
    let point = |i: usize| moved(i, plane(target.points()[i.saturating_sub(late)]));
    let channel = |c: usize, name: &str| Channel::new(name, (0..n).map(|i| point(i)[c]).collect());
    let time = (0..n).map(|i| 7.0 + target.time(i)).collect();
    let channels = vec![channel(0, "tip_x_m"), channel(1, "tip_y_m")];
    Recording::new(time, channels, vec![], Metadata::default()).unwrap()
}

fn scored(target: &TargetPath, recording: &Recording) -> TrackingScore {
    score(target, &TrackedTip::new(target, recording, CurvePart::AtTheSameTimes, TipOrigin::Frame).unwrap())
}

#[test]
fn concentric_circles_have_their_closed_forms() {
    let (inner, outer) = (circle(3.0, [0.2, 0.1]), circle(4.0, [0.2, 0.1]));
    // Polygons of one shape: areas as the squares of the radii, to rounding.
    assert!((iou(&inner, &outer).unwrap() - 9.0 / 16.0).abs() < 1e-12);
    // A corner from the other polygon: 1 from its corner, or its side's sagitta 4 (1 - cos(π/720)) nearer.
    let sagitta = 4.0 * (1.0 - (PI / N as f64).cos());
    for found in [hausdorff(&inner, &outer), chamfer(&inner, &outer), frechet(&inner, &outer)] {
        assert!((found - 1.0).abs() <= sagitta, "{found}");
    }
    assert_eq!(nearest([0.2, 0.1], &[[1.0, 0.0]]), [1.0, 0.0]);
}

#[test]
fn shifted_squares_have_their_closed_forms() {
    for shift in [0.0, 0.25, 0.5, 1.0, 3.0] {
        let (a, b) = (square([0.0, 0.0], 1.0), square([shift, 0.0], 1.0));
        let overlap = f64::max(0.0, 1.0 - shift);
        assert!((iou(&a, &b).unwrap() - overlap / (2.0 - overlap)).abs() < 1e-12, "{shift}");
        assert!((hausdorff(&a, &b) - shift).abs() < 1e-12);
        assert!((frechet(&a, &b) - shift).abs() < 1e-12);
    }
    // Of four corners and the first again, two (and the first) are a shift off the other square, two on its sides.
    let (a, b) = (square([0.0, 0.0], 1.0), square([0.25, 0.0], 1.0));
    assert!((chamfer(&a, &b) - 0.5 * (0.25 * 3.0 / 5.0 + 0.25 * 2.0 / 5.0)).abs() < 1e-12);
}

#[test]
fn what_is_gone_around_twice_is_outside() {
    // A bow tie: both lobes count. Its lobes are half of the square's four quarters.
    let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
    assert!((iou(&bow, &square([0.0, 0.0], 1.0)).unwrap() - 0.5).abs() < 1e-12);
    // A square gone around twice encloses nothing; nor does a line.
    let twice = [square([0.0, 0.0], 1.0), square([0.0, 0.0], 1.0)].concat();
    assert_eq!(iou(&twice, &square([0.0, 0.0], 1.0)), Some(0.0));
    assert_eq!(iou(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]], &twice), None);
}

#[test]
fn a_leash_is_longer_than_the_distance_where_a_curve_turns_back() {
    // There and back, against there alone: every point is near, but the walk is not.
    let there: Vec<PlanarPoint> = (0..=10).map(|i| [f64::from(i), 0.0]).collect();
    let back: Vec<PlanarPoint> = (0..=10).chain((0..10).rev()).map(|i| [f64::from(i), 0.0]).collect();
    assert_eq!(hausdorff(&there, &back), 0.0);
    assert_eq!(frechet(&there, &back), 10.0);
}

#[test]
fn a_tip_on_its_target_has_no_error() {
    for named in ["circle:40", "diamond:60", "lissajous:56", "square:30", "figure_eight:50"] {
        let target = TargetPath::named(named).unwrap();
        let found = scored(&target, &followed(&target, 0, |_, p| p));
        // Samples are 0.1 mm apart: corners are cut by at most half of that, 0.05 mm.
        assert!(
            found.rmse_m < 5e-6 && found.hausdorff_m < 5.1e-5 && found.chamfer_m < 5e-6,
            "{named} {found:?}"
        );
        assert!(found.iou.unwrap() > 0.9999, "{named} {found:?}");
        // The recording begins at 7 s: its times are rounded to 1e-15 s.
        assert!(found.frechet_m == 0.0 && found.aligned_rmse_m.unwrap() < 1e-15, "{named} {found:?}");
        assert!(found.lag_s.unwrap().abs() < 1e-6, "{named} {found:?}");
        assert_eq!(found.samples, target.curve().count());
    }
    let open = TargetPath::named("spiral:40").unwrap();
    assert_eq!(scored(&open, &followed(&open, 0, |_, p| p)).iou, None);
}

#[test]
fn a_circle_that_is_too_large_has_the_error_of_its_radius() {
    let target = TargetPath::named("circle:40").unwrap();
    let found = scored(&target, &followed(&target, 0, |_, p| p.map(|c| 1.1 * c)));
    // 2 mm all around: along each axis 2 mm / √2; what chords of 0.11 mm cut off is 0.1 µm.
    assert!((found.rmse_m - 2e-3 * FRAC_1_SQRT_2).abs() < 2e-7, "{found:?}");
    assert!((found.nrmse.unwrap() - 0.05 * FRAC_1_SQRT_2).abs() < 5e-6, "{found:?}");
    assert!((found.iou.unwrap() - 1.0 / 1.21).abs() < 1e-4, "{found:?}");
    for metric in [found.hausdorff_m, found.chamfer_m, found.frechet_m, found.aligned_rmse_m.unwrap()] {
        assert!((metric - 2e-3).abs() < 2e-7, "{found:?}");
    }
}

#[test]
fn a_tip_that_comes_late_is_late_by_its_lag() {
    let target = TargetPath::named("diamond:60").unwrap();
    let found = scored(&target, &followed(&target, 17, |_, p| p));
    assert!((found.lag_s.unwrap() - 0.17).abs() < 1e-3, "{found:?}");
    // 10 mm/s over 0.17 s, less at ramps and corners; the curve itself is the same.
    assert!((1.5e-3..1.7e-3).contains(&found.aligned_rmse_m.unwrap()), "{found:?}");
    assert!(found.rmse_m < 2e-4, "{found:?}");
    // Half a sample: between two tried shifts.
    let between = followed(&target, 0, |i, p| {
        let before = plane(target.points()[i.saturating_sub(1)]);
        [0, 1].map(|c| 0.5 * (p[c] + before[c]))
    });
    assert!((scored(&target, &between).lag_s.unwrap() - 0.005).abs() < 1e-4);
}

#[test]
fn laps_are_polygons_of_their_own() {
    let text = "format = \"hysteron-target\"\nversion = 1\nname = \"two\"\nrate_hz = 100\nspeed_mm_s = 20\nramp_s = 1\n\
                rest_s = 0.5\nlead_in_s = 2\nlaps = 2\n\n[curve]\nfamily = \"circle\"\nsize_mm = 40\n";
    let target = TargetPath::from_toml(text, std::path::Path::new("")).unwrap();
    let second = *target.laps().nth(1).unwrap().start();
    // The first lap right, the second at half size.
    let recording = followed(&target, 0, |i, p| if i > second { p.map(|c| 0.5 * c) } else { p });
    assert!((scored(&target, &recording).iou.unwrap() - 0.5 * (1.0 + 0.25)).abs() < 2e-3);
    let whole = TrackedTip::new(&target, &recording, CurvePart::Whole, TipOrigin::Frame).unwrap();
    assert_eq!(whole.laps.len(), 2);
    assert_eq!(score(&target, &whole).lag_s, None);
}

#[test]
fn what_was_not_measured_and_where_the_robot_stands_do_not_count() {
    let target = TargetPath::named("circle:40").unwrap();
    let plain = followed(&target, 0, |_, p| p);
    let away = followed(&target, 0, |i, p| if i == 900 { [9.0; 2] } else { [p[0] + 0.5, p[1] - 0.25] });
    let mut gap = vec![false; away.n_samples()];
    gap[900] = true;
    let channels = away.channels().to_vec();
    let away = Recording::new(away.time().to_vec(), channels, gap, Metadata::default()).unwrap();
    let tracked = TrackedTip::new(&target, &away, CurvePart::AtTheSameTimes, TipOrigin::Rest).unwrap();
    let (found, expected) = (score(&target, &tracked), scored(&target, &plain));
    assert_eq!(found.samples, expected.samples - 1);
    // Shifts are exact in binary, their sum over the rest to rounding; a chord over the gap cuts off 0.25 µm.
    assert!((found.rmse_m - expected.rmse_m).abs() < 1e-7, "{found:?}");
    assert!((found.hausdorff_m - expected.hausdorff_m).abs() < 3e-7, "{found:?}");
    let bad = TrackedTip::new(&target, &away, CurvePart::AtTheSameTimes, TipOrigin::Frame).unwrap();
    assert!(score(&target, &bad).rmse_m > 0.2);
}

#[test]
fn recordings_that_cannot_be_compared_are_refused() {
    let target = TargetPath::named("circle:40").unwrap();
    let short = |n: usize| {
        let time = (0..n).map(|i| i as f64 / 100.0).collect();
        let zeros = |name: &str| Channel::new(name, vec![0.0; n]);
        Recording::new(time, vec![zeros("tip_x_m"), zeros("tip_y_m")], vec![], Metadata::default()).unwrap()
    };
    let refused = |recording: &Recording, part| {
        TrackedTip::new(&target, recording, part, TipOrigin::Frame).unwrap_err().to_string()
    };
    assert!(refused(&short(500), CurvePart::AtTheSameTimes).contains("--whole"));
    assert!(refused(&short(2), CurvePart::Whole).contains("three measured samples"));
    assert!(TrackedTip::new(&target, &short(3), CurvePart::Whole, TipOrigin::Frame).is_ok());
    let blind = Recording::new(vec![0.0], vec![], vec![], Metadata::default()).unwrap();
    assert!(refused(&blind, CurvePart::Whole).contains("tip_x_m"));
}

#[test]
fn repeats_vary_by_their_deviation_over_their_mean() {
    let target = TargetPath::named("circle:40").unwrap();
    let one = scored(&target, &followed(&target, 0, |_, p| p));
    let scores: Vec<TrackingScore> =
        [1e-3, 2e-3, 3e-3].map(|rmse_m| TrackingScore { rmse_m, iou: None, ..one }).to_vec();
    let found = repeatability(&scores, |score| Some(score.rmse_m)).unwrap();
    assert!((found.mean - 2e-3).abs() < 1e-15 && (found.deviation - 1e-3).abs() < 1e-15);
    assert!((found.variation.unwrap() - 0.5).abs() < 1e-12);
    assert_eq!(repeatability(&scores, |score| score.iou), None);
    assert_eq!(repeatability(&scores[..1], |score| Some(score.rmse_m)), None);
    assert_eq!(repeatability(&scores, |_| Some(0.0)).unwrap().variation, None);
}
