//! All that must be saved to resume: the configuration of the body, tensions, how much of the load is applied, and the history
//! of friction and backlash.

use crate::chain::Interface;

/// A configuration of the twin.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TwinState {
    /// Node positions [m], model order, padded; of a chain none, see [`crate::Twin::nodes_of`].
    pub positions: Vec<[f64; 4]>,
    /// Interfaces of a chain, the clamped one first; of finite elements none.
    pub interfaces: Vec<Interface>,
    /// Tension of each tendon [N], then the jump of tension at each friction point, negative where the tendon is pulled
    /// through it.
    pub tensions: Vec<f64>,
    /// Part of the constant loads that is applied: 0 at rest, 1 after the first step.
    pub load: f64,
    /// Length of tendon that has slid past each friction point towards the pulled end, where it stuck last [m].
    pub slip: Vec<f64>,
    /// Stroke behind the backlash of each real tendon [m]; empty without backlash.
    pub backlash: Vec<f64>,
}
