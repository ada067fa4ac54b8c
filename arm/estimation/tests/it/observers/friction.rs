//! Estimates through friction.

use hysteron_actuator::law::{CoulombViscous, JointFriction, Law, LoadDependent, Sliding, SymmetricStribeck};
use hysteron_arm_dynamics::*;
use hysteron_arm_estimation::observer::*;

fn stribeck() -> (Law, Vec<f64>) {
    (Law::Stribeck(SymmetricStribeck), vec![3.0, 1.0, 0.1, 0.5])
}

#[test]
fn a_loaded_arm_at_rest_shows_no_contact_where_friction_holds_it() {
    // The simulator's own friction: joints of 2 N m, of which gravity and the motor leave less to be held.
    let text = std::fs::read_to_string(hysteron_arm_fixtures::robots::file("three_link")).unwrap();
    let text = text
        .replace("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 1 0\"/><dynamics friction=\"2\" damping=\"0\"/>");
    let model = Model::from_urdf(&text, "three-link").unwrap();
    assert!(model.joints().iter().all(|joint| joint.drive.dry_friction == 2.0));
    let n = model.n_joints();
    let (mut q, mut dq) = (vec![0.3, -0.7, 0.4], vec![0.0; n]);
    let mut torque = vec![0.0; n];
    gravity_torque(&model, &mut Data::new(&model, 0.0), &q, &mut torque);
    for (tau, left) in torque.iter_mut().zip([1.9, -1.5, 0.7]) {
        *tau += left;
    }
    let friction = || {
        let law = (Law::CoulombViscous(CoulombViscous), vec![2.0, 0.0]);
        FrictionModel::new(vec![law; n], LowSpeed::Stick(0.01))
    };
    let body = || RigidBody::new(&model);
    let gain = ObserverGain::for_bandwidth(30.0, &[2.0; 3], 2.0, 0.0).unwrap();
    let mut observers: [Box<dyn Observer>; 3] = [
        Box::new(StaticResidual::new(body(), friction(), Terms::GravityAndFriction)),
        Box::new(MomentumObserver::new(body(), friction(), &[30.0; 3])),
        Box::new(DisturbanceObserver::new(body(), friction(), &gain)),
    ];
    let mut simulator = Simulator::new(&model, 2e-3, 2, EndStops::None);
    let mut out = vec![0.0; n];
    for _ in 0..300 {
        simulator.step([&mut q, &mut dq], &torque, &[]);
        assert_eq!(dq, [0.0; 3], "friction holds");
        for observer in &mut observers {
            observer
                .update(&ArmSample { period: 2e-3, position: &q, velocity: &dq, torque: &torque }, &mut out);
            assert!(out.iter().all(|x| x.abs() < 1e-12), "{out:?}");
        }
    }
}

#[test]
fn what_exceeds_breakaway_at_rest_is_felt() {
    let friction = FrictionModel::new(vec![stribeck()], LowSpeed::Stick(0.01));
    let at = Sliding::at(0.0);
    assert_eq!(friction.torque(0, &at, 3.9), 3.9);
    assert!((friction.torque(0, &at, 7.0) - 4.0).abs() < 1e-9);
    assert!((friction.torque(0, &at, -7.0) + 4.0).abs() < 1e-9);
}

#[test]
fn modelled_friction_takes_power_at_every_speed() {
    for low_speed in [LowSpeed::Linear(0.2), LowSpeed::Linear(0.0), LowSpeed::Stick(0.0)] {
        let friction = FrictionModel::new(vec![stribeck()], low_speed);
        for velocity in [-1.0, -0.2, -0.1, -1e-6, 0.0, 1e-9, 0.05, 0.2, 3.0] {
            let torque = friction.torque(0, &Sliding::at(velocity), -5.0);
            assert!(torque * velocity >= 0.0, "{low_speed:?} {velocity}: {torque}");
            assert!(torque != 0.0 || velocity == 0.0);
        }
    }
}

#[test]
fn linear_part_meets_the_law_at_its_edge() {
    let (law, p) = stribeck();
    let expected = law.torque(&p, &Sliding::at(0.2));
    let friction = FrictionModel::new(vec![(law, p)], LowSpeed::Linear(0.2));
    assert!((friction.torque(0, &Sliding::at(0.1), 0.0) - 0.5 * expected).abs() < 1e-14);
    assert_eq!(friction.torque(0, &Sliding::at(-0.2), 0.0), -expected);
}

#[test]
fn load_dependent_friction_on_the_torque_of_a_known_pwm_gives_the_contact_back() {
    // Held at constant speed against gravity and a contact: f = f_0 + share |load − motor|, motor = f − load.
    let model = Model::builtin("three-link").unwrap();
    let n = model.n_joints();
    let (base, share, contact) = (0.1, 0.3, [0.4, -0.3, 0.2]);
    let law = (Law::LoadDependent(LoadDependent::M3), vec![base, 0.0, share]);
    let motor = MotorTorque::Pwm { torque_constant: 1.8, resistance: 2.1 };
    let friction = FrictionModel::new(vec![law; n], LowSpeed::Linear(0.0));
    let mut observer = MomentumObserver::new(RigidBody::new(&model), friction, &[50.0; 3]);
    let (speed, period, mut out) = ([0.2, 0.15, 0.1], 1e-3, vec![0.0; n]);
    let mut bias = vec![0.0; n];
    for k in 0..1000 {
        let q: Vec<f64> = speed.iter().map(|v| 0.2 + v * k as f64 * period).collect();
        let between: Vec<f64> = q.iter().zip(speed).map(|(q, v)| q - 0.5 * period * v).collect();
        bias_torque(&model, &mut Data::new(&model, 0.0), [&between, &speed], &[], &mut bias);
        let torque: Vec<f64> = (0..n)
            .map(|j| {
                let load = contact[j] - bias[j];
                let f = (0..100).fold(0.0, |f, _| base + share * (2.0 * load - f).abs());
                // Through the drive: the duty that gives this torque at 12 V.
                let pwm = ((f - load) * 2.1 / 1.8 + 1.8 * speed[j]) / 12.0;
                motor.at(&DriveReading { current: f64::NAN, voltage: 12.0, pwm, velocity: speed[j] })
            })
            .collect();
        observer.update(&ArmSample { period, position: &q, velocity: &speed, torque: &torque }, &mut out);
    }
    for j in 0..n {
        assert!((out[j] - contact[j]).abs() < 5e-3, "{out:?}");
    }
}

#[test]
fn friction_that_absorbs_feels_the_load_under_which_an_arm_came_to_rest() {
    // A joint without gravity or inertia to speak of is pushed back by a load until it stops: the motor gives 1.5 N m, friction
    // holds 2 N m against the motion, so the load was -3.5 N m. At rest the motor then changes, and the load does not.
    let text = std::fs::read_to_string(hysteron_arm_fixtures::robots::file("three_link")).unwrap();
    let model = Model::from_urdf(&text, "three-link").unwrap();
    let n = model.n_joints();
    let observer = |low_speed: LowSpeed| {
        let law = (Law::CoulombViscous(CoulombViscous), vec![2.0, 0.0]);
        MomentumObserver::new(RigidBody::new(&model), FrictionModel::new(vec![law; n], low_speed), &[30.0; 3])
    };
    let q = vec![0.3, -0.7, 0.4];
    let mut gravity = vec![0.0; n];
    gravity_torque(&model, &mut Data::new(&model, 0.0), &q, &mut gravity);
    let run = |low_speed: LowSpeed| {
        let mut observer = observer(low_speed);
        let (mut out, mut felt) = (vec![0.0; n], Vec::new());
        for step in 0..600 {
            // Slowly backwards for 400 steps, then at rest while the motor goes up by 0.8 N m.
            let speed = if step < 400 { -0.05 } else { 0.0 };
            let more = if step < 400 { 0.0 } else { 0.8 * f64::min(f64::from(step - 400) / 100.0, 1.0) };
            let mut torque = gravity.clone();
            torque[0] += 1.5 + more;
            let mut dq = vec![0.0; n];
            dq[0] = speed;
            let sample = ArmSample { period: 2e-3, position: &q, velocity: &dq, torque: &torque };
            observer.update(&sample, &mut out);
            felt.push(out[0]);
        }
        (felt[399], felt[599])
    };
    let (moving, at_rest) = run(LowSpeed::Absorb(0.01));
    // Slowly as it goes, the load is the motor's 1.5 N m with friction's 2 N m; e^(-30 · 0.8) of the start is left.
    assert!((moving + 3.5).abs() < 1e-2, "{moving}");
    // Stopping takes a momentum of a part of a N m s within one sample, which the observer forgets again.
    assert!((at_rest - moving).abs() < 0.05, "{moving} {at_rest}");
    let (_, stuck) = run(LowSpeed::Stick(0.01));
    assert!(stuck.abs() < 0.5, "friction could hold 2.3 N m but for 0.3: {stuck}");
}
