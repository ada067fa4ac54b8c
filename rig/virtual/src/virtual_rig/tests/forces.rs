//! The residual is the derivative of the energy; the tangent is nearly that of the residual.

use super::super::body::TendonBody;
use super::{body, spec};
use hysteron_actuator::Prony;
use hysteron_base::rng;
use rand::RngExt;

/// A body under everything at once, bent at random. Friction is so small that energy decides.
fn loaded(amplitude: f64) -> (TendonBody, [f64; 4]) {
    let mut spec = spec();
    spec.stiffness = [0.019, 0.014, 0.01, 1700.0];
    spec.axes_angle = 0.4;
    spec.natural_curvature = [0.8, -0.5];
    spec.prony = Prony::new(vec![0.2, 0.1], vec![0.5, 20.0]).unwrap();
    spec.mass = 0.01;
    spec.gravity = [1.0, -2.0, -9.0];
    spec.tip_load = [0.1, 0.3, -0.2];
    let mut body = body(spec, 0.0, 1e-12);
    let mut rng = rng(5, "virtual-rig/test/forces");
    for strain in &mut body.work.trial_strains {
        for a in 0..4 {
            let most = if a == 3 { 0.1 * amplitude } else { amplitude };
            strain[a] = rng.random_range(-most..most);
        }
    }
    (body, [2e-3, 1e-3, 0.5e-3, 2.5e-3])
}

fn scaled(body: &TendonBody, a: usize) -> f64 {
    body.stiffness[0][a].sqrt()
}

#[test]
fn residual_is_the_derivative_of_the_energy() {
    for amplitude in [0.1, 0.6] {
        let (mut body, pulled) = loaded(amplitude);
        body.spec.prony.weights.clear();
        body.spec.prony.times.clear();
        body.work.prony_step = f64::NAN;
        body.spec.prony.step_into(0.01, &mut body.work.prony);
        body.evaluate(&pulled);
        let (at, residual) = (body.work.trial_strains.clone(), body.work.residual.clone());
        let h = 1e-6;
        let mut energy = |s: usize, a: usize, sign: f64| {
            body.work.trial_strains.copy_from_slice(&at);
            body.work.trial_strains[s][a] += sign * h;
            body.evaluate(&pulled);
            // The energy of the trial state, through a copy that has committed it.
            let mut copy = body.clone();
            copy.commit(&pulled, 0.01);
            copy.stored_energy()
        };
        for s in 0..8 {
            for a in 0..4 {
                let difference = (energy(s, a, 1.0) - energy(s, a, -1.0)) / (2.0 * h);
                let analytic = residual[4 * s + a] * scaled(&loaded(amplitude).0, a);
                // Rounding of an energy of about 1 J over the step.
                let tolerance = 1e-8 + 1e-6 * analytic.abs();
                assert!((difference - analytic).abs() < tolerance, "[{s}][{a}]: {difference} {analytic}");
            }
        }
    }
}

#[test]
fn tangent_is_close_to_the_derivative_of_the_residual() {
    let (mut body, pulled) = loaded(0.12);
    body.spec.prony.step_into(0.01, &mut body.work.prony);
    body.evaluate(&pulled);
    body.assemble();
    let (at, tangent) = (body.work.trial_strains.clone(), body.work.lu.a.clone());
    let (n, h) = (32, 1e-7);
    let mut worst = 0.0f64;
    for j in 0..n {
        let step = h / body.stiffness[j / 4][j % 4].sqrt();
        let mut residual = |sign: f64| {
            body.work.trial_strains.copy_from_slice(&at);
            body.work.trial_strains[j / 4][j % 4] += sign * step;
            body.evaluate(&pulled);
            body.work.residual.clone()
        };
        let (high, low) = (residual(1.0), residual(-1.0));
        for i in 0..n {
            let difference = (high[i] - low[i]) / (2.0 * h);
            worst = worst.max((difference - tangent[i * n + j]).abs());
        }
    }
    println!("tangent: worst entry misses by {worst:.1e} of the elastic stiffness");
    assert!(worst < 0.05, "{worst}");
}
