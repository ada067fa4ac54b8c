//! Tables of dynamics and simulated motions as recordings.

use hysteron_arm_dynamics::*;
use hysteron_arm_estimation::*;
use hysteron_base::{Channel, Metadata, Recording};
use serde_json::Value;

use hysteron_arm_fixtures::robots::{assert_close, model, reference, robot_file};

fn recording(channels: Vec<(String, Vec<f64>)>) -> Recording {
    let n = channels[0].1.len();
    let time = (0..n).map(|i| 0.01 * i as f64).collect();
    let channels = channels.into_iter().map(|(name, values)| Channel::new(name, values)).collect();
    Recording::new(time, channels, Vec::new(), Metadata::default()).unwrap()
}

/// Torques of viscous damping at speeds `dq`.
fn damping(model: &Model, dq: &[f64]) -> Vec<f64> {
    model.joints().iter().zip(dq).map(|(joint, dq)| joint.drive.damping * dq).collect()
}

/// The reference states of the Panda, with accelerations or with the torques of drives that damping takes its part of.
fn states(given: JointQuantityKind) -> (Model, Recording) {
    let (model, reference) = (model("panda"), reference("panda"));
    let mut channels = Vec::new();
    let driven: Vec<Vec<f64>> = reference
        .states
        .iter()
        .map(|s| s.tau.iter().zip(damping(&model, &s.v)).map(|(tau, damped)| tau + damped).collect())
        .collect();
    for (quantity, rows) in [
        (JointQuantityKind::Position, reference.states.iter().map(|s| &s.q).collect::<Vec<_>>()),
        (JointQuantityKind::Velocity, reference.states.iter().map(|s| &s.v).collect()),
        (
            given,
            match given {
                JointQuantityKind::Torque => driven.iter().collect(),
                _ => reference.states.iter().map(|s| &s.a).collect(),
            },
        ),
    ] {
        for joint in 0..model.n_joints() {
            channels
                .push((channel_name(&model, quantity, joint), rows.iter().map(|row| row[joint]).collect()));
        }
    }
    (model, recording(channels))
}

#[test]
fn a_table_holds_what_the_reference_holds() {
    let reference = reference("panda");
    for (given, result) in [
        (JointQuantityKind::Acceleration, JointQuantityKind::Torque),
        (JointQuantityKind::Torque, JointQuantityKind::Acceleration),
    ] {
        let (model, states) = states(given);
        let frame = model.frame(&reference.tip_frame).unwrap();
        let table = dynamics_of_rows(
            &model,
            &states,
            DynamicsOutput { frame, derivatives: true },
            Metadata::default(),
        )
        .unwrap();
        let rows = joint_rows(&model, &table, result).unwrap().unwrap();
        for (s, (state, row)) in reference.states.iter().zip(rows.chunks(9)).enumerate() {
            let expected = if result == JointQuantityKind::Torque {
                &state.inverse_dynamics
            } else {
                &state.forward_dynamics
            };
            // The reference has no damping; torques of drives have it.
            let damped = damping(&model, &state.v);
            let row: Vec<f64> = match result {
                JointQuantityKind::Torque => {
                    row.iter().zip(&damped).map(|(tau, damped)| tau - damped).collect()
                }
                _ => row.to_vec(),
            };
            assert_close("result", &row, expected, 1e-9);
            let column = table.require("damping_2_n_m").unwrap()[s];
            assert!(column == damped[1] && column != 0.0);
            let mass = table.require("mass_2_3_kg_m2").unwrap()[s];
            assert!((mass - state.mass_matrix[1][2]).abs() < 1e-9);
            let x = table.require("frame_x_m").unwrap()[s];
            assert!((x - state.tip_in_world[0][3]).abs() < 1e-9);
            let speed = table.require("jacobian_vy_4_m").unwrap()[s];
            assert!((speed - state.tip_jacobian_world_aligned[1][3]).abs() < 1e-9);
        }
        assert_eq!(table.meta().extra["joint_names"].split(", ").count(), 9);
        if result == JointQuantityKind::Acceleration {
            for (s, state) in reference.states.iter().enumerate() {
                // A joint that turns by one that slides, and the other way round; the whole of it is tested with the algorithms.
                for (name, expected) in [
                    ("ddq_2_by_q_8_rad_s2_per_m", state.d_fd_dq[1][7]),
                    (
                        "ddq_8_by_dq_2_m_s_per_rad",
                        state.d_fd_dv[7][1] - state.d_fd_dtau[7][1] * model.joints()[1].drive.damping,
                    ),
                    ("ddq_9_by_tau_1_m_s2_per_n_m", state.d_fd_dtau[8][0]),
                ] {
                    assert_close(name, &[table.require(name).unwrap()[s]], &[expected], 1e-9);
                }
            }
        } else {
            for (s, state) in reference.states.iter().enumerate() {
                // The reference's derivatives are at the accelerations of forward dynamics, and those by q̇ do not depend on them.
                let slope = table.require("tau_8_by_dq_1_n_s_per_rad").unwrap()[s];
                assert_close("tau_8_by_dq_1", &[slope], &[state.d_id_dv[7][0]], 1e-9);
            }
            assert!(table.require("tau_8_by_q_1_n_per_rad").is_ok());
            let bad = table.require("ddq_1_by_q_1_rad_s2_per_rad").unwrap_err();
            assert_eq!(bad.expected, "a channel ddq_1_by_q_1_rad_s2_per_rad");
        }
    }
}

#[test]
fn states_that_do_not_fit_are_refused() {
    let (model, states) = states(JointQuantityKind::Torque);
    let without = |name: &str| {
        let kept = states.channels().iter().filter(|channel| !channel.name.starts_with(name));
        recording(kept.map(|channel| (channel.name.clone(), channel.values.clone())).collect())
    };
    let with = |name: &str| {
        let mut all: Vec<_> = states.channels().iter().map(|c| (c.name.clone(), c.values.clone())).collect();
        all.push((name.to_owned(), vec![0.0; states.n_samples()]));
        recording(all)
    };
    for (states, expected) in [
        (without("q_"), "q_1_rad"),
        (without("dq_3"), "dq_3_rad_s"),
        (without("tau_"), "neither"),
        (with("q_10_m"), "9 joints, as \"panda\" has"),
    ] {
        let error = dynamics_of_rows(
            &model,
            &states,
            DynamicsOutput { frame: 0, derivatives: false },
            Metadata::default(),
        )
        .unwrap_err()
        .to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}

#[test]
fn a_motion_under_the_torques_of_gravity_stays_at_rest() {
    let model = model("three_link");
    let start = [0.3, -0.4, 0.5];
    let mut weight = [0.0; 3];
    gravity_torque(&model, &mut Data::new(&model, 0.0), &start, &mut weight);
    let channels =
        (0..3).map(|j| (channel_name(&model, JointQuantityKind::Torque, j), vec![weight[j]; 50])).collect();
    let torques = recording(channels);
    let motion = motion_under_torques(&model, &torques, &start, 4, Metadata::default()).unwrap();
    let q = joint_rows(&model, &motion, JointQuantityKind::Position).unwrap().unwrap();
    // An equilibrium that is unstable: rounding grows, little in half a second.
    assert_close("coordinates", &q[3 * 49..], &start, 1e-9);
    for start in [&start[..2], &[0.0, f64::NAN, 0.0]] {
        let bad = motion_under_torques(&model, &torques, start, 4, Metadata::default()).unwrap_err();
        assert_eq!(bad.place, "start", "{start:?}");
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        other => vec![other.as_f64().unwrap()],
    }
}

/// Torques and their derivatives as a table has them, in SI and in the millimetres of CSV.
#[test]
fn torques_and_derivatives_are_those_of_pinocchio_in_every_unit() {
    let expected: Value = hysteron_base::json::from_text(robot_file("urdf.json")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for name in ["hinge_slide.urdf", "massless_between.urdf"] {
        let model =
            Model::from_text_with(&robot_file(name), "r.urdf", None, &ReadOptions::default()).unwrap();
        let rows = expected[name]["rows"].as_array().unwrap();
        let column = |key: &str, joint: usize| rows.iter().map(|row| numbers(&row[key])[joint]).collect();
        let channels = [
            (JointQuantityKind::Position, "q"),
            (JointQuantityKind::Velocity, "dq"),
            (JointQuantityKind::Acceleration, "ddq"),
        ]
        .iter()
        .flat_map(|(quantity, key)| {
            (0..2)
                .map(|j| Channel::new(channel_name(&model, *quantity, j), column(key, j)))
                .collect::<Vec<_>>()
        })
        .collect();
        let time = (0..rows.len()).map(|k| k as f64).collect();
        let states = Recording::new(time, channels, Vec::new(), Metadata::default()).unwrap();
        let output = DynamicsOutput { frame: 0, derivatives: true };
        let table = dynamics_of_rows(&model, &states, output, Metadata::default()).unwrap();
        assert_eq!(table.channels().len() + 2, columns_of_dynamics(2, true, true));
        let [csv, parquet] = ["csv", "parquet"].map(|ending| folder.path().join(format!("{name}.{ending}")));
        table.write(&csv).unwrap();
        table.write(&parquet).unwrap();
        let mut lines = std::fs::read_to_string(&csv).unwrap();
        lines = lines.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join("\n");
        let header: Vec<&str> = lines.lines().next().unwrap().split(',').collect();
        let is_prismatic = |j: usize| model.joints()[j].kind == JointKind::Prismatic;
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let torque = if is_prismatic(i) { "n" } else { "n_m" };
            let [si, typed] = if is_prismatic(j) { ["m", "mm"] } else { ["rad", "rad"] };
            let stem = format!("tau_{}_by_q_{}_{torque}_per", i + 1, j + 1);
            let slopes: Vec<f64> = rows.iter().map(|row| numbers(&row["dtau_dq"])[2 * i + j]).collect();
            for file in [&csv, &parquet] {
                let back = Recording::read(file).unwrap();
                let found = back.require(&format!("{stem}_{si}")).unwrap().to_vec();
                assert!(found.iter().zip(&slopes).all(|(a, b)| (a - b).abs() < 1e-12), "{name}: {stem}");
            }
            let at = header.iter().position(|column| *column == format!("{stem}_{typed}")).unwrap();
            for (line, slope) in lines.lines().skip(1).zip(&slopes) {
                let shown: f64 = line.split(',').nth(at).unwrap().parse().unwrap();
                let scale = if is_prismatic(j) { 1e-3 } else { 1.0 };
                assert!((shown - scale * slope).abs() < 1e-12, "{stem}_{typed}: {shown}");
            }
        }
        for joint in 0..2 {
            let tau = table.require(&channel_name(&model, JointQuantityKind::Torque, joint)).unwrap();
            let expected: Vec<f64> = column("tau", joint);
            assert_close(name, tau, &expected, 1e-12);
        }
    }
}
