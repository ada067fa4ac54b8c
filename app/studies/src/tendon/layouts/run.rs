//! The run of `study layouts`.

use std::path::Path;

use anyhow::Result;
use hysteron_base::Recording;
use hysteron_workflow::tendon::identify::{self, IdentifiedRecording};
use hysteron_workflow::{Context, WorkflowError};
use nalgebra::Matrix3xX;

use super::outcome::{LayoutMetrics, LayoutReach};
use crate::tendon::commands::{ChainCommands, FRICTION, TESTS, read_outcome};
use crate::tendon::coreact::{TwinAblation, TwinModels};
use crate::tendon::numbers::percentile;
use crate::tendon::{Options, Outcome, session};

/// Segments of two tendons each between the same ends, and their length [mm]: the paper's, and fewer.
const LAYOUTS: [(usize, f64); 4] = [(18, 4.0), (6, 12.0), (4, 18.0), (2, 36.0)];
/// Every third recording is a training recording, in one pass.
const OF_ALL: usize = 3;

/// Runs the study on the virtual rig's `typical`; quick: two layouts, one test, few epochs.
///
/// # Errors
/// A command fails, or an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome<LayoutMetrics>, WorkflowError> {
    session::run("layouts", &options.out, context, || measure(options, context))
}

fn measure(options: &Options, context: &Context) -> Result<LayoutMetrics> {
    let chain = ChainCommands::of_typical(&options.out, &options.repository, context)?;
    chain.record("typical", "paper", "data")?;
    let training: Vec<String> = chain.training_recordings()?.into_iter().step_by(OF_ALL).collect();
    let (layouts, tests, epochs) = if options.quick {
        (&LAYOUTS[2..], &TESTS[..1], Some("2"))
    } else {
        (&LAYOUTS[..], &TESTS[..], None)
    };
    let (mut found, mut twins) = (Vec::new(), Vec::new());
    for &(segments, length) in layouts {
        let n_tendons = 2 * segments;
        let (file, scene) = (format!("layout-{n_tendons}"), write_scene(&chain, segments, length)?);
        let identified = chain.identify(&file, &scene, None, &training)?;
        let name = format!("{n_tendons} auxiliary tendons");
        found.push(layout(&name, Path::new(&identified), n_tendons)?);
        let models = chain.train(&file, &identified, 1, epochs)?.into_iter().map(Some).collect();
        twins.push(TwinModels { name, scene, models });
    }
    let robot = "typical, one pass on a third of the recordings";
    let table = TwinAblation { chain, tests }.roll_out(&twins, "data", robot)?;
    Ok(LayoutMetrics { layouts: found, ladder: table })
}

/// Writes the scene with friction with other auxiliary tendons; gives its path.
fn write_scene(chain: &ChainCommands, segments: usize, length: f64) -> Result<String> {
    let meshes = chain.meshes().canonicalize()?;
    let text = std::fs::read_to_string(meshes.join(FRICTION.1))?;
    let mesh = format!("file = \"{}\"", meshes.join("tpu80.msh").display());
    let lines = [
        ("segments = 18", &format!("segments = {segments}")[..]),
        ("segment_length_mm = 4.0", &format!("segment_length_mm = {length:?}")),
        ("file = \"tpu80.msh\"", &mesh),
    ];
    chain.write_changed(&text, &lines, &format!("layouts/{segments}.toml"))
}

fn layout(name: &str, identified: &Path, n_tendons: usize) -> Result<LayoutReach> {
    let found: identify::Outcome = read_outcome(&identified.join("metrics.json"))?;
    let mean = |of: fn(&IdentifiedRecording) -> f64| {
        1e3 * found.recordings.iter().map(of).sum::<f64>() / found.recordings.len() as f64
    };
    let left_median_p99_mm = [mean(|one| one.summary.after.median_m), mean(|one| one.summary.after.p99_m)];
    let mut singular: [Vec<f64>; 3] = Default::default();
    for entry in std::fs::read_dir(identified.join("sensitivity"))? {
        let recording = Recording::read(entry?.path())?;
        let mut rows = Vec::new();
        for axis in ["x", "y", "z"] {
            for k in 1..=n_tendons {
                rows.push(recording.require(&format!("sensitivity_{axis}_{k:02}_ratio"))?);
            }
        }
        for i in 0..recording.n_samples() {
            let matrix = Matrix3xX::from_fn(n_tendons, |axis, k| rows[axis * n_tendons + k][i]);
            let values = matrix.singular_values();
            singular.iter_mut().zip(values.iter()).for_each(|(all, value)| all.push(*value));
        }
    }
    let singular_values = singular.map(|values| percentile(&values, 0.5));
    Ok(LayoutReach { layout: name.to_owned(), singular_values, left_median_p99_mm })
}
