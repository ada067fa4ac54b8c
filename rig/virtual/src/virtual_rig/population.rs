//! How members of a population of virtual robots differ: a little around one robot, or in everything that a bench
//! may get wrong.

/// How the members of a population differ from the robot in the middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Population {
    /// Normally distributed around it: the same design from the same bench.
    Around(PopulationSpread),
    /// Evenly between limits, mounted anyhow, measured in any frame, with another law of friction.
    Wide(Ranges),
}

/// Standard deviations over a population: relative ones as logarithms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PopulationSpread {
    /// Of all stiffnesses of the body together [-].
    pub stiffness: f64,
    /// Of the ratio of the two bending stiffnesses [-].
    pub anisotropy: f64,
    /// Of the direction of the principal axes [rad].
    pub axes_angle: f64,
    /// Of each component of the natural curvature [1/m].
    pub natural_curvature: f64,
    /// Of the weights of creep [-].
    pub creep: f64,
    /// Of friction at the guides [-].
    pub friction: f64,
    /// Of the tendons' stiffness [-].
    pub tendon_stiffness: f64,
    /// Of each tendon's slack [m].
    pub slack: f64,
    /// Of the play [-].
    pub play: f64,
    /// Of the servos' friction [-].
    pub servo_friction: f64,
}

/// Smallest and largest values over a population. Factors, on the value of the robot in the middle, are drawn evenly
/// by their logarithm, everything else evenly.
///
/// Also drawn, without ranges to give: the direction of gravity, from all directions; the tracker's frame,
/// turned any way; the direction of the principal axes; and the law of friction, Dahl's or Prandtl's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ranges {
    /// Factor of all stiffnesses of the body together [-].
    pub stiffness: [f64; 2],
    /// Ratio of the two bending stiffnesses [-].
    pub bending_ratio: [f64; 2],
    /// Factor of each section's stiffness [-].
    pub section: [f64; 2],
    /// Each component of the natural curvature [1/m].
    pub natural_curvature: [f64; 2],
    /// Factor of the weights of creep [-].
    pub creep: [f64; 2],
    /// Each coordinate of each tendon's offset [m].
    pub guide_offset: [f64; 2],
    /// Each tendon's angle beyond its own [rad].
    pub guide_angle: [f64; 2],
    /// Factor of the tendons' stiffness [-].
    pub tendon_stiffness: [f64; 2],
    /// Factor of friction at the guides [-].
    pub friction: [f64; 2],
    /// Slip over which friction gives way [m].
    pub presliding: [f64; 2],
    /// Play of all tendons [m].
    pub play: [f64; 2],
    /// Each tendon's zero error [m].
    pub zero_error: [f64; 2],
    /// Slack of the one tendon that is slack, at stroke zero [m].
    pub slack_tendon: [f64; 2],
    /// Factor of each pulley's radius, which the rig file does not know [-].
    pub pulley: [f64; 2],
    /// Factor of the servos' friction [-].
    pub servo_friction: [f64; 2],
    /// Each coordinate of the robot in the tracker's frame [m].
    pub tracker_position: [f64; 2],
}
