//! The clock of a recording.

use super::{Finding, MIN_ROWS, Warning};
use crate::Recording;
use crate::statistics::nearest_quantile;

/// Longest step between rows of anything that moves [s]: a robot that is measured less often is not followed. 200 Hz in milliseconds
/// that are read as seconds make 5.
const LONGEST_STEP_S: f64 = 5.0;
/// Shortest step [s]: 50 kHz, above every drive's and tracker's rate. 50 Hz in seconds that are read as milliseconds make it.
const SHORTEST_STEP_S: f64 = 2e-5;
/// A step longer than so many typical ones has lost a row, as in [`Recording::resampled`] [-].
const HOLE: f64 = 1.5;
/// Most of the duration that may be missing [-]: the error of a good fit, some percent of the range, should not come from there.
const MISSING: f64 = 0.01;
/// A hole of so many steps is reported for any length of the recording [-]: what a window of a network or a tendon's
/// reversal is missed in.
const LONG_HOLE: f64 = 10.0;
/// Ratio of the steps at the 90th and the 10th percentile from which there is no rate [-]: half a step of jitter either way.
const UNEVEN: f64 = 1.5;
/// Steps below this part of the typical one are two rows for one instant [-].
const REPEATED: f64 = 0.01;

pub fn check(recording: &Recording) -> Vec<Warning> {
    let time = recording.time();
    let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.len() + 1 < MIN_ROWS {
        return Vec::new();
    }
    let mut sorted = steps.clone();
    let [tenth, median, ninetieth] =
        [0.1, 0.5, 0.9].map(|part| nearest_quantile(&mut sorted, part).unwrap_or(0.0));
    let mut found = Vec::new();
    found.extend(unit(median));
    if ninetieth > UNEVEN * tenth {
        found.push(uneven(tenth, median, ninetieth));
    } else {
        found.extend(holes(&steps, median));
    }
    found.extend(repeated(&steps, median));
    found.extend(filled(recording.gap()));
    found
}

fn unit(median: f64) -> Option<Warning> {
    let warning = |limit: f64, which: &str, hint: &str| {
        let finding = format!("rows are {median:.3e} s apart; {which} {limit} s is plausible");
        Warning::new(Finding::TimeUnit, "time_s", finding).measured(median, limit, "s").hint(hint)
    };
    if median > LONGEST_STEP_S {
        let hint = "are the stamps in milliseconds? name the column time_ms (or time_us), or map it so";
        return Some(warning(LONGEST_STEP_S, "at most", hint));
    }
    (median < SHORTEST_STEP_S)
        .then(|| warning(SHORTEST_STEP_S, "at least", "are the stamps in seconds? name the column time_s"))
}

fn uneven(tenth: f64, median: f64, ninetieth: f64) -> Warning {
    let ratio = ninetieth / tenth;
    let finding = format!(
        "no fixed rate: steps of {:.1} to {:.1} ms (10th to 90th percentile, a ratio of {ratio:.1}; at most {UNEVEN}), {:.1} in the \
         median",
        1e3 * tenth,
        1e3 * ninetieth,
        1e3 * median
    );
    Warning::new(Finding::UnevenTime, "time_s", finding)
        .measured(ratio, UNEVEN, "-")
        .hint("resample it where a rate is needed; hysteron import does")
}

fn holes(steps: &[f64], median: f64) -> Option<Warning> {
    let holes = || steps.iter().enumerate().filter(|(_, step)| **step > HOLE * median);
    let missing: f64 = holes().map(|(_, step)| step - median).sum::<f64>() / steps.iter().sum::<f64>();
    let (at, longest) = holes().max_by(|a, b| a.1.total_cmp(b.1))?;
    if missing <= MISSING && *longest < LONG_HOLE * median {
        return None;
    }
    let finding = format!(
        "{} holes in time, {:.1} % of the duration (at most {:.0} %); the longest is {:.0} steps",
        holes().count(),
        100.0 * missing,
        100.0 * MISSING,
        longest / median
    );
    let warning =
        Warning::new(Finding::Gap, "time_s", finding).measured(100.0 * missing, 100.0 * MISSING, "%");
    Some(
        warning
            .at_rows(at, at + 1)
            .hint("were frames lost? resample it, so that the rows between are marked as gaps"),
    )
}

fn repeated(steps: &[f64], median: f64) -> Option<Warning> {
    let count = steps.iter().filter(|step| **step < REPEATED * median).count();
    let first = steps.iter().position(|step| *step < REPEATED * median)?;
    let finding = format!(
        "{count} rows are less than {:.0} % of a step after the row before; the first {:.2e} s",
        100.0 * REPEATED,
        steps[first]
    );
    let warning = Warning::new(Finding::RepeatedStamp, "time_s", finding);
    Some(
        warning
            .measured(steps[first], REPEATED * median, "s")
            .at_rows(first, first + 1)
            .hint("two rows of one instant: leave one of them out"),
    )
}

fn filled(gap: &[bool]) -> Option<Warning> {
    let count = gap.iter().filter(|gap| **gap).count();
    let part = count as f64 / gap.len() as f64;
    let first = gap.iter().position(|gap| *gap)?;
    if part <= MISSING {
        return None;
    }
    let last = gap.iter().rposition(|gap| *gap).unwrap_or(first);
    let finding = format!(
        "{count} rows are marked as gaps, {:.1} % (at most {:.0} %): they hold no measurement",
        100.0 * part,
        100.0 * MISSING
    );
    let warning = Warning::new(Finding::Gap, "gap", finding).measured(100.0 * part, 100.0 * MISSING, "%");
    Some(warning.at_rows(first, last).hint("they are excluded from fits and scores; why was the tip lost?"))
}
