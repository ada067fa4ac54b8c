//! Materials near ν = 1/2.

use hysteron_base::MaterialLaw;
use hysteron_fem::Order;
use hysteron_twin::{Stepper, Target, Twin};

use super::scenes;

#[test]
fn poisson_ratios_up_to_0_4999_have_equilibria() {
    for law in [MaterialLaw::Corotational, MaterialLaw::NeoHookean] {
        for order in [Order::Linear, Order::Quadratic] {
            for ratio in [0.49, 0.495, 0.499, 0.4995, 0.4999] {
                let (mut scene, mesh) = scenes::robot_with(law, order, 6);
                scene.material.poisson_ratio = ratio;
                // What a scene has by default.
                scene.solver = Default::default();
                let twin = Twin::new(&scene, &mesh).expect("a good scene");
                let mut stepper = Stepper::new(&twin);
                for stroke in [0.0, 0.3e-3, 0.6e-3] {
                    let mut targets = [Target::Stroke(-0.01); 4];
                    targets[0] = Target::Stroke(stroke);
                    let report = stepper
                        .step(&twin, &targets)
                        .unwrap_or_else(|e| panic!("{law:?}, {order:?}, ν = {ratio}, {stroke} m: {e}"));
                    assert!(report.relative_residual <= 1e-6);
                }
                let tip = twin.tip_of(stepper.state());
                assert!(tip[0] > 0.3e-3, "{law:?}, {order:?}, ν = {ratio}: {tip:?}");
            }
        }
    }
}
