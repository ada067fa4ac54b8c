//! Timed runs of a stepper, and the memory of the process.

use std::time::Instant;

use hysteron_twin::{Stepper, Target, Twin};

/// Cost and convergence of a run of steps.
#[derive(Debug, Clone, Default)]
pub struct StepCost {
    /// Duration of every measured step [s].
    pub seconds: Vec<f64>,
    /// Worst relative residual of a measured step [-].
    pub worst_residual: f64,
    /// Worst stroke error of a measured step [m].
    pub worst_stroke_error: f64,
    /// Corrections, factorisations and steps that needed Newton's method, all over the measured steps.
    pub iterations: usize,
    /// Number of refactorisations.
    pub refactorisations: usize,
    /// Steps that the fast iteration did not finish.
    pub newton_steps: usize,
    /// QPs that the active set did not certify.
    pub clarabel_solves: usize,
}

impl StepCost {
    /// Steps from rest through `targets`; the first `n_skipped` are not measured.
    ///
    /// # Errors
    /// A step fails.
    pub fn new(twin: &Twin, targets: &[Vec<Target>], n_skipped: usize) -> hysteron_twin::Result<Self> {
        let mut stepper = Stepper::new(twin);
        let mut run = Self { seconds: Vec::with_capacity(targets.len()), ..Self::default() };
        for (k, targets) in targets.iter().enumerate() {
            let start = Instant::now();
            let report = stepper.step(twin, targets)?;
            let seconds = start.elapsed().as_secs_f64();
            if k < n_skipped {
                continue;
            }
            run.seconds.push(seconds);
            run.worst_residual = run.worst_residual.max(report.relative_residual);
            run.worst_stroke_error = run.worst_stroke_error.max(report.stroke_error);
            run.iterations += report.iterations;
            run.refactorisations += report.refactorisations;
            run.newton_steps += usize::from(report.newton_iterations > 0);
            run.clarabel_solves += report.clarabel_solves;
        }
        Ok(run)
    }

    /// Steps per second.
    pub fn rate(&self) -> f64 {
        self.seconds.len() as f64 / self.seconds.iter().sum::<f64>()
    }
}

/// Value that the share `p` of `values` stays below; NaN when there is none.
pub fn percentile(values: &[f64], p: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1);
    sorted.get((p * last as f64).round() as usize).copied().unwrap_or(f64::NAN)
}

/// Value that the share `p` of all steps of all runs stays below [s]: a step that something else delayed counts as
/// it was.
pub fn percentile_of_steps(runs: &[StepCost], p: f64) -> f64 {
    let seconds: Vec<f64> = runs.iter().flat_map(|run| run.seconds.iter().copied()).collect();
    percentile(&seconds, p)
}

/// Shortest time that each of two ways took [s], called in turn and as often as each other.
///
/// # Errors
/// That of the first call that fails.
pub fn shortest_of_both<E>(
    repetitions: usize,
    mut call: impl FnMut(usize) -> Result<[f64; 2], E>,
) -> Result<[f64; 2], E> {
    (0..repetitions).try_fold([f64::INFINITY; 2], |shortest, k| {
        let seconds = call(k)?;
        Ok([shortest[0].min(seconds[0]), shortest[1].min(seconds[1])])
    })
}

/// Shortest duration of `repetitions` calls [s], after one that does not count.
pub fn shortest(repetitions: usize, mut call: impl FnMut()) -> f64 {
    call();
    let once = |()| {
        let start = Instant::now();
        call();
        start.elapsed().as_secs_f64()
    };
    std::iter::repeat_n((), repetitions).map(once).fold(f64::INFINITY, f64::min)
}

/// Largest resident memory of this process so far [MB], where the system reports it.
pub fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib * 1024e-6)
}

/// Processor time of this process so far, in ticks of 10 ms [s], where the system reports it.
pub fn processor_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The name of the program, in brackets, may hold spaces.
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |k: usize| fields.get(k)?.parse::<f64>().ok();
    Some(0.01 * (ticks(11)? + ticks(12)?))
}

/// Processor, compiler and commit: what a figure depends on.
pub fn machine() -> serde_json::Value {
    let command = |program: &str, arguments: &[&str]| {
        let folder = env!("CARGO_MANIFEST_DIR");
        let output = std::process::Command::new(program).args(arguments).current_dir(folder).output().ok()?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info
        .lines()
        .find_map(|line| line.strip_prefix("model name"))
        .map(|rest| rest.trim_start_matches(['\t', ' ', ':']).to_owned());
    hysteron_base::json!({
        "cpu": model,
        "threads": std::thread::available_parallelism().map_or(1, usize::from),
        // `Isa(V4(V4 { … }))`: the name of the set.
        "isa": format!("{:?}", hysteron_base::lanes::Isa::detect()).split('(').nth(1),
        "compiler": command("rustc", &["--version"]),
        "commit": command("git", &["rev-parse", "--short", "HEAD"]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentile_of_steps_counts_every_step_of_every_run() {
        // Each run is slow in another step: the shortest time of every step hides all of them.
        let run = |slow: usize| {
            let seconds = (0..10).map(|k| if k == slow { 1.0 } else { 1e-3 }).collect();
            StepCost { seconds, ..StepCost::default() }
        };
        let runs: Vec<StepCost> = (0..5).map(run).collect();
        assert_eq!(percentile_of_steps(&runs, 0.99), 1.0);
        assert_eq!(percentile_of_steps(&runs, 0.5), 1e-3);
    }

    #[test]
    fn both_ways_are_timed_as_often() {
        let times = [[3.0, 9.0], [2.0, 8.0], [4.0, 7.0]];
        let found: Result<_, ()> = shortest_of_both(3, |k| Ok(times[k]));
        assert_eq!(found, Ok([2.0, 7.0]));
        assert_eq!(shortest_of_both(3, |k| if k == 1 { Err(k) } else { Ok([1.0; 2]) }), Err(1));
    }
}
