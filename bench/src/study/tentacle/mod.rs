//! Fourteen holds of a silicone tentacle under known tension: with nominal parameters, with fitted ones, and with
//! residual tensions on top.
//!
//! Frames: the mesh has the body along z; mocap x, y, z are the mesh's y, z, x. The robot hangs, gravity
//! along the body. Markers sit on arms fixed to the sections, whose rotation is the best fit over points of the
//! section.
#![allow(clippy::print_stdout)] // this program prints tables

mod fits;
mod residual;
mod setup;

use std::path::Path;

use anyhow::{Context, Result};
use hysteron_base::{Bounds, LengthUnit, Material, MaterialLaw, Scene, json};
use hysteron_fem::{Embedding, FemModel, read_mesh};
use hysteron_twin::{Stepper, Target, TwinState, nearest_rotation};
use nalgebra::{Matrix3, Rotation3, Vector3};

use super::{data_folder, rms, write_metrics};
use crate::columns::read_columns;
use crate::scenes::{Setting, tendon, twin};
use crate::table::print_cells;

const N_MARKERS: usize = 4;
/// Arc length of the markers' sections and their offset along the rod frame's Z [m].
const ARMS: [(f64, f64); 3] = [(0.1291, 0.025), (0.2195, -0.021), (0.2800, 0.020)];
/// Length of the body, and distance of the last marker beyond it [m].
const TIP: (f64, f64) = (0.360, 0.008);
/// Centre of the base from the base marker, mocap axes [m].
const BASE: [f64; 3] = [-0.030, -0.013, 0.0];
/// Largest tension step [N].
const TENSION_STEP: f64 = 0.25;
/// RMSE of upstream's rod model with the same parameters [mm], as published.
const PUBLISHED: f64 = 36.8;
/// A rod model of our own in the same frames [mm]: pooled and mean of markers over session B, pooled over all holds.
const OWN_ROD: [f64; 3] = [47.8, 36.4, 42.0];

/// Runs the study, a quick one with nominal parameters alone; skipped by name where the recordings are not there.
///
/// # Errors
/// The files cannot be read, or a hold has no equilibrium.
pub fn run(folder: &Path, quick: bool) -> Result<()> {
    let path = data_folder().join("tentacle/static_markers.csv");
    if !path.exists() {
        println!("study tentacle skipped: no {}", path.display());
        return Ok(());
    }
    let holds = read_holds(&path)?;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../meshes/tentacle/tentacle-quadratic.msh");
    let mesh = read_mesh(&path, LengthUnit::Millimetre.to_m())?;
    let material = Material {
        law: MaterialLaw::Corotational,
        youngs_modulus: 505e3,
        poisson_ratio: 0.45,
        density: 1500.0,
    };
    let tendons = [30.0f64, 150.0].map(|degrees| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let points = (0..=61).map(|k| {
            let s = 0.305 * f64::from(k) / 61.0;
            let r = 0.0114 - 0.0295 * s;
            [r * cos, r * sin, s]
        });
        tendon(format!("tendon {degrees}"), points.collect(), Bounds { min: 0.0, max: 100.0 })
    });
    let twin = twin(Setting::TARGETS, material, &mesh, tendons.to_vec(), [0.0, 0.0, 9.81])?;
    let markers = Markers::new(&twin.body);

    let mut errors = Vec::new();
    let mut cells = vec![
        ["hold", "session", "T1 [N]", "T2 [N]", "p1 [mm]", "p2", "p3", "p4", "RMSE [mm]"]
            .map(str::to_owned)
            .to_vec(),
    ];
    for tendon in 0..2 {
        // Holds of one tendon in ascending tension follow each other.
        let mut of_tendon: Vec<(usize, &Hold)> =
            holds.iter().enumerate().filter(|(_, hold)| hold.tensions[tendon] > 0.0).collect();
        of_tendon.sort_by(|a, b| a.1.tensions[tendon].total_cmp(&b.1.tensions[tendon]));
        let mut stepper = Stepper::new(&twin);
        stepper.step(&twin, &[Target::Tension(0.0); 2])?;
        for (number, hold) in of_tendon {
            let from = stepper.state().tensions[tendon];
            let rise = hold.tensions[tendon] - from;
            let n = (rise / TENSION_STEP).ceil().max(1.0) as usize;
            for k in 1..=n {
                let mut targets = [Target::Tension(0.0); 2];
                targets[tendon] = Target::Tension(from + rise * k as f64 / n as f64);
                stepper.step(&twin, &targets).with_context(|| format!("hold {}", number + 1))?;
            }
            let predicted = markers.at(stepper.state(), hold.base);
            let error: [f64; N_MARKERS] =
                std::array::from_fn(|m| 1e3 * (predicted[m] - hold.markers[m]).norm());
            errors.push((number, hold.is_session_b(), error));
        }
    }
    errors.sort_by_key(|(number, ..)| *number);
    for (number, is_b, error) in &errors {
        let hold = &holds[*number];
        let mut row = vec![(number + 1).to_string(), if *is_b { "B" } else { "A" }.to_owned()];
        row.extend(hold.tensions.iter().chain(error).map(|v| format!("{v:.2}")));
        row.push(format!("{:.2}", rms(*error)));
        cells.push(row);
    }
    print_cells(&cells);

    let of = |only_b: bool| errors.iter().filter(move |(_, is_b, _)| *is_b || !only_b).map(|(.., e)| *e);
    let pooled = |only_b: bool| rms(of(only_b).flatten());
    let of_markers =
        |only_b: bool| (0..N_MARKERS).map(|m| rms(of(only_b).map(|e| e[m]))).sum::<f64>() / N_MARKERS as f64;
    let figures = [
        ("session B, pooled", pooled(true), Some(OWN_ROD[0]), None),
        ("session B, mean of the markers' RMSE", of_markers(true), Some(OWN_ROD[1]), Some(PUBLISHED)),
        ("all holds, pooled", pooled(false), Some(OWN_ROD[2]), None),
        ("all holds, mean of the markers' RMSE", of_markers(false), None, None),
    ];
    println!();
    let heading = ["RMSE [mm]", "this FE twin", "own rod model", "published rod model"];
    let mut cells = vec![heading.map(str::to_owned).to_vec()];
    for (name, twin, own, published) in figures {
        let optional = |v: Option<f64>| v.map_or("-".into(), |v| format!("{v:.1}"));
        cells.push(vec![name.into(), format!("{twin:.2}"), optional(own), optional(published)]);
    }
    print_cells(&cells);
    let recorded = holds;
    let holds: Vec<_> = errors
        .iter()
        .map(|(number, is_b, error)| {
            json!({
                "hold": number + 1,
                "session": if *is_b { "B" } else { "A" },
                "tensions_n": recorded[*number].tensions,
                "marker_error_mm": error,
                "rmse_mm": rms(*error),
            })
        })
        .collect();
    let summary: Vec<_> = figures
        .iter()
        .map(|(name, twin, own, published)| {
            json!({"over": name, "rmse_mm": twin, "own_rod_mm": own, "published_rod_mm": published})
        })
        .collect();
    if quick {
        return write_metrics(folder, "tentacle", json!({"holds": holds, "summary": summary}));
    }
    let bench = fits::Bench::new(&recorded)?;
    let (setups, fitted) = fits::run(&bench)?;
    let scene =
        Scene::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../meshes/tentacle/scene-coreact.toml"))?;
    let last = setups.last().context("no set")?;
    let residual = residual::run(&bench, last, &scene)?;
    write_metrics(
        folder,
        "tentacle",
        json!({"holds": holds, "summary": summary, "fits": fitted, "residual_tensions": residual}),
    )
}

/// A static hold.
#[derive(Clone)]
struct Hold {
    tensions: [f64; 2],
    base: Vector3<f64>,
    markers: [Vector3<f64>; N_MARKERS],
}

impl Hold {
    /// The two sessions differ in where the base stood.
    fn is_session_b(&self) -> bool {
        (self.base.x - 0.2175).abs() < 0.005
    }
}

fn read_holds(path: &Path) -> Result<Vec<Hold>> {
    let mut names = vec!["tension1_N".to_owned(), "tension2_N".to_owned()];
    for marker in ["pb", "p1", "p2", "p3", "p4"] {
        names.extend(["x", "y", "z"].map(|axis| format!("{marker}_{axis}")));
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let columns = read_columns(path, &names)?;
    let hold = |k: usize| {
        let point = |m: usize| Vector3::from_fn(|c, _| columns[2 + 3 * m + c][k]);
        Hold {
            tensions: [columns[0][k], columns[1][k]],
            base: point(0),
            markers: std::array::from_fn(|m| point(m + 1)),
        }
    };
    Ok((0..columns[0].len()).map(hold).collect())
}

/// A section: its centre and a ring of points, carried by the body.
struct Section {
    rest: Vec<Vector3<f64>>,
    points: Vec<Embedding>,
}

impl Section {
    fn new(body: &FemModel, s: f64, radius: f64) -> Self {
        let ring = (0..8).map(|k| {
            let (sin, cos) = (std::f64::consts::FRAC_PI_4 * f64::from(k)).sin_cos();
            Vector3::new(radius * cos, radius * sin, s)
        });
        let rest: Vec<_> = std::iter::once(Vector3::new(0.0, 0.0, s)).chain(ring).collect();
        let points = rest.iter().map(|point| Embedding::new(body, (*point).into())).collect();
        Self { rest, points }
    }

    /// Centre and best-fit rotation.
    fn pose(&self, state: &TwinState) -> (Vector3<f64>, Matrix3<f64>) {
        let moved: Vec<_> =
            self.points.iter().map(|point| Vector3::from(point.at(&state.positions))).collect();
        let mean = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        let (from, to) = (mean(&self.rest), mean(&moved));
        let mut moment = Matrix3::zeros();
        for (rest, moved) in self.rest.iter().zip(&moved) {
            moment += (moved - to) * (rest - from).transpose();
        }
        (moved[0], nearest_rotation(&moment))
    }
}

struct Markers {
    arms: Vec<(Section, Vector3<f64>)>,
}

impl Markers {
    fn new(body: &FemModel) -> Self {
        let mut arms: Vec<_> = ARMS
            .into_iter()
            .map(|(s, offset)| (Section::new(body, s, 0.004), Vector3::new(0.0, offset, 0.0)))
            .collect();
        arms.push((Section::new(body, TIP.0, 0.004), Vector3::new(0.0, 0.0, TIP.1)));
        Self { arms }
    }

    /// Markers in the mesh's axes, their arms turned by `twist` about the axis [rad].
    fn in_body(&self, state: &TwinState, twist: f64) -> [Vector3<f64>; N_MARKERS] {
        let twist = Rotation3::from_axis_angle(&Vector3::z_axis(), twist);
        std::array::from_fn(|m| {
            let (section, arm) = &self.arms[m];
            let (center, rotation) = section.pose(state);
            center + rotation * (twist * arm)
        })
    }

    /// Markers in the mocap frame.
    fn at(&self, state: &TwinState, base: Vector3<f64>) -> [Vector3<f64>; N_MARKERS] {
        self.in_body(state, 0.0).map(|point| in_mocap(point, base))
    }
}

/// A point in the mesh's axes, in the mocap frame.
fn in_mocap(point: Vector3<f64>, base: Vector3<f64>) -> Vector3<f64> {
    base + Vector3::from(BASE) + Vector3::new(point.y, point.z, point.x)
}
