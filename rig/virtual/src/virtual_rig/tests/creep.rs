//! Creep of the body against the closed form, and anisotropy.

use super::{body, spec};
use hysteron_actuator::Prony;

/// Creep over the relaxed strain of a solid with two Maxwell elements under constant load from t = 0:
/// ε(s) = N(s)/(s D(s)) in the Laplace domain, N = (1 + s τ1)(1 + s τ2), D = N + g1 s τ1 (1 + s τ2) + g2 s τ2 (1 + s
/// τ1).
fn creep([g1, g2]: [f64; 2], [t1, t2]: [f64; 2], t: f64) -> f64 {
    let (a, b) = (t1 * t2 * (1.0 + g1 + g2), t1 * (1.0 + g1) + t2 * (1.0 + g2));
    let root = (b * b - 4.0 * a).sqrt();
    let residue = |s: f64| (1.0 + s * t1) * (1.0 + s * t2) / (s * (2.0 * a * s + b)) * (s * t).exp();
    1.0 + residue((-b + root) / (2.0 * a)) + residue((-b - root) / (2.0 * a))
}

#[test]
fn body_creeps_like_the_closed_form() {
    let (weights, times) = ([0.25, 0.15], [0.5, 8.0]);
    let mut spec = spec();
    spec.prony = Prony::new(weights.to_vec(), times.to_vec()).unwrap();
    spec.guides.clear();
    // Pure stretch is linear: load 3 N along the axis, at once.
    spec.tip_load = [0.0, 0.0, 3.0];
    let relaxed = 3.0 / spec.stiffness[3];
    let error = |h: f64| {
        let mut body = body(spec.clone(), 0.0, 0.01);
        body.step(&[], 0.0);
        let at_once = body.strains[4][3] / relaxed;
        assert!((at_once - creep(weights, times, 0.0)).abs() < 1e-8, "{at_once}");
        let mut worst = 0.0f64;
        for k in 1..=(10.0 / h).round() as usize {
            body.step(&[], h);
            let now = body.strains[4][3] / relaxed;
            worst = worst.max((now - creep(weights, times, k as f64 * h)).abs());
        }
        worst
    };
    let (coarse, fine) = (error(0.1), error(0.05));
    println!("creep: worst error {coarse:.1e}, {fine:.1e} of the relaxed strain at steps of 0.1, 0.05 s");
    assert!(fine < 1e-3 && (coarse / fine).log2() > 1.8, "{coarse} {fine}");
}

#[test]
fn body_under_constant_tension_creeps_towards_the_relaxed_shape() {
    let mut spec = spec();
    spec.prony = Prony::new(vec![0.25, 0.15], vec![0.5, 8.0]).unwrap();
    spec.guides.clear();
    // A bending moment of a constant tension, small: tip force across.
    spec.tip_load = [0.02, 0.0, 0.0];
    let mut body = body(spec, 0.0, 0.01);
    body.step(&[], 0.0);
    let at_once = body.tip().1[0];
    for _ in 0..1000 {
        body.step(&[], 0.1);
    }
    let relaxed = body.tip().1[0];
    assert!((relaxed / at_once - 1.4).abs() < 2e-3, "{}", relaxed / at_once);
}

#[test]
fn stiff_and_soft_axis_deflect_by_the_ratio_of_their_stiffness() {
    let deflection = |angle: f64| {
        let mut spec = spec();
        spec.stiffness[0] = 0.02;
        spec.stiffness[1] = 0.016;
        spec.axes_angle = 0.5;
        spec.guides.clear();
        // The first stiffness is that of bending about the first axis: the tip moves along the second.
        spec.tip_load = [1e-3 * f64::cos(angle), 1e-3 * f64::sin(angle), 0.0];
        let mut body = body(spec, 0.0, 0.01);
        body.step(&[], 1.0);
        body.tip().1
    };
    let soft = deflection(0.5);
    let stiff = deflection(0.5 + std::f64::consts::FRAC_PI_2);
    let ratio = soft[0].hypot(soft[1]) / stiff[0].hypot(stiff[1]);
    assert!((ratio - 0.02 / 0.016).abs() < 1e-4, "{ratio}");
    // Along a principal axis it goes straight.
    assert!((soft[1] / soft[0] - 0.5f64.tan()).abs() < 1e-6);
}
