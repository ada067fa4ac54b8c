//! Recordings of an arm by inverse dynamics: free, loaded, worn.

use hysteron_actuator::CatalogueDrive;
use hysteron_arm_dynamics::{Data, Model, forward_kinematics, frame_jacobian, inverse_dynamics};
use hysteron_arm_estimation::servo_force::observed_arm;
use hysteron_base::{Channel, Metadata, Recording};

/// Time from sample to sample [s].
pub const PERIOD: f64 = 0.017;
/// Joints of the arm.
pub const JOINTS: usize = 4;

/// The arm, without its gripper.
pub fn arm() -> Model {
    observed_arm(&Model::builtin("open-manipulator-x").unwrap(), JOINTS).unwrap()
}

/// Case that a recording shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Case {
    /// Nothing acts on it.
    Free,
    /// The same, without a label of no force.
    Healthy,
    /// A weight of so many newtons that comes and goes.
    Loaded(f64),
    /// The third joint has more friction.
    Worn,
}

/// Waves of all joints; voltages are those which the catalogue's drive needs for them with friction, and with the weight.
pub fn recording(seed: u64, rows: usize, case: Case) -> Recording {
    let model = arm();
    let frame = model.frame("end_effector_link").unwrap();
    let mut data = Data::new(&model, 0.0);
    let drive = CatalogueDrive::named("xm430-w350").unwrap().drive.motor;
    let load = |row: usize| match case {
        Case::Loaded(weight) if (row / 80) % 2 == 1 => -weight,
        _ => 0.0,
    };
    let mut columns = vec![Vec::new(); 3 * JOINTS];
    for row in 0..rows {
        let t = PERIOD * row as f64;
        let wave = |k: usize, order: i32| {
            let rate = 1.1 + 0.35 * k as f64 + 0.07 * ((5 * seed) % 8) as f64;
            0.3 * rate.powi(order) * (rate * t + std::f64::consts::FRAC_PI_2 * f64::from(order)).sin()
        };
        let [q, dq, ddq]: [Vec<f64>; 3] =
            [0, 1, 2].map(|order| (0..JOINTS).map(|k| wave(k, order)).collect());
        let mut torque = vec![0.0; JOINTS];
        inverse_dynamics(&model, &mut data, [&q, &dq, &ddq], &[], &mut torque);
        let mut jacobian = vec![0.0; 6 * JOINTS];
        forward_kinematics(&model, &mut data, &q);
        frame_jacobian(&model, &data, frame, &mut jacobian);
        for k in 0..JOINTS {
            let worn = if case == Case::Worn && k == 2 { 0.25 } else { 0.1 };
            // Friction beyond the observer's law: it grows with the angle.
            let friction = (worn + 0.05 * q[k]) * (dq[k] / 0.02).tanh() + 0.05 * dq[k];
            let needed = torque[k] + friction - jacobian[2 * JOINTS + k] * load(row);
            let volts =
                needed * drive.resistance() / drive.torque_constant() + drive.torque_constant() * dq[k];
            columns[k].push(q[k]);
            columns[JOINTS + k].push(dq[k]);
            columns[2 * JOINTS + k].push(volts / 12.0);
        }
    }
    let mut channels = Vec::new();
    for k in 0..JOINTS {
        let [q, dq, pwm] = [0, 1, 2].map(|of| columns[of * JOINTS + k].clone());
        let number = k + 1;
        channels.push(Channel::new(format!("goal_{number}_rad"), q.clone()));
        channels.push(Channel::new(format!("q_{number}_rad"), q));
        channels.push(Channel::new(format!("dq_{number}_rad_s"), dq));
        channels
            .push(Channel::new(format!("current_{number}_a"), pwm.iter().map(|duty| 4.0 * duty).collect()));
        channels.push(Channel::new(format!("pwm_{number}_ratio"), pwm));
        channels.push(Channel::new(format!("voltage_{number}_v"), vec![12.0; rows]));
        channels.push(Channel::new(format!("temperature_{number}_degc"), vec![30.0; rows]));
    }
    if matches!(case, Case::Loaded(_)) {
        channels.push(Channel::new("force_z_n", (0..rows).map(load).collect()));
    }
    let mut meta = Metadata::default();
    let condition = if case == Case::Worn { "degraded" } else { "healthy" };
    meta.extra.insert("condition".to_owned(), condition.to_owned());
    let time = (0..rows).map(|row| PERIOD * row as f64).collect();
    Recording::new(time, channels, Vec::new(), meta).unwrap()
}
