//! The run of `study convergence`.

use anyhow::Result;
use hysteron_base::MaterialLaw;
use hysteron_fem::{Cells, Mesh, Order};
use hysteron_twin::{Stepper, Twin};
use hysteron_workflow::{Context, WorkflowError};

use super::outcome::{MeshResolution, TUBE};
use crate::tendon::numbers::distance;
use crate::tendon::scenes::{N_PRIMARY, Setting, one_sided, sofa_mesh, sofa_scene, tube, tube_scene};
use crate::tendon::{Options, Outcome, session};

/// Stroke between two equilibria [m], and how many of them.
const STEP: f64 = 0.2e-3;
const N_STEPS: usize = 50;
/// Rows reported: 2, 7 and 10 mm.
const REPORTED: [usize; 3] = [10, 35, 50];
/// Ring in the middle of the wall, which is 3 mm thick [m].
const RING: f64 = 1.2e-3;

/// Runs the study; quick: without the finest meshes.
///
/// # Errors
/// A scene cannot be built.
pub fn run(options: &Options, context: &Context) -> Result<Outcome<Vec<MeshResolution>>, WorkflowError> {
    session::run("convergence", &options.out, context, || resolutions(options, context))
}

fn resolutions(options: &Options, context: &Context) -> Result<Vec<MeshResolution>> {
    let reference = sofa_mesh(&options.repository)?;
    let edges = MaterialLaw::CorotationalEdges;
    let mut meshes = vec![
        ("SOFA's mesh, edges".to_owned(), edges, reference.clone(), true),
        ("SOFA's mesh".to_owned(), MaterialLaw::Corotational, reference.clone(), true),
        ("SOFA's mesh, neo-Hookean".to_owned(), MaterialLaw::NeoHookean, reference.clone(), true),
        ("SOFA's mesh, quadratic".to_owned(), MaterialLaw::Corotational, reference.to_quadratic(), true),
    ];
    let (linear, quadratic): (&[u32], &[u32]) =
        if options.quick { (&[12, 20], &[10]) } else { (&[16, 24, 32], &[8, 12, 16]) };
    for (divisions, order) in
        linear.iter().map(|d| (d, Order::Linear)).chain(quadratic.iter().map(|d| (d, Order::Quadratic)))
    {
        let name = format!("{TUBE}, {divisions} sides");
        meshes.push((name, MaterialLaw::Corotational, tube(*divisions, order).mesh()?, false));
    }
    let mut metrics = Vec::new();
    for ring in [0.0, RING] {
        for (name, law, mesh, is_reference) in &meshes {
            let setting = Setting { law: *law, ring, ..Setting::TARGETS };
            let twin = if *is_reference {
                sofa_scene(&options.repository, setting, mesh, N_PRIMARY)?
            } else {
                tube_scene(setting, mesh)?
            };
            let found = solve(name, setting, mesh, &twin);
            context.print(format_args!(
                "{name}, rings of {:.1} mm: {:.1} mm reached",
                found.ring_mm, found.reached_mm
            ));
            metrics.push(found);
        }
    }
    Ok(metrics)
}

fn solve(name: &str, setting: Setting, mesh: &Mesh, twin: &Twin) -> MeshResolution {
    let order = match mesh.cells {
        Cells::Tet4(_) => 1,
        Cells::Tet10(_) => 2,
    };
    let mut stepper = Stepper::new(twin);
    let rest = twin.tip_of(stepper.state());
    let mut curve = vec![[0.0; 2]];
    let mut failure = None;
    for k in 1..=N_STEPS {
        match stepper.step(twin, &one_sided(N_PRIMARY, STEP * k as f64)) {
            Ok(_) => {
                let state = stepper.state();
                curve.push([1e3 * distance(twin.tip_of(state), rest), state.tensions[0]]);
            }
            Err(error) => {
                failure = Some(error.to_string());
                break;
            }
        }
    }
    let at = |k: usize, c: usize| curve.get(k).map(|values| values[c]);
    MeshResolution {
        mesh: name.to_owned(),
        order,
        law: format!("{:?}", setting.law),
        ring_mm: 1e3 * setting.ring,
        n_unknowns: twin.body.n_unknowns(),
        stroke_mm: REPORTED.map(|k| 1e3 * STEP * k as f64),
        deflection_mm: REPORTED.map(|k| at(k, 0)),
        tension_n: REPORTED.map(|k| at(k, 1)),
        reached_mm: 1e3 * STEP * (curve.len() - 1) as f64,
        failure,
    }
}
