//! The parameters of a drive by rollout: the simulated motion is brought to the measured one.

use hysteron_base::{BadInput, Bounds, parallel};
use hysteron_fit::{Fit, Options, Parameter, ParameterScale, Prior, least_squares, minimum};

use super::pendulum::{PendulumRun, rollout};
use crate::Drive;
use crate::law::{JointFriction, ScalesWith};

/// A number of a drive that can be fitted, friction aside.
pub struct DriveQuantity {
    /// Name with its unit.
    pub name: &'static str,
    /// Factor between the value that a data sheet suggests and the bounds, to both sides.
    pub spread: f64,
    /// The value.
    pub get: fn(&Drive) -> f64,
    /// Changes it.
    pub set: fn(&mut Drive, f64),
}

/// Parameters of motor, supply, winding and gear that can be fitted.
#[rustfmt::skip] // a table
pub const QUANTITIES: [DriveQuantity; 7] = [
    DriveQuantity { name: "torque_constant_n_m_per_a", spread: 2.0, get: |d| d.motor.torque_constant(), set: |d, v| d.motor = d.motor.with_constants(v, d.motor.resistance()) },
    DriveQuantity { name: "resistance_ohm", spread: 2.5, get: |d| d.motor.resistance(), set: |d, v| d.motor = d.motor.with_constants(d.motor.torque_constant(), v) },
    DriveQuantity { name: "current_limit_a", spread: 1.7, get: |d| d.motor.current_limit, set: |d, v| d.motor.current_limit = v },
    DriveQuantity { name: "supply_resistance_ohm", spread: 10.0, get: |d| d.supply.resistance, set: |d, v| d.supply.resistance = v },
    DriveQuantity { name: "winding_heat_capacity_j_per_k", spread: 10.0, get: |d| d.winding.heat_capacity, set: |d, v| d.winding.heat_capacity = v },
    DriveQuantity { name: "magnet_slope_per_k", spread: 4.0, get: |d| d.winding.magnet_slope, set: |d, v| d.winding.magnet_slope = v },
    DriveQuantity { name: "armature_kg_m2", spread: 4.0, get: |d| d.gear.armature, set: |d, v| d.gear.armature = v },
];

/// How a drive is fitted.
pub struct DriveFitOptions<'a> {
    /// Names of [`QUANTITIES`] to fit; friction and the offset of the zero are always fitted.
    pub quantities: &'a [&'a str],
    /// Longest step of a rollout [s].
    pub longest_step: f64,
    /// Error from which on a sample counts linearly [rad].
    pub huber: f64,
    /// Other places to start the friction from, as shares of its bounds: of all, the best is followed.
    pub starts: &'a [f64],
    /// Called with evaluations and the best root mean square [rad]; false ends the fit.
    pub watch: &'a (dyn Fn(usize, f64) -> bool + Sync),
}

/// A drive as fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveFit {
    /// The drive.
    pub drive: Drive,
    /// Offset of the zero [rad].
    pub offset: f64,
    /// Fit result of each parameter.
    pub fit: Fit,
}

/// Farthest that the zero may be off [rad].
const MAX_OFFSET: f64 = 0.1;
/// How friction falls at low speed, v_s [rad/s] and α [-]: middle of the nine models m4 to m6 that bam publishes for MX-64, MX-106 and
/// XL-320. These scatter by factors of 1.45 and 1.28.
const SHAPES: [(&str, f64); 2] = [("dtheta_stribeck", 1.7), ("alpha", 1.3)];
/// Standard deviation of that prior for another servo, a factor.
const SHAPE_WIDTH: f64 = 2.0;
/// Scale of the bounds of friction torques, as a part of the largest weight that was moved [-].
const OF_WEIGHT: f64 = 0.25;

/// Fits drive, friction and zero to `runs`, starting from `drive`, whose numbers (for example of a data sheet) have
/// priors with the spread of each quantity.
///
/// # Errors
/// No run; a name that is none; those of the fit.
pub fn identify_drive(
    drive: &Drive,
    runs: &[PendulumRun],
    options: &DriveFitOptions,
) -> Result<DriveFit, BadInput> {
    if runs.is_empty() {
        return Err(BadInput::new("recordings", "one or more", "none"));
    }
    let quantities: Vec<&DriveQuantity> = (options.quantities.iter())
        .map(|name| {
            QUANTITIES.iter().find(|quantity| quantity.name == *name).ok_or_else(|| {
                let names: Vec<&str> = QUANTITIES.iter().map(|quantity| quantity.name).collect();
                BadInput::new("quantity", format!("one of {}", names.join(", ")), format!("{name:?}"))
            })
        })
        .collect::<Result<_, _>>()?;
    let weight = runs.iter().map(|run| run.pendulum.mass * run.pendulum.length * 9.81).fold(0.0, f64::max);
    let parameters = |place: f64| parameters(drive, &quantities, OF_WEIGHT * weight, place);
    let with = |values: &[f64]| {
        let mut drive = drive.clone();
        for (quantity, value) in quantities.iter().zip(values) {
            (quantity.set)(&mut drive, *value);
        }
        let (friction, offset) = values[quantities.len()..].split_at(drive.gear.friction.len());
        drive.gear.friction.copy_from_slice(friction);
        (drive, offset[0])
    };
    let residuals = |values: &[f64]| {
        let (drive, offset) = with(values);
        let of = |run: &PendulumRun| {
            let simulated = rollout(&drive, offset, run, options.longest_step).position;
            simulated.iter().zip(&run.position).map(|(a, b)| a - b).collect::<Vec<f64>>()
        };
        Ok::<_, BadInput>(parallel::map(runs, of))
    };
    let search = Options {
        huber: Some(options.huber),
        smallest_effect: 1e-5,
        n_nuisance: 0,
        tolerance: 1e-4,
        watch: options.watch,
    };
    let mut best = (parameters(options.starts.first().copied().unwrap_or(0.1)), f64::INFINITY);
    if options.starts.len() > 1 {
        for start in options.starts {
            let mut started = parameters(*start);
            let (values, cost) = minimum(&started, &search, residuals)?;
            for (parameter, value) in started.iter_mut().zip(values) {
                parameter.start = value;
            }
            if cost < best.1 {
                best = (started, cost);
            }
        }
    }
    let fit = least_squares(&best.0, &search, residuals)?;
    let (drive, offset) = with(&fit.values());
    Ok(DriveFit { drive, offset, fit })
}

/// Quantities, friction with torques up to `scale` [N m] that starts at `place` of its bounds, and the zero.
fn parameters(drive: &Drive, quantities: &[&DriveQuantity], scale: f64, place: f64) -> Vec<Parameter> {
    let of = |quantity: &&DriveQuantity| {
        let start = (quantity.get)(drive);
        let bounds = Bounds { min: start / quantity.spread, max: start * quantity.spread };
        let prior = Some(Prior { center: start, width: quantity.spread.sqrt() });
        Parameter { name: quantity.name.into(), start, bounds, scale: ParameterScale::Logarithmic, prior }
    };
    let mut all: Vec<Parameter> = quantities.iter().map(of).collect();
    all.extend(drive.gear.law.parameters().into_iter().map(|p| {
        // A servo turns by the order of 1 rad/s.
        let is_torque = matches!(p.scales_with, ScalesWith::Torque | ScalesWith::TorquePerSpeed);
        let factor = if is_torque { scale } else { 1.0 };
        let bounds = Bounds { min: factor * p.bounds[0], max: factor * p.bounds[1] };
        if let Some((_, center)) = SHAPES.iter().find(|(name, _)| *name == p.name) {
            let prior = Some(Prior { center: *center, width: SHAPE_WIDTH });
            let (name, scale) = (p.name.into_owned(), ParameterScale::Logarithmic);
            return Parameter { name, start: *center, bounds, scale, prior };
        }
        let start = bounds.min + place * (bounds.max - bounds.min);
        Parameter { name: p.name.into_owned(), start, bounds, scale: ParameterScale::Linear, prior: None }
    }));
    let bounds = Bounds { min: -MAX_OFFSET, max: MAX_OFFSET };
    all.push(Parameter {
        name: "offset_rad".into(),
        start: 0.0,
        bounds,
        scale: ParameterScale::Linear,
        prior: None,
    });
    all
}

/// Mean over the runs of the mean absolute error of position, open loop [rad].
pub fn mean_error(drive: &Drive, offset: f64, runs: &[PendulumRun], longest_step: f64) -> f64 {
    let of = |run: &PendulumRun| {
        let simulated = rollout(drive, offset, run, longest_step).position;
        simulated.iter().zip(&run.position).map(|(a, b)| (a - b).abs()).sum::<f64>() / simulated.len() as f64
    };
    parallel::map(runs, of).iter().sum::<f64>() / runs.len() as f64
}
