//! Recordings that `study force` reads: of individual virtual arms, or files of NAD.

use std::path::{Path, PathBuf};

use hysteron_arm_estimation::{ColumnMap, ImportOptions, import};
use hysteron_base::{BadInput, Metadata, Recording, file, parallel};
use hysteron_learn::Error;
use hysteron_virtual_rig::virtual_arm::{N_JOINTS, Planned, VirtualArm, data_set};

use super::methods::TASKS;
use super::{ForceData, ServoForceTelemetry};

/// Contact-free training trajectories of each task.
pub(super) const TRAINING: usize = 3;

type Found<T> = std::result::Result<T, Error>;

/// Recordings of an individual arm: contact-free training, contact-free tests, tests with objects.
pub(super) fn recorded(general: &VirtualArm, seed: u64) -> Found<ForceData> {
    let arm = general.individual(seed);
    let is_training =
        |one: &Planned| one.subset == "force_unlabeled" && one.split == "train" && one.number <= TRAINING;
    let is_free = |one: &Planned| one.subset == "force_unlabeled" && one.split == "test";
    let is_loaded =
        |one: &Planned| one.subset == "weight" && one.split == "test" && TASKS.contains(&one.task.as_str());
    let telemetry = |selects: &(dyn Fn(&Planned) -> bool + Sync)| {
        let planned: Vec<Planned> = data_set().into_iter().filter(selects).collect();
        let one = |one: &Planned| -> Found<(String, ServoForceTelemetry)> {
            let refused = |e: hysteron_rig::Error| BadInput::new(one.name(), "a recording", e.to_string());
            let recording =
                arm.record(&one.trial, seed, &one.name(), Metadata::default()).map_err(refused)?;
            Ok((one.task.clone(), ServoForceTelemetry::of(&recording, N_JOINTS)?))
        };
        parallel::try_map(&planned, one)
    };
    Ok(ForceData {
        training: telemetry(&is_training)?.into_iter().map(|(_, one)| one).collect(),
        free: telemetry(&is_free)?,
        loaded: telemetry(&is_loaded)?,
    })
}

/// Files of NAD, or of `hysteron arm generate`, with their tasks.
pub(super) struct NadFiles {
    training: Vec<(String, PathBuf)>,
    free: Vec<(String, PathBuf)>,
    loaded: Vec<(String, PathBuf)>,
}

impl NadFiles {
    /// Those in `force_unlabeled` and `weight` below a folder.
    pub fn below(folder: &Path) -> Found<Self> {
        let free = tasks(&folder.join("force_unlabeled"))?;
        let mut found = Self { training: vec![], free: vec![], loaded: vec![] };
        for (task, folder) in &free {
            let training = trajectories(&folder.join("train"))?.into_iter().take(TRAINING);
            found.training.extend(training.map(|path| (task.clone(), path)));
            found
                .free
                .extend(trajectories(&folder.join("test"))?.into_iter().map(|path| (task.clone(), path)));
        }
        for (task, folder) in tasks(&folder.join("weight"))? {
            if TASKS.contains(&task.as_str()) {
                let tests = trajectories(&folder.join("test"))?.into_iter();
                found.loaded.extend(tests.map(|path| (task.clone(), path)));
            }
        }
        if found.loaded.is_empty() {
            let place = folder.join("weight").display().to_string();
            let expected = format!("tests of one of {}", TASKS.join(", "));
            return Err(BadInput::new(place, expected, "none").into());
        }
        Ok(found)
    }

    /// Tells one set of files from another.
    pub fn digest(&self) -> Found<String> {
        let mut all = Vec::new();
        for (_, path) in self.training.iter().chain(&self.free).chain(&self.loaded) {
            all.extend_from_slice(file::sha256_of(path)?.as_bytes());
        }
        Ok(file::sha256_hex(&all))
    }

    pub fn read(&self) -> Found<ForceData> {
        let each = |files: &[(String, PathBuf)]| -> Found<Vec<_>> {
            let one = |(task, path): &(String, PathBuf)| Ok((task.clone(), telemetry(path)?));
            parallel::try_map(files, one)
        };
        Ok(ForceData {
            training: each(&self.training)?.into_iter().map(|(_, one)| one).collect(),
            free: each(&self.free)?,
            loaded: each(&self.loaded)?,
        })
    }
}

fn telemetry(path: &Path) -> Found<ServoForceTelemetry> {
    let recording = if path.extension().is_some_and(|ending| ending == "csv") {
        let options = ImportOptions { columns: Some(ColumnMap::named("nad-omx")?), ..Default::default() };
        import(path, &options, Metadata::default())?.recording
    } else {
        Recording::read(path)?
    };
    Ok(ServoForceTelemetry::of(&recording, N_JOINTS).map_err(|bad| bad.within(path.display()))?)
}

/// Entries of a folder that there must be, in order of their names.
fn entries(folder: &Path) -> Found<Vec<PathBuf>> {
    let missing = |e: std::io::Error| {
        BadInput::new("--data", format!("a folder of NAD with {}", folder.display()), e.to_string())
    };
    let entries = std::fs::read_dir(folder).map_err(missing)?;
    let mut paths = entries
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<Vec<_>, _>>()
        .map_err(missing)?;
    paths.sort();
    Ok(paths)
}

/// Folders of tasks by name.
fn tasks(folder: &Path) -> Found<Vec<(String, PathBuf)>> {
    let named = |path: PathBuf| Some((path.file_name()?.to_str()?.to_owned(), path));
    Ok(entries(folder)?.into_iter().filter(|path| path.is_dir()).filter_map(named).collect())
}

fn trajectories(folder: &Path) -> Found<Vec<PathBuf>> {
    let is_one =
        |path: &PathBuf| path.extension().is_some_and(|ending| ending == "csv" || ending == "parquet");
    Ok(entries(folder)?.into_iter().filter(is_one).collect())
}
