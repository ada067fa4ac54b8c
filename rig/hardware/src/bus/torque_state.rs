//! Known torque state of servos that were commanded to be off.

/// Torque state of a servo after it was commanded to be off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TorqueState {
    /// The servo has confirmed that it is off.
    Off,
    /// The servo reports that it is on.
    On,
    /// The servo does not answer: it may be off, on or without power.
    Silent,
}

/// One servo and what is known of its torque.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ServoTorque {
    /// Its id.
    pub servo: u8,
    /// Its torque state.
    pub state: TorqueState,
}

/// The state of every servo, for people: `servo 2 is silent (on, off or without power), servos 1, 3, 4 are off`.
pub fn describe_torques(servos: &[ServoTorque]) -> String {
    let of = |state| -> Vec<String> {
        servos.iter().filter(|one| one.state == state).map(|one| one.servo.to_string()).collect()
    };
    let sentence = |ids: Vec<String>, one: &str, several: &str| match ids.len() {
        0 => None,
        1 => Some(format!("servo {} {one}", ids[0])),
        _ => Some(format!("servos {} {several}", ids.join(", "))),
    };
    let silent = "silent (off, on or without power)";
    let parts = [
        sentence(of(TorqueState::On), "is still on", "are still on"),
        sentence(of(TorqueState::Silent), &format!("is {silent}"), &format!("are {silent}")),
        sentence(of(TorqueState::Off), "is off", "are off"),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join("; ")
}
