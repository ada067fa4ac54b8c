//! Recordings: quantised as NAD's, labelled as NAD's, the same again.

use std::f64::consts::TAU;

use hysteron_base::{Metadata, Recording};

use super::arm;
use crate::virtual_arm::data_set;

fn recorded(part: &str, seed: u64) -> Recording {
    let arm = arm().individual(2);
    let planned = data_set().into_iter().find(|one| one.name() == part).unwrap();
    arm.record(&planned.trial, seed, &planned.name(), Metadata::default()).unwrap()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, x| x.abs().max(most))
}

#[test]
fn readings_are_whole_steps_of_the_registers() {
    let recording = recorded("weight/pick_place_object_300g/test/001", 1);
    for (name, step) in [
        ("q_2_rad", TAU / 4096.0),
        ("goal_3_rad", TAU / 4096.0),
        ("dq_2_rad_s", 0.02398082392),
        ("current_2_a", 2.69e-3),
        ("voltage_4_v", 0.1),
        ("pwm_2_ratio", 1.0 / 885.0),
    ] {
        let values = recording.channel(name).unwrap();
        let off_grid = values.iter().map(|x| (x / step - (x / step).round()).abs()).fold(0.0, f64::max);
        assert!(off_grid < 1e-6, "{name}: {off_grid}");
        assert!(values.iter().any(|x| *x != values[0]), "{name} changes");
    }
    assert!(recording.channel("temperature_5_degc").unwrap().iter().all(|t| t.fract() == 0.0));
    let time = recording.time();
    let mean = time[time.len() - 1] / (time.len() - 1) as f64;
    assert!((mean - 0.017).abs() < 2e-4, "{mean}");
    let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(recording.rate_hz().is_none(), "it jitters: {}", largest(&steps));
}

#[test]
fn a_lifted_object_is_labelled_with_its_weight_and_nothing_else_is() {
    let recording = recorded("weight/go_up_and_stay_still_500g/test/001", 1);
    assert!(recording.channel("force_x_n").is_none());
    let (force, labelled) =
        (recording.channel("force_z_n").unwrap(), recording.channel("force_z_labelled_ratio").unwrap());
    let truth = recording.channel("truth_force_z_n").unwrap();
    let mut held = 0;
    for ((force, labelled), truth) in force.iter().zip(labelled).zip(truth) {
        if *labelled == 1.0 {
            held += 1;
            assert_eq!(*force, -0.5 * 9.81);
            // Accelerations of the hand stay below a fifth of g.
            assert!((truth - force).abs() < 0.2 * 4.905 + 0.3, "{truth} {force}");
        } else {
            assert_eq!(*force, 0.0);
        }
    }
    assert!(held > force.len() / 3 && held < force.len(), "{held}");
    let free = recorded("force_unlabeled/sweep_2/test/001", 1);
    assert!(free.channel("force_z_n").is_none());
    assert_eq!(largest(free.channel("truth_force_z_n").unwrap()), 0.0);
}

#[test]
fn pushes_are_read_by_a_noisy_sensor_in_their_direction() {
    let pushed = recorded("force_sensor/y_minus/test/001", 1);
    let [read, truth] = ["force_y_n", "truth_force_y_n"].map(|name| pushed.channel(name).unwrap());
    assert!(truth.iter().copied().fold(0.0, f64::min) < -2.0);
    let errors: Vec<f64> = read.iter().zip(truth).map(|(a, b)| a - b).collect();
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    // Noise 0.03 N about an offset of at most three times 0.02 N.
    assert!((0.02..0.08).contains(&rms), "{rms}");
    assert_eq!(pushed.channel("force_y_labelled_ratio").unwrap().iter().copied().fold(1.0, f64::min), 1.0);
    let reference = recorded("force_sensor/y_minus_reference/test/001", 1);
    assert_eq!(largest(reference.channel("truth_force_y_n").unwrap()), 0.0);
}

#[test]
fn a_trajectory_is_the_same_again_and_another_with_another_seed_or_name() {
    let name = "motor_condition/pick_place_200g_degraded/train/001";
    let first = recorded(name, 1);
    assert_eq!(first, recorded(name, 1));
    assert_ne!(first, recorded(name, 2));
    let second = recorded("motor_condition/pick_place_200g_degraded/train/002", 1);
    assert_ne!(first.channel("goal_2_rad"), second.channel("goal_2_rad"));
    assert!(first.meta().extra.contains_key("fault"));
}

#[test]
fn motors_friction_and_forces_explain_the_motion() {
    let recording = recorded("force_sensor/z_minus/test/001", 1);
    let chain = arm().individual(2).chain;
    let column = |stem: &str, k: usize, unit: &str| recording.channel(&format!("{stem}_{k}_{unit}")).unwrap();
    let (mut worst, mut n) = (0.0_f64, 0);
    for row in 1..recording.n_samples() {
        let q: [f64; 4] = std::array::from_fn(|k| column("truth_q", k + 1, "rad")[row]);
        let dq: [f64; 4] = std::array::from_fn(|k| column("truth_dq", k + 1, "rad_s")[row]);
        let before: [f64; 4] = std::array::from_fn(|k| column("truth_dq", k + 1, "rad_s")[row - 1]);
        if dq != [0.0; 4] || before != [0.0; 4] {
            continue;
        }
        n += 1;
        let bias = chain.at(&q, &dq).bias;
        for k in 0..4 {
            let sum = column("truth_motor", k + 1, "n_m")[row] - column("truth_friction", k + 1, "n_m")[row]
                + column("truth_external", k + 1, "n_m")[row];
            worst = worst.max((sum - bias[k]).abs());
        }
    }
    // At rest all torques balance; forces and torques are means over 17 ms of a push that changes by up to 40 N/s at 0.3 m.
    assert!(n > 20 && worst < 40.0 * 0.017 * 0.3, "{n} {worst}");
}
