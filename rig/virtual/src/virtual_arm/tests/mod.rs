//! The physics of the virtual arm against facts that are independent of it.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod files;
mod motion;
mod rest;
mod trajectories;

use super::{GearFriction, VirtualArm};

fn arm() -> VirtualArm {
    VirtualArm::preset("open-manipulator-x").unwrap()
}

const FRICTIONLESS: GearFriction = GearFriction {
    base: 0.0,
    stribeck: 0.0,
    load: [0.0; 2],
    load_stribeck: [0.0; 2],
    load_squared: [0.0; 2],
    stribeck_speed: 1.0,
    alpha: 1.0,
    viscous: 0.0,
};

/// That of the preset, its joints without ends.
fn endless() -> VirtualArm {
    let mut arm = arm();
    for link in &mut arm.chain.links {
        link.range = [-1e3, 1e3];
    }
    arm
}

/// Without friction, backlash or damping of the teeth either.
fn ideal() -> VirtualArm {
    let mut arm = endless();
    for servo in &mut arm.servos {
        (servo.friction, servo.bearing, servo.backlash, servo.damping) = (FRICTIONLESS, 0.0, 0.0, 0.0);
    }
    arm
}
