//! Traces of joint faults in the arm's telemetry: the same motions of the virtual arm, with the same sensor
//! noise, with and without the fault.
//!
//! `cargo run --release -p hysteron-virtual-rig --example fault_traces`
#![allow(clippy::print_stdout)] // a program that prints

use hysteron_base::{Metadata, Recording};
use hysteron_virtual_rig::virtual_arm::{Degraded, Planned, VirtualArm, fault_set};

/// The degraded joint, as channels count it.
const JOINT: usize = 3;
/// Speed above which it moves [rad/s].
const MIN_MOVING_SPEED_RAD_S: f64 = 0.05;
/// Scatter of the torque that drive, bodies and friction as identified leave unexplained on healthy motion [N m], and samples in a row that
/// count as one.
const UNEXPLAINED: (f64, f64) = (0.035, 16.0);

/// Changes that a fault causes along a trajectory.
struct Trace {
    kind: &'static str,
    /// Root mean square of the motor's torque, while the joint moves [N m].
    torque: f64,
    /// Of the joint's angle [rad].
    angle: f64,
    /// Distance of both in units of the scatter: of the sensors, of what is left unexplained.
    distances: [f64; 2],
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arm = VirtualArm::preset("open-manipulator-x")?.individual(0);
    let kinds =
        [(Degraded::Band, "band"), (Degraded::Friction, "friction"), (Degraded::LostTooth, "lost tooth")];
    let mut traces = Vec::new();
    for planned in fault_set() {
        let Some((_, kind)) = kinds.iter().find(|(degraded, _)| *degraded == planned.trial.degraded) else {
            continue;
        };
        traces.push(trace(&arm, kind, &planned)?);
    }
    println!(
        "fault, trajectories: torque [N m], angle [deg], area by the scatter of sensors, by what is left unexplained"
    );
    for (_, kind) in kinds {
        let own: Vec<&Trace> = traces.iter().filter(|trace| trace.kind == kind).collect();
        let n = own.len() as f64;
        let mean = |of: &dyn Fn(&Trace) -> f64| own.iter().map(|trace| of(trace)).sum::<f64>() / n;
        // Both are Gaussians of unit variance, one at the distance: the area of the likelihood ratio.
        let area = |k: usize| mean(&|trace| normal(trace.distances[k] / std::f64::consts::SQRT_2));
        println!(
            "{kind}, {n}: {:.4}, {:.3}, {:.3}, {:.3}",
            mean(&|trace| trace.torque),
            mean(&|trace| trace.angle.to_degrees()),
            area(0),
            area(1)
        );
    }
    Ok(())
}

fn trace(
    arm: &VirtualArm,
    kind: &'static str,
    planned: &Planned,
) -> Result<Trace, Box<dyn std::error::Error>> {
    let mut healthy = planned.trial;
    healthy.degraded = Degraded::No;
    let of = |trial| arm.record(&trial, 0, &planned.name(), Metadata::default());
    let (with, without) = (of(planned.trial)?, of(healthy)?);
    let channel = |recording: &Recording, stem: &str, unit: &str| -> Result<Vec<f64>, String> {
        let name = format!("{stem}_{JOINT}_{unit}");
        Ok(recording.channel(&name).ok_or(format!("no channel {name}"))?.to_vec())
    };
    let n = with.n_samples().min(without.n_samples());
    let off = |stem: &str, unit: &str| -> Result<Vec<f64>, String> {
        let [a, b] = [channel(&with, stem, unit)?, channel(&without, stem, unit)?];
        Ok(a.iter().zip(&b).take(n).map(|(a, b)| a - b).collect())
    };
    let (current, angle) = (off("current", "a")?, off("q", "rad")?);
    let speed = channel(&without, "dq", "rad_s")?;
    let servo = &arm.servos[JOINT - 1];
    let torque: Vec<f64> = current.iter().map(|i| servo.torque_constant * i).collect();
    let moving: Vec<f64> = torque
        .iter()
        .zip(&speed)
        .filter(|(_, speed)| speed.abs() > MIN_MOVING_SPEED_RAD_S)
        .map(|(torque, _)| *torque)
        .collect();
    let squares = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>();
    let rms = |values: &[f64]| (squares(values) / values.len().max(1) as f64).sqrt();
    // Noise is the same in both and cancels; steps of the registers, with a variance of a twelfth of their square, do not where readings differ.
    let beyond = |off: &[f64], step: f64| {
        let different: Vec<f64> = off.iter().copied().filter(|off| *off != 0.0).collect();
        (squares(&different) - different.len() as f64 * step * step / 6.0).max(0.0)
    };
    let (tick, [step, noise]) = (std::f64::consts::TAU / 4096.0, arm.telemetry.current);
    let of_sensors = beyond(&current, step) / (noise * noise + step * step / 12.0)
        + beyond(&angle, tick) * 12.0 / (tick * tick);
    let (unexplained, alike) = UNEXPLAINED;
    let of_torque = beyond(&moving, servo.torque_constant * step) / (alike * unexplained * unexplained);
    Ok(Trace {
        kind,
        torque: rms(&moving),
        angle: rms(&angle),
        distances: [of_sensors.sqrt(), of_torque.sqrt()],
    })
}

/// Distribution function of the standard normal distribution.
fn normal(x: f64) -> f64 {
    0.5 * libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2)
}
