//! Effects of friction along a bent tendon on tensions and tip.

use super::super::loop_width;
use super::{body, spec};

/// Pulls tendon 0 to `stroke` [m] and releases it, the others free; tensions at the top, and the loop.
fn pull(friction: f64, stroke: f64) -> (Vec<f64>, f64, f64) {
    let mut body = body(spec(), friction, 1e-4);
    let slack = -0.05;
    let n = 400;
    let (mut strokes, mut tips, mut top, mut wraps) = (Vec::new(), Vec::new(), Vec::new(), 0.0);
    for i in 0..=2 * n {
        let now = stroke * (1.0 - (i as f64 / n as f64 - 1.0).abs());
        body.step(&[now, slack, slack, slack], 0.01);
        strokes.push(now);
        tips.push(body.tip().1);
        if i == n {
            top = body.tendons[0].tensions.clone();
            wraps = body.work.wraps[0][1..9].iter().sum();
        }
    }
    (top, wraps, loop_width(&strokes, &tips).unwrap().relative())
}

#[test]
fn tension_at_the_tip_is_that_at_the_pulley_less_the_capstan() {
    for friction in [0.1, 0.3] {
        let (tensions, wrap, _) = pull(friction, 5e-3);
        let expected = tensions[0] * f64::exp(-friction * wrap);
        let last = tensions[8];
        assert!(wrap > 0.7, "{wrap}");
        assert!((last - expected).abs() < 2e-3 * tensions[0], "{friction}: {last} {expected}");
    }
}

#[test]
fn loop_of_the_tip_has_the_width_that_the_capstan_predicts() {
    // Bending goes with the mean tension in the body: m T on the way there, T/m on the way back, T at the pulley and m
    // the mean of exp(-μ θ). The same mean needs m² of the tension on the way back: meanwhile the tip rests, and the
    // tendon outside gives back its stretch.
    let (friction, stroke) = (0.2, 5e-3);
    let (tensions, _, width) = pull(friction, stroke);
    let mean = tensions[1..].iter().sum::<f64>() / 8.0 / tensions[0];
    let stretch = tensions[0] * 0.3 / 5000.0;
    let expected = stretch * (1.0 - mean * mean) / stroke;
    println!("loop: {width:.4}, by the capstan {expected:.4}");
    assert!((width / expected - 1.0).abs() < 0.25, "{width} {expected} {mean} {stretch}");
    let (_, _, smooth) = pull(0.0, stroke);
    assert!(smooth < 1e-3, "{smooth}");
}
