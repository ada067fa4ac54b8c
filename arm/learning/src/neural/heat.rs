//! How warm drives in the loop get.

use hysteron_actuator::Drive;

use super::data::Trajectory;
use super::features::FeatureLayout;
use super::segment::Segment;
use super::simulation::SimulationOptions;

/// Temperatures of drives along rollouts. Torques follow from them, and gradients take them as given: windings warm in seconds.
#[derive(Debug, Clone)]
pub(super) struct WindingTemperatures<'a> {
    drive: Option<&'a Drive>,
    motors: usize,
    period: f64,
    /// Windings and cases at the beginning (trajectories × m) [°C], and now.
    start: Vec<[f64; 2]>,
    now: Vec<[f64; 2]>,
    /// Windings at every step so far (steps × trajectories × m) [°C].
    windings: Vec<f64>,
}

impl<'a> WindingTemperatures<'a> {
    /// Of rollouts along these segments: drives were as warm as recorded at the beginning of a recording, and warmed from there on.
    pub fn new(options: &'a SimulationOptions, features: &FeatureLayout, segments: &[Segment<'_>]) -> Self {
        let (drive, period) = (options.drive.as_ref().map(|one| &one.drive), options.period);
        let of = |drive| {
            let of_segment =
                move |one: &Segment<'_>| warmed(drive, (features, period), one.trajectory, one.start);
            segments.iter().flat_map(of_segment).collect()
        };
        let start: Vec<[f64; 2]> = drive.map(of).unwrap_or_default();
        Self { drive, motors: features.motors(), period, now: start.clone(), start, windings: Vec::new() }
    }

    /// Windings at a step (trajectories × m) [°C]; empty without drives.
    pub fn at(&self, step: usize) -> &[f64] {
        let width = self.start.len();
        &self.windings[step * width..(step + 1) * width]
    }

    /// Stores the windings of a step; the first resets them.
    pub fn begin(&mut self, step: usize) {
        if step == 0 {
            self.windings.clear();
            self.now.clone_from(&self.start);
        }
        self.windings.extend(self.now.iter().map(|[winding, _]| winding));
    }

    /// Lets a step from `states` towards `goals` pass, with these gains of the rows; all as a simulation is asked.
    pub fn pass(&mut self, states: &[f64], [goals, gains]: [&[f64]; 2]) {
        let (Some(drive), m) = (self.drive, self.motors) else { return };
        for (at, now) in self.now.iter_mut().enumerate() {
            let (row, k) = (at / m, at % m);
            let state = &states[row * 2 * m..][..2 * m];
            let off = [goals[at] - state[k], state[m + k]];
            *now = drive.warmed_by_following(gains[row], off, *now, self.period);
        }
    }
}

/// Winding and case of every motor at a row of a recording.
fn warmed(
    drive: &Drive,
    (features, period): (&FeatureLayout, f64),
    trajectory: &Trajectory,
    row: usize,
) -> Vec<[f64; 2]> {
    let m = features.motors();
    let gain = trajectory.position_gain.unwrap_or(0.0);
    let of = |k: usize| {
        let first = trajectory.inputs_at(0)[features.temperatures() + k];
        (0..row).fold([first; 2], |now, row| {
            let (state, goal) = (trajectory.state_at(row), trajectory.inputs_at(row as isize)[k]);
            drive.warmed_by_following(gain, [goal - state[k], state[m + k]], now, period)
        })
    };
    (0..m).map(of).collect()
}
