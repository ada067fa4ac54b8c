//! Bodies and friction of real arms identified, and tested on motions that were not fitted.
//!
//!     HYSTERON_DATA=../shared/data cargo run --release -p hysteron-arm-learning --example identify_bodies [-- metrics.json]
//!
//! Data: Panda of Gaz et al. (RA-L 2019); Baxter of Valencia-Vidal et al. (2023); KUKA LWR4+ of FloBaRoID; UR10e of Mamedov.
#![allow(clippy::print_stdout)] // this program prints tables

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use hysteron_arm_dynamics::{Data, Model, inverse_dynamics};
use hysteron_arm_estimation::identify::{
    BodyFit, BodyOptions, JointMotion, JointTerm, TorqueResponse, identify_bodies,
};
use hysteron_arm_estimation::{ArmRecording, ColumnMap, ImportOptions, import};
use hysteron_arm_learning::datasets::kuka_arm;
use hysteron_base::{Metadata, json};
use hysteron_fuzz::data_folder;
use serde_json::Value;

type Fallible<T> = Result<T, Box<dyn Error>>;

const TERMS: [JointTerm; 5] =
    [JointTerm::Armature, JointTerm::Coulomb, JointTerm::Viscous, JointTerm::Offset, JointTerm::Spring];

fn main() -> Fallible<()> {
    let folder = data_folder().join("arms");
    if !folder.is_dir() {
        println!("skipped: no recordings in {}", folder.display());
        return Ok(());
    }
    let metrics = json!({
        "format": "hysteron-metrics", "version": 1, "study": "identify_bodies",
        "metrics": {"panda": panda(&folder.join("panda-gaz"))?, "baxter": baxter(&folder.join("baxter"))?, "kuka": kuka(&folder.join("kuka-lwr4"))?,
            "ur10e": ur10e(&folder.join("ur10e"))?},
    });
    if let Some(path) = std::env::args().nth(1) {
        hysteron_base::file::write_bytes(Path::new(&path), json::to_text(&metrics)?)?;
    }
    Ok(())
}

/// A file of other people's, smoothed.
fn read(path: &Path, columns: &str, rate: Option<f64>, cutoff: f64) -> Fallible<JointMotion> {
    with_currents(path, columns, (rate, cutoff), &[])
}

/// The same of a file with currents and these torque constants [N m/A].
fn with_currents(
    path: &Path,
    columns: &str,
    (rate, cutoff): (Option<f64>, f64),
    torque_constants: &[f64],
) -> Fallible<JointMotion> {
    let options = ImportOptions {
        columns: Some(ColumnMap::named(columns)?),
        rate_hz: rate,
        ..ImportOptions::default()
    };
    let imported = import(path, &options, Metadata::default())?;
    Ok(JointMotion::of_recording(&ArmRecording::of(&imported.recording)?, torque_constants, 4, cutoff)?)
}

fn report(name: &str, fit: &BodyFit, tests: &[(&str, &JointMotion)], seconds: f64) -> Value {
    println!("\n{name}: {seconds:.2} s, {} determined, condition {:.0}", fit.n_determined, fit.condition);
    println!("  fit                {:.4?} N m RMS", fit.rms);
    let mut rows = serde_json::Map::new();
    for (test, motion) in tests {
        let rms = fit.rms_on(motion);
        println!("  {test:18} {rms:.4?}");
        rows.insert((*test).into(), json!(rms));
    }
    let least = fit.least_pseudo_inertias().into_iter().fold(f64::MAX, f64::min);
    println!("  least eigenvalue of a pseudo-inertia {least:.2e}");
    fit.warnings.iter().for_each(|warning| println!("  {warning}"));
    json!({"rms_of_fit_n_m": fit.rms, "rms_n_m": rows, "seconds": seconds, "least_pseudo_inertia": least,
        "n_determined": fit.n_determined, "condition": fit.condition})
}

/// The width of Coulomb friction that leaves least on a motion which is neither fitted nor tested.
fn chosen(model: &Model, training: &JointMotion, validation: &JointMotion) -> Fallible<BodyOptions<'static>> {
    let mut best = (f64::INFINITY, 0.0);
    for width in [0.01, 0.02, 0.05, 0.1, 0.2, 0.4] {
        let fit = identify_bodies(model, training, &BodyOptions { terms: &TERMS, width, prior: 1.0 })?;
        // Every joint counts by its share.
        let left: f64 = fit.rms_on(validation).iter().map(|rms| rms.ln()).sum();
        println!("  width {width}: {left:.3}, {:.3?}", fit.rms_on(validation));
        if left < best.0 {
            best = (left, width);
        }
    }
    Ok(BodyOptions { terms: &TERMS, width: best.1, prior: 1.0 })
}

/// The first 70 % fitted, the last 30 % tested.
fn panda(folder: &Path) -> Fallible<Value> {
    let motion = read(folder, "panda-gaz", Some(1000.0), 8.0)?;
    let (n, cut) = (motion.n_samples(), motion.n_samples() * 7 / 10);
    let model = Model::builtin("panda")?
        .with_locked(&[("panda_finger_joint1", 0.0), ("panda_finger_joint2", 0.0)])?;
    let options = chosen(&model, &motion.part(0..cut * 5 / 7), &motion.part(cut * 5 / 7..cut))?;
    let begun = Instant::now();
    let fit = identify_bodies(&model, &motion.part(0..cut), &options)?;
    let seconds = begun.elapsed().as_secs_f64();
    Ok(report("Panda", &fit, &[("last 30 %", &motion.part(cut..n))], seconds))
}

/// Kinematics of an arm of Baxter; bodies of two kilogrammes, which no data sheet gives.
fn baxter_model() -> Fallible<Model> {
    let joints = [
        ("s0", "0 0 0", "0 0 0"),
        ("s1", "0.069 0 0.27035", "-1.57079632679 0 0"),
        ("e0", "0.102 0 0", "1.57079632679 0 1.57079632679"),
        ("e1", "0.069 0 0.26242", "-1.57079632679 -1.57079632679 0"),
        ("w0", "0.10359 0 0", "1.57079632679 0 1.57079632679"),
        ("w1", "0.01 0 0.2707", "-1.57079632679 -1.57079632679 0"),
        ("w2", "0.115975 0 0", "1.57079632679 0 1.57079632679"),
    ];
    let mut urdf = String::from("<robot name=\"baxter\"><link name=\"base\"/>");
    let mut parent = "base".to_owned();
    for (name, xyz, rpy) in joints {
        urdf += &format!(
            "<link name=\"{name}_link\"><inertial><origin xyz=\"0 0 0.05\"/><mass value=\"2\"/>\
             <inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/></inertial></link>\
             <joint name=\"{name}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"{name}_link\"/>\
             <origin xyz=\"{xyz}\" rpy=\"{rpy}\"/><axis xyz=\"0 0 1\"/></joint>"
        );
        parent = format!("{name}_link");
    }
    Ok(Model::from_urdf(&(urdf + "</robot>"), "baxter")?)
}

fn baxter(folder: &Path) -> Fallible<Value> {
    let read = |path: &Path| read(path, "baxter", None, 10.0);
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder.join("train"))?
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<_, std::io::Error>>()?;
    paths.sort();
    let runs = paths.iter().map(|path| read(path)).collect::<Fallible<Vec<JointMotion>>>()?;
    let joined = |runs: &[JointMotion]| {
        let mut all = runs[0].clone();
        runs[1..].iter().for_each(|run| all.extend(run));
        all
    };
    let training = joined(&runs);
    let circle = read(&folder.join("test/circle_XY_T2_r10_ang_vel_torq.csv"))?;
    let helix = read(&folder.join("test/sin_XYZ_12_5s_T2_5_Tz_5T_r18_ang_vel_torq.csv"))?;
    let (validation, others) = runs.split_last().ok_or("no recordings")?;
    let without = joined(others);
    let model = baxter_model()?;
    let options = chosen(&model, &without, validation)?;
    let fewer = identify_bodies(&model, &without, &options)?;
    let response = TorqueResponse::identify(&fewer, &others.iter().collect::<Vec<_>>())?;
    println!("  validation, rigid         {:.4?}", fewer.rms_on(validation));
    println!("  validation, with response {:.4?}", response.rms_on(&fewer, &[validation]));
    let begun = Instant::now();
    let fit = identify_bodies(&model, &training, &options)?;
    let seconds = begun.elapsed().as_secs_f64();
    let mut row = report("Baxter", &fit, &[("circle XY", &circle), ("helical", &helix)], seconds);
    for (name, motion) in [("circle XY", &circle), ("helical", &helix)] {
        let squares: Vec<f64> = fit.rms_on(motion).iter().map(|x| x * x).collect();
        println!("  {name}: MSE {squares:.4?}");
        row["mse"][name] = json!(squares);
    }
    let response = TorqueResponse::identify(&fit, &runs.iter().collect::<Vec<_>>())?;
    println!("  measured torques: lead {:.4?} s, second order {:.6?} s²", response.lead, response.second);
    for (name, motion) in [("circle XY", &circle), ("helical", &helix)] {
        let squares: Vec<f64> = response.rms_on(&fit, &[motion]).iter().map(|x| x * x).collect();
        println!("  {name}, with response: MSE {squares:.4?}");
        row["mse_with_response"][name] = json!(squares);
    }
    Ok(row)
}

/// The first run fitted, the second tested, compared with the robot as identified upstream.
fn kuka(folder: &Path) -> Fallible<Value> {
    let [first, second] =
        ["1", "2"].map(|k| read(&folder.join(format!("measurements_{k}.npz")), "flobaroid", None, 8.0));
    let (first, second) = (first?, second?);
    let nominal = kuka_arm(folder)?;
    let n = first.n_samples();
    let options = chosen(&nominal, &first.part(0..n * 7 / 10), &first.part(n * 7 / 10..n))?;
    let begun = Instant::now();
    let fit = identify_bodies(&nominal, &first, &options)?;
    let mut row = report("KUKA LWR4+", &fit, &[("second run", &second)], begun.elapsed().as_secs_f64());
    let rms = rigid_rms(&nominal, &second);
    println!("  kuka_lwr4_identified.urdf, rigid bodies alone, second run {rms:.4?}");
    row["upstream_rigid_rms_n_m"] = json!(rms);
    Ok(row)
}

/// One exciting trajectory fitted, another and a motion from point to point tested, compared with the
/// parameters that come with the data.
fn ur10e(folder: &Path) -> Fallible<Value> {
    let published = UpstreamUr10e::read(&folder.join("UR10E_parameters.txt"))?;
    let read = |name: &str| with_currents(&folder.join(name), "ur10e", (None, 8.0), &published.gains);
    let training = read("ur-20_02_19_15harm50sec.csv")?;
    let tests = [
        ("12 harmonics", read("ur-20_02_12-50sec_12harm.csv")?),
        ("point to point", read("ur-20_01_17-ptp_10_points.csv")?),
    ];
    let text = std::fs::read_to_string(folder.join("ur10e.urdf"))?;
    let nominal = Model::from_urdf(&text, "ur10e.urdf")?;
    let n = training.n_samples();
    let options = chosen(&nominal, &training.part(0..n * 7 / 10), &training.part(n * 7 / 10..n))?;
    let begun = Instant::now();
    let fit = identify_bodies(&nominal, &training, &options)?;
    let seconds = begun.elapsed().as_secs_f64();
    let shown: Vec<(&str, &JointMotion)> = tests.iter().map(|(name, motion)| (*name, motion)).collect();
    let mut row = report("UR10e", &fit, &shown, seconds);
    let upstream = Model::from_urdf(&published.urdf(&text)?, "ur10e.urdf with its parameters")?;
    for (name, motion) in &tests {
        let rms = published.rms(&upstream, motion);
        println!("  parameters supplied with the data, {name} {rms:.4?}");
        row["upstream_rms_n_m"][name] = json!(rms);
    }
    Ok(row)
}

/// Upstream parameters of the UR10e: drive gains, rotor inertias, friction, ten inertial parameters of every
/// body about its link's frame.
struct UpstreamUr10e {
    gains: Vec<f64>,
    rotors: Vec<f64>,
    /// Viscous, Coulomb and offset of every joint.
    friction: Vec<f64>,
    /// xx, xy, xz, yy, yz, zz, first moment, mass of every link.
    bodies: Vec<f64>,
}

impl UpstreamUr10e {
    fn read(path: &Path) -> Fallible<Self> {
        let text = std::fs::read_to_string(path)?;
        let list = |name: &str, n: usize| -> Fallible<Vec<f64>> {
            let from = text.find(&format!("{name} = [")).ok_or("a list is missing")? + name.len() + 4;
            let list = text[from..].split(']').next().unwrap_or_default();
            let numbers = list.split_whitespace().map(str::parse).collect::<Result<Vec<f64>, _>>()?;
            if numbers.len() == n {
                Ok(numbers)
            } else {
                Err(format!("{name}: {} numbers", numbers.len()).into())
            }
        };
        Ok(Self {
            gains: list("drvGains", 6)?,
            rotors: list("pi_drvs", 6)?,
            friction: list("pi_frcn", 18)?,
            bodies: list("pi_rgd", 60)?,
        })
    }

    /// The robot's file with these bodies.
    fn urdf(&self, text: &str) -> Fallible<String> {
        let links = ["shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3"];
        let mut text = text.to_owned();
        for (link, body) in links.iter().zip(self.bodies.chunks(10)) {
            let at = text.find(&format!("<link name=\"{link}_link\">")).ok_or("a link is missing")?;
            let from = at + text[at..].find("<inertial>").ok_or("no inertial")?;
            let to = at + text[at..].find("</inertial>").ok_or("no inertial")? + "</inertial>".len();
            let [xx, xy, xz, yy, yz, zz, hx, hy, hz, m] = <[f64; 10]>::try_from(body)?;
            let [x, y, z] = [hx, hy, hz].map(|h| h / m);
            let inertial = format!(
                "<inertial><mass value=\"{m}\"/><origin rpy=\"0 0 0\" xyz=\"{x} {y} {z}\"/>\
                 <inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/></inertial>",
                xx - m * (y * y + z * z),
                xy + m * x * y,
                xz + m * x * z,
                yy - m * (x * x + z * z),
                yz + m * y * z,
                zz - m * (x * x + y * y),
            );
            text.replace_range(from..to, &inertial);
        }
        Ok(text)
    }

    fn rms(&self, model: &Model, motion: &JointMotion) -> Vec<f64> {
        rms_of(model, motion, &|j, dq, ddq| {
            let [viscous, coulomb, offset] = [0, 1, 2].map(|k| self.friction[3 * j + k]);
            self.rotors[j] * ddq + viscous * dq + coulomb * dq.signum() + offset
        })
    }
}

fn rigid_rms(model: &Model, motion: &JointMotion) -> Vec<f64> {
    rms_of(model, motion, &|_, _, _| 0.0)
}

/// Root mean square torque residual of every joint (n_joints) after rigid bodies and `more`, a function of
/// joint, speed and acceleration.
fn rms_of(model: &Model, motion: &JointMotion, more: &dyn Fn(usize, f64, f64) -> f64) -> Vec<f64> {
    let n = motion.n_joints;
    let (mut data, mut tau, mut squares) = (Data::new(model, 0.0), vec![0.0; n], vec![0.0; n]);
    for s in 0..motion.n_samples() {
        let at = s * n..(s + 1) * n;
        inverse_dynamics(
            model,
            &mut data,
            [&motion.q[at.clone()], &motion.dq[at.clone()], &motion.ddq[at.clone()]],
            &[],
            &mut tau,
        );
        for (j, square) in squares.iter_mut().enumerate() {
            let k = s * n + j;
            *square += (tau[j] + more(j, motion.dq[k], motion.ddq[k]) - motion.tau[k]).powi(2);
        }
    }
    squares.iter().map(|square| (square / motion.n_samples() as f64).sqrt()).collect()
}
