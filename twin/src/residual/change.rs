//! How a robot has changed since its network was trained, in a few physical numbers that act before twin and network.
//!
//! A tendon that is tensioned again behaves at the stroke u as before at u + z. A servo with new backlash behaves
//! at u as before at u after a backlash of that size, because backlashes in series add up. Both are therefore exact in
//! front of the whole model, network included. Increased friction is another factor on all friction of the twin.

use hysteron_actuator::Play;
use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

use crate::model::Twin;

/// A change of the robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotChange {
    /// Length by which each primary tendon is pulled beyond its stroke [m]; negative is slack.
    pub zeros_m: Vec<f64>,
    /// Play of the servos beyond that of the training, from flank to flank [m].
    pub play_m: f64,
    /// Friction over that of the scene [-].
    pub friction_ratio: f64,
}

impl RobotChange {
    /// None, of a robot with so many primary tendons.
    pub fn none(n_primary: usize) -> Self {
        Self { zeros_m: vec![0.0; n_primary], play_m: 0.0, friction_ratio: 1.0 }
    }

    /// True where nothing has changed.
    pub fn is_none(&self) -> bool {
        *self == Self::none(self.zeros_m.len())
    }

    /// Refuses numbers that no robot with so many primary tendons has.
    ///
    /// # Errors
    /// `BadInput` naming the number.
    pub fn check(&self, n_primary: usize) -> Result<(), BadInput> {
        if self.zeros_m.len() != n_primary || !self.zeros_m.iter().all(|zero| zero.is_finite()) {
            let found = format!("{:?}", self.zeros_m);
            return Err(BadInput::new("change.zeros_m", format!("{n_primary} finite numbers"), found));
        }
        for (name, value) in [("play_m", self.play_m), ("friction_ratio", self.friction_ratio)] {
            if !(value >= 0.0 && value.is_finite()) {
                let place = format!("change.{name}");
                return Err(BadInput::new(place, "a finite number >= 0", value.to_string()));
            }
        }
        Ok(())
    }

    /// The twin with as much more friction.
    pub(super) fn twin(&self, twin: &Twin) -> Twin {
        let mut changed = twin.clone();
        for point in &mut changed.friction {
            point.coefficient *= self.friction_ratio;
            point.constant *= self.friction_ratio;
        }
        changed
    }
}

/// Strokes on their way through a change.
#[derive(Debug, Clone)]
pub(super) struct ChangedStrokes {
    change: RobotChange,
    /// By tendon; none before the first sample.
    plays: Vec<Play>,
}

impl ChangedStrokes {
    pub fn new(change: &RobotChange) -> Self {
        Self { change: change.clone(), plays: Vec::new() }
    }

    /// Writes what the commanded strokes of the next sample (n_primary) come to [m].
    pub fn follow_into(&mut self, commanded: &[f64], strokes: &mut Vec<f64>) {
        if self.plays.is_empty() {
            self.plays = commanded.iter().map(|&stroke| Play::new(self.change.play_m, stroke)).collect();
        }
        let through = self.plays.iter_mut().zip(commanded).map(|(play, stroke)| play.follow(*stroke));
        strokes.clear();
        strokes.extend(through.zip(&self.change.zeros_m).map(|(stroke, zero)| stroke + zero));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plays_in_a_row_add_up_and_zeros_shift() {
        let of = |play_m, zero| RobotChange { zeros_m: vec![zero], play_m, friction_ratio: 1.0 };
        let [mut first, mut second] =
            [of(3e-4, 1e-4), of(2e-4, -5e-4)].map(|change| ChangedStrokes::new(&change));
        let mut both = ChangedStrokes::new(&of(5e-4, -4e-4));
        let (mut between, mut after, mut at_once) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..500 {
            let stroke = 3e-3 * (0.05 * f64::from(i)).sin() * (0.013 * f64::from(i)).cos();
            first.follow_into(&[stroke], &mut between);
            second.follow_into(&between, &mut after);
            both.follow_into(&[stroke], &mut at_once);
            // Round-off of sums of millimetres.
            assert!((after[0] - at_once[0]).abs() < 1e-17, "{i}: {after:?} {at_once:?}");
        }
    }

    #[test]
    fn numbers_that_no_robot_has_are_named() {
        let none = RobotChange::none(2);
        assert!(none.is_none() && none.check(2).is_ok());
        let bad = [
            ("change.zeros_m", RobotChange::none(3)),
            ("change.zeros_m", RobotChange { zeros_m: vec![0.0, f64::NAN], ..none.clone() }),
            ("change.play_m", RobotChange { play_m: -1e-6, ..none.clone() }),
            ("change.friction_ratio", RobotChange { friction_ratio: f64::INFINITY, ..none.clone() }),
        ];
        for (place, change) in bad {
            let message = change.check(2).err().map(|bad| bad.to_string()).unwrap_or_default();
            assert!(message.starts_with(place), "{message}");
        }
    }
}
