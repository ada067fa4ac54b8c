//! The interface between the program and a rig: a real one or an emulated one through its ports, or one simulated in this
//! process on a clock of its own.

use crate::bus::{BusCounts, ServoReport};
use crate::{Event, Pose, Result};

/// Reading of one servo in one cycle.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ServoSample {
    /// Position of the output [ticks].
    pub position: i32,
    /// Speed of the output [rad/s].
    pub velocity: f64,
    /// Load, -1 to 1 of the stall torque, positive in the direction of positive ticks [-].
    pub load: f64,
    /// Whether the motor is driven.
    pub torque_on: bool,
    /// Register of hardware errors; 0 if there is none.
    pub hardware_error: u8,
}

/// Reading of one servo at a lower rate.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SlowSample {
    /// Supply voltage [V].
    pub voltage: f64,
    /// Temperature [°C].
    pub temperature: f64,
}

/// A rig with its servos and its tracker, on one clock.
pub trait Hardware {
    /// Time on the rig's clock [s].
    fn now(&self) -> f64;
    /// Waits until that time [s]; returns at once if it is past.
    fn wait_until(&mut self, time: f64);
    /// Whether that clock is real time, so that a cycle must not wait for anything else.
    fn is_real_time(&self) -> bool;
    /// Number of servos, one per tendon.
    fn n_servos(&self) -> usize;
    /// Checks every servo against the rig file and makes it ready, with its torque off.
    ///
    /// # Errors
    /// `Bus` with everything that is wrong.
    fn prepare(&mut self) -> Result<Vec<ServoReport>>;
    /// Commands all servos (n_servos) [ticks].
    ///
    /// # Errors
    /// `Bus` if the command could not be sent.
    fn write_goals(&mut self, goals: &[i32]) -> Result<()>;
    /// Reads all servos (n_servos); `None` for one that did not answer although asked again.
    ///
    /// # Errors
    /// `Bus` if nothing could be sent.
    fn read_servos(&mut self, samples: &mut [Option<ServoSample>]) -> Result<()>;
    /// Reads voltage and temperature of all servos (n_servos); `None` as above.
    ///
    /// # Errors
    /// `Bus` if nothing could be sent.
    fn read_slow(&mut self, samples: &mut [Option<SlowSample>]) -> Result<()>;
    /// Switches the torque of all servos on, and makes sure that they did. While it is on, silence on the bus stops
    /// them.
    ///
    /// # Errors
    /// `Bus` naming the servos that did not confirm.
    fn enable_torque(&mut self) -> Result<()>;
    /// Switches the torque of all servos off at once, also if some are silent, and then confirms it.
    ///
    /// # Errors
    /// `Bus` naming the servos that did not confirm.
    fn disable_torque(&mut self) -> Result<()>;
    /// Leaves the torque on, and silence on the bus without consequence.
    ///
    /// # Errors
    /// `Bus` naming the servos that did not confirm.
    fn hold(&mut self) -> Result<()>;
    /// Channels of instruments other than servos and tracker, as recordings name them; none by default.
    fn instruments(&self) -> Vec<String> {
        Vec::new()
    }
    /// Appends what they show now, one number each.
    fn read_instruments(&mut self, _values: &mut Vec<f64>) {}
    /// Appends the poses that came since the last call, in the tracker's frame, on the rig's clock.
    fn take_poses(&mut self, poses: &mut Vec<Pose>);
    /// Appends what went wrong since the last call, on the rig's clock: one event each.
    fn take_events(&mut self, events: &mut Vec<Event>);
    /// Counts of the bus traffic and its errors.
    fn counts(&self) -> BusCounts;
    /// Processor time that this process has used [s], where that is of interest: in real time.
    fn processor_time(&self) -> Option<f64>;
    /// Time that the transfers of the last cycle took, and that their bytes take on the wire [s].
    fn bus_time(&self) -> (f64, f64);
}
