//! Energy of the whole body: what the pulleys put in is stored or turned into heat, and heat never comes back.

use super::super::body::{BodySpec, TendonBody};
use super::{body, spec};
use hysteron_actuator::{Prony, TendonModel};
use hysteron_base::rng;
use rand::RngExt;

fn full() -> BodySpec {
    let mut spec = spec();
    spec.stiffness[1] = 0.016;
    spec.axes_angle = 0.4;
    spec.natural_curvature = [0.4, -0.3];
    spec.prony = Prony::new(vec![0.15, 0.1], vec![0.5, 20.0]).unwrap();
    spec.mass = 0.01;
    spec.gravity = [0.0, -3.0, -9.0];
    spec
}

fn heat(body: &TendonBody) -> f64 {
    body.creep_heat + body.tendons.iter().map(|tendon| tendon.dissipated).sum::<f64>()
}

/// Random strokes, passed through in `n` steps between each two; imbalance over the heat, and the heat [J].
fn run(n: usize) -> (f64, f64) {
    let mut body = body(full(), 0.2, 0.05);
    let mut pulled = [0.0; 4];
    body.step(&pulled, 1e3);
    let mut rng = rng(11, "virtual-rig/test/energy");
    let (mut work, before) = (0.0, (body.stored_energy(), heat(&body)));
    for _ in 0..12 {
        let goal: [f64; 4] = std::array::from_fn(|_| rng.random_range(-2e-3..7e-3));
        let start = pulled;
        for i in 1..=n {
            let tensions: Vec<f64> = body.tendons.iter().map(|tendon| tendon.tensions[0]).collect();
            let heats: Vec<f64> = body.tendons.iter().map(|tendon| tendon.dissipated).collect();
            let last = pulled;
            for k in 0..4 {
                pulled[k] = start[k] + (goal[k] - start[k]) * i as f64 / n as f64;
            }
            let report = body.step(&pulled, 1.0 / n as f64);
            assert_eq!(report.failures, 0);
            for (k, tendon) in body.tendons.iter().enumerate() {
                work += 0.5 * (tensions[k] + tendon.tensions[0]) * (pulled[k] - last[k]);
                assert!(
                    tendon.dissipated >= heats[k] - 1e-14,
                    "a guide gave {}",
                    tendon.dissipated - heats[k]
                );
            }
        }
    }
    let heat_made = heat(&body) - before.1;
    ((work - (body.stored_energy() - before.0) - heat_made) / heat_made, heat_made)
}

#[test]
fn work_of_the_pulleys_is_stored_or_turned_into_heat() {
    let runs = [50, 100, 200].map(run);
    println!("energy: imbalance over heat {:?}", runs.map(|(miss, _)| miss));
    // Slip is integrated by its end values, so the balance closes with the step.
    assert!(runs[2].0.abs() < 0.02, "{runs:?}");
    assert!(runs[2].0.abs() < 0.7 * runs[0].0.abs(), "{runs:?}");
    assert!(runs[2].1 > 0.01, "{runs:?}");
}

#[test]
fn frictionless_elastic_body_gives_back_what_it_was_given() {
    let mut spec = full();
    spec.prony = Prony::new(vec![], vec![]).unwrap();
    let mut body = body(spec, 0.0, 1e-9);
    body.step(&[0.5e-3; 4], 1.0);
    let (start, strains) = (body.stored_energy(), body.strains.clone());
    for k in 1..=200 {
        let s = 4e-3 * (1.0 - (k as f64 / 100.0 - 1.0).abs());
        body.step(&[0.5e-3 + s, 0.5e-3, 0.5e-3 - s, 0.5e-3], 0.01);
    }
    assert!((body.stored_energy() - start).abs() < 1e-8, "{}", body.stored_energy() - start);
    for (now, then) in body.strains.iter().zip(&strains) {
        assert!((0..4).all(|a| (now[a] - then[a]).abs() < 1e-6), "{now:?} {then:?}");
    }
    assert!(body.tendons.iter().map(TendonModel::stored_energy).sum::<f64>() > 0.0);
}

#[test]
fn any_command_leaves_a_finite_body() {
    let mut rng = rng(2, "virtual-rig/test/abuse");
    let mut failures = 0;
    for friction in [0.0, 0.3, 0.8] {
        let mut body = body(full(), friction, 0.02);
        for _ in 0..400 {
            // Jumps of a centimetre and more, any duration.
            let pulled: [f64; 4] = std::array::from_fn(|_| rng.random_range(-20e-3..20e-3));
            let h = 10f64.powf(rng.random_range(-4.0..2.0));
            failures += body.step(&pulled, h).failures;
            let (q, p) = body.tip();
            assert!(p.iter().chain(&q).all(|x| x.is_finite()) && p.iter().all(|x| x.abs() < 0.2), "{p:?}");
            assert!(body.tendons.iter().all(|tendon| tendon.tensions.iter().all(|t| *t >= 0.0)));
        }
    }
    println!("abuse: {failures} substeps of 1200 jumps without balance");
    assert!(failures < 60, "{failures}");
}

#[test]
fn a_command_that_is_no_number_leaves_the_body_where_it_was() {
    let mut body = body(full(), 0.2, 0.05);
    body.step(&[1e-3, 0.0, 0.0, 0.0], 0.1);
    let tip = body.tip();
    let report = body.step(&[f64::NAN, 0.0, 0.0, 0.0], 0.1);
    assert!(report.failures > 0);
    assert_eq!(body.tip(), tip);
    assert_eq!(body.step(&[1.1e-3, 0.0, 0.0, 0.0], 0.1).failures, 0);
}
