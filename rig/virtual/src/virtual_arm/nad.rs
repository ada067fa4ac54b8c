//! The data set NAD as the virtual arm would record it: 350 trajectories in the folders of the OpenManipulator-X; and more faults than it has.

use super::task::{ArmTask, ArmTrial, Degraded, Labels, PushDirection};

/// Names of the parts of a task.
pub const SPLITS: [&str; 3] = ["train", "validation", "test"];
/// Trajectories in each of them.
const TRAJECTORIES: [usize; 3] = [8, 1, 1];

/// One trajectory of the set.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// `force_unlabeled`, `force_sensor`, `weight` or `motor_condition`; of [`fault_set`], `motor_faults`.
    pub subset: &'static str,
    /// Folder of the task.
    pub task: String,
    /// One of [`SPLITS`].
    pub split: &'static str,
    /// From 1.
    pub number: usize,
    /// Trial of the trajectory.
    pub trial: ArmTrial,
}

impl Planned {
    /// Folders and number: `weight/pick_place_object_500g/test/001`.
    pub fn name(&self) -> String {
        format!("{}/{}/{}/{:03}", self.subset, self.task, self.split, self.number)
    }
}

/// All trajectories, in the order of their folders.
pub fn data_set() -> Vec<Planned> {
    let mut all = Vec::new();
    for (subset, task, trial) in tasks() {
        for (split, n) in SPLITS.into_iter().zip(TRAJECTORIES) {
            all.extend((1..=n).map(|number| Planned { subset, task: task.clone(), split, number, trial }));
        }
    }
    all
}

/// Trajectories of each split and task of [`fault_set`].
const FAULT_TRAJECTORIES: [usize; 3] = [8, 2, 4];

/// Trajectories that NAD does not have: pick and place with every fault and without, with no payload and with
/// all its payloads.
pub fn fault_set() -> Vec<Planned> {
    let faults = [
        ("healthy", Degraded::No),
        ("band", Degraded::Band),
        ("friction", Degraded::Friction),
        ("lost_tooth", Degraded::LostTooth),
    ];
    let mut all = Vec::new();
    for grams in [0_u32, 100, 200, 300, 400, 500] {
        let carried = if grams == 0 { "empty".to_owned() } else { format!("{grams}g") };
        let payload = f64::from(grams) * 1e-3;
        for (name, degraded) in faults {
            let trial =
                ArmTrial { task: ArmTask::PickPlace, payload, push: None, degraded, labels: Labels::None };
            let task = format!("pick_place_{carried}_{name}");
            for (split, n) in SPLITS.into_iter().zip(FAULT_TRAJECTORIES) {
                all.extend((1..=n).map(|number| Planned {
                    subset: "motor_faults",
                    task: task.clone(),
                    split,
                    number,
                    trial,
                }));
            }
        }
    }
    all
}

fn tasks() -> Vec<(&'static str, String, ArmTrial)> {
    let plain = |task: ArmTask| ArmTrial {
        task,
        payload: 0.0,
        push: None,
        degraded: Degraded::No,
        labels: Labels::None,
    };
    let mut all = Vec::new();
    let free = [
        ("backward_forward", ArmTask::BackwardForward),
        ("circular_ccw", ArmTask::CircularCounterclockwise),
        ("circular_cw", ArmTask::CircularClockwise),
        ("go_up_and_stay", ArmTask::GoUpAndStay),
        ("sweep_1", ArmTask::Sweep(0)),
        ("sweep_2", ArmTask::Sweep(1)),
        ("sweep_3", ArmTask::Sweep(2)),
        ("sweep_4", ArmTask::Sweep(3)),
        ("sweep_5", ArmTask::Sweep(4)),
        ("pick_place_empty", ArmTask::PickPlace),
    ];
    all.extend(free.map(|(name, task)| ("force_unlabeled", name.to_owned(), plain(task))));
    for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
        for (sign, word) in [(1.0, "plus"), (-1.0, "minus")] {
            let pushed = |push| ArmTrial { push, labels: Labels::Sensor, ..plain(ArmTask::Push) };
            let direction = PushDirection { axis, sign };
            all.push(("force_sensor", format!("{letter}_{word}"), pushed(Some(direction))));
            all.push(("force_sensor", format!("{letter}_{word}_reference"), pushed(None)));
        }
    }
    let carried = |task, grams: u32| ArmTrial {
        payload: f64::from(grams) * 1e-3,
        labels: Labels::Weight,
        ..plain(task)
    };
    for grams in [200, 300, 400, 500] {
        all.push(("weight", format!("go_up_and_stay_still_{grams}g"), carried(ArmTask::GoUpAndStay, grams)));
    }
    for grams in [100, 200, 300, 400, 500] {
        all.push(("weight", format!("pick_place_object_{grams}g"), carried(ArmTask::PickPlace, grams)));
    }
    for (name, payload) in [("empty", 0.0), ("200g", 0.2)] {
        for (condition, degraded) in [("healthy", Degraded::No), ("degraded", Degraded::Band)] {
            let trial = ArmTrial { payload, degraded, ..plain(ArmTask::PickPlace) };
            all.push(("motor_condition", format!("pick_place_{name}_{condition}"), trial));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_set_has_the_folders_of_nad() {
        let all = data_set();
        assert_eq!(all.len(), 350);
        let of = |subset: &str| all.iter().filter(|one| one.subset == subset).count();
        assert_eq!(
            ["force_unlabeled", "force_sensor", "weight", "motor_condition"].map(of),
            [100, 120, 90, 40]
        );
        let mut names: Vec<String> = all.iter().map(Planned::name).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), 350);
    }
}
