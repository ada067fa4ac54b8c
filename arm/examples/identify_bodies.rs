//! Bodies and friction of real arms identified, and tested on motions that were not fitted.
//!
//!     HYSTERON_DATA=../shared/data cargo run --release -p hysteron-arm --example identify_bodies [-- metrics.json]
//!
//! Data: Panda of Gaz et al. (RA-L 2019); Baxter of Valencia-Vidal et al. (2023); KUKA LWR4+ of FloBaRoID; UR10e of Mamedov.
#![allow(clippy::print_stdout)] // this program prints tables

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use hysteron_arm::identify::{BodyFit, BodyOptions, JointMotion, JointTerm, identify_bodies};
use hysteron_arm::{Columns, Data, ImportOptions, Model, Recorded, import, inverse_dynamics};
use hysteron_base::Metadata;
use serde_json::{Value, json};

type Fallible<T> = Result<T, Box<dyn Error>>;

const TERMS: [JointTerm; 5] =
    [JointTerm::Armature, JointTerm::Coulomb, JointTerm::Viscous, JointTerm::Offset, JointTerm::Spring];

fn main() -> Fallible<()> {
    let folder =
        std::env::var_os("HYSTERON_DATA").map_or_else(|| PathBuf::from("../shared/data"), PathBuf::from);
    let folder = folder.join("arms");
    if !folder.is_dir() {
        println!("skipped: no recordings in {}", folder.display());
        return Ok(());
    }
    let metrics = json!({
        "format": "hysteron-metrics", "version": 1, "study": "identify_bodies",
        "metrics": {"panda": panda(&folder.join("panda-gaz"))?, "baxter": baxter(&folder.join("baxter"))?, "kuka": kuka(&folder.join("kuka-lwr4"))?},
    });
    if let Some(path) = std::env::args().nth(1) {
        hysteron_base::file::write_bytes(Path::new(&path), serde_json::to_vec_pretty(&metrics)?)?;
    }
    Ok(())
}

/// A file of other people's, smoothed.
fn read(path: &Path, columns: &str, rate: Option<f64>, cutoff: f64) -> Fallible<JointMotion> {
    let options =
        ImportOptions { columns: Some(Columns::named(columns)?), rate_hz: rate, ..ImportOptions::default() };
    let imported = import(path, &options, Metadata::default())?;
    Ok(JointMotion::of_recording(&Recorded::of(&imported.recording)?, &[], 4, cutoff)?)
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
    let mut training = read(&paths[0])?;
    for path in &paths[1..] {
        training.extend(&read(path)?);
    }
    let circle = read(&folder.join("test/circle_XY_T2_r10_ang_vel_torq.csv"))?;
    let helix = read(&folder.join("test/sin_XYZ_12_5s_T2_5_Tz_5T_r18_ang_vel_torq.csv"))?;
    let mut without = read(&paths[0])?;
    for path in &paths[1..paths.len() - 1] {
        without.extend(&read(path)?);
    }
    let model = baxter_model()?;
    let options = chosen(&model, &without, &read(&paths[paths.len() - 1])?)?;
    let begun = Instant::now();
    let fit = identify_bodies(&model, &training, &options)?;
    let seconds = begun.elapsed().as_secs_f64();
    let mut row = report("Baxter", &fit, &[("circle XY", &circle), ("helical", &helix)], seconds);
    for (name, motion) in [("circle XY", &circle), ("helical", &helix)] {
        let squares: Vec<f64> = fit.rms_on(motion).iter().map(|x| x * x).collect();
        println!("  {name}: MSE {squares:.4?}");
        row["mse"][name] = json!(squares);
    }
    Ok(row)
}

/// The first run fitted, the second tested, beside the robot as identified upstream.
fn kuka(folder: &Path) -> Fallible<Value> {
    let [first, second] =
        ["1", "2"].map(|k| read(&folder.join(format!("measurements_{k}.npz")), "flobaroid", None, 8.0));
    let (first, second) = (first?, second?);
    // Of the three files that come with the data, one gives links two origins, one a body that cannot exist, and the identified
    // one friction below zero, which is left out.
    let text = std::fs::read_to_string(folder.join("kuka_lwr4_identified.urdf"))?;
    let lines: Vec<&str> = text.lines().filter(|line| !line.contains("<dynamics")).collect();
    let nominal = Model::from_urdf(&lines.join("\n"), "kuka_lwr4_identified.urdf")?;
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

fn rigid_rms(model: &Model, motion: &JointMotion) -> Vec<f64> {
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
        for (square, (a, b)) in squares.iter_mut().zip(tau.iter().zip(&motion.tau[at])) {
            *square += (a - b).powi(2);
        }
    }
    squares.iter().map(|square| (square / motion.n_samples() as f64).sqrt()).collect()
}
