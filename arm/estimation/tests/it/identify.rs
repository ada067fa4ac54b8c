//! Bodies are recovered from motions of known arms, are physically consistent with any noise, and their standard errors are right.

use hysteron_arm_dynamics::{Data, Model, inverse_dynamics};
use hysteron_arm_estimation::identify::{
    BodyOptions, Determined, JointMotion, JointTerm, Smoothing, TorqueResponse, identify_bodies,
    identify_payload, pseudo_inertia,
};
use hysteron_arm_estimation::{ArmRecording, ColumnMap, ImportOptions, import};
use hysteron_base::{Metadata, rng};
use hysteron_fuzz::recorded;
use rand::RngExt;

const TERMS: [JointTerm; 3] = [JointTerm::Coulomb, JointTerm::Viscous, JointTerm::Offset];
const OPTIONS: BodyOptions<'static> = BodyOptions { terms: &TERMS, width: 0.02, prior: 1e-3 };
/// Coulomb, viscous and offset of every joint.
const FRICTION: [f64; 3] = [0.3, 0.2, 0.05];

/// Sums of five sines for each joint, with exact speeds and accelerations, and torques with noise of `sigma` [N m].
fn motion(model: &Model, n_samples: usize, sigma: f64, seed: u64) -> JointMotion {
    let n = model.n_joints();
    let (mut rng, mut waves_rng) = (rng(seed, "identify/noise"), rng(7, "identify/waves"));
    let waves: Vec<[f64; 3]> = (0..5 * n)
        .map(|k| {
            [
                0.4 * waves_rng.random_range(0.5..1.0),
                1.3 * (1 + k % 5) as f64,
                waves_rng.random_range(0.0..6.0),
            ]
        })
        .collect();
    let mut motion =
        JointMotion { n_joints: n, period: 0.01, q: vec![], dq: vec![], ddq: vec![], tau: vec![] };
    let (mut data, mut tau) = (Data::new(model, 0.0), vec![0.0; n]);
    for s in 0..n_samples {
        let t = 0.01 * s as f64;
        let state = [0, 1, 2].map(|order| {
            let sum = |waves: &[[f64; 3]]| {
                let of = |[a, w, p]: &[f64; 3]| match order {
                    0 => a * (w * t + p).sin(),
                    1 => a * w * (w * t + p).cos(),
                    _ => -a * w * w * (w * t + p).sin(),
                };
                waves.iter().map(of).sum::<f64>()
            };
            waves.chunks(5).map(sum).collect::<Vec<f64>>()
        });
        inverse_dynamics(model, &mut data, [&state[0], &state[1], &state[2]], &[], &mut tau);
        for (tau, dq) in tau.iter_mut().zip(&state[1]) {
            let noise = (0..12).map(|_| rng.random_range(0.0..1.0)).sum::<f64>() - 6.0;
            *tau += FRICTION[0] * (dq / 0.02).tanh() + FRICTION[1] * dq + FRICTION[2] + sigma * noise;
        }
        let [q, dq, ddq] = state;
        motion.extend(&JointMotion { n_joints: n, period: 0.01, q, dq, ddq, tau: tau.clone() });
    }
    motion
}

#[test]
fn torques_of_another_motion_are_predicted_and_friction_comes_back() {
    for name in ["three-link", "so101"] {
        let truth = Model::builtin(name).unwrap();
        let fit = identify_bodies(&truth, &motion(&truth, 1500, 0.0, 1), &OPTIONS).unwrap();
        // Without noise what is left is the pull of the prior and the barrier.
        assert!(fit.rms.iter().all(|rms| *rms < 1e-3), "{name}: {:?}", fit.rms);
        for estimate in fit.estimates.iter().filter(|estimate| estimate.name.starts_with("coulomb")) {
            assert!((estimate.value - 0.3).abs() < 2e-3, "{name}: {estimate:?}");
        }
        // A planar arm of three links moves by fewer combinations than it has parameters.
        assert!(fit.n_determined < fit.estimates.len());
        assert!(fit.estimates.iter().any(|estimate| estimate.determined == Determined::Together));
    }
}

#[test]
fn torques_that_come_a_sample_early_are_identified_exactly() {
    let truth = Model::builtin("three-link").unwrap();
    let n = truth.n_joints();
    let motion = motion(&truth, 800, 0.0, 1);
    let fit = identify_bodies(&truth, &motion, &OPTIONS).unwrap();
    let rigid = fit.torques(&motion);
    let shifted = |from: usize| {
        // Joint 1 has what comes a sample later, the others what is now.
        let at = |k: usize| if k.is_multiple_of(n) { rigid[(k + n).min(rigid.len() - n)] } else { rigid[k] };
        JointMotion { tau: (0..rigid.len()).map(at).collect(), ..motion.clone() }.part(from..799)
    };
    let [early, other] = [shifted(1), shifted(300)];
    // x(t + h) = x + (x₊ - x₋)/2 + (x₊ - 2x + x₋)/2.
    let found = TorqueResponse::identify(&fit, &[&early, &other]).unwrap();
    for (j, (lead, second)) in found.lead.iter().zip(&found.second).enumerate() {
        let exact = if j == 0 { [0.01, 0.5e-4] } else { [0.0; 2] };
        assert!((lead - exact[0]).abs() < 1e-9 && (second - exact[1]).abs() < 1e-11, "{found:?}");
    }
    // The first and the last sample have no neighbours.
    let left = found.rms_on(&fit, &[&early]);
    assert!(left[0] < 0.2 * fit.rms_on(&early)[0] && left[1] == 0.0, "{left:?}");
}

#[test]
fn bodies_can_exist_however_large_the_noise() {
    let truth = Model::builtin("three-link").unwrap();
    let fit = identify_bodies(&truth, &motion(&truth, 300, 3.0, 1), &OPTIONS).unwrap();
    assert!(
        fit.least_pseudo_inertias().iter().all(|least| *least > 0.0),
        "{:?}",
        fit.least_pseudo_inertias()
    );
    assert_eq!(fit.model.suspicions().iter().filter(|s| s.contains("triangle")).count(), 0);
}

#[test]
fn standard_errors_cover_the_truth_as_often_as_they_say() {
    let truth = Model::builtin("three-link").unwrap();
    let n = truth.n_joints();
    let (mut inside, sets) = ([0; 3], 100);
    for seed in 0..sets {
        let fit = identify_bodies(&truth, &motion(&truth, 400, 0.1, 100 + seed), &OPTIONS).unwrap();
        for (term, count) in inside.iter_mut().enumerate() {
            let estimate = &fit.estimates[10 * n + term];
            *count += usize::from((estimate.value - FRICTION[term]).abs() < 1.96 * estimate.standard_error);
        }
    }
    // 95 of 100, give or take three times 2.2.
    assert!(inside.iter().all(|count| (88..=100).contains(count)), "{inside:?}");
}

#[test]
fn pseudo_inertia_of_a_point_mass_has_its_place_in_it() {
    let (m, c) = (2.0, [0.1, -0.2, 0.3]);
    let [x, y, z] = c;
    let second = [y * y + z * z, -x * y, x * x + z * z, -x * z, -y * z, x * x + y * y].map(|s| m * s);
    let p = pseudo_inertia(&[
        m,
        m * x,
        m * y,
        m * z,
        second[0],
        second[1],
        second[2],
        second[3],
        second[4],
        second[5],
    ]);
    for (i, a) in [x, y, z, 1.0].into_iter().enumerate() {
        for (j, b) in [x, y, z, 1.0].into_iter().enumerate() {
            assert!((p[i][j] - m * a * b).abs() < 1e-15);
        }
    }
}

/// A payload of 0.7 kg comes back within three of its standard errors, in the axes of the frame that holds it.
#[test]
fn a_payload_comes_back_from_the_torques_that_it_adds() {
    let bare = Model::builtin("so101").unwrap();
    let frame = bare.frames().last().unwrap().name.clone();
    let (mass, centre, second) = (0.7, [0.02, -0.01, 0.06], [4e-4, 0.0, 5e-4, 0.0, 1e-5, 3e-4]);
    let loaded = bare.with_payload(&frame, mass, centre, second).unwrap();
    let known = identify_bodies(&bare, &motion(&bare, 1500, 0.01, 1), &OPTIONS).unwrap();
    let found = identify_payload(&known, &frame, &motion(&loaded, 1500, 0.01, 2)).unwrap();
    let truth = [&[mass][..], &centre, &second].concat();
    for (estimate, truth) in found.estimates.iter().zip(&truth).take(4) {
        // The bare arm was identified from as much data: its error adds as much again.
        let most = 3.0 * 2f64.sqrt() * estimate.standard_error;
        assert!((estimate.value - truth).abs() < most, "{estimate:?} {truth}");
    }
    assert!((found.estimates[0].value - mass).abs() < 0.01, "{:?}", found.estimates[0]);
    for (without, with) in found.rms[0].iter().zip(&found.rms[1]) {
        assert!(with <= without && *with < 0.02, "{without} {with}");
    }
    let bad = identify_payload(&known, "nowhere", &motion(&loaded, 200, 0.0, 2)).unwrap_err();
    assert_eq!((bad.place.as_str(), bad.found.as_str()), ("frame", "\"nowhere\""));
}

#[test]
fn recordings_that_say_nothing_are_refused() {
    let smoothing = Smoothing { rate: 100.0, order: 4, cutoff: 10.0 };
    let moving: Vec<f64> = (0..400).map(|k| (0.1 * f64::from(k)).sin()).collect();
    let place = |q: Vec<f64>, tau: Vec<f64>| {
        JointMotion::smoothed([&[moving.clone(), q], &[], &[moving.clone(), tau]], smoothing).unwrap_err()
    };
    let constant = place(vec![0.3; 400], moving.clone());
    assert!(constant.place == "q_2" && constant.hint.contains("locked"), "{constant:?}");
    assert_eq!(place(moving.clone(), vec![1.0; 400]).place, "tau_2");
    let clipped: Vec<f64> = moving.iter().map(|x| x.clamp(-0.7, 0.7)).collect();
    assert!(place(moving.clone(), clipped).hint.contains("limit"));
    let mut nan = moving.clone();
    nan[7] = f64::NAN;
    assert_eq!(place(nan, moving.clone()).place, "q_2, sample 8");
    let short = vec![moving[..40].to_vec()];
    assert_eq!(JointMotion::smoothed([&short, &[], &short], smoothing).unwrap_err().place, "motion");
}

#[test]
fn springs_and_carried_weight_are_refused_where_bodies_are_identified() {
    let read = |joint: &str, body: &str| {
        let text = format!(
            "<mujoco><worldbody><body {body}><joint name=\"elbow\" axis=\"0 1 0\" {joint}/><geom size=\".1\" pos=\".2 0 0\"/></body>\
             </worldbody></mujoco>"
        );
        Model::from_mjcf(&text, "r.xml").unwrap()
    };
    let plain = read("", "");
    let motion = motion(&plain, 200, 0.1, 1);
    identify_bodies(&plain, &motion, &OPTIONS).unwrap();
    for (model, named) in
        [(read("stiffness=\"2\"", ""), "stiffness"), (read("", "gravcomp=\".5\""), "gravcomp")]
    {
        let error = identify_bodies(&model, &motion, &OPTIONS).unwrap_err();
        assert!(error.place == "joint[elbow]" && error.found.contains(named), "{error}");
        assert!(error.hint.contains("robot file"), "{error}");
    }
}

#[test]
fn wrong_options_are_refused() {
    let model = Model::builtin("three-link").unwrap();
    let motion = motion(&model, 200, 0.1, 1);
    let refused = |options: &BodyOptions| identify_bodies(&model, &motion, options).unwrap_err().place;
    assert!(refused(&BodyOptions { prior: 0.0, ..OPTIONS }).contains("prior"));
    assert!(refused(&BodyOptions { width: f64::NAN, ..OPTIONS }).contains("width"));
    assert_eq!(identify_bodies(&model, &motion.part(0..20), &OPTIONS).unwrap_err().place, "motion");
    let other = Model::builtin("scara").unwrap();
    if other.n_joints() != model.n_joints() {
        assert_eq!(identify_bodies(&other, &motion, &OPTIONS).unwrap_err().place, "motion");
    }
}

#[test]
fn panda_is_predicted_where_it_was_not_fitted() {
    let Some(folder) = recorded("panda_is_predicted", "arms/panda-gaz") else { return };
    let columns = Some(ColumnMap::named("panda-gaz").unwrap());
    let options = ImportOptions { columns, rate_hz: Some(1000.0), ..ImportOptions::default() };
    let imported = import(&folder, &options, Metadata::default()).unwrap();
    let motion =
        JointMotion::of_recording(&ArmRecording::of(&imported.recording).unwrap(), &[], 4, 8.0).unwrap();
    let fingers = [("panda_finger_joint1", 0.0), ("panda_finger_joint2", 0.0)];
    let model = Model::builtin("panda").unwrap().with_locked(&fingers).unwrap();
    let cut = motion.n_samples() * 7 / 10;
    let terms = [JointTerm::Coulomb, JointTerm::Viscous, JointTerm::Offset, JointTerm::Spring];
    let options = BodyOptions { terms: &terms, width: 0.05, prior: 1.0 };
    let fit = identify_bodies(&model, &motion.part(0..cut), &options).unwrap();
    let rms = fit.rms_on(&motion.part(cut..motion.n_samples()));
    // A regression without consistency leaves these; published models 0.22 to 0.75 N m.
    for (rms, most) in rms.iter().zip([0.16, 0.25, 0.18, 0.19, 0.08, 0.05, 0.06]) {
        assert!(*rms <= most, "{rms} > {most}");
    }
    assert!(fit.least_pseudo_inertias().iter().all(|least| *least > 0.0));
}
