//! The force sensor: fitted errors of a robot and its twin, and estimates sample by sample.

use hysteron_actuator::{LoadModel, Stribeck};
use hysteron_base::BadInput;
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::observer::{Observation, SenseSample, Steady, TwinObserver};
use super::tension::{TensionErrors, TensionFilter};
use super::tip_force::{TipForceErrors, TipForceEstimate, TipForceFilter, TipSample};
use crate::Result;

/// Tensions from the load of the servos: torque, radius and friction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ServoLoad {
    /// Torque of a load of 1 [N m].
    pub stall_torque_n_m: f64,
    /// Radius of the pulleys [m].
    pub radius_m: f64,
    /// Friction of motor and gear, back EMF included, as torques at the output.
    pub coulomb_n_m: f64,
    /// See `coulomb_n_m`.
    pub breakaway_n_m: f64,
    /// See `coulomb_n_m`.
    pub stribeck_velocity_rad_s: f64,
    /// See `coulomb_n_m`.
    pub viscous_n_m_s_per_rad: f64,
}

impl ServoLoad {
    pub(super) fn of(model: &LoadModel) -> Self {
        let friction = &model.friction;
        Self {
            stall_torque_n_m: model.stall_torque,
            radius_m: model.radius,
            coulomb_n_m: friction.coulomb,
            breakaway_n_m: friction.breakaway,
            stribeck_velocity_rad_s: friction.stribeck_velocity,
            viscous_n_m_s_per_rad: friction.viscous,
        }
    }

    /// The same as a model.
    ///
    /// # Errors
    /// `BadInput` naming a number that cannot be.
    pub fn model(&self) -> std::result::Result<LoadModel, BadInput> {
        let friction = Stribeck::new(
            self.coulomb_n_m,
            self.breakaway_n_m,
            self.stribeck_velocity_rad_s,
            self.viscous_n_m_s_per_rad,
        )?;
        Ok(LoadModel { stall_torque: self.stall_torque_n_m, radius: self.radius_m, friction })
    }
}

/// Fitted errors of a robot and its twin, from which forces are estimated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ForceSensor {
    /// Duration of a sample [s].
    pub period_s: f64,
    /// The servos, where their loads were recorded.
    pub servo: Option<ServoLoad>,
    /// Errors of tensions.
    pub tension: TensionErrors,
    /// Stiffness of the robot's tip over the twin's, all friction points slipping [-].
    pub stiffness_scale: f64,
    /// Errors of the tip.
    pub tip: TipForceErrors,
}

/// Estimates of one sample.
#[derive(Debug, Clone, PartialEq)]
pub struct SensedSample {
    /// Tension at each pulley and its standard error (n_primary) [N].
    pub tensions: Vec<(f64, f64)>,
    /// Force on the tip.
    pub tip: TipForceEstimate,
}

/// Estimates tensions and the force on the tip, sample by sample.
pub struct TendonSensing {
    sensor: ForceSensor,
    load: Option<LoadModel>,
    tensions: Vec<TensionFilter>,
    tip: TipForceFilter,
}

impl TipSample {
    /// The observation, of a robot so many times as stiff as its twin.
    pub(super) fn of(observed: &Observation, stiffness_scale: f64) -> Self {
        let response = observed.response / stiffness_scale;
        Self { gap: observed.gap, response, free_tip: observed.free_tip, path: observed.path }
    }
}

impl ForceSensor {
    /// Refuses numbers that no sensor has.
    ///
    /// # Errors
    /// `BadInput` naming the number.
    pub fn check(&self) -> std::result::Result<(), BadInput> {
        let tip = &self.tip;
        let axes = |name: &'static str, values: [f64; 3]| values.map(|value| (name, value));
        let numbers = [
            ("period_s", self.period_s),
            ("stiffness_scale", self.stiffness_scale),
            ("tension.force_scale", self.tension.force_scale),
            ("tension.load_n", self.tension.load_n),
            ("tension.model_n", self.tension.model_n),
            ("tip.length_m", tip.length_m),
            ("tip.walk_along_sqrt_m", tip.walk_along_sqrt_m),
            ("tip.walk_across_sqrt_m", tip.walk_across_sqrt_m),
        ];
        let thresholds = tip.thresholds.map(|threshold| ("tip.thresholds", threshold));
        let of_axes = [
            axes("tip.noise_m", tip.noise_m),
            axes("tip.model_m", tip.model_m),
            axes("tip.offset_m", tip.offset_m),
            axes("tip.creep_m_per_sqrt_s", tip.creep_m_per_sqrt_s),
        ];
        for (name, value) in numbers.into_iter().chain(of_axes.into_iter().flatten()).chain(thresholds) {
            if !(value > 0.0 && value.is_finite()) {
                return Err(BadInput::new(name, "a finite number > 0", value.to_string()));
            }
        }
        for (name, value) in
            [("tension.walk_sqrt_n", self.tension.walk_sqrt_n), ("tip.response", tip.response)]
        {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(BadInput::new(name, "a finite number >= 0", value.to_string()));
            }
        }
        self.servo.map_or(Ok(()), |servo| servo.model().map(|_| ()))
    }
}

impl TendonSensing {
    /// Of a robot with `n_primary` tendons, without contact at first.
    ///
    /// # Errors
    /// As [`ForceSensor::check`].
    pub fn new(sensor: &ForceSensor, n_primary: usize) -> std::result::Result<Self, BadInput> {
        sensor.check()?;
        Ok(Self {
            load: sensor.servo.map(|servo| servo.model()).transpose()?,
            tensions: vec![TensionFilter::new(sensor.tension, sensor.period_s); n_primary],
            tip: TipForceFilter::new(sensor.tip, sensor.period_s),
            sensor: sensor.clone(),
        })
    }

    /// Goes on by what was observed in a sample.
    pub fn step(&mut self, observed: &Observation) -> SensedSample {
        let load = self.load;
        let measured = |steady: &Option<Steady>| {
            let steady = (*steady)?;
            Some((load?.tension(steady.load, steady.velocity), steady.twin))
        };
        let tensions = self.tensions.iter_mut().zip(&observed.tensions).zip(&observed.steady);
        let tensions =
            tensions.map(|((filter, twin), steady)| filter.step(*twin, measured(steady))).collect();
        SensedSample { tensions, tip: self.tip.step(&TipSample::of(observed, self.sensor.stiffness_scale)) }
    }

    /// Compares a sample with the twin, and advances by it. Also returns the tip without contact [m].
    ///
    /// # Errors
    /// The twin has no equilibrium under its strokes.
    pub fn sense(
        &mut self,
        observer: &mut TwinObserver,
        sample: &SenseSample,
    ) -> Result<(SensedSample, Vector3<f64>)> {
        let observed = observer.step(sample)?;
        Ok((self.step(&observed), observed.free_tip))
    }
}
