//! One trajectory of a plan, simulated.

use hysteron_base::{Metadata, Scene};
use hysteron_control::plan::Space;
use hysteron_control::{StrokeLimits, Trajectory};
use hysteron_twin::Error;
use hysteron_twin::Twin;
use hysteron_twin::synthetic::{RecordedStrokes, StrokeSource, SyntheticOutcome, Unphysical, synthesise};

use super::steer::Steered;
use crate::COMMIT;
use crate::shared::network::{Network, plant};

/// Metadata key: hash of the residual network's checkpoint.
pub(super) const NETWORK: &str = "residual.sha256";

/// The twin that simulates trajectories: uncorrected, or with its residual network.
#[derive(Clone, Copy)]
pub(crate) struct TrajectorySimulator<'a> {
    pub scene: &'a Scene,
    pub twin: &'a Twin,
    pub network: Option<&'a Network>,
    /// Within which strokes for a way of the tip are found.
    pub limits: StrokeLimits,
    /// Command that the recordings name as their origin.
    pub command: &'a str,
}

impl TrajectorySimulator<'_> {
    /// The provenance of a trajectory's recording.
    pub fn metadata(&self, trajectory: &Trajectory) -> Metadata {
        let mut meta = trajectory.metadata();
        meta.source = format!("twin {}, {}", self.scene.name, meta.source);
        meta.scene_hash.clone_from(&self.scene.hash);
        meta.commit = COMMIT.to_owned();
        meta.command = self.command.to_owned();
        if let Some(network) = self.network {
            meta.extra.insert(NETWORK.to_owned(), network.hash.clone());
        }
        meta
    }

    /// Simulates a trajectory; `go_on` is called after each sample and ends it where it returns false.
    pub fn run(
        &self,
        trajectory: &Trajectory,
        go_on: &mut dyn FnMut() -> bool,
    ) -> anyhow::Result<SyntheticOutcome> {
        let twin = self.twin;
        let mut plant = plant(self.network, twin, trajectory.rate_hz.recip())?;
        let mut simulate = |drive: &mut dyn StrokeSource| {
            synthesise(twin, &mut *plant, drive, self.metadata(trajectory), go_on)
        };
        let coordinates =
            |point: [f64; 2], strokes: &mut [f64]| trajectory.tendons.strokes_into(point, strokes);
        Ok(match trajectory.space {
            Space::Tendons => simulate(&mut RecordedStrokes::new(twin, &trajectory.commands()?)?)?,
            Space::Tip => match Steered::new(twin, trajectory, &coordinates, self.limits) {
                Ok(mut steered) => simulate(&mut steered)?,
                Err(Error::NoEquilibrium { .. }) => SyntheticOutcome::Dropped(0, Unphysical::NoEquilibrium),
                Err(other) => return Err(other.into()),
            },
        })
    }
}

/// Why a trajectory was dropped at a sample, in words.
pub(crate) fn reason(trajectory: &Trajectory, sample: usize, why: &Unphysical) -> String {
    format!("{why} at {:.2} s", sample as f64 / trajectory.rate_hz)
}
