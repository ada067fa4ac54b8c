//! The runs of the studies of learned inverse dynamics.

use std::path::{Path, PathBuf};

use hysteron_arm_dynamics::Model;
use hysteron_arm_learning::datasets::{BaxterTraining, RealSet, baxter, kuka, kuka_arm, panda};
use hysteron_base::BadInput;
use hysteron_workflow::shared::outputs::Outputs;
use hysteron_workflow::{Context, WorkflowError};

use super::options::{CharactersOptions, RecordedOptions, SimulatedOptions};
use super::outcome::{Outcome, Recorded, RecordedTable, Simulated, Study};
use super::page::{self, TorqueSeries};
use super::real::real_study;
use super::simulated::{SimulatedRow, SimulatedStudy, characters_study, simulated_study};
use crate::runner::{self, Listener};

/// A recorded arm, or all whose recordings are there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordedSet {
    /// Baxter draws circles.
    BaxterCircle,
    /// Baxter draws helices.
    BaxterHelical,
    /// KUKA LWR4+.
    Kuka,
    /// Panda.
    Panda,
    /// Every recorded arm that is there, each with its table.
    All,
}

/// Runs the study of the three-link arm.
///
/// # Errors
/// Bad options, cells of another study, files that cannot be written, an interruption.
pub fn simulated(options: &SimulatedOptions, context: &Context) -> Result<Outcome, WorkflowError> {
    let study = options.three_link().map_err(anyhow::Error::from)?;
    let compute = |cells: &Path, listener: Listener<'_>| {
        Ok(Some(simulated_study(&study, &Model::builtin("three-link")?, cells, listener)?))
    };
    runner::run(&options.out, Outputs::default(), context, compute, |rows| {
        report(&options.out, (study.clone(), rows), context)
    })
}

/// Runs the study of the arm that writes.
///
/// # Errors
/// As [`simulated`], and recordings that cannot be read.
pub fn characters(options: &CharactersOptions, context: &Context) -> Result<Outcome, WorkflowError> {
    let (file, out) = (options.data.join("delan-characters/characters.csv"), &options.simulated.out);
    let study = options.simulated.characters().map_err(anyhow::Error::from)?;
    let compute = |cells: &Path, listener: Listener<'_>| {
        let data = hysteron_arm_learning::datasets::characters(&file)?;
        Ok(Some(characters_study(&study, data, cells, listener)?))
    };
    runner::run(out, Outputs::reading([&file]), context, compute, |rows| {
        report(out, (study.clone(), rows), context)
    })
}

fn report(
    out: &Path,
    (study, rows): (SimulatedStudy, Vec<SimulatedRow>),
    context: &Context,
) -> anyhow::Result<Outcome> {
    let outcome = Outcome::new(Study::Simulated(Simulated { study, rows }), context);
    page::write(out, &outcome, &[])?;
    Ok(outcome)
}

/// Runs the study of a recorded arm, or of all that are there.
///
/// # Errors
/// Bad options, recordings that are missing or cannot be read, cells of another study, files that cannot be written, an
/// interruption.
pub fn recorded(
    set: RecordedSet,
    options: &RecordedOptions,
    context: &Context,
) -> Result<Outcome, WorkflowError> {
    let models = options.models().map_err(anyhow::Error::from)?;
    let compute = |cells: &Path, mut listener: Listener<'_>| -> anyhow::Result<_> {
        let (sets, left_out) = match set {
            RecordedSet::All => there(&options.data)?,
            one => (vec![(one, PathBuf::new())], Vec::new()),
        };
        let (mut tables, mut series) = (Vec::new(), Vec::new());
        for (set, folder) in sets {
            let folder = cells.join(folder);
            let (set, model) = read(set, &options.data)?;
            let mut rows = real_study(&set, &model, &models, &folder, &mut listener)?;
            if context.is_cancelled() {
                return Ok(None);
            }
            series.push(TorqueSeries::take(&set.test, &mut rows));
            tables.push(RecordedTable::new(&set, rows));
        }
        Ok(Some((Recorded { options: models.clone(), tables, left_out }, series)))
    };
    runner::run(&options.out, inputs(set, &options.data), context, compute, |(study, series)| {
        let outcome = Outcome::new(Study::Recorded(study), context);
        page::write(&options.out, &outcome, &series)?;
        Ok(outcome)
    })
}

/// Files that a set is read from.
fn inputs(set: RecordedSet, data: &Path) -> Outputs {
    match set {
        RecordedSet::Kuka => Outputs::reading(
            ["measurements_1.npz", "measurements_2.npz"].map(|name| data.join("kuka-lwr4").join(name)),
        ),
        _ => Outputs::default(),
    }
}

/// Recorded sets, each with the folder of its cells.
type SetsOfCells = Vec<(RecordedSet, PathBuf)>;

/// Recorded sets whose folder is there, each with a folder of its own below that of the cells; and those that are not there.
fn there(data: &Path) -> Result<(SetsOfCells, Vec<String>), BadInput> {
    let sets = [
        (RecordedSet::BaxterCircle, "baxter", "baxter-circle"),
        (RecordedSet::BaxterHelical, "baxter", "baxter-helical"),
        (RecordedSet::Kuka, "kuka-lwr4", "kuka"),
        (RecordedSet::Panda, "panda-gaz", "panda"),
    ];
    let (there, missing): (Vec<_>, Vec<_>) =
        sets.into_iter().partition(|(_, folder, _)| data.join(folder).is_dir());
    if there.is_empty() {
        let expected = sets.map(|(_, folder, _)| folder)[1..].join(", or ");
        return Err(BadInput::new(data.display().to_string(), expected, "none of them"));
    }
    let left_out: Vec<String> =
        missing.iter().map(|(_, folder, set)| format!("{set}: no {folder}/")).collect();
    left_out.iter().for_each(|why| tracing::warn!("skipped: {why} in {}", data.display()));
    Ok((there.into_iter().map(|(set, _, cells)| (set, cells.into())).collect(), left_out))
}

/// A recorded set and the kinematics of its arm.
fn read(set: RecordedSet, data: &Path) -> anyhow::Result<(RealSet, Model)> {
    let folder = data.join("baxter");
    let arm = || {
        Ok::<_, anyhow::Error>(Model::from_urdf(
            hysteron_arm_learning::datasets::BAXTER_ARM,
            "baxter_arm.urdf",
        )?)
    };
    Ok(match set {
        RecordedSet::BaxterHelical => {
            let test = "sin_XYZ_12_5s_T2_5_Tz_5T_r18_ang_vel_torq.csv";
            (baxter(&folder, test, BaxterTraining::Helical)?, arm()?)
        }
        RecordedSet::Kuka => {
            let folder = data.join("kuka-lwr4");
            (kuka(&folder)?, kuka_arm(&folder)?)
        }
        RecordedSet::Panda => {
            let fingers = [("panda_finger_joint1", 0.0), ("panda_finger_joint2", 0.0)];
            (panda(&data.join("panda-gaz"))?, Model::builtin("panda")?.with_locked(&fingers)?)
        }
        _ => (baxter(&folder, "circle_XY_T2_r10_ang_vel_torq.csv", BaxterTraining::All)?, arm()?),
    })
}
