//! The run of `study sorosim`.

use std::f64::consts::{PI, TAU};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};
use hysteron_base::{Material, MaterialLaw};
use hysteron_fem::{Cells, Embedding, Layers, Mesh, Order, Tube};
use hysteron_twin::{Couple, Stepper, Twin};
use hysteron_workflow::{Context, WorkflowError};
use rayon::prelude::*;

use super::outcome::{ErrorStatistics, RodResolution, StationErrors};
use crate::tendon::numbers::{distance, percentile};
use crate::tendon::scenes::{Setting, twin};
use crate::tendon::{DataOptions, Outcome, session};

const LENGTH: f64 = 0.4;
const RADIUS: f64 = 5e-3;
const YOUNGS_MODULUS: f64 = 70e6;
const POISSON_RATIO: f64 = 0.4;
const DENSITY: f64 = 1200.0;
const N_STATIONS: usize = 14;

/// One row of the reference; SI, world frame with the rod along x.
#[derive(Debug, Clone)]
struct Shape {
    gravity: [f64; 3],
    /// Moment, then force, at mid-length and at the tip.
    wrenches: [[[f64; 3]; 2]; 2],
    stations: [[f64; 3]; N_STATIONS],
}

/// Runs the study, quick: on every 25th shape.
///
/// # Errors
/// The reference is missing or cannot be read, or a shape has no equilibrium.
pub fn run(options: &DataOptions, context: &Context) -> Result<Outcome<Vec<RodResolution>>, WorkflowError> {
    let quick = options.shared.quick;
    session::run("sorosim", &options.shared.out, context, || {
        let path = options.require("../reference/sorosim/TPURodMuJoCo_dataStatics.csv")?;
        let (arc_lengths, shapes) = read(&path)?;
        let shapes: Vec<Shape> = shapes.into_iter().step_by(if quick { 25 } else { 1 }).collect();
        // The finer one shows what is left of the discretisation.
        let resolutions: &[(u32, u32)] = if quick { &[(6, 50)] } else { &[(6, 64), (6, 100)] };
        resolutions.iter().map(|&size| compare(&arc_lengths, &shapes, size, context)).collect()
    })
}

fn compare(
    arc_lengths: &[f64; N_STATIONS],
    shapes: &[Shape],
    (sides, layers): (u32, u32),
    context: &Context,
) -> Result<RodResolution> {
    let rod = Rod::new(sides, layers)?;
    let start = Instant::now();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build()?;
    let solved: Vec<Solved> = pool.install(|| {
        let solve = |(k, shape)| rod.solve(shape, arc_lengths).with_context(|| format!("shape {}", k + 1));
        shapes.par_iter().enumerate().map(solve).collect::<Result<_>>()
    })?;
    let percent =
        |k: usize, s: usize| 100.0 / LENGTH * distance(solved[k].stations[s], shapes[k].stations[s]);
    let over = |stations: Range<usize>| {
        let errors: Vec<f64> =
            (0..shapes.len()).flat_map(|k| stations.clone().map(move |s| percent(k, s))).collect();
        ErrorStatistics {
            median: percentile(&errors, 0.5),
            mean: errors.iter().sum::<f64>() / errors.len() as f64,
            p95: percentile(&errors, 0.95),
            max: percentile(&errors, 1.0),
        }
    };
    let iterations = solved.iter().map(|solved| solved.iterations).sum::<usize>();
    let found = RodResolution {
        shapes: shapes.len(),
        sides,
        layers,
        n_unknowns: rod.twin.body.n_unknowns(),
        seconds_on_two_threads: start.elapsed().as_secs_f64(),
        worst_relative_residual: solved.iter().map(|solved| solved.residual).fold(0.0, f64::max),
        iterations_per_shape: iterations as f64 / shapes.len() as f64,
        error_percent_of_length: StationErrors {
            mid_length: over(6..7),
            tip: over(13..14),
            all: over(1..14),
        },
    };
    context.print(format_args!("{sides} sides, {layers} layers: {:.0} s", found.seconds_on_two_threads));
    Ok(found)
}

/// The meshed rod, unloaded.
struct Rod {
    twin: Twin,
    /// Nodes of the loaded sections with their share of a uniform traction.
    sections: [Vec<(u32, f64)>; 2],
}

struct Solved {
    stations: [[f64; 3]; N_STATIONS],
    residual: f64,
    iterations: usize,
}

impl Rod {
    fn new(sides: u32, layers: u32) -> Result<Self> {
        // The polygon with corners at `radius` has area n/2 R² sin(2π/n) and second moment
        // n/24 R⁴ sin(2π/n) (2 + cos(2π/n)).
        let n = f64::from(sides);
        let (sin, cos) = (TAU / n).sin_cos();
        let radius = (0.25 * PI * RADIUS.powi(4) / (n / 24.0 * sin * (2.0 + cos))).powf(0.25);
        let area = 0.5 * n * radius * radius * sin;
        let mut mesh = Tube {
            profile: vec![[0.0, radius], [LENGTH, radius]],
            bore_radius: 0.0,
            channels: Vec::new(),
            outer_divisions: sides,
            bore_divisions: sides,
            channel_divisions: sides,
            layers: Layers::Count(layers),
            order: Order::Quadratic,
        }
        .mesh()?;
        for node in &mut mesh.nodes {
            // Along x, right-handed.
            node.rotate_right(1);
        }
        let material = Material {
            law: MaterialLaw::Corotational,
            youngs_modulus: YOUNGS_MODULUS,
            poisson_ratio: POISSON_RATIO,
            density: DENSITY * PI * RADIUS * RADIUS / area,
        };
        let setting = Setting::TARGETS;
        let twin = twin(setting, material, &mesh, Vec::new(), [0.0; 3])?;
        let section = |x: f64| traction(&mesh, &twin, x);
        let sections = [section(0.5 * LENGTH), section(LENGTH)];
        ensure!(sections.iter().all(|section| !section.is_empty()), "no section where a wrench acts");
        Ok(Self { twin, sections })
    }

    /// The equilibrium of `shape`, from rest: the step applies the loads in parts where it must.
    fn solve(&self, shape: &Shape, arc_lengths: &[f64; N_STATIONS]) -> Result<Solved> {
        let mut twin = self.twin.clone();
        let mut loads = twin.body.weight(shape.gravity);
        for (nodes, [_, force]) in self.sections.iter().zip(&shape.wrenches) {
            for &(node, share) in nodes {
                for c in 0..3 {
                    loads[node as usize][c] += share * force[c];
                }
            }
        }
        twin.loads = loads;
        let couple = |(nodes, [moment, _]): (&Vec<_>, &[[f64; 3]; 2])| Couple {
            nodes: nodes.clone(),
            moment: *moment,
        };
        twin.couples = self.sections.iter().zip(&shape.wrenches).map(couple).collect();
        let mut stepper = Stepper::new(&twin);
        let mut solved = Solved { stations: [[0.0; 3]; N_STATIONS], residual: 0.0, iterations: 0 };
        let report = stepper.step(&twin, &[])?;
        solved.residual = report.relative_residual;
        solved.iterations = report.newton_iterations;
        for (station, s) in solved.stations.iter_mut().zip(arc_lengths) {
            *station = Embedding::new(&twin.body, [*s, 0.0, 0.0]).at(&stepper.state().positions);
        }
        Ok(solved)
    }
}

/// Nodes of the section at `x` with their shares of a uniform traction: on a quadratic triangle, a third of its
/// area at each middle of an edge.
fn traction(mesh: &Mesh, twin: &Twin, x: f64) -> Vec<(u32, f64)> {
    const FACES: [([usize; 3], [usize; 3]); 4] =
        [([0, 1, 2], [4, 5, 6]), ([0, 1, 3], [4, 8, 7]), ([0, 2, 3], [6, 9, 7]), ([1, 2, 3], [5, 9, 8])];
    let mut shares = std::collections::BTreeMap::new();
    let Cells::Tet10(cells) = &mesh.cells else { return Vec::new() };
    let point = |node: u32| nalgebra::Vector3::from(mesh.nodes[node as usize]);
    for cell in cells {
        for (corners, middles) in FACES {
            let [a, b, c] = corners.map(|i| point(cell[i]));
            if [a, b, c].iter().all(|corner| (corner.x - x).abs() < 1e-9) {
                let area = 0.5 * (b - a).cross(&(c - a)).norm();
                for i in middles {
                    *shares.entry(twin.body.model_node[cell[i] as usize]).or_insert(0.0) += area;
                }
            }
        }
    }
    let total: f64 = shares.values().sum();
    shares.into_iter().map(|(node, share)| (node, share / total)).collect()
}

/// Arc lengths of the stations [m] and all shapes.
fn read(path: &Path) -> Result<([f64; N_STATIONS], Vec<Shape>)> {
    let path: PathBuf = path.to_owned();
    let place = || path.display().to_string();
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_path(&path).with_context(place)?;
    let mut rows = Vec::new();
    for record in reader.records().skip(1) {
        let record = record.with_context(place)?;
        let row: Vec<f64> =
            record.iter().skip(1).map(str::parse).collect::<Result<_, _>>().with_context(place)?;
        ensure!(row.len() == 3 + N_STATIONS, "{}: {} columns", place(), row.len());
        rows.push(row);
    }
    ensure!(rows.len() % 6 == 1, "{}: {} rows after the heading", place(), rows.len());
    // The heading counts from 0 to 1 along each half.
    let half = 0.5 * LENGTH;
    let arc_lengths =
        std::array::from_fn(|s| half * (rows[0][3 + s] + if s < N_STATIONS / 2 { 0.0 } else { 1.0 }));
    let shape = |rows: &[Vec<f64>]| {
        let angular = |c: usize| [rows[0][c], rows[1][c], rows[2][c]];
        let linear = |c: usize| [rows[3][c], rows[4][c], rows[5][c]];
        Shape {
            gravity: linear(0),
            wrenches: [1, 2].map(|c| [angular(c), linear(c)]),
            stations: std::array::from_fn(|s| linear(3 + s)),
        }
    };
    Ok((arc_lengths, rows[1..].chunks_exact(6).map(shape).collect()))
}
