//! External force on a simulated robot's tip while it is recorded.

use std::path::Path;

use hysteron_base::{BadInput, Recording, file};

/// Metadata key: hash of the file that the force is from.
pub const KEY: &str = "tip_force.sha256";
/// Largest plausible force, per axis [N].
const LARGEST: f64 = 100.0;

/// A force on the tip over the time of a recording.
pub struct TipForce {
    time: Vec<f64>,
    /// In the robot's frame [N].
    force: [Vec<f64>; 3],
    /// SHA-256 of its file.
    pub hash: String,
}

impl TipForce {
    /// Reads `tip_force_x_n`, `tip_force_y_n`, `tip_force_z_n`.
    ///
    /// # Errors
    /// No recording with these channels, or a force that would break the robot.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let hash = file::sha256_of(path)?;
        let recording = Recording::read(path)?;
        let place = |bad: BadInput| bad.within(path.display());
        let axis = |axis: &str| -> Result<Vec<f64>, BadInput> {
            let name = format!("tip_force_{axis}_n");
            let values = recording.require(&name).map_err(place)?;
            match values.iter().position(|value| value.abs() > LARGEST) {
                Some(row) => {
                    let place = format!("{}: row {}: {name}", path.display(), row + 1);
                    Err(BadInput::new(place, format!("at most {LARGEST} N"), format!("{} N", values[row])))
                }
                None => Ok(values.to_vec()),
            }
        };
        let force = [axis("x")?, axis("y")?, axis("z")?];
        Ok(Self { time: recording.time().to_vec(), force, hash })
    }

    /// Force `time` [s] after a recording's first row [N]: that of the last row of the file that is not later, or of its first.
    pub fn at(&self, time: f64) -> [f64; 3] {
        let row = self.time.partition_point(|t| *t <= time + 1e-9).saturating_sub(1);
        [0, 1, 2].map(|c| self.force[c][row])
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    #[test]
    fn a_force_holds_until_the_next_row() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("push.csv");
        std::fs::write(
            &path,
            "time_s,tip_force_x_n,tip_force_y_n,tip_force_z_n\n0,0,0,0\n1,0.1,0,-0.2\n2,0,0,0\n",
        )
        .unwrap();
        let force = TipForce::read(&path).unwrap();
        let at = [-1.0, 0.99, 1.0, 1.5, 2.0, 9.0].map(|time| force.at(time)[0]);
        assert_eq!(at, [0.0, 0.0, 0.1, 0.1, 0.0, 0.0]);
        std::fs::write(&path, "time_s,tip_force_x_n,tip_force_y_n,tip_force_z_n\n0,0,0,500\n").unwrap();
        let refused = TipForce::read(&path).map(|_| ()).unwrap_err().to_string();
        assert!(refused.contains("row 1: tip_force_z_n: expected at most 100 N, got 500 N"), "{refused}");
    }
}
