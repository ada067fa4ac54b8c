//! Shared parts of tests, and tests of the whole chain against the finite elements.

use hysteron_base::MaterialLaw;
use hysteron_fem::Order;
use rand::RngExt;

use super::balance::ChainBalance;
use super::band::BlockVector;
use super::cut::Cut;
use super::tangent::TangentAssembly;
use super::warping::{interfaces, responses, rest};
use super::{BLOCK, Chain, Interface};
use crate::coreact::distance;
use crate::equilibrium_residual::StepTargets;
use crate::{Stepper, Target, Twin, scenes};

/// A chain away from rest.
pub(super) struct Moved {
    pub chain: Chain,
    pub interfaces: Vec<Interface>,
    /// Tension of each cable [N].
    pub tensions: Vec<f64>,
}

/// A chain with tendons, friction points, a constant load and curved interfaces: turns of a tenth of a radian from section to
/// section, and a tenth of a millimetre of everything else.
pub(super) fn moved_chain() -> (Twin, Moved) {
    let (mut scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, 24);
    scene.gravity = [3.0, -5.0, 9.0];
    scenes::roughen(&mut scene, 1e-4);
    let twin = Twin::new(&scene, &mesh).expect("a good scene");
    let chain = Chain::new(&twin).expect("a chain");
    let mut rng = hysteron_base::rng(1, "chain/moved");
    let mut interfaces = chain.rest.clone();
    for i in 1..interfaces.len() {
        let change: Vec<BlockVector> = (1..interfaces.len())
            .map(|k| {
                let mut change = [0.0; BLOCK];
                if k >= i {
                    change[..6].fill_with(|| 1e-4 * rng.random_range(-1.0..1.0));
                    let turn: [f64; 3] = [0.08, -0.05, 0.03];
                    for c in 0..3 {
                        change[3 + c] += chain.lever * turn[c];
                    }
                }
                if k == i {
                    change[6..].fill_with(|| 1e-4 * rng.random_range(-1.0..1.0));
                }
                change
            })
            .collect();
        chain.apply(1.0, &change, &mut interfaces);
    }
    let tensions = (0..twin.cables.len()).map(|_| rng.random_range(0.0..2.0)).collect();
    (twin, Moved { chain, interfaces, tensions })
}

impl Chain {
    /// The same, its parts held where the strain of their sections brings them.
    pub(super) fn without_sinks(mut self) -> Self {
        self.sinks.clear();
        self.reach.iter_mut().for_each(|reach| reach.sinks.clear());
        self
    }
}

/// The same robot, moved by a chain of its own.
fn reduced(twin: &Twin) -> Twin {
    twin.clone().with_chain(Chain::new(twin).expect("a chain"))
}

#[test]
fn small_deflections_are_those_of_the_finite_elements_where_the_warpings_span_them() {
    // Nine unit loads have nine responses: all of them are in the basis of ten warpings, so only round-off is left.
    let mesh = scenes::tube(0.04, 0.006, 0.0025, 24, Order::Quadratic);
    let mut scene = scenes::scene("beam", MaterialLaw::SmallStrain);
    // So little that geometric terms, weight over E A, are 1e-11.
    scene.gravity = [1e-6, -2e-6, 3e-6];
    let twin = Twin::new(&scene, &mesh).expect("a good scene");
    let chain = Chain::new(&twin).expect("a chain");
    let load: Vec<f64> =
        twin.loads[..twin.body.n_free].iter().flat_map(|force| force[..3].to_vec()).collect();
    let exact = &responses(&twin.body, vec![load]).expect("a factor")[0];
    let mut balance = ChainBalance::new(&chain);
    balance.evaluate(&chain, &StepTargets::new(&twin, &[]), &chain.rest, &[]);
    let mut tangent = TangentAssembly::pattern(&chain);
    TangentAssembly::new(&chain).assemble_into(&chain, &balance, &[], &mut tangent);
    assert_eq!(tangent.factorize(), Some(0));
    let mut change = balance.residual.clone();
    tangent.solve(&mut change);
    let interfaces = interfaces(&twin, &Cut::new(&twin.body, &[]).expect("a cut")).expect("responses");
    let largest = exact.iter().fold(0.0f64, |max, u| max.max(u.abs()));
    assert!(largest > 1e-12);
    for (interface, change) in interfaces[1..].iter().zip(&change) {
        for (node, warpings) in interface.nodes.iter().zip(&interface.warpings) {
            let arm = rest(&twin.body, *node) - interface.center;
            let turn = nalgebra::Vector3::new(change[3], change[4], change[5]) / chain.lever;
            let rigid = nalgebra::Vector3::new(change[0], change[1], change[2]) + turn.cross(&arm);
            let moved = warpings.iter().zip(&change[6..]).fold(rigid, |sum, (warping, w)| sum + *w * warping);
            for c in 0..3 {
                // The chain moves against its residual.
                let error = (moved[c] + exact[3 * *node as usize + c]).abs();
                assert!(error < 1e-9 * largest, "node {node}: {error} of {largest}");
            }
        }
    }
}

#[test]
fn pulled_chain_follows_its_finite_elements() {
    let (scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, 24);
    let twin = Twin::new(&scene, &mesh).expect("a good scene");
    let reduced = reduced(&twin);
    let (mut fine, mut coarse) = (Stepper::new(&twin), Stepper::new(&reduced));
    for k in 1..=10 {
        let part = 2e-4 * f64::from(k);
        let targets = [part, 0.3 * part, -part, -0.3 * part].map(Target::Stroke);
        fine.step(&twin, &targets).expect("an equilibrium");
        let report = coarse.step(&reduced, &targets).expect("an equilibrium of the chain");
        let (tip, moved) = (twin.tip_of(fine.state()), reduced.tip_of(coarse.state()));
        let rest = twin.tip_of(&twin.rest());
        let apart = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
        let error = apart(tip, moved) / apart(tip, rest);
        // Of a turn by 25 degrees in 40 mm: what the energy leaves out is of fourth order.
        assert!(error < 1e-3, "{k}: tip {error}");
        let error = (fine.state().tensions[0] - coarse.state().tensions[0]).abs() / fine.state().tensions[0];
        assert!(error < 1e-3, "{k}: tension {error}");
        assert!(report.relative_residual <= twin.accuracy.relative_residual);
    }
}

#[test]
fn compliance_and_tip_response_are_derivatives_by_tensions() {
    let (mut scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, 24);
    scene.solver.relative_residual = 1e-12;
    scene.gravity = [3.0, -5.0, 9.0];
    for tendon in &mut scene.tendons {
        tendon.compliance = 1e-4;
    }
    let twin = Twin::new(&scene, &mesh).expect("a good scene");
    let twin = reduced(&twin);
    let tensions = [4.0, 1.0, 0.5, 2.0];
    let mut stepper = Stepper::new(&twin);
    let mut at = |tensions: [f64; 4]| {
        stepper.step(&twin, &tensions.map(Target::Tension)).expect("an equilibrium");
        let tip = twin.tip_of(stepper.state());
        (tip, twin.pulled(stepper.state()))
    };
    // How far cable points sink in depends on the shape, which the tangent leaves out: a part T/l C of the sinking, which is a
    // few thousandths of the stroke here.
    const NEGLECTED: f64 = 1e-3;
    // Third derivatives are of the size of the first over tensions of newtons, squared: 1e-6 at a millinewton.
    let h = 1e-3;
    let mut differences = Vec::new();
    for j in 0..4 {
        let moved = |sign: f64| {
            let mut moved = tensions;
            moved[j] += sign * h;
            moved
        };
        let ((tip_ahead, ahead), (tip_behind, behind)) = (at(moved(1.0)), at(moved(-1.0)));
        let tip: [f64; 3] = std::array::from_fn(|c| (tip_ahead[c] - tip_behind[c]) / (2.0 * h));
        let strokes: Vec<f64> = ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * h)).collect();
        differences.push((tip, strokes));
    }
    at(tensions);
    let delassus = stepper.delassus(&twin).expect("a factor");
    let tip = stepper.tip_derivatives(&twin, &[]).expect("a factor").per_tension;
    let largest = delassus.iter().fold(0.0f64, |max, w| max.max(w.abs()));
    let farthest = tip.iter().flatten().fold(0.0f64, |max, w| max.max(w.abs()));
    for (j, (by_tip, by_strokes)) in differences.iter().enumerate() {
        for i in 0..4 {
            let (exact, difference) = (delassus[4 * i + j], by_strokes[i]);
            assert!((exact - difference).abs() < NEGLECTED * largest, "{i} {j}: {exact} and {difference}");
        }
        for c in 0..3 {
            assert!(
                (tip[c][j] - by_tip[c]).abs() < NEGLECTED * farthest,
                "{c} {j}: {} and {}",
                tip[c][j],
                by_tip[c]
            );
        }
    }
    assert!(farthest > 1e-4 && largest > 1e-5);
}

#[test]
fn friction_leaves_the_chain_where_it_leaves_the_finite_elements() {
    let (mut scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, 24);
    scenes::roughen(&mut scene, 1e-5);
    scene.friction = Some(hysteron_base::Friction { backlash: 1e-4, ..scenes::ROUGH });
    let twin = Twin::new(&scene, &mesh).expect("a good scene");
    let reduced = reduced(&twin);
    let (mut fine, mut coarse) = (Stepper::new(&twin), Stepper::new(&reduced));
    let mut turned = Vec::new();
    for k in 0..60 {
        // There and back: the way back lags behind.
        let stroke = 1e-3 * (f64::from(k) / 30.0 * std::f64::consts::PI).sin().abs();
        let targets = [stroke, 0.0, -stroke, 0.0].map(Target::Stroke);
        fine.step(&twin, &targets).expect("an equilibrium");
        coarse.step(&reduced, &targets).expect("an equilibrium of the chain");
        let (tension, other) = (fine.state().tensions[0], coarse.state().tensions[0]);
        // Of three newtons: a thousandth, as without friction.
        assert!((tension - other).abs() < 3e-3, "{k}: {tension} and {other}");
        turned.push(tension);
    }
    assert!(turned[15] > 2.0 && (turned[10] - turned[20]).abs() > 0.2, "{turned:?}");
}

#[test]
fn tendon_that_ends_within_a_section_sinks_in_as_in_the_finite_elements() {
    let (mut scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, 24);
    // Between the layers at 30 and 31.7 mm; sections end at 30 and 35 mm.
    scene.tendons = vec![scenes::tendon(0, 0.0309, scenes::TENDON_RADIUS, 4)];
    let twin = Twin::new(&scene, &mesh).expect("a good scene");
    let chain = Chain::new(&twin).expect("a chain");
    let exact = Stepper::new(&twin).delassus(&twin).expect("a factor")[0];
    let of = |chain: Chain| {
        let reduced = twin.clone().with_chain(chain);
        Stepper::new(&reduced).delassus(&reduced).expect("a factor")[0]
    };
    // The response to the tension is in the basis, so that only weaker ones of other loads are left out.
    let error = (of(chain.clone()) - exact).abs() / exact;
    assert!(error < 1e-4, "{error}");
    assert!(!chain.sinks.is_empty());
    let error = (of(chain.without_sinks()) - exact).abs() / exact;
    assert!(error > 1e-2, "{error}: an end that does not sink in tests nothing");
}

/// The robot of the tests with everything that a chain follows, in two versions.
fn variants() -> (Twin, Twin) {
    let (mut scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, 24);
    scene.solver.relative_residual = 1e-9;
    scene.gravity = [3.0, -5.0, 9.0];
    scene.auxiliary = scenes::actuated(4).0.auxiliary;
    let made = Twin::new(&scene, &mesh).expect("a good scene");
    scenes::roughen(&mut scene, 1e-4);
    scene.friction = Some(hysteron_base::Friction { backlash: 1e-4, ..scenes::ROUGH });
    scene.material.youngs_modulus *= 1.7;
    scene.material.density *= 0.6;
    scene.gravity = [-2.0, 7.0, 1.0];
    scene.tracker.turn = [0.1, -0.2, 0.3];
    scene.tendons[1].zero = 2e-4;
    scene.auxiliary = None;
    (made, Twin::new(&scene, &mesh).expect("a good scene"))
}

#[test]
fn chain_of_a_changed_scene_is_that_made_from_it() {
    let (made, changed) = variants();
    let chain = Chain::new(&made).expect("a chain");
    let carried = changed.clone().with_chain(chain.of(&changed).expect("the same body"));
    let again = reduced(&changed);
    let (mut of, mut anew) = (Stepper::new(&carried), Stepper::new(&again));
    for k in 1..=20 {
        let targets = [1e-4, 0.0, -1e-4, 3e-5].map(|step| Target::Stroke(f64::from(k) * step));
        of.step(&carried, &targets).expect("an equilibrium");
        anew.step(&again, &targets).expect("an equilibrium");
    }
    let (state, other) = (of.state(), anew.state());
    let strongest = other.tensions.iter().fold(0.0f64, |max, tension| max.max(tension.abs()));
    for (tension, other) in state.tensions.iter().zip(&other.tensions) {
        // The warpings of the first also follow auxiliary tendons, so that those of the others are a little different.
        assert!((tension - other).abs() < 2e-3 * strongest, "{tension} for {other} of {strongest} N");
    }
    let (tip, expected) = (carried.tip_of(state), again.tip_of(other));
    let moved = distance(expected, again.tip_of(&again.rest()));
    assert!(moved > 2e-3 && distance(tip, expected) < 2e-3 * moved, "{tip:?} for {expected:?}");
    assert_eq!(state.slip.len(), changed.friction.len());
}

#[test]
fn chain_of_another_body_is_refused() {
    let (made, changed) = variants();
    let refused = |chain: &Chain, twin: &Twin| chain.of(twin).expect_err("another body").to_string();
    let without = Chain::new(&changed).expect("a chain");
    let found = refused(&without, &made);
    assert!(found.contains("auxiliary") && found.contains("without them"), "{found}");
    let (mut scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, 24);
    scene.material.poisson_ratio = 0.41;
    let found = refused(&without, &Twin::new(&scene, &mesh).expect("a good scene"));
    assert!(found.contains("Poisson's ratio"), "{found}");
}

#[test]
fn twin_with_the_numbers_of_another_scene_is_the_one_built_from_it() {
    let (mut scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, 24);
    scenes::roughen(&mut scene, 1e-4);
    scene.point_forces = vec![hysteron_base::PointForce { at: [0.0, 0.005, 0.02], force: [0.0, 0.01, 0.0] }];
    let twin = Twin::new(&scene, &mesh).expect("a good scene");
    let mut other = scene.clone();
    (other.gravity, other.material.youngs_modulus) = ([1.0, 2.0, -3.0], 0.7 * scene.material.youngs_modulus);
    (other.tendons[1].zero, other.tendons[2].compliance) = (3e-4, 2e-5);
    other.friction.as_mut().expect("friction").coefficient *= 2.0;
    for known in [twin.clone(), reduced(&twin)] {
        let fresh = Twin::new(&other, &mesh).expect("a good scene");
        let fresh = match &known.chain {
            Some(chain) => fresh.clone().with_chain(chain.of(&fresh).expect("the same body")),
            None => fresh,
        };
        let changed = known.clone().with_numbers_of(&other).expect("the same body");
        let state = |twin: &Twin| {
            let mut stepper = Stepper::new(twin);
            for part in [0.5, 1.0] {
                let targets = [2e-3, 3e-4, -2e-3, 0.0].map(|stroke| Target::Stroke(part * stroke));
                stepper.step(twin, &targets).expect("an equilibrium");
            }
            (stepper.state().tensions.clone(), twin.tip_of(stepper.state()))
        };
        let (found, expected) = (state(&changed), state(&fresh));
        // Forces without gravity are those with it less gravity: round-off.
        let far = found.0.iter().zip(&expected.0).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(
            far < 1e-9 * expected.0[0] && distance(found.1, expected.1) < 1e-11,
            "{found:?} {expected:?}"
        );
        assert_ne!(expected.0, state(&known).0);
        let smooth = hysteron_base::Scene { friction: None, ..other.clone() };
        assert!(known.clone().with_numbers_of(&smooth).is_none());
        let mut elsewhere = other.clone();
        elsewhere.tendons[0].points[1][2] += 1e-4;
        assert!(known.with_numbers_of(&elsewhere).is_none());
    }
}
