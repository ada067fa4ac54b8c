//! A scene and its mesh: elements, tendons, equations.

use std::path::Path;
use std::sync::Arc;

use hysteron_base::{PrescribedQuantity, Scene};
use hysteron_fem::{FactorKind, Stiffness, StiffnessFactor, Tangent};
use hysteron_twin::{LockingEstimator, Twin};

use super::outcome::SceneSummary;
use crate::Context;
use crate::shared::locking;
use crate::shared::recording_checks::body_length;
use crate::tendon::mesh::{MeshSummary, print_quality};

/// Checks a scene and its mesh; gives the length of the body too [m].
pub(super) fn check(path: &Path, context: &Context) -> anyhow::Result<(SceneSummary, f64)> {
    let scene = Scene::read(path)?;
    let (body, quality) = hysteron_twin::read_body(&scene)?;
    let twin = Twin::new(&scene, &body)?.with_body_of(&scene)?;

    context.print(format_args!("{}: {}", scene.name, scene.mesh_path.display()));
    print_quality(&body, &quality, context);
    let mass = scene.material.density * quality.volume.sum;
    let tip = twin.tip_of(&twin.rest()).map(|c| (1e6 * c).round() / 1e3 + 0.0);
    context.print("");
    context.print(format_args!(
        "mass {:.2} g, tip at ({:.3}, {:.3}, {:.3}) mm",
        1e3 * mass,
        tip[0],
        tip[1],
        tip[2]
    ));
    context.print("");
    print_tendons(&twin, context);
    print_friction(&twin, context);
    context.print("");
    let factor = print_equations(&twin, context)?;
    print_chain(&scene, &twin, context);
    quality.warnings().iter().for_each(|warning| tracing::warn!("{warning}"));
    let estimator = LockingEstimator::new(&scene, &body)?;
    locking::warn(&estimator);
    let outcome = SceneSummary {
        robot: scene.name.clone(),
        scene_sha256: scene.hash.clone(),
        mesh: MeshSummary::new(&body, &quality),
        mass_kg: mass,
        tip_m: twin.tip_of(&twin.rest()),
        tendons: twin.n_primary,
        auxiliary_tendons: twin.tendons.len() - twin.n_primary,
        unknowns: twin.body.n_unknowns(),
        factor_bytes: factor,
        locking: estimator.estimate().clone(),
        warnings: quality.warnings(),
    };
    Ok((outcome, body_length(&twin)))
}

fn print_chain(scene: &Scene, twin: &Twin, context: &Context) {
    let Some((path, chain)) = scene.reduced_path.as_ref().zip(twin.chain.as_ref()) else { return };
    let (sections, unknowns) = (chain.n_sections(), chain.n_unknowns());
    context.print(format_args!("moved by {}: {sections} sections, {unknowns} unknowns", path.display()));
    if let Some(errors) = &chain.validation {
        context.print(format_args!(
            "against the mesh, in 99 of 100 equilibria: tip within {:.2} %, tensions within {:.2} %, turn within {:.2} deg",
            100.0 * errors.tip.percentile_99,
            100.0 * errors.tensions.percentile_99,
            errors.turn.percentile_99.to_degrees()
        ));
    }
}

fn print_friction(twin: &Twin, context: &Context) {
    if twin.backlash > 0.0 {
        context.print(format_args!("backlash {} mm", in_thousandths(twin.backlash)));
    }
    for (j, tendon) in twin.tendons.iter().enumerate() {
        let points = twin.friction.iter().filter(|point| point.tendon == j);
        let sheath = points
            .clone()
            .filter(|point| point.first == 0)
            .map(|point| format!("in the sheath, exponent {}, {} N; ", point.coefficient, point.constant));
        let inside: Vec<_> = points.filter(|point| point.first > 0).collect();
        let constant: f64 = inside.iter().map(|point| point.constant).sum();
        let body = inside.first().map(|point| {
            let n = inside.len();
            format!("at {n} points of the body, coefficient {}, {constant} N in all", point.coefficient)
        });
        let parts: String = sheath.chain(body).collect();
        if !parts.is_empty() {
            context.print(format_args!("{} has friction {}", tendon.name, parts.trim_end_matches("; ")));
        }
    }
}

fn print_tendons(twin: &Twin, context: &Context) {
    context.print(
        "tendon             driven by   points   length [mm]   outside the body [mm]   tension [N]   stretch [mm/N]   zero [mm]",
    );
    for j in 0..twin.n_primary {
        print_row(twin, &twin.tendons[j].name, j, j + 1, context);
    }
    if twin.tendons.len() > twin.n_primary {
        let (first, last) = (&twin.tendons[twin.n_primary], &twin.tendons[twin.tendons.len() - 1]);
        let name = format!("{} to {}", first.name, last.name.trim_start_matches("aux_"));
        print_row(twin, &name, twin.n_primary, twin.tendons.len(), context);
    }
}

/// A row for the tendons from `first` up to, not including, `end`, which differ only in where they run.
fn print_row(twin: &Twin, name: &str, first: usize, end: usize, context: &Context) {
    let tendon = &twin.tendons[first];
    let n_points = twin.cables.polyline(first, &twin.body.rest).len();
    let outside = twin.tendons[first..end].iter().map(|tendon| tendon.outside).fold(0.0, f64::max);
    let drive = match tendon.drive {
        PrescribedQuantity::Stroke => "stroke",
        PrescribedQuantity::Tension => "tension",
        PrescribedQuantity::Free => "nothing",
    };
    context.print(format_args!(
        "{name:<19}{drive:<12}{:>6}{:>14.3}{:>24.3}   {:<14}{:<17}{}",
        n_points,
        1e3 * twin.cables.rest_lengths[first],
        1e3 * outside,
        format!("{} to {}", tendon.tension.min, tendon.tension.max),
        in_thousandths(tendon.compliance),
        in_thousandths(tendon.zero),
    ));
}

/// A length in millimetres, or a compliance in millimetres per newton, without the noise of the conversion.
fn in_thousandths(value: f64) -> f64 {
    (1e9 * value).round() / 1e6 + 0.0
}

/// Prints their size; gives that of the factor [bytes].
fn print_equations(twin: &Twin, context: &Context) -> anyhow::Result<usize> {
    let pattern = Arc::new(twin.body.stiffness_pattern(&[]));
    let kind = FactorKind::fastest(&pattern);
    let mut factor = StiffnessFactor::new(&pattern, kind, twin.body.isa);
    let mut stiffness = Stiffness::zeros(pattern);
    twin.body.stiffness_into(&twin.body.rest, Tangent::Warped, &mut stiffness);
    factor.factorize(&stiffness)?;
    let (name, bytes) = match kind {
        FactorKind::Envelope => ("block envelope, single precision", 4),
        FactorKind::Supernodal => ("supernodal Cholesky, double precision", 8),
    };
    context.print(format_args!(
        "{} unknowns, {} tensions; factor: {name}, {:.1} MB",
        twin.body.n_unknowns(),
        twin.cables.len(),
        (factor.n_stored() * bytes) as f64 / 1e6,
    ));
    Ok(factor.n_stored() * bytes)
}
