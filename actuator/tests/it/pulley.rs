//! A servo behind a pulley: what is identified of it is what it was simulated with.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

use hysteron_actuator::identify::{PulleyFit, PulleyServo, SteadySamples, identify_pulley};
use hysteron_actuator::law::{CoulombViscous, JointFriction, Law, Sliding, SymmetricStribeck};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SCALE: f64 = 1.5;
const RADIUS: f64 = 0.01;
const TRUTH: [f64; 4] = [0.05, 0.02, 0.3, 0.24];
const SERVO: PulleyServo = PulleyServo { stall_torque: 1.4, radius: RADIUS };

/// Some recordings of steady motion with Stribeck's friction; noise of the load that neighbours share for `alike` samples on average.
fn samples(seed: u64, alike: f64, has_tension: bool) -> SteadySamples {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut samples = SteadySamples::default();
    let stay = (-1.0 / alike).exp();
    for record in 0..4 {
        let first = samples.velocity.len();
        let mut noise = 0.0;
        let phase = rng.random_range(0.0..6.0);
        for i in 0..1000 {
            let t = 0.01 * f64::from(i);
            let angle = 1.1 * t + phase;
            let (v, a) = (0.7 * angle.sin(), 0.77 * angle.cos());
            // Uniform of deviation 1, then a process of deviation 2e-3.
            let white = 3f64.sqrt() * rng.random_range(-1.0..1.0);
            noise = stay * noise + (1.0 - stay * stay).sqrt() * white;
            let tension = [15.0 + 14.0 * (0.7 * t + phase).sin(), 9.8 * (0.7 * t + phase).cos()];
            let tension = if has_tension { tension } else { tension.map(|_| 0.0) };
            if v.abs() < 0.1 {
                continue;
            }
            let friction = SymmetricStribeck.torque(&TRUTH, &Sliding::at(v));
            let torque = friction + RADIUS * (tension[0] + 0.02 * tension[1]) - 0.003 * a;
            samples.velocity.push(v);
            samples.acceleration.push(a);
            samples.load.push(torque / SCALE + 2e-3 * noise);
            samples.at.push(i as usize);
            if has_tension {
                samples.tension.push(tension);
            }
        }
        assert!(samples.velocity.len() > first, "{record}");
        samples.series.push(first..samples.velocity.len());
    }
    samples
}

/// Distance of estimates from the truth in their standard errors: those of the law, then the load scale.
fn distances(found: &PulleyFit) -> Vec<f64> {
    let truth = [
        ("coulomb_n_m", TRUTH[0]),
        ("breakaway_excess_n_m", TRUTH[1]),
        ("stribeck_velocity_rad_s", TRUTH[2]),
        ("viscous_n_m_s_per_rad", TRUTH[3]),
        ("load_scale_n_m", SCALE),
    ];
    let of = |(name, value): (&str, f64)| {
        let estimate = found.fit.estimates.iter().find(|estimate| estimate.name == name)?;
        Some((estimate.value - value) / estimate.standard_error.unwrap_or(f64::INFINITY))
    };
    truth.into_iter().filter_map(of).collect()
}

#[test]
fn standard_errors_cover_the_truth_in_95_of_100() {
    let law = Law::Stribeck(SymmetricStribeck);
    let found = (0..40).map(|seed| identify_pulley(&samples(seed, 4.0, true), &law, &SERVO).unwrap());
    let all: Vec<f64> = found.flat_map(|found| distances(&found)).collect();
    let covered = all.iter().filter(|d| d.abs() < 1.96).count() as f64 / all.len() as f64;
    // Of 200 numbers 95 % within ± 1.5 %, were they independent; the five of a data set are not.
    assert!(covered > 0.9, "{covered}");
    // Standard errors that are too large would cover everything.
    let within_one = all.iter().filter(|d| d.abs() < 1.0).count() as f64 / all.len() as f64;
    assert!((0.5..0.85).contains(&within_one), "{within_one}");
}

#[test]
fn a_law_that_misses_the_curve_has_large_standard_errors() {
    let samples = samples(1, 4.0, true);
    let right = identify_pulley(&samples, &Law::Stribeck(SymmetricStribeck), &SERVO).unwrap();
    let wrong = identify_pulley(&samples, &Law::CoulombViscous(CoulombViscous), &SERVO).unwrap();
    // A mean of eleven independent squares is below 1.69² in 999 of 1000.
    assert!(right.misfit < 1.69 && wrong.misfit > 1.69, "{} {}", right.misfit, wrong.misfit);
}

#[test]
fn a_slack_tendon_gives_friction_in_shares_of_the_load() {
    let samples = samples(2, 4.0, false);
    let servo = PulleyServo { stall_torque: SCALE, ..SERVO };
    let found = identify_pulley(&samples, &Law::Stribeck(SymmetricStribeck), &servo).unwrap();
    let [coulomb, .., viscous] = distances(&found)[..4] else { panic!("four parameters") };
    assert!(coulomb.abs() < 3.0 && viscous.abs() < 3.0, "{coulomb} {viscous}");
    assert!(found.fit.estimates.iter().all(|estimate| estimate.name != "load_scale_n_m"));
}

#[test]
fn uninformative_recordings_are_refused() {
    let law = Law::Stribeck(SymmetricStribeck);
    let refused = |samples: &SteadySamples| identify_pulley(samples, &law, &SERVO).unwrap_err().to_string();
    let good = samples(1, 4.0, true);
    let with = |change: &dyn Fn(&mut SteadySamples)| {
        let mut samples = good.clone();
        change(&mut samples);
        refused(&samples)
    };
    type Change<'a> = &'a dyn Fn(&mut SteadySamples);
    let cases: [(&str, Change); 6] = [
        ("divide by 100", &|s| s.load.iter_mut().for_each(|l| *l *= 100.0)),
        ("divide by 1000", &|s| s.load.iter_mut().for_each(|l| *l *= 1000.0)),
        ("expected loads that change", &|s| s.load.fill(0.1)),
        ("steady motion, releasing", &|s| s.velocity.iter_mut().for_each(|v| *v = v.abs())),
        ("speeds that differ", &|s| s.velocity.iter_mut().for_each(|v| *v = 0.3 * v.signum())),
        ("tensions that change", &|s| s.tension.fill([4.0, 0.0])),
    ];
    for (expected, change) in cases {
        let found = with(change);
        assert!(found.contains(expected), "{expected}: {found}");
    }
    assert!(refused(&SteadySamples::default()).contains("got 0"));
}
