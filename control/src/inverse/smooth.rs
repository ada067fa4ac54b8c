//! Results of smoothed paths: delay, static regression and workspace.

use hysteron_base::BadInput;

use super::delay::{ahead, fit_delay};
use super::path_point::{PathPoint, PathSmoothing, smooth};
use super::{Dataset, Demonstration, StaticRegression, TipWorkspace};

/// The paths of a data set, smoothed, and as far ahead of themselves as the tip comes after its strokes.
pub(super) struct Smoothed {
    /// Of the training.
    pub training: Vec<Vec<PathPoint>>,
    /// Of the validation.
    pub validation: Vec<Vec<PathPoint>>,
    /// How much later than a stroke the tip is where it brings it [s].
    pub delay_s: f64,
    /// Strokes without memory but for the delay, fitted to the training.
    pub regression: StaticRegression,
    /// Root mean square error of each of its strokes on the validation [mm].
    pub regression_mm: Vec<f64>,
    /// Where the tip was in training.
    pub workspace: TipWorkspace,
}

/// Smooths all paths, finds the delay, up to `largest_delay` [s], and fits what else has no memory.
pub(super) fn smoothed(
    data: &Dataset,
    smoothing: PathSmoothing,
    half_width: f64,
    largest_delay: f64,
) -> Result<Smoothed, BadInput> {
    let half = (half_width / data.step).round() as usize;
    let paths = |all: &[Demonstration]| -> Vec<Vec<PathPoint>> {
        all.iter().map(|one| smooth(&one.tip, &one.gap, data.step, smoothing, half)).collect()
    };
    let (mut training, mut validation) = (paths(&data.training), paths(&data.validation));
    let workspace =
        TipWorkspace::new(data.axes, training.iter().flatten().map(|point| point.position).collect());
    let most = (largest_delay / data.step) as usize;
    // Chosen on training data: validation errors stay those of something that was not chosen by them.
    let known = (&data.training[..], &training[..]);
    let delay = fit_delay(data.axes, known, known, most)?;
    for paths in [&mut training, &mut validation] {
        paths.iter_mut().for_each(|path| *path = ahead(path, delay));
    }
    let regression = StaticRegression::new(data.axes, &data.training, &training)?;
    let regression_mm =
        regression.squares(&data.validation, &validation).into_iter().map(f64::sqrt).collect();
    Ok(Smoothed { training, validation, delay_s: delay * data.step, regression, regression_mm, workspace })
}
