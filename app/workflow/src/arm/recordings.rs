//! Recordings of arms: who makes one, and those that a person names, as files or as folders like those of the data set NAD.

use std::path::{Path, PathBuf};

use hysteron_arm_dynamics::Model;
use hysteron_arm_learning::neural::{FeatureLayout, Trajectory, Unlabelled, trajectory_of};
use hysteron_base::checks::{CheckContext, Purpose};
use hysteron_base::{BadInput, Metadata, Recording};

use crate::shared::recording_checks::{self, Findings};
use crate::{COMMIT, Context};

/// Metadata of a recording that a verb makes; `source` describes it.
pub fn meta(context: &Context, source: &str) -> Metadata {
    Metadata {
        source: source.to_owned(),
        commit: COMMIT.to_owned(),
        command: context.command.clone(),
        ..Metadata::default()
    }
}

/// Role of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// For the fit.
    Training,
    /// For early stopping and selection.
    Validation,
    /// For the test.
    Test,
}

/// A recording with the names that it goes by.
pub(crate) struct Named {
    pub path: PathBuf,
    /// Folders of subset and task, where they are known: `weight/pick_place_object_500g`.
    pub task: String,
    pub role: Role,
    /// Whether the data set marks it.
    pub is_split: bool,
    pub recording: Recording,
}

/// How deep folders are looked through.
const DEEPEST: usize = 6;
/// Most recordings of a call.
const MAX_RECORDINGS: usize = 10_000;
/// Of files named one by one, every so many one is for validation.
const VALIDATION: usize = 4;

/// Files that `paths` name, folders looked through, in the order of their names; those whose path contains one of `leave_out` are not
/// among them.
///
/// # Errors
/// `BadInput` where nothing is found, or too much.
pub fn files(paths: &[PathBuf], leave_out: &[String]) -> Result<Vec<PathBuf>, BadInput> {
    let mut all = Vec::new();
    for path in paths {
        if path.is_dir() { collect_files(path, DEEPEST, &mut all)? } else { all.push(path.clone()) }
    }
    let is_kept = |path: &PathBuf| {
        let text = path.display().to_string();
        !leave_out.iter().any(|part| text.contains(part.as_str()))
    };
    all.retain(is_kept);
    all.sort();
    all.dedup();
    if all.is_empty() {
        let named: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
        return Err(BadInput::new("recordings", "at least one file .parquet or .csv", named.join(", ")));
    }
    Ok(all)
}

fn collect_files(folder: &Path, depth: usize, all: &mut Vec<PathBuf>) -> Result<(), BadInput> {
    let unreadable = |error: std::io::Error| {
        BadInput::new(folder.display().to_string(), "a folder that can be read", error.to_string())
    };
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if path.is_dir() && depth > 0 {
            collect_files(&path, depth - 1, all)?;
        } else if matches!(path.extension().and_then(|ending| ending.to_str()), Some("parquet" | "csv")) {
            all.push(path);
        }
        if all.len() > MAX_RECORDINGS {
            let place = folder.display().to_string();
            return Err(BadInput::new(place, format!("at most {MAX_RECORDINGS} recordings"), "more"));
        }
    }
    Ok(())
}

/// Reads them. Folders called `train`, `validation` and `test` set the use of a recording; of others every fourth is for validation.
///
/// # Errors
/// Those of reading.
pub(crate) fn read(files: &[PathBuf]) -> anyhow::Result<Vec<Named>> {
    let mut n_others = 0;
    files
        .iter()
        .map(|path| {
            let recording = crate::shared::memory::recording(path)?;
            let named = recording.meta().extra.get("trajectory").cloned();
            let parts: Vec<String> = match named {
                Some(named) => named.split('/').map(str::to_owned).collect(),
                None => path.iter().map(|part| part.to_string_lossy().into_owned()).collect(),
            };
            let split = split_of(&parts);
            let own = split.as_ref().map(|(role, _)| *role).unwrap_or_else(|| {
                n_others += 1;
                if n_others % VALIDATION == VALIDATION / 2 { Role::Validation } else { Role::Training }
            });
            let is_split = split.is_some();
            let task = match split {
                Some((_, task)) => task,
                None => path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned()),
            };
            Ok(Named { path: path.clone(), task, role: own, is_split, recording })
        })
        .collect()
}

/// Checks recordings of an arm before they are used.
///
/// # Errors
/// A finding that cannot be right.
pub(crate) fn checked(named: &[Named], model: &Model, purpose: Purpose) -> anyhow::Result<Findings> {
    let names: Vec<String> = named.iter().map(|one| recording_checks::name_of(&one.path)).collect();
    let recordings = names.iter().zip(named).map(|(name, one)| (name.as_str(), &one.recording));
    let ranges = recording_checks::joint_ranges(model);
    let checks = CheckContext { joint_ranges: &ranges, ..CheckContext::new(purpose) };
    recording_checks::of_named(&recordings.collect::<Vec<_>>(), &checks)
}

/// The trajectories of a role, for these inputs at this period [s]; paths that contain one of `free` move freely.
pub(crate) fn trajectories(
    named: &[Named],
    role: Role,
    (features, period, free): (&FeatureLayout, f64, &[String]),
) -> anyhow::Result<Vec<Trajectory>> {
    let one = |one: &Named| -> anyhow::Result<Trajectory> {
        let path = one.path.display().to_string();
        let is_free = free.iter().any(|part| path.contains(part.as_str()));
        let unlabelled = if is_free { Unlabelled::Free } else { Unlabelled::Unknown };
        let found =
            trajectory_of(&one.recording, features, period, unlabelled).map_err(|bad| bad.within(&path))?;
        Ok(Trajectory { name: path, ..found })
    };
    let found: Vec<Trajectory> =
        named.iter().filter(|one| one.role == role).map(one).collect::<anyhow::Result<_>>()?;
    if found.is_empty() && role != Role::Test {
        let expected = "two or more, one of them for validation";
        let found = if role == Role::Training { "none for training" } else { "none for validation" };
        return Err(BadInput::new("recordings", expected, found).into());
    }
    Ok(found)
}

/// Role of a file, by its folders, and the folders of subset and task; `None` where no folder gives a role.
pub fn role_and_task(path: &Path) -> Option<(Role, String)> {
    let parts: Vec<String> = path.iter().map(|part| part.to_string_lossy().into_owned()).collect();
    split_of(&parts)
}

fn split_of(parts: &[String]) -> Option<(Role, String)> {
    let at = parts.iter().position(|part| role(part).is_some())?;
    Some((role(&parts[at])?, parts[at.saturating_sub(2)..at].join("/")))
}

fn role(part: &str) -> Option<Role> {
    match part {
        "train" => Some(Role::Training),
        "validation" => Some(Role::Validation),
        "test" => Some(Role::Test),
        _ => None,
    }
}
