//! Estimators compared with theory.

use hysteron_arm_dynamics::*;
use hysteron_arm_estimation::observer::*;
use nalgebra::{DMatrix, SymmetricEigen};

use super::motion::{largest, panda, run, sines};
use hysteron_arm_fixtures::numbers::{Complex, STEP};
use hysteron_arm_fixtures::robots::{assert_close, each};

#[test]
fn momentum_and_its_rate_are_those_of_the_energy() {
    each(|name, model, _, s| {
        let n = model.n_joints();
        let mut data = Data::new(model, 0.0);
        let (mut p, mut rate) = (vec![0.0; n], vec![0.0; n]);
        generalized_momentum(model, &mut data, [&s.q, &s.v], &mut p, &mut rate);
        let expected: Vec<f64> =
            s.mass_matrix.iter().map(|row| row.iter().zip(&s.v).map(|(m, v)| m * v).sum()).collect();
        assert_close(&format!("{name}: p"), &p, &expected, 1e-9);
        // ∂(T − V)/∂q by complex steps.
        let zero = Complex { x: 0.0, y: 0.0 };
        let mut data = Data::new(model, zero);
        let v: Vec<Complex> = s.v.iter().map(|x| Complex { x: *x, y: 0.0 }).collect();
        let expected: Vec<f64> = (0..n)
            .map(|j| {
                let mut q: Vec<Complex> = s.q.iter().map(|x| Complex { x: *x, y: 0.0 }).collect();
                q[j].y = STEP;
                let kinetic = kinetic_energy(model, &mut data, &q, &v).y;
                (kinetic - potential_energy(model, &mut data, &q).y) / STEP
            })
            .collect();
        assert_close(&format!("{name}: rate"), &rate, &expected, 1e-11);
    });
}

/// An external torque of 2 N m on joint 2 from `at` on.
fn push(n: usize, at: f64) -> impl Fn(f64) -> Vec<f64> {
    move |t| (0..n).map(|j| if j == 1 && t > at { 2.0 } else { 0.0 }).collect()
}

#[test]
fn momentum_observer_answers_a_step_with_its_time_constant() {
    let model = panda();
    let n = model.n_joints();
    let (gain, period, at) = (25.0, 1e-3, 0.1);
    let mut observer = MomentumObserver::new(RigidBody::new(&model), FrictionModel::none(n), &[gain; 7]);
    let estimates = run(&mut observer, &model, (period, 600), &push(n, at));
    // (1 + K T)^-m for exp(-K T m): at most K T/2 · max x e^-x = K T/(2 e) off, to first order. Trapezoids: T².
    let tolerance = 2.0 * (1.1 * gain * period / (2.0 * std::f64::consts::E)) + 1e-3;
    for (k, estimate) in estimates.iter().enumerate() {
        let since = (k as f64 * period - at).max(0.0);
        let exact = 2.0 * (1.0 - (-gain * since).exp());
        assert!((estimate[1] - exact).abs() <= tolerance, "{k}: {} {exact}", estimate[1]);
        for j in [0, 2, 3, 4, 5, 6] {
            assert!(estimate[j].abs() <= 1e-3, "joint {j}: {}", estimate[j]);
        }
    }
    assert!((estimates[599][1] - 2.0).abs() < 1e-3);
}

#[test]
fn a_perfect_model_leaves_nothing_but_the_square_of_the_period() {
    let model = panda();
    let n = model.n_joints();
    let none = |_: f64| vec![0.0; n];
    let rest = |period: f64| {
        let samples = (period, (1.0 / period) as usize);
        let body = || RigidBody::new(&model);
        let noise = KalmanNoise { momentum: 1e-3, torque: 1e-2, contact: 10.0 };
        let observers: [Box<dyn Observer>; 2] = [
            Box::new(MomentumObserver::new(body(), FrictionModel::none(n), &[30.0; 7])),
            Box::new(KalmanObserver::new(body(), FrictionModel::none(n), &[noise; 7])),
        ];
        observers.map(|mut observer| largest(&run(observer.as_mut(), &model, samples, &none)))
    };
    let (coarse, fine) = (rest(4e-3), rest(2e-3));
    for (coarse, fine) in coarse.iter().zip(&fine) {
        assert!(*fine < 2e-3 && (3.5..4.5).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
    }
}

#[test]
fn disturbance_observer_converges_at_the_rate_of_its_gain() {
    // A robot that is held still: e' = -y M^-1 e, in the eigenvectors of M^-1; the step is implicit: (1 + T y/m)^-k.
    let model = Model::builtin("three-link").unwrap();
    let n = model.n_joints();
    let q = [0.3, -0.7, 0.4];
    let (mut mass, mut gravity) = (vec![0.0; n * n], vec![0.0; n]);
    let mut data = Data::new(&model, 0.0);
    mass_matrix(&model, &mut data, &q, &mut mass);
    gravity_torque(&model, &mut data, &q, &mut gravity);
    let eigen = SymmetricEigen::new(DMatrix::from_row_slice(n, n, &mass));
    let gain =
        ObserverGain::for_bandwidth(20.0, &vec![eigen.eigenvalues.max(); n], eigen.eigenvalues.max(), 0.0)
            .unwrap();
    assert!((gain.decay - 20.0).abs() < 1e-12);
    let mut observer = DisturbanceObserver::new(RigidBody::new(&model), FrictionModel::none(n), &gain);
    let external = [1.0, -0.5, 0.2];
    let torque: Vec<f64> = gravity.iter().zip(external).map(|(g, f)| g - f).collect();
    let (period, mut out) = (1e-3, vec![0.0; n]);
    let first = eigen.eigenvectors.transpose() * DMatrix::from_column_slice(n, 1, &external);
    for k in 0..200 {
        let sample = ArmSample { period, position: &q, velocity: &[0.0; 3], torque: &torque };
        observer.update(&sample, &mut out);
        let left = DMatrix::from_fn(n, 1, |i, _| {
            first[i] * (1.0 + period * gain.y[0] / eigen.eigenvalues[i]).powi(-k)
        });
        let expected = DMatrix::from_column_slice(n, 1, &external) - &eigen.eigenvectors * left;
        assert_close(
            &format!("sample {k}"),
            &out,
            expected.as_slice(),
            if k == 0 { f64::INFINITY } else { 1e-9 },
        );
    }
}

#[test]
fn disturbance_observer_forgets_at_the_rate_of_the_matrix_inequality() {
    // Along a motion: eᵀM e falls at least by exp(-2 decay t).
    let model = panda();
    let n = model.n_joints();
    let (period, count) = (1e-3, 400);
    let mut data = Data::new(&model, 0.0);
    let masses: Vec<DMatrix<f64>> = (0..=count)
        .map(|k| {
            let [q, ..] = sines(n, k as f64 * period);
            let mut mass = vec![0.0; n * n];
            mass_matrix(&model, &mut data, &q, &mut mass);
            DMatrix::from_row_slice(n, n, &mass)
        })
        .collect();
    let norm = |m: &DMatrix<f64>| SymmetricEigen::new(m.clone()).eigenvalues.abs().max();
    let inertia = masses.iter().map(norm).fold(0.0, f64::max);
    let rate = masses.windows(2).map(|w| norm(&((&w[1] - &w[0]) / period))).fold(0.0, f64::max);
    assert!(rate > 0.1, "the motion changes the inertia: {rate}");
    let gain = ObserverGain::for_bandwidth(10.0, &vec![inertia; n], inertia, rate).unwrap();
    assert!(gain.y[0] > 2.0 * rate);
    let external: Vec<f64> = (0..n).map(|j| 1.0 - 0.2 * j as f64).collect();
    // With and without the contact: what the sampling of the motion errs by is in both, and the observer is linear.
    let [with, without] = [external.clone(), vec![0.0; n]].map(|external| {
        let mut observer = DisturbanceObserver::new(RigidBody::new(&model), FrictionModel::none(n), &gain);
        run(&mut observer, &model, (period, count), &|_| external.clone())
    });
    let energy = |k: usize| {
        let e = DMatrix::from_fn(n, 1, |j, _| external[j] - (with[k][j] - without[k][j]));
        (e.transpose() * &masses[k] * &e)[0]
    };
    // e_k = (M_k + y T)⁻¹ M_k e_{k−1}: with y > 2 ζ, V_{k−1} ≥ V_k + (2y − ζ) T |e_k|².
    for k in 1..count {
        let bound = energy(0) * (1.0 + 2.0 * gain.decay * period).powi(-(k as i32));
        assert!(energy(k) <= bound * (1.0 + 1e-9) + 1e-18, "{k}: {} {bound}", energy(k));
    }
    assert!(energy(count - 1) < 1e-2 * energy(0));
}

#[test]
fn closed_form_gain_solves_the_matrix_inequality_and_no_larger_one_does() {
    for (bandwidth, inertias, rate) in
        [(20.0, [0.04, 0.003], 0.1), (3.0, [1.2, 1.2], 2.0), (0.6, [2.0, 3.0], 2.3)]
    {
        let gain = ObserverGain::for_bandwidth(bandwidth, &inertias, 3.0, rate).unwrap();
        let smallest = |factor: f64| {
            let n = 2;
            let m = DMatrix::from_fn(2 * n, 2 * n, |i, j| match (i / n, j / n) {
                _ if i % n != j % n => 0.0,
                (0, 0) => 2.0 * gain.y[i % n] - rate,
                (1, 1) => 1.0 / (factor * gain.gamma[i % n]),
                _ => gain.y[i % n],
            });
            SymmetricEigen::new(m).eigenvalues.min()
        };
        let scale = gain.y[0] + gain.y[1] + 1.0 / gain.gamma[0] + 1.0 / gain.gamma[1];
        assert!(smallest(1.0) >= -1e-12 * scale, "{}", smallest(1.0));
        assert!(smallest(1.01) < 0.0);
    }
    let refused = ObserverGain::for_bandwidth(1.0, &[1.0, 2.0], 2.0, 2.0).unwrap_err();
    assert!(refused.expected.contains("more than 1.000 rad/s"), "{refused:?}");
}

#[test]
fn sliding_mode_follows_a_ramp_that_a_first_order_observer_lags_behind() {
    let model = Model::builtin("three-link").unwrap();
    let n = model.n_joints();
    let (period, slope) = (1e-3, 4.0);
    let ramp = |t: f64| vec![slope * t.max(0.0), 0.0, 0.0];
    let error = |observer: &mut dyn Observer| {
        let estimates = run(observer, &model, (period, 1000), &ramp);
        (500..1000).map(|k| (estimates[k][0] - slope * (k as f64 - 0.5) * period).abs()).fold(0.0, f64::max)
    };
    let body = || RigidBody::new(&model);
    let first_order = error(&mut MomentumObserver::new(body(), FrictionModel::none(n), &[40.0; 3]));
    let sliding = error(&mut SlidingModeObserver::new(body(), FrictionModel::none(n), &[10.0; 3]));
    // Slope/K of lag; chatter of order L T, here a few of them.
    assert!((first_order - slope / 40.0).abs() < 0.01, "{first_order}");
    assert!(sliding < 5.0 * 10.0 * period, "{sliding}");
}

#[test]
fn kalman_observer_states_its_own_error() {
    // At rest in one place, with noise on the speeds such that momentum has independent noise in every joint, and a random walk of
    // the external torque: the squared error over the stated variance is 1 in the mean.
    let model = Model::builtin("three-link").unwrap();
    let n = model.n_joints();
    let q = [0.3, -0.7, 0.4];
    let (mut mass, mut gravity) = (vec![0.0; n * n], vec![0.0; n]);
    let mut data = Data::new(&model, 0.0);
    mass_matrix(&model, &mut data, &q, &mut mass);
    gravity_torque(&model, &mut data, &q, &mut gravity);
    let inverse = DMatrix::from_row_slice(n, n, &mass).try_inverse().unwrap();
    let noise = KalmanNoise { momentum: 1e-4, torque: 1e-3, contact: 3.0 };
    let period: f64 = 2e-3;
    let mut observer = KalmanObserver::new(RigidBody::new(&model), FrictionModel::none(n), &[noise; 3]);
    let mut random = hysteron_base::rng(7, "kalman");
    let mut normal = || hysteron_base::normal(&mut random);
    let (mut truth, mut out) = (vec![0.0; n], vec![0.0; n]);
    let (mut sum, mut count) = (0.0, 0);
    for k in 0..20_000 {
        let p = DMatrix::from_fn(n, 1, |_, _| noise.momentum * normal());
        let dq = &inverse * p;
        // The momentum itself stays zero: the motor resists the contact, up to the model's error.
        let torque: Vec<f64> = (0..n)
            .map(|j| {
                let before = truth[j];
                truth[j] += noise.contact * period.sqrt() * normal();
                gravity[j] - 0.5 * (before + truth[j]) + noise.torque / period.sqrt() * normal()
            })
            .collect();
        let sample = ArmSample { period, position: &q, velocity: dq.as_slice(), torque: &torque };
        observer.update(&sample, &mut out);
        if k > 500 {
            for j in 0..n {
                sum += ((out[j] - truth[j]) / observer.deviation(j)).powi(2);
                count += 1;
            }
        }
    }
    let mean = sum / f64::from(count);
    assert!((0.85..1.15).contains(&mean), "{mean}");
}
