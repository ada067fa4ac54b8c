//! Designed motions: their ends, their limits, and the information on the parameters.

use hysteron_arm_dynamics::*;
use hysteron_arm_estimation::*;
use hysteron_base::Metadata;

fn options(watch: &(dyn Fn(usize, f64) -> bool + Sync)) -> ExcitationOptions<'_> {
    ExcitationOptions { period: 5.0, harmonics: 4, generations: 25, seed: 3, watch }
}

fn limits(model: &Model) -> MotionLimits {
    let options = LimitOptions { speed: Some(2.0), acceleration: Some(20.0), ..LimitOptions::default() };
    MotionLimits::of(model, options).unwrap()
}

/// Speeds and accelerations of a motion against differences: of second order in the step.
fn assert_derivatives(motion: &impl Motion, n: usize) {
    let h = 1e-4 * motion.duration();
    for joint in 0..n {
        for k in 1..20 {
            let t = motion.duration() * f64::from(k) / 20.0;
            let [before, here, after] = [t - h, t, t + h].map(|t| motion.at(joint, t));
            let scale = 1e-6 * (1.0 + here[1].abs() + here[2].abs());
            assert!(((after[0] - before[0]) / (2.0 * h) - here[1]).abs() < scale * 10.0, "{joint} {t}");
            assert!(((after[1] - before[1]) / (2.0 * h) - here[2]).abs() < scale * 100.0, "{joint} {t}");
        }
    }
}

#[test]
fn moves_begin_and_end_at_rest_and_keep_their_limits() {
    let model = Model::builtin("three-link").unwrap();
    let limits = limits(&model);
    let (from, to) = ([0.0, 0.5, -0.3], [1.0, -0.5, 0.8]);
    for law in [MotionLaw::Quintic, MotionLaw::Cycloid] {
        let motion = PointToPoint::new(&model, [&from, &to], None, law, &limits).unwrap();
        assert_derivatives(&motion, 3);
        for joint in 0..3 {
            for (t, q) in [(0.0, from[joint]), (motion.duration(), to[joint])] {
                let [at, dq, ddq] = motion.at(joint, t);
                // Rounding of polynomials with coefficients up to 15.
                assert!(
                    (at - q).abs() < 1e-14 && dq.abs() < 1e-13 && ddq.abs() < 1e-12,
                    "{law:?} {at} {dq} {ddq}"
                );
            }
            let fastest = (0..=1000).map(|k| motion.at(joint, motion.duration() * f64::from(k) / 1000.0));
            for [_, dq, ddq] in fastest {
                let most = 1.0 + 1e-12;
                assert!(
                    dq.abs() <= most * limits.speed[joint] && ddq.abs() <= most * limits.acceleration[joint]
                );
            }
        }
        let longer =
            PointToPoint::new(&model, [&from, &to], Some(2.0 * motion.duration()), law, &limits).unwrap();
        assert_eq!(longer.duration(), 2.0 * motion.duration());
        let shorter = PointToPoint::new(&model, [&from, &to], Some(0.9 * motion.duration()), law, &limits);
        assert_eq!(shorter.unwrap_err().place, "duration");
    }
    let refused = |from: &[f64], to: &[f64]| {
        PointToPoint::new(&model, [from, to], None, MotionLaw::Quintic, &limits).unwrap_err().place
    };
    assert_eq!(refused(&from, &[0.0]), "to");
    assert_eq!(refused(&[f64::NAN, 0.0, 0.0], &to), "from");
    assert_eq!(refused(&from, &[9.0, 0.0, 0.0]), "to");
    assert_eq!(refused(&from, &from), "to");
}

#[test]
fn the_cycloid_is_that_of_the_three_link_study() {
    // Equation (12): q₀ + Δ/T (t − T/2π sin(2πt/T)).
    let model = Model::builtin("three-link").unwrap();
    let (from, to, duration) = ([0.1, 0.2, 0.3], [0.6, -0.2, 0.5], 4.0);
    let motion =
        PointToPoint::new(&model, [&from, &to], Some(duration), MotionLaw::Cycloid, &limits(&model)).unwrap();
    for (joint, t) in (0..3).flat_map(|joint| [0.3, 1.7, 3.9].map(|t| (joint, t))) {
        let full = 2.0 * std::f64::consts::PI;
        let way = (to[joint] - from[joint]) / duration;
        let expected = from[joint] + way * (t - duration / full * (full * t / duration).sin());
        assert!((motion.at(joint, t)[0] - expected).abs() < 1e-15);
    }
}

#[test]
fn exciting_trajectories_keep_their_limits_and_show_more() {
    for name in ["three-link", "scara"] {
        let model = Model::builtin(name).unwrap();
        let limits = limits(&model);
        let watch = |_: usize, _: f64| true;
        let found = exciting_trajectory(&model, &limits, &options(&watch)).unwrap();
        assert!(found.condition < 0.5 * found.condition_before, "{name}: {found:?}");
        let motion = &found.motion;
        assert_derivatives(motion, model.n_joints());
        for joint in 0..model.n_joints() {
            for t in [0.0, motion.duration()] {
                let [_, dq, ddq] = motion.at(joint, t);
                assert!(dq.abs() < 1e-12 && ddq.abs() < 1e-11, "{name}: {dq} {ddq}");
            }
            for k in 0..=2000 {
                let [q, dq, ddq] = motion.at(joint, motion.duration() * f64::from(k) / 2000.0);
                let [low, high] = limits.range[joint];
                // Between 20 samples of the highest harmonic's cycle a sinusoid rises by 1 - cos(pi / 20) of its size.
                let most = 1.013;
                let middle = 0.5 * (low + high);
                assert!((q - middle).abs() <= most * 0.5 * (high - low), "{name} {q}");
                assert!(
                    dq.abs() <= most * limits.speed[joint] && ddq.abs() <= most * limits.acceleration[joint]
                );
            }
        }
        let states = states_of(&model, motion, 100.0, Metadata::default()).unwrap();
        assert_eq!((states.n_samples(), states.rate_hz().map(f64::round)), (501, Some(100.0)));
        // Torques, on rows that the search did not see.
        let output = DynamicsOutput { frame: 0, derivatives: false };
        let dynamics = dynamics_of_rows(&model, &states, output, Metadata::default()).unwrap();
        for (k, joint) in model.joints().iter().enumerate() {
            let of = |quantity| dynamics.require(&channel_name(&model, quantity, k)).unwrap();
            for (tau, dq) in of(JointQuantityKind::Torque).iter().zip(of(JointQuantityKind::Velocity)) {
                let friction = joint.drive.damping * dq + joint.drive.dry_friction * dq.signum();
                let limit = joint.drive.effort_limit.unwrap_or(f64::INFINITY);
                assert!((tau + friction).abs() <= limit, "{name}: {tau} + {friction} beyond {limit}");
            }
        }
        // The same seed, the same motion; on one thread too.
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(alone.install(|| exciting_trajectory(&model, &limits, &options(&watch)).unwrap()), found);
    }
}

#[test]
fn base_parameters_are_as_many_as_known() {
    // Planar arms on a vertical axis: of two links the inertia of both about their axes, and two first moments of the second
    // (Gautier 1991: 4 of 20, without gravity); armature of the first joint acts as its inertia, that of the second does not;
    // viscous and dry friction of both: 4 + 1 + 4.
    let scara = Model::builtin("scara").unwrap();
    let without_gravity = scara.with_gravity([0.0; 3]);
    let information = Information::of(&without_gravity, &limits(&scara), 1);
    assert_eq!(information.n_parameters(), 9);
    // Every joint of a vertical planar chain adds its inertia and two first moments (3 n with gravity), armature from the
    // second joint on, and two frictions.
    let three_link = Model::builtin("three-link").unwrap();
    assert_eq!(Information::of(&three_link, &limits(&three_link), 1).n_parameters(), 9 + 2 + 6);
}

#[test]
fn limits_that_cannot_be() {
    let model = Model::builtin("scara").unwrap();
    let refused = |options: LimitOptions| MotionLimits::of(&model, options).unwrap_err().place;
    assert_eq!(refused(LimitOptions { part: 0.0, ..LimitOptions::default() }), "limits");
    assert_eq!(refused(LimitOptions { part: f64::NAN, ..LimitOptions::default() }), "limits");
    assert_eq!(refused(LimitOptions { speed: Some(-1.0), ..LimitOptions::default() }), "speed");
    assert_eq!(
        refused(LimitOptions { acceleration: Some(f64::INFINITY), ..LimitOptions::default() }),
        "acceleration"
    );
    let limits = limits(&model);
    let watch = |_: usize, _: f64| true;
    let place = |change: &dyn Fn(&mut ExcitationOptions)| {
        let mut options = options(&watch);
        change(&mut options);
        exciting_trajectory(&model, &limits, &options).unwrap_err().place
    };
    assert_eq!(place(&|options| options.period = 0.0), "period");
    assert_eq!(place(&|options| options.harmonics = 1), "harmonics");
    let weak = MotionLimits { torque: vec![1e-9; 2], ..limits.clone() };
    // A planar arm holds itself, but may not move: nothing is seen.
    assert_eq!(exciting_trajectory(&model, &weak, &options(&watch)).unwrap_err().place, "limits");
}
