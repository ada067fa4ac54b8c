//! A system that advances by one sample under its primary strokes: the twin alone, or with its
//! residual network; and its rest state.

use nalgebra::Vector3;

use crate::friction_points::FrictionPoints;
use crate::model::{Target, Twin};
use crate::report::StepReport;
use crate::stepper::Stepper;
use crate::tip::TipResponse;
use crate::{Result, TwinState};

/// One sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlantStep {
    /// Tip [m].
    pub tip: [f64; 3],
    /// True where an input of the network was outside its training range.
    pub is_extrapolating: bool,
    /// Radius of the band about the tip [m]; none where nothing was learned, or nothing was left out in learning.
    pub tip_band: Option<f64>,
    /// Cost and convergence of the twin's step.
    pub report: StepReport,
}

/// A system that advances by one sample under its primary strokes.
pub trait Plant {
    /// Goes on by one sample of primary strokes (n_primary) [m].
    ///
    /// # Errors
    /// Those of [`Stepper::step`].
    fn step(&mut self, primary: &[f64]) -> Result<PlantStep>;

    /// Shape and tensions now.
    fn state(&self) -> &TwinState;

    /// See [`Stepper::tip_response`].
    fn tip_response(&mut self, friction: FrictionPoints) -> Option<TipResponse>;
}

/// Most samples that a plant is given to come to rest.
const MAX_SETTLING: usize = 500;
/// Movement of the tip in a sample below which it rests, over the robot's length [-]: a few times what a step leaves.
const SETTLED: f64 = 1e-5;

/// Brings `plant`, a simulation with `twin` that has just been made, to where the robot rests under the strokes
/// `primary` (n_primary) [m]: zeros, gravity and a network hold it away from the undeformed body, and auxiliary
/// tendons get there at a limited rate. Returns the last of at most 500 samples.
///
/// # Errors
/// Those of [`Plant::step`].
pub fn relax_to_equilibrium(twin: &Twin, plant: &mut dyn Plant, primary: &[f64]) -> Result<PlantStep> {
    let still = SETTLED * twin.cables.longest();
    let mut step = plant.step(primary)?;
    for _ in 1..MAX_SETTLING {
        let before = Vector3::from(step.tip);
        step = plant.step(primary)?;
        if (Vector3::from(step.tip) - before).norm() <= still {
            break;
        }
    }
    Ok(step)
}

/// A twin whose auxiliary tendons rest.
#[derive(Debug, Clone)]
pub struct PhysicsTwin<'a> {
    twin: &'a Twin,
    resting: Vec<Target>,
    stepper: Stepper,
    targets: Vec<Target>,
}

impl<'a> PhysicsTwin<'a> {
    /// Starts from the undeformed body; see [`relax_to_equilibrium`].
    pub fn new(twin: &'a Twin) -> Self {
        let resting = twin.tendons[twin.n_primary..].iter();
        let resting = resting.map(|tendon| Target::Tension(tendon.tension.clamp(0.0))).collect();
        Self { twin, resting, stepper: Stepper::new(twin), targets: Vec::new() }
    }
}

impl Plant for PhysicsTwin<'_> {
    fn step(&mut self, primary: &[f64]) -> Result<PlantStep> {
        self.targets.clear();
        self.targets.extend(primary.iter().map(|stroke| Target::Stroke(*stroke)));
        self.targets.extend_from_slice(&self.resting);
        let report = self.stepper.step(self.twin, &self.targets)?;
        Ok(PlantStep {
            tip: self.twin.tip_of(self.stepper.state()),
            is_extrapolating: false,
            tip_band: None,
            report,
        })
    }

    fn state(&self) -> &TwinState {
        self.stepper.state()
    }

    fn tip_response(&mut self, friction: FrictionPoints) -> Option<TipResponse> {
        self.stepper.tip_response(self.twin, friction)
    }
}
