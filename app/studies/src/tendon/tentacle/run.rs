//! The run of `study tentacle`.

use anyhow::{Context as _, Result};
use hysteron_base::{Bounds, LengthUnit, Material, MaterialLaw, Scene};
use hysteron_fem::read_mesh;
use hysteron_twin::{Stepper, Target, Twin};
use hysteron_workflow::{Context, WorkflowError};

use super::holds::{Hold, Markers, N_MARKERS, read_holds};
use super::outcome::{HoldErrors, PooledError, TentacleMetrics};
use super::{fits, residual};
use crate::tendon::numbers::rms;
use crate::tendon::scenes::{Setting, tendon, twin};
use crate::tendon::{DataOptions, Outcome, session};

/// Largest tension step [N].
const TENSION_STEP: f64 = 0.25;
/// RMSE of upstream's rod model with the same parameters [mm], as published.
const PUBLISHED: f64 = 36.8;
/// A rod model of our own in the same frames [mm]: pooled and mean of markers over session B, pooled over all holds.
const OWN_ROD: [f64; 3] = [47.8, 36.4, 42.0];

/// Runs the study, a quick one with nominal parameters alone.
///
/// # Errors
/// The files are missing or cannot be read, or a hold has no equilibrium.
pub fn run(options: &DataOptions, context: &Context) -> Result<Outcome<TentacleMetrics>, WorkflowError> {
    session::run("tentacle", &options.shared.out, context, || measure(options, context))
}

fn measure(options: &DataOptions, context: &Context) -> Result<TentacleMetrics> {
    let recorded = read_holds(&options.require("tentacle/static_markers.csv")?)?;
    let meshes = options.shared.repository.join("meshes/tentacle");
    let twin = nominal(&meshes.join("tentacle-quadratic.msh"))?;
    let holds = errors(&twin, &recorded)?;
    let summary = summary(&holds);
    if options.shared.quick {
        return Ok(TentacleMetrics { holds, summary, fits: None, residual_tensions: None });
    }
    let bench = fits::Bench::new(&recorded)?;
    let (setups, fitted) = fits::run(&bench, context)?;
    let scene = Scene::read(meshes.join("scene-coreact.toml"))?;
    let last = setups.last().context("no set")?;
    let residual = residual::run(&bench, last, &scene)?;
    Ok(TentacleMetrics { holds, summary, fits: Some(fitted), residual_tensions: Some(residual) })
}

/// The twin with nominal parameters.
fn nominal(mesh: &std::path::Path) -> Result<Twin> {
    let mesh = read_mesh(mesh, LengthUnit::Millimetre.to_m())?;
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
    twin(Setting::TARGETS, material, &mesh, tendons.to_vec(), [0.0, 0.0, 9.81])
}

/// Errors of every hold, in their order.
fn errors(twin: &Twin, holds: &[Hold]) -> Result<Vec<HoldErrors>> {
    let markers = Markers::new(&twin.body);
    let mut errors = Vec::new();
    for tendon in 0..2 {
        // Holds of one tendon in ascending tension follow each other.
        let mut of_tendon: Vec<(usize, &Hold)> =
            holds.iter().enumerate().filter(|(_, hold)| hold.tensions[tendon] > 0.0).collect();
        of_tendon.sort_by(|a, b| a.1.tensions[tendon].total_cmp(&b.1.tensions[tendon]));
        let mut stepper = Stepper::new(twin);
        stepper.step(twin, &[Target::Tension(0.0); 2])?;
        for (number, hold) in of_tendon {
            let from = stepper.state().tensions[tendon];
            let rise = hold.tensions[tendon] - from;
            let n = (rise / TENSION_STEP).ceil().max(1.0) as usize;
            for k in 1..=n {
                let mut targets = [Target::Tension(0.0); 2];
                targets[tendon] = Target::Tension(from + rise * k as f64 / n as f64);
                stepper.step(twin, &targets).with_context(|| format!("hold {}", number + 1))?;
            }
            let predicted = markers.at(stepper.state(), hold.base);
            let error: [f64; N_MARKERS] =
                std::array::from_fn(|m| 1e3 * (predicted[m] - hold.markers[m]).norm());
            errors.push(HoldErrors {
                hold: number + 1,
                session: if hold.is_session_b() { "B" } else { "A" }.to_owned(),
                tensions_n: hold.tensions,
                marker_error_mm: error,
                rmse_mm: rms(error),
            });
        }
    }
    errors.sort_by_key(|one| one.hold);
    Ok(errors)
}

/// Errors over the holds, compared with rod models.
fn summary(holds: &[HoldErrors]) -> Vec<PooledError> {
    let of = |sessions: &'static [&str]| {
        holds.iter().filter(|one| sessions.contains(&one.session.as_str())).map(|one| one.marker_error_mm)
    };
    let pooled = |sessions| rms(of(sessions).flatten());
    let of_markers =
        |sessions| (0..N_MARKERS).map(|m| rms(of(sessions).map(|e| e[m]))).sum::<f64>() / N_MARKERS as f64;
    let (b, all): (&'static [&str], &'static [&str]) = (&["B"], &["A", "B"]);
    let row = |over: &str, rmse_mm, own_rod_mm, published_rod_mm| PooledError {
        over: over.to_owned(),
        rmse_mm,
        own_rod_mm,
        published_rod_mm,
    };
    vec![
        row("session B, pooled", pooled(b), Some(OWN_ROD[0]), None),
        row("session B, mean of the markers' RMSE", of_markers(b), Some(OWN_ROD[1]), Some(PUBLISHED)),
        row("all holds, pooled", pooled(all), Some(OWN_ROD[2]), None),
        row("all holds, mean of the markers' RMSE", of_markers(all), None, None),
    ]
}
