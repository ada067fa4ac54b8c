#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::*;

/// Every law with parameters in the inside of their bounds, all different.
fn laws() -> Vec<(Law, Vec<f64>)> {
    let knots = vec![0.0, 0.3, 1.0, 2.5];
    let mut laws: Vec<Law> = LAW_NAMES.iter().map(|name| Law::named(name).unwrap()).collect();
    laws.push(Law::PiecewiseLinear(PiecewiseLinear { knots }));
    laws.push(Law::Capstan(Capstan { wrap: 0.9 }));
    laws.push(Law::LearnedMap(LearnedMap::new(vec![0.1, 0.5, 2.5], Vec::new()).unwrap()));
    laws.push(Law::LearnedMap(LearnedMap::new(vec![0.0, 1.0, 3.0], vec![0.0, 0.5, 2.0]).unwrap()));
    laws.into_iter()
        .map(|law| {
            let value = |(k, p): (usize, LawParameter)| {
                p.bounds[0] + (0.15 + 0.04 * k as f64) * (p.bounds[1] - p.bounds[0])
            };
            let p = law.parameters().into_iter().enumerate().map(value).collect();
            (law, p)
        })
        .collect()
}

const STATES: [Sliding; 4] = [
    Sliding { velocity: 0.7, motor_torque: 0.9, load_torque: -0.4 },
    Sliding { velocity: -0.7, motor_torque: 0.9, load_torque: -0.4 },
    Sliding { velocity: 1.9, motor_torque: -0.2, load_torque: 0.5 },
    Sliding { velocity: -2.1, motor_torque: -0.3, load_torque: -1.1 },
];

#[test]
fn derivatives_are_those_of_differences() {
    for (law, p) in laws() {
        let mut n_nonzero = 0;
        for at in STATES {
            let torque = |velocity: f64| law.torque(&p, &Sliding { velocity, ..at });
            let h = 1e-6;
            let difference = (torque(at.velocity + h) - torque(at.velocity - h)) / (2.0 * h);
            let slope = law.by_velocity(&p, &at);
            // Rounding 1e-16 / h, and the third derivative times h².
            assert!(
                (slope - difference).abs() < 1e-8 * (1.0 + slope.abs()),
                "{law:?} {at:?}: {slope} {difference}"
            );
            let mut gradient = vec![0.0; p.len()];
            law.by_parameters(&p, &at, &mut gradient);
            for k in 0..p.len() {
                let moved = |by: f64| {
                    let mut p = p.clone();
                    p[k] += by;
                    law.torque(&p, &at)
                };
                let difference = (moved(h) - moved(-h)) / (2.0 * h);
                assert!((gradient[k] - difference).abs() < 1e-7, "{law:?} {k}: {} {difference}", gradient[k]);
                n_nonzero += usize::from(gradient[k] != 0.0);
            }
        }
        assert!(n_nonzero >= p.len(), "{law:?}: hardly any derivative");
    }
}

#[test]
fn friction_opposes_motion_and_rests_at_rest() {
    for (law, p) in laws() {
        for at in STATES {
            assert!(law.torque(&p, &at) * at.velocity > 0.0, "{law:?} {at:?}");
            assert_eq!(law.torque(&p, &Sliding { velocity: 0.0, ..at }), 0.0);
            let budget = law.budget(&p, &at);
            assert_eq!(budget.velocity_after(0.99 * budget.dry, 3.0), 0.0);
            assert!(budget.velocity_after(-1.01 * budget.dry, 3.0) < 0.0);
        }
    }
}

#[test]
fn models_of_bam_contain_each_other() {
    let at = STATES[0];
    let torque = |name: &str, p: &[f64]| Law::named(name).unwrap().torque(p, &at);
    let m1 = torque("m1", &[0.1, 0.2]);
    assert_eq!(torque("m2", &[0.1, 0.2, 0.0, 1.0, 2.0]), m1);
    assert_eq!(torque("m3", &[0.1, 0.2, 0.0]), m1);
    let m3 = torque("m3", &[0.1, 0.2, 0.3]);
    assert!((m3 - m1 - 0.3 * 1.3).abs() < 1e-15);
    assert_eq!(torque("m4", &[0.1, 0.2, 0.0, 0.3, 0.0, 1.0, 2.0]), m3);
    // With equal parts the directional models get the torque through the gear.
    assert!((torque("m5", &[0.1, 0.2, 0.0, 0.3, 0.3, 0.0, 0.0, 1.0, 2.0]) - m3).abs() < 1e-15);
    assert!((torque("m6", &[0.1, 0.2, 0.0, 0.3, 0.3, 0.0, 0.0, 0.0, 0.0, 1.0, 2.0]) - m3).abs() < 1e-15);
}

#[test]
fn knots_are_met_and_held_beyond() {
    let law = PiecewiseLinear { knots: vec![0.0, 1.0, 2.0] };
    let p = [3.0, 1.0, 2.0, 5.0, 4.0, 4.5];
    let torque = |velocity: f64| law.torque(&p, &Sliding::at(velocity));
    assert_eq!([torque(1.0), torque(1.5), torque(2.0), torque(9.0)], [1.0, 1.5, 2.0, 2.0]);
    assert_eq!([torque(-1.0), torque(-0.5), torque(-9.0)], [-4.0, -4.5, -4.5]);
}

#[test]
fn directed_law_with_equal_sides_is_the_struct_of_the_servo() {
    let servo = crate::Stribeck::new(0.3, 0.5, 0.2, 0.1).unwrap();
    let p = [0.3, 0.3, 0.2, 0.2, 0.2, 0.2, 0.1];
    for velocity in [-1.3, -0.1, 0.0, 0.05, 0.4] {
        let law = DirectedStribeck.torque(&p, &Sliding::at(velocity));
        assert!((law - servo.torque(velocity)).abs() < 1e-15);
    }
}

#[test]
fn bristles_converge_to_the_steady_law_for_any_step() {
    let p = vec![0.3, 0.2, 0.1, 0.05];
    for h in [1e-4, 1e-2, 1.0] {
        let mut bristles = Bristles {
            law: SymmetricStribeck,
            parameters: p.clone(),
            stiffness: 200.0,
            damping: 0.1,
            deflection: 0.0,
        };
        let mut torque = 0.0;
        for _ in 0..(2.0 / h) as usize + 2 {
            torque = bristles.step(&Sliding::at(-0.08), h);
        }
        let steady = SymmetricStribeck.torque(&p, &Sliding::at(-0.08));
        assert!((torque - steady).abs() < 1e-9, "{h}: {torque} {steady}");
    }
}

#[test]
fn bristles_of_constant_strength_are_the_model_of_dahl() {
    // dF/dx = σ (1 - F/F_c sgn v): from rest F = F_c (1 - exp(-σ x / F_c)), however it is stepped.
    let law = CoulombViscous;
    let mut bristles =
        Bristles { law, parameters: vec![0.4, 0.0], stiffness: 90.0, damping: 0.0, deflection: 0.0 };
    let (h, speed) = (1e-3, 0.5);
    for k in 1..=30 {
        bristles.step(&Sliding::at(speed), h);
        let x = k as f64 * h * speed;
        let exact = 0.4 * (1.0 - (-90.0 * x / 0.4f64).exp());
        assert!((90.0 * bristles.deflection - exact).abs() < 1e-13);
    }
}

#[test]
fn unknown_law_is_refused_with_the_names_there_are() {
    let error = Law::named("m7").unwrap_err();
    assert!(error.expected.contains("m6"), "{error:?}");
    assert_eq!(Law::named("m0").unwrap_err().place, "law of friction");
}
