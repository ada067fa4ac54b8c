//! Time of a streaming step of every estimator of external torques, on the Panda's seven joints, as one JSON object [ns].
//!
//!     cargo run --release -p hysteron-arm-estimation --example observer_rates
//!
//! Processor time of one core, the best of seven rounds.

use std::hint::black_box;
use std::time::Duration;

use hysteron_actuator::law::{Law, SymmetricStribeck};
use hysteron_arm_dynamics::*;
use hysteron_arm_estimation::observer::*;
use rustix::time::{ClockId, clock_gettime};

const SAMPLES: usize = 512;

/// Processor time of this program [s].
fn now() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32).as_secs_f64()
}

/// Nanoseconds of one of the `SAMPLES` steps of `run`.
fn nanoseconds(mut run: impl FnMut(usize)) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..7 {
        let (start, mut steps, mut end) = (now(), 0, 0.0);
        while end - start < 0.1 {
            (0..SAMPLES).for_each(&mut run);
            steps += SAMPLES;
            end = now();
        }
        best = best.min(1e9 * (end - start) / steps as f64);
    }
    best.round()
}

#[allow(clippy::print_stdout)] // what it is for
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let panda = Model::builtin("panda")?;
    let fingers: Vec<(&str, f64)> = panda.joints()[7..].iter().map(|joint| (&*joint.name, 0.01)).collect();
    let model = panda.with_locked(&fingers)?;
    let n = model.n_joints();
    let row = |k: usize, f: &dyn Fn(f64) -> f64| -> Vec<f64> {
        (0..n).map(|j| f(0.01 * k as f64 + j as f64)).collect()
    };
    let rows: Vec<[Vec<f64>; 3]> = (0..SAMPLES)
        .map(|k| [row(k, &f64::sin), row(k, &|x| 0.6 * x.cos()), row(k, &|x| 20.0 * (1.3 * x).sin())])
        .collect();
    let body = || RigidBody::new(&model);
    let law = (Law::Stribeck(SymmetricStribeck), vec![3.0, 1.0, 0.1, 0.5]);
    let friction = || FrictionModel::new(vec![law.clone(); n], LowSpeed::Stick(0.01));
    let noise = KalmanNoise { momentum: 1e-3, torque: 1e-2, contact: 10.0 };
    let observers: Vec<(&str, Box<dyn Observer + '_>)> = vec![
        ("torque", Box::new(StaticResidual::new(body(), friction(), Terms::Torque))),
        ("gravity", Box::new(StaticResidual::new(body(), friction(), Terms::Gravity))),
        ("gravity_friction", Box::new(StaticResidual::new(body(), friction(), Terms::GravityAndFriction))),
        ("momentum", Box::new(MomentumObserver::new(body(), friction(), &vec![30.0; n]))),
        ("kalman", Box::new(KalmanObserver::new(body(), friction(), &vec![noise; n]))),
        ("sliding_mode", Box::new(SlidingModeObserver::new(body(), friction(), &vec![30.0; n]))),
        (
            "disturbance",
            Box::new(DisturbanceObserver::new(
                body(),
                friction(),
                &ObserverGain::for_bandwidth(20.0, &vec![3.0; n], 3.0, 2.0)?,
            )),
        ),
    ];
    let mut external = vec![0.0; n];
    let mut times = serde_json::Map::new();
    for (name, mut observer) in observers {
        let step = nanoseconds(|k| {
            let [position, velocity, torque] = &rows[k];
            observer.update(&ArmSample { period: 1e-3, position, velocity, torque }, &mut external);
            black_box(&external);
        });
        times.insert(name.to_owned(), step.into());
    }
    let mut tip =
        TipForceEstimator::new(&model, model.frames().len() - 1, &vec![0.2; n], ContactPrior::Force(20.0));
    let step = nanoseconds(|k| {
        tip.update(&rows[k][0], &external);
        black_box(&tip.force);
    });
    times.insert("tip_force".to_owned(), step.into());
    println!("{}", hysteron_base::json!({ "robot": "panda", "joints": n, "step_ns": times }));
    Ok(())
}
