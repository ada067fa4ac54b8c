//! Where a rollout begins, and what comes from the recording along it.

use super::current::CurrentModel;
use super::data::Trajectory;

/// Where a rollout begins.
#[derive(Debug, Clone, Copy)]
pub struct Segment<'a> {
    /// The trajectory to follow.
    pub trajectory: &'a Trajectory,
    /// Its row with the initial state.
    pub start: usize,
    /// Where its currents, voltages and temperatures come from.
    pub telemetry: TelemetrySource<'a>,
}

impl<'a> Segment<'a> {
    /// From this row on, with recorded currents.
    pub fn recorded(trajectory: &'a Trajectory, start: usize) -> Self {
        Self { trajectory, start, telemetry: TelemetrySource::Recorded }
    }

    /// Goals of the motors m at a step of the rollout.
    pub(super) fn goals(&self, step: usize, m: usize) -> &'a [f64] {
        &self.trajectory.inputs_at((self.start + step) as isize)[..m]
    }
}

/// Where currents, voltages and temperatures of a rollout come from.
#[derive(Debug, Clone, Copy)]
pub enum TelemetrySource<'a> {
    /// The recording, as published: the measured current carries part of the answer.
    Recorded,
    /// A model of the drives gives the currents from errors and speeds of the simulation; voltages and temperatures stay as they
    /// were at the beginning. Nothing but goals comes from the recording.
    Modelled(&'a CurrentModel),
}
