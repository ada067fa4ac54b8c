//! Tests for contacts compared with closed forms.

use hysteron_arm_estimation::detection::*;
use rand::RngExt;

#[test]
fn cumulated_sum_finds_a_shift_after_the_time_that_its_size_implies() {
    let free = FreeMotion { mean: vec![0.5], deviation: vec![0.2], largest: vec![1.0] };
    for sign in [1.0, -1.0] {
        let mut test = Cusum::new(free.clone(), 0.5, &[10.0]);
        // z = 2: 1.5 a sample, above 10 with the seventh.
        let values: Vec<f64> = (0..8).map(|_| test.update(&[0.5 + sign * 0.4])).collect();
        assert_eq!(values.iter().position(|v| *v > 1.0), Some(6));
        assert_eq!(test.joint(), Some(0));
        for _ in 0..100 {
            test.update(&[0.5 + sign * 0.4]);
        }
        // Capped at twice the limit, it is gone 0.5 a sample later.
        let back = (0..100).position(|_| test.update(&[0.5]) == 0.0);
        assert!(back.is_some_and(|n| n < 45), "{back:?}");
    }
}

#[test]
fn learned_tests_are_silent_on_what_they_were_learned_from() {
    let mut random = hysteron_base::rng(2, "free");
    let rows: Vec<f64> = (0..3000).map(|k| f64::from(k % 3) + random.random_range(-0.3..0.3)).collect();
    let free = FreeMotion::learn(&rows, 3);
    assert!((free.mean[2] - 2.0).abs() < 0.02 && (free.deviation[1] - 0.6 / 12f64.sqrt()).abs() < 0.01);
    let mut tests: [Box<dyn Test>; 2] = [
        Box::new(Band::learned(&free, 1.0 + 1e-9)),
        Box::new(Cusum::learned(free.clone(), 0.5, &rows, 1.0 + 1e-9)),
    ];
    for test in &mut tests {
        assert!(rows.chunks(3).all(|row| test.update(row) <= 1.0));
        test.reset();
        assert_eq!(test.joint(), None);
        for _ in 0..50 {
            test.update(&[0.9, 2.4, 2.0]);
        }
        assert_eq!(test.joint(), Some(1), "the outermost that is loaded");
    }
}

#[test]
fn alarm_stays_on_until_well_below() {
    let mut alarm = Alarm::new(0.6);
    let states: Vec<bool> = [0.9, 1.1, 0.8, 0.7, 0.5, 0.9].map(|x| alarm.update(x)).to_vec();
    assert_eq!(states, [false, true, true, true, false, false]);
}

#[test]
fn assessment_counts_delays_and_false_alarms() {
    let mut values = vec![0.0; 3600];
    values[100] = 2.0; // false
    values[1003..1010].fill(2.0); // contact 1000..1020, found after 3
    values[1022] = 2.0; // settling
    values[3000] = 1.5; // false
    let truth = Truth { contacts: vec![1000..1020, 2000..2020], settling: 5, period: 1.0 };
    let found = assess(&values, 1.0, 0.5, &truth);
    assert_eq!((found.recall, found.delay_samples, found.false_alarms), (0.5, [3.0, 3.0], 2));
    let hours = (3600.0 - 50.0) / 3600.0;
    assert!((found.false_alarms_per_hour - 2.0 / hours).abs() < 1e-12);
    let curve = roc(&values, &[1.0, 1.7, 3.0], 0.5, &truth);
    assert_eq!(curve.iter().map(|at| at.false_alarms).collect::<Vec<_>>(), [2, 1, 0]);
    assert_eq!(curve.iter().map(|at| at.recall).collect::<Vec<_>>(), [0.5, 0.5, 0.0]);
    let thresholds = logarithmic(0.1, 10.0, 3);
    assert!(thresholds.iter().zip([0.1, 1.0, 10.0]).all(|(a, b)| (a / b - 1.0).abs() < 1e-12));
}
