//! Cable points that are fixed in space: eyelets and pulleys of the base.

use hysteron_base::{Friction, Scene};
use hysteron_fem::Mesh;
use hysteron_twin::{Twin, TwinState};

use super::{assert_close, distance, scenes, tolerance};

/// The robot with the first tendon led from outside over a pulley to the middle of its side: three points, of which the
/// last is carried.
fn led_over_a_pulley() -> (Scene, Mesh) {
    let (mut scene, mesh) = scenes::robot();
    let carried = scene.tendons[0].points[5];
    scene.tendons[0].points = vec![[0.03, 0.0, -0.01], PULLEY, carried];
    scene.tendons[0].fixed = vec![0, 1];
    (scene, mesh)
}

const PULLEY: [f64; 3] = [0.02, 0.004, 0.005];

#[test]
fn a_fixed_point_on_the_clamp_is_a_clamped_point() {
    let (scene, mesh) = scenes::robot();
    let clamped = Twin::new(&scene, &mesh).expect("a good scene");
    let mut fixed = scene.clone();
    for tendon in &mut fixed.tendons {
        assert_eq!(tendon.points[0][2], 0.0, "the first point is on the clamp");
        tendon.fixed = vec![0];
    }
    let fixed = Twin::new(&fixed, &mesh).expect("a good scene");
    let targets = super::strokes(&[2e-3, -1e-3, -2e-3, 0.5e-3]);
    let [a, b] = [&clamped, &fixed].map(|twin| (super::after(twin, &twin.rest(), &targets), twin));
    // Barycentric coordinates place the carried point within round-off of 5 mm, 1e-18 m; the solver stops at 1e-8 of the
    // forces, which moves the tip by that share of its 10 mm.
    assert!(distance(a.1.tip_of(&a.0), b.1.tip_of(&b.0)) < tolerance(1e-10));
    for (a, b) in a.0.tensions.iter().zip(&b.0.tensions) {
        assert_close("tension", *a, *b, 1e-6);
    }
}

#[test]
fn a_pulley_outside_redirects_and_keeps_tension_and_stroke() {
    // The way from the pulled end to the pulley does not change: the same as a tendon that ends at the pulley.
    let (scene, mesh) = led_over_a_pulley();
    let mut direct = scene.clone();
    direct.tendons[0].points.remove(0);
    direct.tendons[0].fixed = vec![0];
    let targets = super::strokes(&[1.5e-3, -0.01, -0.01, -0.01]);
    let [a, b] = [&scene, &direct].map(|scene| {
        let twin = Twin::new(scene, &mesh).expect("a good scene");
        let state = super::after(&twin, &twin.rest(), &targets);
        (twin, state)
    });
    assert!(a.1.tensions[0] > 0.1, "{:?}", a.1.tensions);
    assert_close("tension", a.1.tensions[0], b.1.tensions[0], 1e-6);
    // Closed form: the stroke is what the last segment has lost.
    let [pulled, pulley, end] = a.0.cables.polyline(0, &a.1.positions)[..] else { panic!("three points") };
    assert_eq!((pulled, pulley), (scene.tendons[0].points[0], PULLEY));
    let lost = distance(scene.tendons[0].points[2], PULLEY) - distance(end, pulley);
    assert_close("stroke", lost, 1.5e-3, 1e-9);
    assert_close(
        "rest length",
        a.0.cables.rest_lengths[0] - b.0.cables.rest_lengths[0],
        distance(pulled, pulley),
        1e-15,
    );
}

#[test]
fn compliance_is_the_derivative_of_the_stroke_over_a_pulley() {
    let (mut scene, mesh) = led_over_a_pulley();
    scene.solver.relative_residual = 1e-12;
    let twin = Twin::new(&scene, &mesh).expect("a good scene");
    let at = |tension: f64| -> TwinState {
        super::after(&twin, &twin.rest(), &super::tensions(&[tension, 0.0, 0.0, 0.0]))
    };
    // Central differences as in `delassus.rs`: 1e-6 of the entry.
    let (tension, step) = (1.0, 1e-3);
    let stroke = |state: &TwinState| twin.strokes_of(state)[0];
    let difference = (stroke(&at(tension + step)) - stroke(&at(tension - step))) / (2.0 * step);
    let analytic = super::stepper_at(&twin, &at(tension)).delassus(&twin).expect("a factor")[0];
    assert!(analytic > 1e-6, "{analytic}");
    assert_close("compliance", analytic / difference, 1.0, 1e-6);
}

#[test]
fn a_fixed_pulley_rubs_by_its_wrap_angle() {
    let (mut scene, mesh) = led_over_a_pulley();
    scene.tendons.truncate(1);
    let coefficient = 0.3;
    scene.friction = Some(Friction {
        coefficient,
        coulomb: 0.0,
        points: 1,
        sheath_exponent: 0.0,
        sheath_coulomb: 0.0,
        sheath_compliance_share: 0.0,
        backlash: 0.0,
    });
    let twin = Twin::new(&scene, &mesh).expect("a good scene");
    let mut stepper = super::stepper_at(&twin, &twin.rest());
    // The tendon slides one way, so that friction is at its bound.
    for step in 1..=10 {
        stepper.step(&twin, &super::strokes(&[1.5e-4 * f64::from(step)])).expect("an equilibrium");
    }
    let state = stepper.state();
    let [before, after] = twin.tensions_along(0, state)[..] else { panic!("two parts") };
    let [a, p, b] = twin.cables.polyline(0, &state.positions)[..] else { panic!("three points") };
    let along = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| (p[c] - a[c]) * (b[c] - p[c])).sum::<f64>();
    let angle = (along(a, b) / (distance(a, p) * distance(p, b))).acos();
    assert!(angle > 0.3, "{angle}");
    // A step keeps the friction bounds of where it began as long as they change by less than a tenth.
    assert_close("capstan", (before / after).ln(), coefficient * angle, 0.1 * coefficient * angle);
}

#[test]
fn a_tendon_without_a_moving_point_is_refused() {
    let (mut scene, mesh) = scenes::robot();
    scene.tendons[0].fixed = (0..scene.tendons[0].points.len()).collect();
    let error = Twin::new(&scene, &mesh).expect_err("no tendon");
    assert_eq!(error.bad_input().expect("bad input").found, "clamped or fixed ones alone");
}
