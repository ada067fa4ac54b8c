//! Trajectories of the data set NAD, and of the faults that it does not have, that are asked for.

use hysteron_base::BadInput;
use hysteron_virtual_rig::virtual_arm::{Planned, SPLITS, data_set, fault_set};

use super::Options;

/// The trajectories that are asked for.
pub(super) fn selected(options: &Options) -> Result<Vec<Planned>, BadInput> {
    let nad = data_set();
    let mut own: Vec<&str> = nad.iter().map(|one| one.subset).collect();
    own.dedup();
    let all = [nad.clone(), fault_set()].concat();
    let mut subsets: Vec<&str> = all.iter().map(|one| one.subset).collect();
    subsets.dedup();
    known("--subsets", &options.subsets, &subsets)?;
    known("--splits", &options.splits, &SPLITS)?;
    let grams = |one: &Planned| (1e3 * one.trial.payload).round() as u32;
    if let Some(none) =
        options.payloads_g.iter().find(|requested| all.iter().all(|one| grams(one) != **requested))
    {
        let mut there: Vec<u32> = all.iter().map(grams).collect();
        there.sort_unstable();
        there.dedup();
        let there: Vec<String> = there.iter().map(u32::to_string).collect();
        return Err(BadInput::new("--payloads-g", format!("some of {}", there.join(", ")), none.to_string()));
    }
    let is_in =
        |requested: &[String], name: &str| requested.is_empty() || requested.iter().any(|one| one == name);
    // What NAD does not have is asked for by name.
    let is_wanted = |name: &str| {
        if options.subsets.is_empty() { own.contains(&name) } else { is_in(&options.subsets, name) }
    };
    let mut tasks: Vec<&str> = all.iter().map(|one| one.task.as_str()).collect();
    tasks.dedup();
    if let Some(none) =
        options.tasks.iter().find(|requested| !tasks.iter().any(|task| task.contains(requested.as_str())))
    {
        let expected = format!("parts of names of tasks: {}", tasks.join(", "));
        return Err(BadInput::new("--tasks", expected, format!("\"{none}\"")));
    }
    let chosen: Vec<Planned> = all
        .iter()
        .filter(|one| is_wanted(one.subset) && is_in(&options.splits, one.split))
        .filter(|one| {
            options.tasks.is_empty() || options.tasks.iter().any(|part| one.task.contains(part.as_str()))
        })
        .filter(|one| options.payloads_g.is_empty() || options.payloads_g.contains(&grams(one)))
        .filter(|one| options.trajectories.is_none_or(|most| one.number <= most))
        .cloned()
        .collect();
    if chosen.is_empty() {
        return Err(BadInput::new("--subsets, --tasks, --splits, --payloads-g", "a trajectory", "none")
            .hint("no trajectory satisfies all of these options"));
    }
    Ok(chosen)
}

fn known(option: &str, requested: &[String], there: &[&str]) -> Result<(), BadInput> {
    match requested.iter().find(|name| !there.contains(&name.as_str())) {
        Some(name) => {
            Err(BadInput::new(option, format!("some of {}", there.join(", ")), format!("\"{name}\"")))
        }
        None => Ok(()),
    }
}
