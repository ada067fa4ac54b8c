//! Servos of the X series, which share the control table of [`xl430`](super::xl430) up to the position: what differs.

use hysteron_base::BadInput;

/// Quantity in the register at address 126.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EffortRegister {
    /// The load, in thousandths of the stall torque, as the servo estimates it from its PWM.
    Load,
    /// The motor's current, in units of so many amperes [A].
    Current(f64),
}

/// A kind of servo. Source: ROBOTIS e-Manual, "Control Table" of each.
#[derive(Debug, PartialEq)]
pub struct ServoModel {
    /// As the manual and arm files call it.
    pub name: &'static str,
    /// Model number in its register.
    pub number: u16,
    /// Effort that it reports of its motor.
    pub effort: EffortRegister,
    /// Least and largest supply voltage from the factory [0.1 V].
    pub voltage: [u8; 2],
    /// Largest temperature from the factory [°C].
    pub temperature: u8,
    /// Largest profile velocity from the factory [0.229 turns per minute].
    pub velocity: u16,
    /// Gains of the position loop from the factory: P, I, D.
    pub gains: [u16; 3],
    /// Gains of the velocity loop from the factory: I, P.
    pub velocity_gains: [u16; 2],
    /// Limit of the current from the factory, in units of its current; `None` for a model without that register.
    pub current_limit: Option<u16>,
    /// Slope of the PWM from the factory; `None` for a model without that register.
    pub pwm_slope: Option<u8>,
    /// Errors that switch the torque off, from the factory.
    pub shutdown: u8,
}

/// The tendon rig's.
pub const XL430_W250: ServoModel = ServoModel {
    name: "XL430-W250",
    number: 1060,
    effort: EffortRegister::Load,
    voltage: [60, 140],
    temperature: 72,
    velocity: 265,
    gains: [640, 0, 4000],
    velocity_gains: [1000, 100],
    current_limit: None,
    pwm_slope: None,
    shutdown: 52,
};

/// The OpenManipulator-X's.
pub const XM430_W350: ServoModel = ServoModel {
    name: "XM430-W350",
    number: 1020,
    effort: EffortRegister::Current(2.69e-3),
    voltage: [95, 160],
    temperature: 80,
    velocity: 200,
    gains: [800, 0, 0],
    velocity_gains: [1920, 100],
    current_limit: Some(1193),
    pwm_slope: None,
    shutdown: 52,
};

/// Of small followers and leaders.
pub const XL330_M288: ServoModel = ServoModel {
    name: "XL330-M288",
    number: 1200,
    effort: EffortRegister::Current(1e-3),
    voltage: [35, 70],
    temperature: 70,
    velocity: 445,
    gains: [400, 0, 0],
    velocity_gains: [1600, 180],
    current_limit: Some(1750),
    pwm_slope: Some(140),
    shutdown: 53,
};

/// Of leaders that a hand moves easily.
pub const XL330_M077: ServoModel =
    ServoModel { name: "XL330-M077", number: 1190, velocity: 1620, ..XL330_M288 };

/// All that are known.
const MODELS: [&ServoModel; 4] = [&XL430_W250, &XM430_W350, &XL330_M288, &XL330_M077];

impl ServoModel {
    /// The model of that name.
    ///
    /// # Errors
    /// `BadInput` listing the known ones.
    pub fn named(key: &str, name: &str) -> Result<&'static Self, BadInput> {
        MODELS.into_iter().find(|model| model.name == name).ok_or_else(|| {
            let names = MODELS.map(|model| model.name).join(", ");
            BadInput::new(key, format!("one of {names}"), format!("\"{name}\""))
                .hint("servos of other makers, as Feetech's STS series, speak another protocol")
        })
    }
}
