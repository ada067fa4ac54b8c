//! The recipe: path to strokes, strokes to recording and report.

use hysteron_base::BadInput;
use hysteron_base::statistics::nearest_quantile;
use hysteron_control::path::PathSpan;
use hysteron_report::folder::ReportFolder;
use hysteron_twin::residual::TipBand;

use super::answer::LimitOverrides;
use super::options::Options;
use super::outcome::Outcome;
use super::page;
use crate::shared::outcome::MetricsFormat;
use crate::shared::run::{TIP_BAND, expected_within};
use crate::{COMMIT, Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; an interruption; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(command(options, context)?)
}

/// Finds the strokes and writes them.
fn command(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    check_strokes(options)?;
    let metres = |mm: Option<f64>| mm.map(|mm| 1e-3 * mm);
    let overrides = LimitOverrides {
        stroke: [options.stroke_min_mm, options.stroke_max_mm].map(metres),
        rate: metres(options.stroke_rate_max_mm_s),
    };
    let outputs = options.way.reads()?.file("--out", &options.out);
    let _lock = outputs.report("--figures", options.figures.as_deref()).check(context)?;
    let recording = options.way.strokes(&overrides, context)?;
    recording.write(&options.out)?;
    let PathSpan { begins, ends } = PathSpan::of(&recording)?;
    let step = recording.rate_hz().map_or(1.0, f64::recip);
    let (first, n) = ((begins / step).round() as usize, ((ends - begins) / step).round() as usize + 1);
    let part = |flag: &str| {
        recording.channel(flag).map_or(0.0, |flags| flags[first..first + n].iter().sum::<f64>() / n as f64)
    };
    let outcome = Outcome {
        format: MetricsFormat,
        version: 1,
        out: options.out.clone(),
        samples: n,
        approach_samples: first,
        return_samples: recording.n_samples() - first - n,
        source: recording.meta().source.clone(),
        limited: part("limited"),
        extrapolating: part("extrapolating"),
        tip_band_m: recording
            .channel(TIP_BAND)
            .and_then(|radii| nearest_quantile(&mut radii[first..first + n].to_vec(), 0.5)),
        command: context.command.clone(),
        commit: COMMIT.to_owned(),
    };
    if let Some(folder) = &options.figures {
        page::write(&ReportFolder { path: folder, png: false }, &outcome, &recording)?;
    }
    if let Some(radius) = outcome.tip_band_m {
        context.print(format_args!("{}", expected_within(TipBand::LEVEL, radius)));
    }
    context.wrote(&options.out);
    Ok(outcome)
}

/// Strokes begin and end at none, which the limits must allow.
fn check_strokes(options: &Options) -> Result<(), BadInput> {
    let bad = |option: &str, expected: &str, mm: f64| {
        Err(BadInput::new(option, expected, format!("{mm} mm")).hint("strokes begin and end at none"))
    };
    match (options.stroke_min_mm, options.stroke_max_mm) {
        (Some(min), _) if min > 0.0 => bad("--stroke-min-mm", "at most 0 mm", min),
        (_, Some(max)) if max <= 0.0 => bad("--stroke-max-mm", "more than 0 mm", max),
        _ => Ok(()),
    }
}
