//! A twin that follows a command sample by sample: by its strokes and tensions, towards goals of its tip, or with its
//! residual network.

use super::Command;
use crate::model::Twin;
use crate::plant::{Plant, PlantStep};
use crate::report::StepReport;
use crate::residual::CorrectedRollout;
use crate::stepper::Stepper;
use crate::{Result, TwinState};

/// One sample of a command that was followed.
#[derive(Debug, Clone, PartialEq)]
pub struct CommandStep {
    /// Tip [m].
    pub tip: [f64; 3],
    /// Strokes that servos show (n_tendons) [m].
    pub strokes: Vec<f64>,
    /// True where an input of the network was outside its training range.
    pub is_extrapolating: bool,
    /// Radius of the band about the tip [m]; none without a network that has one.
    pub tip_band: Option<f64>,
    /// QPs solved for strokes that goals left open; none without goals.
    pub rounds: usize,
    /// Cost and convergence of the step.
    pub report: StepReport,
}

/// Model that moves the robot from sample to sample.
#[derive(Debug)]
enum Driver<'a> {
    Stepper(Box<Stepper>),
    Network(Box<CorrectedRollout<'a>>),
}

/// A twin that follows a command.
#[derive(Debug)]
pub struct CommandRollout<'a> {
    twin: &'a Twin,
    command: &'a Command<'a>,
    driver: Driver<'a>,
    state: TwinState,
    rest: [f64; 3],
    farthest: Farthest,
    n_outside: usize,
}

/// Sample in which the tip was farthest from rest.
#[derive(Debug)]
struct Farthest {
    row: usize,
    state: TwinState,
    /// Squared distance [m²].
    square: f64,
}

impl<'a> CommandRollout<'a> {
    /// From the equilibrium `start`, before sample `row`; a network begins at rest, whatever `start` is.
    ///
    /// # Errors
    /// Those of [`Stepper::restore`].
    pub fn new(
        twin: &'a Twin,
        command: &'a Command<'a>,
        network: Option<CorrectedRollout<'a>>,
        (start, row): (&TwinState, usize),
    ) -> Result<Self> {
        let driver = match network {
            Some(network) => Driver::Network(Box::new(network)),
            None => {
                let mut stepper = Stepper::new(twin);
                stepper.restore(twin, start)?;
                Driver::Stepper(Box::new(stepper))
            }
        };
        let farthest = Farthest { row, state: start.clone(), square: f64::NEG_INFINITY };
        let rest = twin.tip_of(&twin.rest());
        Ok(Self { twin, command, driver, state: start.clone(), rest, farthest, n_outside: 0 })
    }

    /// Moves the robot to the equilibrium of sample `row`; where there is none, [`Self::state`] stays that of the last sample.
    ///
    /// # Errors
    /// Those of [`Stepper::step`]; a stroke that takes more than the largest tension of its tendon.
    pub fn step(&mut self, row: usize) -> Result<CommandStep> {
        let step = self.driver.step(self.twin, self.command, row)?;
        let state = self.driver.state();
        if let Some(error) = self.command.overloaded(self.twin, state) {
            return Err(error);
        }
        self.state.clone_from(state);
        self.n_outside += usize::from(step.report.outside > 0.0);
        let square = (0..3).map(|c| (step.tip[c] - self.rest[c]).powi(2)).sum::<f64>();
        if square > self.farthest.square {
            self.farthest.square = square;
            self.farthest.row = row;
            self.farthest.state.clone_from(&self.state);
        }
        Ok(step)
    }

    /// Equilibrium of the last sample.
    pub fn state(&self) -> &TwinState {
        &self.state
    }

    /// Strokes that the network commands to the auxiliary tendons now (n_aux) [m], if there is a network.
    pub fn network_strokes(&self) -> Option<&[f64]> {
        match &self.driver {
            Driver::Network(network) => Some(network.strokes()),
            Driver::Stepper(_) => None,
        }
    }

    /// Sample in which the tip was farthest from rest, and its equilibrium; before the first sample the start.
    pub fn farthest(&self) -> (usize, &TwinState) {
        (self.farthest.row, &self.farthest.state)
    }

    /// Number of samples in which a chain was bent further than it was validated.
    pub fn n_outside(&self) -> usize {
        self.n_outside
    }
}

impl Driver<'_> {
    fn step(&mut self, twin: &Twin, command: &Command, row: usize) -> Result<CommandStep> {
        match self {
            Self::Network(network) => {
                let step = Plant::step(network.as_mut(), &command.primary_strokes(row))?;
                let strokes = twin.commands_of(Plant::state(network.as_ref()));
                let PlantStep { tip, is_extrapolating, tip_band, report } = step;
                Ok(CommandStep { tip, strokes, is_extrapolating, tip_band, rounds: 0, report })
            }
            Self::Stepper(stepper) => {
                let targets = command.targets(row);
                let (report, rounds) = match &command.goals {
                    None => (stepper.step(twin, &targets)?, 0),
                    Some(goals) => {
                        let reach = stepper.reach(twin, &goals.tip_goal(row), &targets)?;
                        (reach.step, reach.rounds)
                    }
                };
                let (tip, strokes) = (twin.tip_of(stepper.state()), stepper.commands(twin));
                Ok(CommandStep { tip, strokes, is_extrapolating: false, tip_band: None, rounds, report })
            }
        }
    }

    fn state(&self) -> &TwinState {
        match self {
            Self::Network(network) => Plant::state(network.as_ref()),
            Self::Stepper(stepper) => stepper.state(),
        }
    }
}
