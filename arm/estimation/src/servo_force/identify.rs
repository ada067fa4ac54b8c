//! Identification of motors and friction for the estimators, from contact-free motion alone.

use hysteron_actuator::filter::LowPass;
use hysteron_actuator::law::{Law, SymmetricStribeck};
use hysteron_actuator::{CatalogueDrive, Motor};
use hysteron_base::BadInput;

use super::ServoForceTelemetry;
use super::drive::{FixedModel, ServoDrive};
use crate::observer::{FrictionModel, LowSpeed, MotorTorque};
use hysteron_arm_dynamics::{Data, Model, dense, inverse_dynamics};

/// Signals above this are noise [Hz].
pub(super) const CUTOFF: f64 = 6.0;
/// A joint moves where its speed is above this: two steps of the register [rad/s].
pub(super) const MIN_MOVING_SPEED_RAD_S: f64 = 0.05;
/// Spread of the torque that a motion needs, above which it weighs the motor [N m].
const MIN_TORQUE_SPREAD_NM: f64 = 0.1;
/// Stribeck speeds that are tried [rad/s].
const STRIBECK: [f64; 6] = [0.05, 0.1, 0.2, 0.5, 1.0, 2.0];

/// One joint's rows of all training trajectories, low-passed without delay.
struct JointRows {
    /// M q̈ + C q̇ + g [N m].
    needed: Vec<f64>,
    velocity: Vec<f64>,
    current: Vec<f64>,
    voltage: Vec<f64>,
    /// Where the joint moves.
    moves: Vec<bool>,
}

/// Parameters of all methods: ID-Linear and GMO-linear, ID-Friction; GMO-drive but for its noise.
pub(super) fn identify(
    model: &Model,
    training: &[ServoForceTelemetry],
) -> Result<([FixedModel; 2], ServoDrive), BadInput> {
    let n = model.n_joints();
    let mut rows: Vec<JointRows> = (0..n).map(|_| JointRows::new()).collect();
    for trajectory in training {
        append(model, trajectory, &mut rows)?;
    }
    for (k, joint) in rows.iter().enumerate() {
        let n_moving = joint.moves.iter().filter(|moves| **moves).count();
        if n_moving < 100 {
            let place = format!("training, joint {}", k + 1);
            return Err(BadInput::new(place, "100 rows in motion", n_moving.to_string()));
        }
    }
    let drive = CatalogueDrive::named("xm430-w350")?.drive.motor;
    let linear = rows.iter().map(JointRows::linear).collect();
    let (motors, laws) = rows.iter().map(JointRows::with_stribeck).unzip();
    // Weights scale the motors where there are weights; the servos are of one kind.
    let weighed: Vec<f64> = rows
        .iter()
        .filter(|joint| joint.spread() > MIN_TORQUE_SPREAD_NM)
        .map(|joint| joint.scale(&drive))
        .filter(|scale| *scale > 0.0)
        .collect();
    let scale = if weighed.is_empty() { 1.0 } else { weighed.iter().sum::<f64>() / weighed.len() as f64 };
    let loaded: Vec<[f64; 3]> = rows.iter().map(|joint| joint.load_dependent(&drive, scale)).collect();
    let column = |k: usize| loaded.iter().map(|own| own[k]).collect::<Vec<f64>>();
    let servo = ServoDrive {
        torque_constant: drive.torque_constant(),
        resistance: drive.resistance() / scale,
        dry: column(0),
        load_share: column(1),
        viscous: column(2),
        noise: vec![1.0; n],
    };
    let known = [
        FixedModel { motors: linear, friction: FrictionModel::none(n) },
        FixedModel { motors, friction: FrictionModel::new(laws, LowSpeed::Linear(MIN_MOVING_SPEED_RAD_S)) },
    ];
    Ok((known, servo))
}

fn append(model: &Model, trajectory: &ServoForceTelemetry, rows: &mut [JointRows]) -> Result<(), BadInput> {
    let (n, n_samples) = (model.n_joints(), trajectory.n_samples());
    let filter = LowPass::new(2, CUTOFF, trajectory.rate())?;
    let smooth = |of: &[f64], joint: usize| filter.zero_phase(&trajectory.column(of, joint));
    let every = |of: &[f64]| (0..n).map(|joint| smooth(of, joint)).collect::<Vec<_>>();
    let [q, dq, current, voltage] =
        [&trajectory.position, &trajectory.velocity, &trajectory.current, &trajectory.voltage]
            .map(|of| every(of));
    let mut data = Data::new(model, 0.0);
    let mut torque = vec![0.0; n];
    for row in 1..n_samples - 1 {
        let at = |columns: &[Vec<f64>]| columns.iter().map(|column| column[row]).collect::<Vec<f64>>();
        let around = trajectory.time[row + 1] - trajectory.time[row - 1];
        let ddq: Vec<f64> = dq.iter().map(|column| (column[row + 1] - column[row - 1]) / around).collect();
        inverse_dynamics(model, &mut data, [&at(&q), &at(&dq), &ddq], &[], &mut torque);
        for (k, joint) in rows.iter_mut().enumerate() {
            joint.needed.push(torque[k]);
            joint.velocity.push(dq[k][row]);
            joint.current.push(current[k][row]);
            joint.voltage.push(voltage[k][row]);
            let now = trajectory.velocity[n * row + k];
            joint.moves.push(
                now.abs() > MIN_MOVING_SPEED_RAD_S
                    && dq[k][row].abs() > MIN_MOVING_SPEED_RAD_S
                    && now * dq[k][row] > 0.0,
            );
        }
    }
    Ok(())
}

impl JointRows {
    fn new() -> Self {
        Self { needed: vec![], velocity: vec![], current: vec![], voltage: vec![], moves: vec![] }
    }

    /// k_t and b of τ = k_t i + b; a torque constant below zero is taken as zero, as the paper clamps it.
    fn linear(&self) -> MotorTorque {
        let ones = vec![1.0; self.needed.len()];
        let [torque_constant, offset] =
            least_squares([&self.current, &ones], &self.needed, [Sign::Positive, Sign::Any]).0;
        MotorTorque::Current { torque_constant, offset }
    }

    /// The same with Stribeck's friction, in motion; the Stribeck speed is that of the least error.
    fn with_stribeck(&self) -> (MotorTorque, (Law, Vec<f64>)) {
        let moving = |of: &dyn Fn(usize) -> f64| self.moving(of);
        let needed = moving(&|row| self.needed[row]);
        let [current, ones, velocity] =
            [moving(&|row| self.current[row]), moving(&|_| 1.0), moving(&|row| -self.velocity[row])];
        let coulomb = moving(&|row| -self.velocity[row].signum());
        let fitted = STRIBECK.map(|speed| {
            let slow = moving(&|row| {
                let ratio = self.velocity[row] / speed;
                -self.velocity[row].signum() * (-ratio * ratio).exp()
            });
            let positive = Sign::Positive;
            let signs = [positive, Sign::Any, positive, positive, positive];
            (speed, least_squares([&current, &ones, &coulomb, &slow, &velocity], &needed, signs))
        });
        let least = |a: &(f64, ([f64; 5], f64)), b: &(f64, ([f64; 5], f64))| a.1.1.total_cmp(&b.1.1);
        let (speed, ([torque_constant, offset, coulomb, excess, viscous], _)) =
            fitted.into_iter().min_by(least).unwrap_or((1.0, ([0.0; 5], 0.0)));
        let law = (Law::Stribeck(SymmetricStribeck), vec![coulomb, excess, speed, viscous]);
        (MotorTorque::Current { torque_constant, offset }, law)
    }

    /// Torque of the catalogue's drive at its PWM [N m].
    fn motor(&self, drive: &Motor) -> Vec<f64> {
        let k = drive.torque_constant();
        let at = |(voltage, velocity): (&f64, &f64)| k * (voltage - k * velocity) / drive.resistance();
        self.voltage.iter().zip(&self.velocity).map(at).collect()
    }

    /// Factor on the torque of the catalogue's drive, for friction that grows with it to explain the rest
    /// [-].
    fn scale(&self, drive: &Motor) -> f64 {
        let motor = self.motor(drive);
        let sign = |row: usize| self.velocity[row].signum();
        let [scaled, coulomb, load, viscous, ones] = [
            self.moving(&|row| motor[row]),
            self.moving(&|row| -sign(row)),
            self.moving(&|row| -sign(row) * motor[row].abs()),
            self.moving(&|row| -self.velocity[row]),
            self.moving(&|_| 1.0),
        ];
        let needed = self.moving(&|row| self.needed[row]);
        let positive = Sign::Positive;
        let signs = [positive, positive, positive, positive, Sign::Any];
        least_squares([&scaled, &coulomb, &load, &viscous, &ones], &needed, signs).0[0]
    }

    /// Dry friction, its growth with the motor's torque, which is `scale` times that of the catalogue's drive, and viscous friction: bam's m5
    /// without Stribeck's effect.
    fn load_dependent(&self, drive: &Motor, scale: f64) -> [f64; 3] {
        let motor: Vec<f64> = self.motor(drive).iter().map(|torque| scale * torque).collect();
        let sign = |row: usize| self.velocity[row].signum();
        let friction = self.moving(&|row| motor[row] - self.needed[row]);
        let [coulomb, load, viscous, ones] = [
            self.moving(&|row| sign(row)),
            self.moving(&|row| sign(row) * motor[row].abs()),
            self.moving(&|row| self.velocity[row]),
            self.moving(&|_| 1.0),
        ];
        let positive = Sign::Positive;
        // What stays is an error of the bodies' weights, and no friction.
        let signs = [positive, positive, positive, Sign::Any];
        let ([base, share, viscous, _], _) =
            least_squares([&coulomb, &load, &viscous, &ones], &friction, signs);
        [base, share.min(0.9), viscous]
    }

    /// Spread of the torque that the motion needs [N m].
    fn spread(&self) -> f64 {
        let n = self.needed.len() as f64;
        let mean = self.needed.iter().sum::<f64>() / n;
        (self.needed.iter().map(|torque| (torque - mean) * (torque - mean)).sum::<f64>() / n).sqrt()
    }

    fn moving(&self, of: &dyn Fn(usize) -> f64) -> Vec<f64> {
        (0..self.moves.len()).filter(|row| self.moves[*row]).map(of).collect()
    }
}

/// Sign that a coefficient may have.
#[derive(Clone, Copy, PartialEq)]
enum Sign {
    Any,
    Positive,
}

/// Coefficients of `columns` that come nearest to `target`, and the mean squared error. One that may not be negative and would
/// be is left out, the worst first.
fn least_squares<const N: usize>(
    columns: [&Vec<f64>; N],
    target: &[f64],
    signs: [Sign; N],
) -> ([f64; N], f64) {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let mut is_out = [false; N];
    loop {
        let mut normal = vec![0.0; N * N];
        let mut right = vec![0.0; N];
        for i in 0..N {
            for j in 0..N {
                normal[N * i + j] = if is_out[i] || is_out[j] { 0.0 } else { dot(columns[i], columns[j]) };
            }
            // A column of zeros gets the coefficient zero.
            normal[N * i + i] = normal[N * i + i] * (1.0 + 1e-12) + 1e-12;
            right[i] = if is_out[i] { 0.0 } else { dot(columns[i], target) };
        }
        dense::factor(N, &mut normal);
        dense::solve_columns(N, &normal, &mut right);
        let found: [f64; N] = std::array::from_fn(|i| right[i]);
        let worst = (0..N)
            .filter(|i| signs[*i] == Sign::Positive && found[*i] < 0.0)
            .min_by(|a, b| found[*a].total_cmp(&found[*b]));
        match worst {
            Some(out) => is_out[out] = true,
            None => {
                let error = |row: usize| {
                    target[row] - columns.iter().zip(found).map(|(column, x)| x * column[row]).sum::<f64>()
                };
                let squares: f64 = (0..target.len()).map(|row| error(row) * error(row)).sum();
                return (found, squares / target.len().max(1) as f64);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_squares_finds_what_made_the_data_and_keeps_to_signs() {
        let x: Vec<f64> = (0..50).map(|k| f64::from(k) * 0.1).collect();
        let ones = vec![1.0; 50];
        let y: Vec<f64> = x.iter().map(|x| 2.0 - 0.5 * x).collect();
        let ([slope, offset], error) = least_squares([&x, &ones], &y, [Sign::Any, Sign::Any]);
        // Normal equations of 50 rows lose half of the digits.
        assert!((slope + 0.5).abs() < 1e-8 && (offset - 2.0).abs() < 1e-8 && error < 1e-15);
        let ([slope, offset], _) = least_squares([&x, &ones], &y, [Sign::Positive, Sign::Any]);
        assert!(slope.abs() < 1e-9 && (offset - (2.0 - 0.5 * 2.45)).abs() < 1e-8, "{slope} {offset}");
    }
}
