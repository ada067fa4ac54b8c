//! Facts about the body that need its insides.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test may stop where it stands, and prints what it measures

mod bench;
mod creep;
mod elastica;
mod energy;
mod files;
mod forces;
mod friction;
mod golden;
mod population;
mod presets;
mod recordings;
mod whole;

use super::body::{BodySpec, TendonBody};
use hysteron_actuator::{FrictionLaw, Prony, TendonModel, TendonSpec};

/// The tube of the CoReAct paper with round numbers, four tendons, and nothing that is not asked for.
pub(super) fn spec() -> BodySpec {
    BodySpec {
        length: 0.08,
        n_sections: 8,
        stiffness: [0.019, 0.019, 0.013, 1700.0],
        section_factors: vec![1.0; 8],
        axes_angle: 0.0,
        natural_curvature: [0.0; 2],
        prony: Prony::new(vec![], vec![]).unwrap(),
        mass: 0.0,
        gravity: [0.0; 3],
        tip_load: [0.0; 3],
        guides: (0..4)
            .map(|k| {
                let angle = f64::from(k) * std::f64::consts::FRAC_PI_2;
                [0.0045 * angle.cos(), 0.0045 * angle.sin()]
            })
            .collect(),
        base_wrap: 0.5,
    }
}

/// A body with tendons of that friction.
pub(super) fn body(spec: BodySpec, friction: f64, friction_force: f64) -> TendonBody {
    body_of_law(spec, friction, friction_force, FrictionLaw::Coulomb)
}

/// The same with another law of friction.
pub(super) fn body_of_law(
    spec: BodySpec,
    friction: f64,
    friction_force: f64,
    law: FrictionLaw,
) -> TendonBody {
    let mut rest_lengths = vec![spec.length / spec.n_sections as f64; spec.n_sections + 1];
    rest_lengths[0] = 0.3;
    let tendon = TendonSpec { rest_lengths, axial_stiffness: 5000.0, friction, friction_force, law };
    let tendons = spec.guides.iter().map(|_| TendonModel::new(tendon.clone()).unwrap()).collect();
    TendonBody::new(spec, tendons)
}
