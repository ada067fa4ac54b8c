#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::*;
use crate::Quality;
use hysteron_base::rng;
use rand::{Rng, RngExt};

/// Rounding of points of a metre [m].
const ROUNDING: f64 = 1e-14;

fn normal(random: &mut impl Rng) -> f64 {
    let (u, v): (f64, f64) = (random.random(), random.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

fn random_registration(random: &mut impl Rng) -> Registration {
    let q: [f64; 4] = std::array::from_fn(|_| normal(random));
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    Registration::new(q.map(|x| x / length), std::array::from_fn(|_| 0.3 * normal(random))).unwrap()
}

fn random_points(random: &mut impl Rng, n: usize) -> Vec<[f64; 3]> {
    (0..n).map(|_| std::array::from_fn(|_| random.random_range(-0.1..0.1))).collect()
}

fn apply(registration: &Registration, points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    points.iter().map(|&point| registration.apply_to_point(point)).collect()
}

fn of_four_tendons(displacements: &[[f64; 3]; 4]) -> Vec<PulledMotion> {
    let angles = [0.0, 1.0, 2.0, 3.0].map(|k| k * std::f64::consts::FRAC_PI_2);
    PulledMotion::of_tendons(displacements, &angles)
}

#[test]
fn points_without_noise_are_brought_together_exactly() {
    let mut random = rng(1, "exact");
    for k in 0..200 {
        let truth = random_registration(&mut random);
        let mut points = random_points(&mut random, 3 + k % 5);
        if k % 2 == 0 {
            points.iter_mut().for_each(|point| point[2] = 0.01); // in a plane
        }
        let result = Registration::from_points(&points, &apply(&truth, &points));
        let Ok((found, error)) = result else {
            // Three random points may nearly be on a line.
            assert!(points.len() == 3, "{result:?}");
            continue;
        };
        assert!(error < ROUNDING, "{k}: {error}");
        // The width of the points is at least 2 % of 0.1 m.
        assert!(found.angle_to(&truth) < 1e-7, "{k}: {}", found.angle_to(&truth));
        for point in &points {
            let (a, b) = (found.apply_to_point(*point), truth.apply_to_point(*point));
            assert!((0..3).all(|i| (a[i] - b[i]).abs() < 10.0 * ROUNDING));
        }
    }
}

#[test]
fn residual_and_error_follow_the_noise() {
    // Fitzpatrick (1998): E[FRE²] = (1 - 2/n) 3 σ², and the error at the centre is 3 σ²/n, squared.
    const N: usize = 8;
    const RUNS: usize = 2000;
    for sigma in [1e-5, 1e-4, 1e-3] {
        let mut random = rng(1, "noise");
        let (mut left, mut missed) = (0.0, 0.0);
        for _ in 0..RUNS {
            let truth = random_registration(&mut random);
            let points = random_points(&mut random, N);
            let mut there = apply(&truth, &points);
            there.iter_mut().flatten().for_each(|x| *x += sigma * normal(&mut random));
            let (found, error) = Registration::from_points(&points, &there).unwrap();
            left += error * error;
            let centre: [f64; 3] =
                std::array::from_fn(|k| points.iter().map(|p| p[k]).sum::<f64>() / N as f64);
            let (a, b) = (found.apply_to_point(centre), truth.apply_to_point(centre));
            missed += (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>();
        }
        let n = N as f64;
        let expected_left = (1.0 - 2.0 / n) * 3.0 * sigma * sigma;
        let expected_missed = 3.0 * sigma * sigma / n;
        // Chi-square with 18 and 3 degrees of freedom over 2000 runs: deviation sqrt(2 / (dof RUNS)), five of them.
        let bound = |dof: f64| 5.0 * (2.0 / (dof * RUNS as f64)).sqrt();
        assert!((left / RUNS as f64 / expected_left - 1.0).abs() < bound(18.0));
        assert!((missed / RUNS as f64 / expected_missed - 1.0).abs() < bound(3.0));
    }
}

#[test]
fn points_that_fix_no_rotation_are_refused() {
    let found = |p: &[[f64; 3]], q: &[[f64; 3]]| Registration::from_points(p, q).unwrap_err();
    let line: Vec<[f64; 3]> = (0..5).map(|k| [0.01 * f64::from(k), 0.02 * f64::from(k), 0.0]).collect();
    assert_eq!(found(&line, &line).expected, "points that do not lie on a line");
    let same = [[0.1, 0.2, 0.3]; 4];
    assert_eq!(found(&same, &same).expected, "points that do not lie on a line");
    assert!(found(&line[..2], &line[..2]).expected.starts_with("3 or more"));
    assert_eq!(found(&line[..4], &line).found, "4 and 5");
    let points = random_points(&mut rng(1, "units"), 6);
    let in_mm: Vec<[f64; 3]> = points.iter().map(|p| p.map(|x| x * 1e3)).collect();
    assert!(found(&in_mm, &points).hint.contains("unit"));
    let mut nan = points.clone();
    nan[2][1] = f64::NAN;
    assert!(found(&nan, &points).place.ends_with("pair 3"));
    let mut swapped = points.clone();
    swapped.rotate_left(2);
    assert!(found(&swapped, &points).hint.contains("order"));
}

#[test]
fn mirrored_points_are_refused_and_noisy_flat_ones_are_not() {
    let mut random = rng(1, "mirror");
    for _ in 0..200 {
        let truth = random_registration(&mut random);
        let points = random_points(&mut random, 6);
        let mut there = apply(&truth, &points);
        there.iter_mut().flatten().for_each(|x| *x += 1e-4 * normal(&mut random));
        assert!(Registration::from_points(&points, &there).is_ok());
        there.iter_mut().for_each(|point| point[1] = -point[1]);
        let bad = Registration::from_points(&points, &there).unwrap_err();
        assert!(bad.found.starts_with("a mirror image"), "{bad}");

        let flat: Vec<[f64; 3]> = points.iter().map(|p| [p[0], p[1], 0.0]).collect();
        let mut there = apply(&truth, &flat);
        there.iter_mut().flatten().for_each(|x| *x += 5e-4 * normal(&mut random));
        assert!(Registration::from_points(&flat, &there).is_ok());
    }
}

/// Displacements of the tip in the robot's frame: tendon k bends by 20 mm and shortens by 3 mm.
const BENDS: [[f64; 3]; 4] =
    [[0.02, 0.0, -0.003], [0.0, 0.02, -0.003], [-0.02, 0.0, -0.003], [0.0, -0.02, -0.003]];

/// The same in the tracker's frame.
fn bends_in_tracker(truth: &Registration, bends: [[f64; 3]; 4]) -> [[f64; 3]; 4] {
    bends.map(|d| (truth.rotation.inverse() * Vector3::from(d)).into())
}

#[test]
fn motions_of_four_tendons_give_the_frame() {
    let mut random = rng(1, "motions");
    for _ in 0..200 {
        let truth = random_registration(&mut random);
        let rest = [0.01, -0.02, 0.3];
        let mut bends = bends_in_tracker(&truth, BENDS);
        let motions = of_four_tendons(&bends);
        let rest_there = truth.apply_to_point(rest);
        let (found, error) = Registration::from_motions(&motions, rest, rest_there).unwrap();
        assert!(error < 1e-7 && found.angle_to(&truth) < 1e-7, "{error}");
        let at = found.apply_to_point(rest);
        assert!((0..3).all(|k| (at[k] - rest_there[k]).abs() < ROUNDING));

        // Two are enough, if no mirror image has to be excluded.
        assert!(Registration::from_motions(&motions[..2], rest, rest_there).is_ok());

        // 0.2 mm of noise on each end of 40 mm.
        bends.iter_mut().flatten().for_each(|x| *x += 2e-4 * normal(&mut random));
        let motions = of_four_tendons(&bends);
        let (found, _) = Registration::from_motions(&motions, rest, rest_there).unwrap();
        // sqrt(2) · 0.2 mm / 40 mm per axis, five deviations.
        assert!(found.angle_to(&truth) < 5.0 * 2e-4 * 2.0_f64.sqrt() / 0.04 * 3.0_f64.sqrt());
    }
}

#[test]
fn motions_that_no_rotation_explains_are_refused() {
    let truth = random_registration(&mut rng(1, "motions/bad"));
    let bad = |bends: [[f64; 3]; 4]| {
        let motions = of_four_tendons(&bends_in_tracker(&truth, bends));
        Registration::from_motions(&motions, [0.0; 3], [0.0; 3]).unwrap_err()
    };
    let [d1, d2, d3, d4] = BENDS;
    assert_eq!(bad([d1, d4, d3, d2]).found, "a mirror image");
    assert_eq!(bad([d2, d1, d4, d3]).hint, "the tendons may be numbered the other way round");
    let same = of_four_tendons(&bends_in_tracker(&truth, [d1, d1, d3, d3]));
    let refusal = Registration::from_motions(&same[..2], [0.0; 3], [0.0; 3]).unwrap_err();
    assert!(refusal.found.contains("parallel"));
    let skew = [0.02 * 0.5, 0.02 * 0.866, -0.003];
    let back = [-skew[0], -skew[1], skew[2]];
    let skew_more = [0.02 * 0.866, 0.01, -0.003];
    let back_more = [-skew_more[0], -skew_more[1], -0.003];
    let [a, b] = [[d1, skew, d3, back], [d1, skew_more, d3, back_more]];
    // 60° in place of 90° leaves 15°, 30° more.
    let motions = |bends| of_four_tendons(&bends_in_tracker(&truth, bends));
    assert!(Registration::from_motions(&motions(a), [0.0; 3], [0.0; 3]).unwrap().1 > 0.2);
    assert!(bad(b).expected.contains("within 15 deg"));
    let still = [[0.0; 3]; 4];
    assert!(bad(still).place.ends_with("motion 1"));
}

#[test]
fn poses_turn_with_the_frame() {
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let quarter_about_z = Registration::new([h, 0.0, 0.0, h], [1.0, 0.0, 0.0]).unwrap();
    let pose =
        Pose { time: 2.0, position: [0.1, 0.2, 0.3], orientation: [h, 0.0, 0.0, h], quality: Quality::Jump };
    let there = quarter_about_z.apply(&pose);
    assert_eq!((there.time, there.quality), (2.0, Quality::Jump));
    assert!((0..3).all(|k| (there.position[k] - [0.8, 0.1, 0.3][k]).abs() < 1e-15));
    assert!((0..4).all(|k| (there.orientation[k] - [0.0, 0.0, 0.0, 1.0][k]).abs() < 1e-15));
    assert_eq!(Registration::identity().apply(&pose), pose);
}

#[test]
fn files_must_hold_a_rotation() {
    for rotation in [[1.0, 0.0, 0.0, 2e-3], [f64::NAN, 0.0, 0.0, 0.0]] {
        let bad = Registration::new(rotation, [0.0; 3]).unwrap_err();
        assert_eq!(bad.place, "registration rotation", "{rotation:?}");
    }
    let bad = Registration::new([1.0, 0.0, 0.0, 0.0], [f64::INFINITY, 0.0, 0.0]).unwrap_err();
    assert_eq!(bad.place, "registration translation");
}
