//! Response of the tip and of tensions to a force, against equilibria under that force.

use hysteron_twin::{FrictionPoints, Stepper, Target, Twin};

use super::{scenes, strokes};

/// Force of central differences [N]: moves the tip by some 10 µm, a thousandth of the bend; second order is 1e-6 of the response.
const FORCE: f64 = 1e-2;
/// One per cent: ten times what the adjoint solves leave.
const EXACT: f64 = 0.01;

/// Tip and tensions of `twin` after the strokes `bent`, then under a force on the tip, strokes held.
fn under(twin: &Twin, bent: &[Target], force: [f64; 3]) -> ([f64; 3], Vec<f64>) {
    let mut loaded = twin.clone();
    let mut stepper = Stepper::new(twin);
    stepper.step(twin, bent).expect("an equilibrium");
    for (node, weight) in twin.tip.nodes.iter().zip(&twin.tip.weights) {
        for c in 0..3 {
            loaded.loads[*node as usize][c] += weight * force[c];
        }
    }
    stepper.step(&loaded, bent).expect("an equilibrium");
    (loaded.tip_of(stepper.state()), stepper.state().tensions.clone())
}

#[test]
fn a_force_moves_the_tip_and_changes_tensions_by_the_response() {
    let (mut scene, mesh) = scenes::robot();
    scene.tendons.iter_mut().for_each(|tendon| tendon.compliance = 1e-4);
    let twin = Twin::new(&scene, &mesh).expect("a good scene");
    let bent = strokes(&[4e-3, 2e-3, -3e-3, 1e-3]);
    let mut stepper = Stepper::new(&twin);
    stepper.step(&twin, &bent).expect("an equilibrium");
    let response = stepper.tip_response(&twin, FrictionPoints::Slipping).expect("a stiffness");
    // By Betti's theorem, -(∂y/∂s)ᵀ: the response of each tension to a force on the tip.
    let by_force = |j: usize| [0, 1, 2].map(|c| -response.per_stroke[c][j]);
    let tensions: Vec<[f64; 3]> = (0..response.per_stroke[0].len()).map(by_force).collect();
    let size = |values: &[f64]| values.iter().fold(0.0f64, |size, value| size.max(value.abs()));
    let (yields, pulls) = (size(response.per_force.as_flattened()), size(tensions.as_flattened()));
    assert!(yields > 1e-4 && pulls > 0.1, "a robot that feels nothing: {yields} m/N, {pulls}");
    for axis in 0..3 {
        let force = |sign: f64| std::array::from_fn(|c| if c == axis { sign * FORCE } else { 0.0 });
        let (ahead, behind) = (under(&twin, &bent, force(1.0)), under(&twin, &bent, force(-1.0)));
        for c in 0..3 {
            let difference = (ahead.0[c] - behind.0[c]) / (2.0 * FORCE);
            let error = (difference - response.per_force[c][axis]).abs();
            assert!(error < EXACT * yields, "tip {c} by force {axis}: {difference} {:?}", response.per_force);
            // Maxwell and Betti.
            let turned = (response.per_force[c][axis] - response.per_force[axis][c]).abs();
            assert!(turned < EXACT * yields, "{:?}", response.per_force);
        }
        for (j, by) in tensions.iter().enumerate() {
            let difference = (ahead.1[j] - behind.1[j]) / (2.0 * FORCE);
            assert!(
                (difference - by[axis]).abs() < EXACT * pulls,
                "tension {j} by force {axis}: {difference} {by:?}"
            );
        }
    }
}
