//! Commands and scenes that cannot be: the error, and what is left behind.

use hysteron_base::{
    AuxiliaryLayout, BadInput, Bounds, MaterialLaw, PointForce, PrescribedQuantity, Region, Scene,
    TipDefinition,
};
use hysteron_fem::Order;
use hysteron_twin::{Cause, Error, Target, Twin};

use super::{Robot, distance, scenes, strokes, tolerance};

fn refused(targets: &[Target]) -> BadInput {
    let mut robot = Robot::new(&scenes::robot());
    robot.go(&strokes(&[1e-3, 0.0, -2e-3, 0.0]));
    let before = robot.state.clone();
    let error = robot.try_step(targets).expect_err("a bad command");
    assert_eq!(robot.state, before, "a refused command leaves the state alone");
    error.bad_input().unwrap_or_else(|| panic!("{error}")).clone()
}

#[test]
fn wrong_number_of_targets_is_refused() {
    for n in [0, 3, 5] {
        let bad = refused(&vec![Target::Free; n]);
        assert_eq!((bad.place.as_str(), bad.found), ("targets", n.to_string()));
    }
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let bad = refused(&[Target::Free, Target::Stroke(value), Target::Free, Target::Free]);
        assert_eq!(bad.place, "stroke of tendon tendon_2");
        let bad = refused(&[Target::Free, Target::Free, Target::Tension(value), Target::Free]);
        assert_eq!(bad.place, "tension of tendon tendon_3");
    }
}

#[test]
fn stroke_longer_than_tendon_is_refused_with_a_hint_at_units() {
    // 1.5 as typed in mm, but taken as metres.
    let bad = refused(&strokes(&[1.5, 0.0, 0.0, 0.0]));
    assert!(bad.expected.contains("40.000 mm") && bad.found == "1500.000 mm" && bad.hint.contains("metres"));
}

#[test]
fn tension_outside_bounds_is_refused() {
    for tension in [-0.1, 100.5] {
        let bad = refused(&[Target::Tension(tension), Target::Free, Target::Free, Target::Free]);
        assert!(bad.place == "tension of tendon tendon_1" && bad.expected.contains("0 to 100 N"), "{bad}");
    }
}

#[test]
fn state_that_does_not_fit_is_refused() {
    let mut robot = Robot::new(&scenes::robot());
    robot.go(&strokes(&[1e-3, 0.0, -2e-3, 0.0]));
    let mut shorter = robot.state.clone();
    shorter.positions.pop();
    let mut fewer = robot.state.clone();
    fewer.tensions.pop();
    let mut broken = robot.state.clone();
    broken.positions[7][1] = f64::NAN;
    let mut loose = robot.state.clone();
    loose.tensions[0] = f64::NAN;
    for state in [shorter, fewer, broken, loose] {
        let error = robot.stepper.restore(&robot.twin, &state).expect_err("a bad state");
        assert!(!matches!(error, Error::NoEquilibrium { .. }), "{error}");
    }
    robot.go(&strokes(&[1e-3, 1e-3, -2e-3, 0.0]));
}

#[test]
fn impossible_stroke_stops_at_the_last_equilibrium() {
    // Opposite tendons cannot both shorten by three quarters of their length: the body would have to
    // vanish.
    let mut robot = Robot::new(&scenes::robot());
    for tendon in &mut robot.twin.tendons {
        tendon.tension.max = 1e9;
    }
    robot.go(&strokes(&[0.0; 4]));
    let goal = 0.95 * scenes::LENGTH;
    let result = robot.try_step(&strokes(&[goal; 4]));
    let Err(Error::NoEquilibrium { reached, relative_residual, cause, hint }) = result else {
        panic!("expected no equilibrium, got {result:?}");
    };
    println!(
        "all tendons by 95 %: reached {:.1} %, residual {relative_residual:.1e}, {cause}",
        100.0 * reached
    );
    assert!(reached > 0.0 && reached < 1.0, "{reached}");
    assert!(hint.contains("reduce the stroke"));
    let strokes_there = robot.strokes();
    for stroke in &strokes_there {
        assert!((stroke - reached * goal).abs() < 1e-9, "{stroke} at {reached}");
    }
    // It is an equilibrium: stepping to its own strokes does not move it.
    let tip = robot.tip();
    let shape = robot.state.clone();
    robot.go(&strokes(&strokes_there));
    assert!(distance(tip, robot.tip()) < tolerance(1e-8));
    let moved = shape.positions.iter().zip(&robot.state.positions).map(|(a, b)| (a[2] - b[2]).abs());
    assert!(moved.fold(0.0, f64::max) < tolerance(1e-7));
    // And the robot goes on from there.
    robot.go(&strokes(&[1e-3, 0.0, 0.0, 0.0]));
}

#[test]
fn error_names_the_part_reached() {
    let cause = Cause::Inverted { element: 7 };
    let error =
        Error::NoEquilibrium { reached: 0.25, relative_residual: 0.5, cause, hint: "pull less".into() };
    assert_eq!(
        error.to_string(),
        "no equilibrium found beyond 25.0 % of the step: element 7 turns inside out (relative residual 5.0e-1; hint: \
         pull less)"
    );
}

/// Error of building the twin of a changed scene.
#[track_caller]
fn refusal(change: impl FnOnce(&mut Scene)) -> BadInput {
    let (mut scene, mesh) = scenes::robot();
    change(&mut scene);
    let error = Twin::new(&scene, &mesh).expect_err("a bad scene");
    error.bad_input().unwrap_or_else(|| panic!("{error}")).clone()
}

#[test]
fn unknown_groups_are_refused_with_the_known_ones() {
    let bad = refusal(|scene| scene.clamp = Region::Group("bottom".into()));
    assert!(bad.place == "clamp.group" && bad.found.contains("base, body, tip"), "{bad}");
    let bad = refusal(|scene| scene.tip = TipDefinition::Group("top".into()));
    assert_eq!(bad.place, "tip.group");
}

#[test]
fn empty_group_is_refused() {
    let (mut scene, mut mesh) = scenes::robot();
    mesh.groups.insert("nothing".into(), Vec::new());
    scene.tip = TipDefinition::Group("nothing".into());
    let error = Twin::new(&scene, &mesh).expect_err("an empty group");
    assert!(error.bad_input().is_some_and(|bad| bad.place == "tip.group"), "{error}");
}

#[test]
fn empty_box_is_refused() {
    let bad = refusal(|scene| scene.clamp = Region::Box { min: [1.0; 3], max: [2.0; 3] });
    assert_eq!((bad.place.as_str(), bad.found.as_str()), ("clamp", "none"));
}

#[test]
fn box_clamps_the_nodes_in_it() {
    let (mut scene, mesh) = scenes::robot();
    let base = Twin::new(&scene, &mesh).unwrap().body.n_free;
    scene.clamp = Region::Box { min: [-1.0, -1.0, -1e-6], max: [1.0, 1.0, 1e-6] };
    assert_eq!(Twin::new(&scene, &mesh).unwrap().body.n_free, base);
}

#[test]
fn points_outside_the_body_are_refused_by_name() {
    let bad = refusal(|scene| scene.tendons[2].points[4] = [0.02, 0.0, 0.02]);
    assert!(bad.place == "tendon.tendon_3.points_mm[4]" && bad.found.contains("mm outside"), "{bad}");
    let bad = refusal(|scene| scene.tip = TipDefinition::Point([0.0, 0.0, 0.05]));
    assert_eq!(bad.place, "tip.point_mm");
    let force = PointForce { at: [0.0, 0.0045, 0.041], force: [1.0, 0.0, 0.0] };
    let bad = refusal(|scene| scene.point_forces.push(force));
    assert_eq!(bad.place, "point_force[1].at_mm");
    let bad = refusal(|scene| {
        scene.auxiliary = Some(AuxiliaryLayout {
            segments: 2,
            segment_length: 4e-3,
            start: 0.038,
            radius: 5e-3,
            cables_per_segment: 2,
            first_plane: 0.0,
            plane_step: 1.0,
            drive: PrescribedQuantity::Stroke,
            tension: Bounds { min: -10.0, max: 10.0 },
            stroke: Bounds { min: 0.0, max: 5e-3 },
            stroke_rate: f64::INFINITY,
            attach_within: 1e-4,
            anchor: None,
        });
    });
    assert!(bad.place.starts_with("tendon.aux_01.points_mm[1]"), "{bad}");
}

#[test]
fn edge_frames_need_linear_elements() {
    let (scene, mesh) = scenes::robot_with(MaterialLaw::CorotationalEdges, Order::Quadratic, 4);
    let error = Twin::new(&scene, &mesh).expect_err("edges of ten nodes");
    assert!(error.bad_input().is_some_and(|bad| bad.place == "material.law"), "{error}");
}
