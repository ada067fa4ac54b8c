//! One sample at a time is the same as all of them, and allocates nothing.

use hysteron_actuator::filter::LowPass;
use hysteron_actuator::law::{Law, SymmetricStribeck};
use hysteron_arm_dynamics::*;
use hysteron_arm_estimation::observer::*;

use super::motion::{panda, sines, torque_at};

fn every(model: &Model) -> Vec<Box<dyn Observer + '_>> {
    let n = model.n_joints();
    let body = || RigidBody::new(model);
    let law = (Law::Stribeck(SymmetricStribeck), vec![3.0, 1.0, 0.1, 0.5]);
    let friction = || FrictionModel::new(vec![law.clone(); n], LowSpeed::Stick(0.01));
    let noise = KalmanNoise { momentum: 1e-3, torque: 1e-2, contact: 10.0 };
    let smoothing = LowPass::new(5, 30.0, 1000.0).unwrap();
    let gain = ObserverGain::for_bandwidth(20.0, &vec![3.0; n], 3.0, 2.0).unwrap();
    vec![
        Box::new(StaticResidual::new(body(), friction(), Terms::Torque)),
        Box::new(StaticResidual::new(body(), friction(), Terms::Gravity)),
        Box::new(StaticResidual::new(body(), friction(), Terms::GravityAndFriction)),
        Box::new(MomentumObserver::new(body(), friction(), &vec![30.0; n])),
        Box::new(KalmanObserver::new(body(), friction(), &vec![noise; n])),
        Box::new(SlidingModeObserver::new(body(), friction(), &vec![30.0; n])),
        Box::new(DisturbanceObserver::new(body(), friction(), &gain)),
        Box::new(FilteredInverseDynamics::new(body(), friction(), smoothing.clone())),
        Box::new(FilteredInverseDynamics::new(body(), friction(), smoothing).at_bandwidth(&vec![30.0; n])),
    ]
}

/// Periods with jitter, and rows of coordinates, speeds and torques.
fn recording(model: &Model) -> (Vec<f64>, [Vec<f64>; 3]) {
    let (mut t, mut periods, mut rows) = (0.0, vec![], [vec![], vec![], vec![]]);
    for k in 0..300 {
        let period = 1e-3 * (1.0 + f64::from(k % 7) / 10.0);
        t += period;
        let [q, dq, _] = sines(model.n_joints(), t);
        let tau = torque_at(model, t - 0.5 * period, &vec![0.3; q.len()]);
        periods.push(period);
        rows.iter_mut().zip([q, dq, tau]).for_each(|(rows, row)| rows.extend(row));
    }
    (periods, rows)
}

#[test]
fn streaming_equals_offline_and_a_reset_forgets() {
    let model = panda();
    let n = model.n_joints();
    let (periods, [q, dq, tau]) = recording(&model);
    for (which, mut observer) in every(&model).into_iter().enumerate() {
        let offline = estimate(observer.as_mut(), &periods, [&q, &dq, &tau]);
        assert!(offline.iter().any(|x| x.abs() > 0.1), "{which}");
        observer.reset();
        let mut out = vec![0.0; n];
        for (k, period) in periods.iter().enumerate() {
            let row = n * k..n * (k + 1);
            let (position, velocity) = (&q[row.clone()], &dq[row.clone()]);
            observer.update(
                &ArmSample { period: *period, position, velocity, torque: &tau[row.clone()] },
                &mut out,
            );
            assert_eq!(out, offline[row], "{which}, sample {k}");
        }
    }
}

#[test]
fn no_estimator_allocates() {
    let model = panda();
    let n = model.n_joints();
    let (periods, [q, dq, tau]) = recording(&model);
    let mut tip =
        TipForceEstimator::new(&model, model.frames().len() - 1, &[0.2; 7], ContactPrior::Force(20.0));
    for (which, mut observer) in every(&model).into_iter().enumerate() {
        let mut out = vec![0.0; n];
        let counted = allocation_counter::measure(|| {
            for (k, period) in periods.iter().enumerate() {
                let row = n * k..n * (k + 1);
                let (position, velocity) = (&q[row.clone()], &dq[row.clone()]);
                observer
                    .update(&ArmSample { period: *period, position, velocity, torque: &tau[row] }, &mut out);
                tip.update(position, &out);
            }
        });
        assert_eq!(counted.count_total, 0, "{which}");
    }
    assert!(allocation_counter::measure(|| drop(std::hint::black_box(vec![1.0; 9]))).count_total > 0);
}
