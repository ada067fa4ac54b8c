//! A scene fitted to recordings of full length: how long it takes with all cores.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use hysteron_base::Scene;
use hysteron_twin::chain::Chain;
use hysteron_twin::fit::{FitBody, FitParameter, MaterialOptions, Stepping, TipFrame, fit_material, select};
use hysteron_twin::{RobotMotion, Twin};

use crate::coreact::recorded;
use crate::measure::processor_seconds;
use crate::table::{FigureTarget, TableRow};

/// Parameters of the fit: friction among them, which makes a step dear and a fit begin from several places.
const PARAMETERS: [&str; 4] = ["common_zero", "compliance", "sheath_exponent", "backlash"];
/// Amplitudes of the recordings' strokes [m].
const AMPLITUDES: [f64; 3] = [6.5e-3, 5e-3, 3.5e-3];
/// As `hysteron fit-material` without options.
const STEPPING: Stepping = Stepping { step: 3e-4, every: 2e-4, most: 2000 };
/// Longest time that is asked for, with two cores [s].
const LONGEST: f64 = 60.0;

/// Time of a fit of four parameters to three recordings of `n` samples, with the finite elements and with a chain of sections.
///
/// # Errors
/// The scene or the rig's preset is bad, or a step fails.
pub fn rows(n: usize) -> Result<Vec<TableRow>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../meshes/tpu80");
    let scene = Scene::read(folder.join("scene-typical-friction.toml"))?;
    let mesh = hysteron_fem::read_mesh(&scene.mesh_path, scene.mesh_unit.to_m())?;
    let twin = Twin::new(&scene, &mesh)?;
    let motion =
        |amplitude: &f64| Ok(RobotMotion::new(&twin, &recorded(*amplitude, n)?, "the virtual rig's circle")?);
    let motions: Vec<RobotMotion> = AMPLITUDES.iter().map(motion).collect::<Result<_>>()?;
    let parameters: Vec<FitParameter> = PARAMETERS.iter().map(|name| FitParameter::named(*name)).collect();
    let selected = select(&scene, &parameters)?;
    let options = MaterialOptions {
        frame: TipFrame::Trusted,
        stepping: STEPPING,
        huber: None,
        tension_max: None,
        watch: &|_| true,
    };
    let chain = Chain::new(&twin)?;
    let mut rows = Vec::new();
    for (body, chain) in [("", None), ("chain, ", Some(&chain))] {
        let (start, before) = (Instant::now(), processor_seconds());
        let found = fit_material(&scene, FitBody { mesh: &mesh, chain }, &motions, &selected, &options)?;
        let (seconds, after) = (start.elapsed().as_secs_f64(), processor_seconds());
        let name = format!("{body}fit of a scene, four parameters, three recordings of {n} samples");
        let mut row = TableRow::new(name, seconds, "s").goal(FigureTarget::AtMost(LONGEST));
        if let Some(processor) = before.zip(after).map(|(before, after)| after - before) {
            row = row.against(processor, "processor time of all threads");
        }
        let [given, fitted] = found.errors.each_ref().map(|errors| 1e3 * errors.distance);
        rows.push(row);
        rows.push(
            TableRow::new(format!("{body}tip with that fit"), fitted, "mm")
                .against(given, "the scene as given"),
        );
    }
    Ok(rows)
}
