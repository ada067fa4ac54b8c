//! Drives identified by rollout: parameters that are known come back, and recordings of a real servo are met.

use hysteron_actuator::identify::{
    DriveFitOptions, FrictionMethod, Pendulum, PendulumRun, identify_drive, identify_friction,
    identify_friction_by, mean_error, rollout,
};
use hysteron_actuator::law::{JointFriction, Law, Sliding};
use hysteron_actuator::{Drive, Gear, LoopSpec, Motor, Supply, Winding};
use hysteron_base::json;
use hysteron_fit::IdentifiedParameter;
use hysteron_fuzz::recorded;
use rand::RngExt;
use rayon::prelude::*;
use serde_json::Value;

const LOOP: LoopSpec = LoopSpec { gains: [256.0, 65536.0, 16.0], ..LoopSpec::XL430 };

fn options<'a>(quantities: &'a [&'a str]) -> DriveFitOptions<'a> {
    DriveFitOptions { quantities, longest_step: 2e-3, huber: 0.03, starts: &[0.1], watch: &|_, _| true }
}

fn drive(law: &str, friction: Vec<f64>) -> Drive {
    let law = Law::named(law).unwrap();
    assert_eq!(law.parameters().len(), friction.len());
    Drive {
        motor: Motor { current_limit: 1.75, ..Motor::new(0.36, 3.4, 7.3) },
        supply: Supply { voltage: 7.3, resistance: 0.5 },
        winding: Winding { resistance_slope: 0.0, ..Winding::COLD },
        gear: Gear { armature: 0.002, backlash: 0.0, law, friction },
        position_loop: LOOP,
    }
}

/// Sines of growing size for 3 s, in the manner of bam.
fn run(gain: f64) -> PendulumRun {
    let time: Vec<f64> = (0..600).map(|k| 5e-3 * f64::from(k)).collect();
    let goal = time.iter().map(|t| 1.2 * (3.0 * t).sin() + 0.5 * (7.0 * t).sin()).collect();
    PendulumRun {
        name: format!("gain {gain}"),
        goal,
        position: vec![0.0; time.len()],
        torque_on: vec![true; time.len()],
        time,
        temperature: 25.0,
        gain,
        pendulum: Pendulum { mass: 0.49, length: 0.1, offset: 0.0 },
    }
}

#[test]
fn drive_that_made_the_recordings_comes_back() {
    let truth = drive("m3", vec![0.02, 0.004, 0.15]);
    let runs: Vec<PendulumRun> = [150.0, 600.0]
        .into_iter()
        .map(|gain| {
            let run = run(gain);
            let position = rollout(&truth, 0.02, &run, 2e-3).position;
            PendulumRun { position, ..run }.checked().unwrap()
        })
        .collect();
    let mut start = drive("m3", vec![0.0; 3]);
    start.motor = start.motor.with_constants(0.45, 3.4);
    start.gear.armature = 0.0015;
    let names = ["torque_constant_n_m_per_a", "armature_kg_m2"];
    let found = identify_drive(&start, &runs, &options(&names)).unwrap();
    // The recordings have no noise; priors pull by less than a thousandth.
    let pairs = [
        (found.drive.motor.torque_constant(), 0.36),
        (found.drive.gear.armature, 0.002),
        (found.drive.gear.friction[0], 0.02),
        (found.drive.gear.friction[2], 0.15),
        (found.offset, 0.02),
    ];
    for (found, truth) in pairs {
        assert!((found / truth - 1.0).abs() < 0.03, "{found} instead of {truth}");
    }
    assert!(mean_error(&found.drive, found.offset, &runs, 2e-3) < 1e-3);
}

#[test]
fn standard_errors_of_a_law_cover_the_truth_as_often_as_they_say() {
    // The first joint of Wan et al. (2026), table 2, with a Stribeck velocity that the speeds reach; 200 trials with 0.43 N m.
    let law = Law::named("directed-stribeck").unwrap();
    let truth = [6.17, 6.26, 4.98, 4.73, 0.2, 0.2, 12.1787];
    let speeds: Vec<f64> = (1..=100).flat_map(|k| [0.01 * f64::from(k), -0.01 * f64::from(k)]).collect();
    let inside_of = |set: u64| {
        let mut rng = hysteron_base::rng(set, "identify/friction");
        let torques: Vec<f64> = (speeds.iter())
            .map(|v| {
                let noise = (0..12).map(|_| rng.random_range(0.0..1.0)).sum::<f64>() - 6.0;
                law.torque(&truth, &Sliding::at(*v)) + 0.43 * noise
            })
            .collect();
        let found = identify_friction(&law, &speeds, &torques, None).unwrap();
        let estimates = found.fit.estimates[..truth.len()].iter();
        let is_inside = |(estimate, truth): (&IdentifiedParameter, &f64)| {
            (estimate.value - truth).abs() < 1.96 * estimate.standard_error.unwrap()
        };
        estimates.zip(&truth).map(is_inside).collect::<Vec<bool>>()
    };
    let sets: Vec<Vec<bool>> = (0..1000).into_par_iter().map(inside_of).collect();
    let inside: Vec<usize> = (0..truth.len()).map(|k| sets.iter().filter(|set| set[k]).count()).collect();
    // 950 of 1000, give or take three times 6.9; neighbours that are alike by chance make the errors 4 % larger, which is 958 of 1000.
    assert!(inside.iter().all(|count| (929..=979).contains(count)), "{inside:?}");
}

#[test]
fn channels_that_never_change_are_refused() {
    let law = Law::named("coulomb-viscous").unwrap();
    let moving: Vec<f64> = (0..50).map(|k| f64::from(k % 7) - 3.0).collect();
    let refused = |v: &[f64], t: &[f64]| identify_friction(&law, v, t, None).unwrap_err();
    assert!(refused(&[0.5; 50], &moving).hint.contains("speeds"));
    assert_eq!(refused(&moving, &[0.5; 50]).place, "torque");
    assert_eq!(refused(&moving, &moving[..9]).place, "torque");
}

#[test]
fn recording_without_motion_is_refused() {
    let error = run(100.0).checked().unwrap_err();
    assert!(error.place.ends_with("position") && error.hint.contains("motion"), "{error:?}");
    let mut backwards = run(100.0);
    backwards.time[5] = 0.0;
    assert!(backwards.checked().unwrap_err().place.ends_with("time"));
}

#[test]
fn a_run_with_one_number_that_is_not_finite_is_refused() {
    let moving = || {
        let mut moving = run(100.0);
        moving.position.iter_mut().enumerate().for_each(|(k, angle)| *angle = (0.1 * k as f64).sin());
        moving
    };
    assert!(moving().checked().is_ok());
    for bad in [f64::NAN, f64::INFINITY] {
        for (what, series) in [("time", 0), ("goal", 1), ("position", 2)] {
            let mut run = moving();
            [&mut run.time, &mut run.goal, &mut run.position][series][3] = bad;
            let error = run.checked().unwrap_err();
            assert!(error.place.ends_with(what) && error.found.contains("sample 4"), "{error:?}");
        }
    }
}

#[test]
fn pendulum_of_an_xl330_is_met_on_logs_that_were_not_fitted() {
    let Some(folder) = recorded("pendulum_of_an_xl330", "arms/bam/xl330") else { return };
    let logs: Vec<Value> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| json::from_text(std::fs::read(entry.unwrap().path()).unwrap()).unwrap())
        .collect();
    let runs = |trajectory: &str| -> Vec<PendulumRun> {
        logs.iter().filter(|log| log["trajectory"] == trajectory).map(read).collect()
    };
    let mut start = drive("m4", vec![0.0; 7]);
    start.winding = Winding { heat_capacity: 1.0, to_case: 20.0, reference: 30.0, ..Winding::COLD };
    let names = [
        "torque_constant_n_m_per_a",
        "resistance_ohm",
        "supply_resistance_ohm",
        "armature_kg_m2",
        "winding_heat_capacity_j_per_k",
    ];
    let found = identify_drive(&start, &runs("sin_sin"), &options(&names)).unwrap();
    let error = mean_error(&found.drive, found.offset, &runs("up_and_down"), 2e-3);
    // The published models leave 0.104 to 0.117 rad in the same rollouts.
    assert!(error < 0.06, "{error}");
}

fn read(log: &Value) -> PendulumRun {
    let entries = log["entries"].as_array().unwrap();
    let column = |key: &str| entries.iter().map(|entry| entry[key].as_f64().unwrap()).collect::<Vec<f64>>();
    let number = |key: &str| log[key].as_f64().unwrap();
    let run = PendulumRun {
        name: "log".into(),
        time: column("timestamp"),
        goal: column("goal_position"),
        position: column("position"),
        torque_on: vec![true; entries.len()],
        temperature: entries[0]["temp"].as_f64().unwrap(),
        gain: number("kp"),
        pendulum: Pendulum { mass: number("mass"), length: number("length"), offset: 0.0 },
    };
    run.checked().unwrap()
}

/// A joint that creeps at 2 mrad/s: its viscous coefficient is a hundred times what its torque would suggest at 1 rad/s.
#[test]
fn viscous_friction_of_a_slow_joint_is_found() {
    let law = Law::named("coulomb-viscous").unwrap();
    let velocity: Vec<f64> = (0..400).map(|k| 2e-3 * (0.05 * f64::from(k)).sin()).collect();
    let torque: Vec<f64> = velocity.iter().map(|v| 0.2 * v.signum() + 150.0 * v).collect();
    let found = identify_friction(&law, &velocity, &torque, None).unwrap();
    // Without noise what is left is the tolerance of the search.
    assert!((found.parameters[1] / 150.0 - 1.0).abs() < 1e-3, "{:?}", found.parameters);
}

/// Wan et al., table 2, joint 1, without noise: every method recovers the law within its stated accuracy.
#[test]
fn methods_recover_the_law_within_their_stated_errors() {
    let law = Law::named("directed-stribeck").unwrap();
    let truth = [6.17, 6.26, 4.98, 4.73, 0.2, 0.2, 12.18];
    let velocity: Vec<f64> = (1..=100).flat_map(|k| [0.01 * f64::from(k), -0.01 * f64::from(k)]).collect();
    let torque: Vec<f64> = velocity.iter().map(|v| law.torque(&truth, &Sliding::at(*v))).collect();
    let error = |method| {
        let found = identify_friction_by(method, &law, &velocity, &torque, 1).unwrap();
        let errors = velocity
            .iter()
            .zip(&torque)
            .map(|(v, tau)| (law.torque(&found.parameters, &Sliding::at(*v)) + found.offset - tau).abs());
        errors.fold(0.0, f64::max)
    };
    assert!(error(FrictionMethod::LeastSquares) < 1e-3);
    // Five rules follow the curve to a few hundredths; the law that is fitted to them inherits that.
    assert!(error(FrictionMethod::Anfis) < 0.05);
    // Constants cannot follow a slope of 12 N m s/rad.
    assert!((0.1..2.0).contains(&error(FrictionMethod::FuzzyNetwork)));
    // Populations stop before the minimum; what they leave is far below the friction of 6 to 18 N m.
    assert!(error(FrictionMethod::DifferentialEvolution) < 0.5);
    assert!(error(FrictionMethod::ParticleSwarm) < 2.0);
}
