//! Observation of a sample: robot compared with twin, before any estimate.

use hysteron_actuator::{SteadyLoad, SteadyMotion};
use nalgebra::{Matrix3, Vector3};

use crate::friction_points::FrictionPoints;
use crate::model::Twin;
use crate::plant::{Plant, relax_to_equilibrium};
use crate::{Result, TipResponse};

/// Commands and measurements of one sample.
#[derive(Debug, Clone, Copy)]
pub struct SenseSample<'a> {
    /// Strokes as the twin takes them (n_primary) [m].
    pub strokes: &'a [f64],
    /// Turned by each pulley (n_primary) [rad], positive where it pulls; none without servos.
    pub angles: Option<&'a [f64]>,
    /// Loads (n_primary) [-], positive where the servo pulls.
    pub loads: Option<&'a [f64]>,
    /// The tip, in the twin's recorded frame [m]; none where it was not measured.
    pub tip: Option<[f64; 3]>,
}

/// A servo in steady motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steady {
    /// Speed [rad/s].
    pub velocity: f64,
    /// Load [-].
    pub load: f64,
    /// Tension of the twin over the same samples [N].
    pub twin: f64,
}

/// One sample of the robot compared with the twin.
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// Where the tip would be without contact [m].
    pub free_tip: Vector3<f64>,
    /// How far it is from there [m]; none where it was not measured.
    pub gap: Option<Vector3<f64>>,
    /// Response of the twin's tip to a force, all friction points slipping (3 × 3) [m/N].
    pub response: Matrix3<f64>,
    /// How far the tendons have been pulled since the sample before [m].
    pub path: f64,
    /// Tensions of the twin (n_primary) [N].
    pub tensions: Vec<f64>,
    /// Of each servo that moves steadily (n_primary).
    pub steady: Vec<Option<Steady>>,
}

/// Path of the tendons, and time, after which the response is recomputed [m], [s].
const RESPONSE_PATH: f64 = 2e-4;
const RESPONSE_TIME: f64 = 0.5;
/// Delay of a load after the servo's torque, with the speed that belongs to it [s].
const LOAD_DELAY: f64 = 0.02;

/// Goes through samples with the twin.
pub struct TwinObserver<'a> {
    plant: Box<dyn Plant + 'a>,
    period: f64,
    motions: Vec<SteadyMotion>,
    strokes: Vec<f64>,
    /// Tensions of the last samples, the newest last.
    tensions: Vec<Vec<f64>>,
    response: Matrix3<f64>,
    /// Path and time since the response was taken.
    aged: [f64; 2],
}

impl<'a> TwinObserver<'a> {
    /// Brings `plant`, a simulation with `twin` that has just been made, to rest under the strokes of the first sample.
    ///
    /// # Errors
    /// The twin has no equilibrium there.
    pub fn new(twin: &Twin, mut plant: Box<dyn Plant + 'a>, strokes: &[f64], period: f64) -> Result<Self> {
        relax_to_equilibrium(twin, plant.as_mut(), strokes)?;
        let n_delay = (LOAD_DELAY / period).round() as usize;
        Ok(Self {
            plant,
            period,
            motions: vec![SteadyMotion::new(period); twin.n_primary],
            strokes: strokes.to_vec(),
            tensions: vec![vec![0.0; twin.n_primary]; n_delay + SteadyMotion::SPAN],
            response: Matrix3::zeros(),
            aged: [f64::INFINITY; 2],
        })
    }

    /// Goes on by one sample.
    ///
    /// # Errors
    /// The twin has no equilibrium under its strokes.
    pub fn step(&mut self, sample: &SenseSample) -> Result<Observation> {
        let step = self.plant.step(sample.strokes)?;
        let n = self.motions.len();
        let path = sample.strokes.iter().zip(&self.strokes).map(|(now, before)| (now - before).powi(2));
        // One of a pair of antagonists is enough: both do the same.
        let path = (0.5 * path.sum::<f64>()).sqrt();
        self.strokes.copy_from_slice(sample.strokes);
        self.take_response(path);
        self.tensions.rotate_left(1);
        let now = self.plant.state().tensions[..n].to_vec();
        if let Some(last) = self.tensions.last_mut() {
            last.copy_from_slice(&now);
        }
        let steady = (0..n).map(|j| {
            let SteadyLoad { velocity, load } = self.motions[j].step(sample.angles?[j], sample.loads?[j])?;
            let then = self.tensions[..SteadyMotion::SPAN].iter().map(|tensions| tensions[j]);
            Some(Steady { velocity, load, twin: then.sum::<f64>() / SteadyMotion::SPAN as f64 })
        });
        let steady = steady.collect();
        let free_tip = Vector3::from(step.tip);
        Ok(Observation {
            free_tip,
            gap: sample.tip.map(|tip| Vector3::from(tip) - free_tip),
            response: self.response,
            path,
            tensions: now,
            steady,
        })
    }

    /// The response changes with the shape, slowly; where the tangent cannot be solved with the last one stays.
    fn take_response(&mut self, path: f64) {
        self.aged[0] += path;
        self.aged[1] += self.period;
        let moved = self.aged[0] > RESPONSE_PATH;
        // At rest tendons go slack and taut by themselves for a while.
        if moved || (self.aged[1] > RESPONSE_TIME && self.aged[0] > 0.0) {
            if let Some(TipResponse { per_force, .. }) = self.plant.tip_response(FrictionPoints::Slipping) {
                self.response = Matrix3::from_fn(|r, c| 0.5 * (per_force[r][c] + per_force[c][r]));
            }
            self.aged = [0.0; 2];
        }
    }
}
