//! Residuals of the momentum observer on recordings of real arms without contact, before and after identified friction.
//!
//!     HYSTERON_DATA=../shared/data cargo run --release -p hysteron-studies --example observer_residuals [-- metrics.json]
//!
//! Data: Panda of Gaz et al. (RA-L 2019); KUKA LWR4+ of FloBaRoID; UR10e of Mamedov and Mikhel (2020), whose torques are currents
//! times the drive gains that come with the data. Bodies and friction are identified from one part, residuals are of another.
#![allow(clippy::print_stdout)] // this program prints tables

use std::error::Error;
use std::path::Path;

use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::detection::FreeMotion;
use hysteron_arm_estimation::identify::{BodyOptions, JointMotion, identify_bodies};
use hysteron_arm_estimation::observer::{FrictionModel, MomentumObserver, RigidBody, estimate};
use hysteron_arm_estimation::{ArmRecording, ColumnMap, ImportOptions, JointQuantityKind, import};
use hysteron_arm_learning::datasets::kuka_arm;
use hysteron_base::{Metadata, Recording, json};
use hysteron_fuzz::data_folder;
use hysteron_studies::arm::estimation::{KnownArm, TERMS};
use hysteron_workflow::shared::outcome::MetricsFormat;
use serde::Serialize;

type Fallible<T> = Result<T, Box<dyn Error>>;

/// K of every joint [1/s].
const GAIN: f64 = 25.0;
/// Speed within which friction is a line through zero, and over which Coulomb friction changes its sign in the fit [rad/s].
const WIDTH: f64 = 0.05;
/// Drive gains of the UR10e [N m/A], from the file of parameters that comes with its data.
const UR10E_GAINS: [f64; 6] = [10.0, 10.6956, 8.4566, 9.0029, 9.48, 10.1232];

/// The file that the example writes.
#[derive(Serialize)]
struct Outcome {
    format: MetricsFormat,
    version: u32,
    study: &'static str,
    /// K of every joint [1/s].
    gain_per_s: f64,
    metrics: Arms,
}

/// Residuals of every arm.
#[derive(Serialize)]
struct Arms {
    panda: ArmResiduals,
    kuka: ArmResiduals,
    ur10e: PushedArm,
}

/// Residuals of an arm without contact, joint by joint.
#[derive(Serialize)]
struct ArmResiduals {
    /// Root mean square [N m].
    rms_n_m: ResidualsByModel,
    /// Largest, with identified bodies and friction [N m].
    largest_n_m: Vec<f64>,
}

/// Root mean square by what is known of the arm, joint by joint [N m].
#[derive(Serialize)]
struct ResidualsByModel {
    /// Of the torque of the motors itself.
    motor_torque: Vec<f64>,
    nominal_bodies: Vec<f64>,
    identified_bodies: Vec<f64>,
    identified_bodies_and_friction: Vec<f64>,
}

/// Residuals of an arm, and of the same arm while a hand pushes it.
#[derive(Serialize)]
struct PushedArm {
    #[serde(flatten)]
    free: ArmResiduals,
    /// Largest while it is pushed, joint by joint [N m].
    push_largest_n_m: Vec<f64>,
    /// The same over the largest without contact [-].
    push_over_free: Vec<f64>,
}

fn main() -> Fallible<()> {
    let folder = data_folder().join("arms");
    if !folder.is_dir() {
        println!("skipped: no recordings in {}", folder.display());
        return Ok(());
    }
    let metrics = Arms {
        panda: panda(&folder.join("panda-gaz"))?,
        kuka: kuka(&folder.join("kuka-lwr4"))?,
        ur10e: ur10e(&folder.join("ur10e"))?,
    };
    let outcome =
        Outcome { format: MetricsFormat, version: 1, study: "observer_residuals", gain_per_s: GAIN, metrics };
    if let Some(path) = std::env::args().nth(1) {
        hysteron_base::file::write_bytes(Path::new(&path), json::to_text(&outcome)?)?;
    }
    Ok(())
}

/// Coordinates, speeds and torques of all joints as they were measured, column by column, and the samples per second.
struct Measured {
    columns: [Vec<Vec<f64>>; 3],
    rate: f64,
}

impl Measured {
    fn of(recording: &Recording, gains: &[f64]) -> Fallible<Self> {
        let recorded = ArmRecording::of(recording)?;
        let owned = |columns: Vec<&[f64]>| columns.into_iter().map(<[f64]>::to_vec).collect::<Vec<_>>();
        let q = owned(recorded.require(JointQuantityKind::Position)?);
        let tau = if gains.is_empty() {
            owned(recorded.require(JointQuantityKind::Torque)?)
        } else {
            let currents = recorded.require(JointQuantityKind::Current)?;
            currents.iter().zip(gains).map(|(column, k)| column.iter().map(|i| k * i).collect()).collect()
        };
        let time = recorded.time;
        let rate = (time.len() - 1) as f64 / (time[time.len() - 1] - time[0]);
        let differences = |column: &Vec<f64>| -> Vec<f64> {
            (0..column.len()).map(|k| if k == 0 { 0.0 } else { (column[k] - column[k - 1]) * rate }).collect()
        };
        let dq = match recorded.require(JointQuantityKind::Velocity) {
            Ok(columns) => owned(columns),
            Err(_) => q.iter().map(differences).collect(),
        };
        Ok(Self { columns: [q, dq, tau], rate })
    }

    fn smoothed(&self, cutoff: f64) -> Fallible<JointMotion> {
        let [q, dq, tau] = &self.columns;
        let smoothing = hysteron_arm_estimation::identify::Smoothing { rate: self.rate, order: 4, cutoff };
        Ok(JointMotion::smoothed([q, dq, tau], smoothing)?)
    }

    fn part(&self, range: std::ops::Range<usize>) -> Self {
        let part = |columns: &Vec<Vec<f64>>| columns.iter().map(|c| c[range.clone()].to_vec()).collect();
        Self { columns: self.columns.each_ref().map(part), rate: self.rate }
    }

    fn len(&self) -> usize {
        self.columns[0][0].len()
    }

    /// Residual of the momentum observer, from half a second on, row by row.
    fn residual(&self, model: &Model, friction: FrictionModel) -> Vec<f64> {
        let n = model.n_joints();
        let rows = self.columns.each_ref().map(|columns| -> Vec<f64> {
            (0..self.len()).flat_map(|k| columns.iter().map(move |column| column[k])).collect()
        });
        let mut observer = MomentumObserver::new(RigidBody::new(model), friction, &vec![GAIN; n]);
        let periods = vec![1.0 / self.rate; self.len()];
        let residual = estimate(&mut observer, &periods, [&rows[0], &rows[1], &rows[2]]);
        residual[n * (0.5 * self.rate) as usize..].to_vec()
    }
}

fn read(path: &Path, columns: &str, rate: Option<f64>) -> Fallible<Recording> {
    let options = ImportOptions {
        columns: Some(ColumnMap::named(columns)?),
        rate_hz: rate,
        ..ImportOptions::default()
    };
    Ok(import(path, &options, Metadata::default())?.recording)
}

fn rms(rows: &[f64], n: usize) -> Vec<f64> {
    let free = FreeMotion::learn(rows, n);
    free.mean.iter().zip(&free.deviation).map(|(m, s)| (m * m + s * s).sqrt()).collect()
}

/// Bodies and friction from `training`; residuals on `test`.
fn compare(
    name: &str,
    model: &Model,
    training: &Measured,
    test: &Measured,
    cutoff: f64,
) -> Fallible<(KnownArm, ArmResiduals)> {
    let options = BodyOptions { terms: &TERMS, width: WIDTH, prior: 1.0 };
    let fit = identify_bodies(model, &training.smoothed(cutoff)?, &options)?;
    let known = KnownArm::of(&fit, WIDTH);
    let n = model.n_joints();
    let bodies = test.residual(&known.model, FrictionModel::none(n));
    let friction = test.residual(&known.model, known.friction.clone());
    let before = test.residual(model, FrictionModel::none(n));
    println!("\n{name}: root mean square of the residual without contact [N m]");
    let rms_n_m = ResidualsByModel {
        motor_torque: rms(&rows(&test.columns[2]), n),
        nominal_bodies: rms(&before, n),
        identified_bodies: rms(&bodies, n),
        identified_bodies_and_friction: rms(&friction, n),
    };
    for (what, values) in [
        ("motor_torque", &rms_n_m.motor_torque),
        ("nominal_bodies", &rms_n_m.nominal_bodies),
        ("identified_bodies", &rms_n_m.identified_bodies),
        ("identified_bodies_and_friction", &rms_n_m.identified_bodies_and_friction),
    ] {
        println!("  {what:32} {values:.3?}");
    }
    let free = FreeMotion::learn(&friction, n);
    println!("  largest, with friction           {:.3?}", free.largest);
    Ok((known, ArmResiduals { rms_n_m, largest_n_m: free.largest }))
}

fn rows(columns: &[Vec<f64>]) -> Vec<f64> {
    (0..columns[0].len()).flat_map(|k| columns.iter().map(move |column| column[k])).collect()
}

/// The first 70 % and the rest.
fn panda(folder: &Path) -> Fallible<ArmResiduals> {
    let all = Measured::of(&read(folder, "panda-gaz", Some(1000.0))?, &[])?;
    let model = Model::builtin("panda")?
        .with_locked(&[("panda_finger_joint1", 0.0), ("panda_finger_joint2", 0.0)])?;
    let cut = all.len() * 7 / 10;
    Ok(compare("Panda", &model, &all.part(0..cut), &all.part(cut..all.len()), 8.0)?.1)
}

/// The first run and the second.
fn kuka(folder: &Path) -> Fallible<ArmResiduals> {
    let measured = |k: u32| -> Fallible<Measured> {
        Measured::of(&read(&folder.join(format!("measurements_{k}.npz")), "flobaroid", None)?, &[])
    };
    let model = kuka_arm(folder)?;
    Ok(compare("KUKA LWR4+", &model, &measured(1)?, &measured(2)?, 8.0)?.1)
}

/// One exciting trajectory and another; then a run in which a hand pushes the arm at rest.
fn ur10e(folder: &Path) -> Fallible<PushedArm> {
    let measured = |name: &str| -> Fallible<Measured> {
        Measured::of(&read(&folder.join(name), "ur10e", None)?, &UR10E_GAINS)
    };
    let model = Model::read(&folder.join("ur10e.urdf"))?;
    let (training, test) =
        (measured("ur-20_02_19_15harm50sec.csv")?, measured("ur-20_02_12-50sec_12harm.csv")?);
    let (known, free) = compare("UR10e", &model, &training, &test, 5.0)?;
    let pushed = measured("ur-20_01_22-push_pose_1.csv")?.residual(&known.model, known.friction);
    let n = model.n_joints();
    let pushes = FreeMotion::learn(&pushed, n);
    let ratios: Vec<f64> =
        pushes.largest.iter().zip(&free.largest_n_m).map(|(push, free)| push / free).collect();
    println!("  pushed at rest: largest          {:.3?}", pushes.largest);
    println!("  over the largest without contact {ratios:.2?}");
    Ok(PushedArm { free, push_largest_n_m: pushes.largest, push_over_free: ratios })
}
