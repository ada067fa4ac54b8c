//! One fold: every method on patterns that were held out.

use anyhow::Result;
use hysteron_base::rng;
use nalgebra::Vector3;
use rand::seq::SliceRandom;

use super::fit::{Fitted, ParameterSet};
use super::outcome::{CORRECTED, MODEL};
use super::recording::{N_TENDONS, Pattern, Row};
use super::reduced::Shape;
use super::robot::Robot;
use super::{lstm, regression};
use crate::tendon::numbers::distance;

/// Folds.
pub const N_FOLDS: usize = 5;

/// The finite-element twin is fitted to every fourth row of a pattern, and goes to every fourth of a test
/// one; its residual is fitted to every second.
const TWIN_EVERY: usize = 4;
const LEARN_EVERY: usize = 2;

/// The fold of every pattern, drawn with a seed.
pub fn folds(n_patterns: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..n_patterns).collect();
    order.shuffle(&mut rng(1, "ftdcr/folds"));
    let mut fold_of = vec![0; n_patterns];
    order.into_iter().enumerate().for_each(|(place, pattern)| fold_of[pattern] = place % N_FOLDS);
    fold_of
}

/// Results on the test patterns of a fold.
pub(super) struct Fold {
    /// Labels of its patterns.
    pub patterns: Vec<String>,
    /// The reduced model.
    pub fitted: Fitted,
    /// The finite-element twin's own parameters.
    pub twin: Option<Fitted>,
    /// Distance of the tip for every method and test row [mm].
    pub errors: Vec<Vec<f64>>,
    /// Rows without an equilibrium of the twin.
    pub rows_without_equilibrium: usize,
}

impl Fold {
    /// Fits every method to `training` and predicts the tips of `held`.
    ///
    /// # Errors
    /// A fit fails.
    pub fn new(
        robot: Option<&Robot>,
        fit_every: usize,
        training: &[Pattern],
        held: &[Pattern],
    ) -> Result<Self> {
        let simplest = Fitted::new(training, fit_every, ParameterSet::Tendons)?;
        let fitted = Fitted::new(training, fit_every, ParameterSet::All)?;
        let [known_rows, new_rows] = [training, held].map(rows_of);
        let [known_strokes, new_strokes] = [&known_rows, &new_rows]
            .map(|rows| rows.iter().map(|row| row.strokes.map(|s| 1e3 * s).to_vec()).collect::<Vec<_>>());
        let [known_tips, measured] = [&known_rows, &new_rows]
            .map(|rows| rows.iter().map(|row| row.tip.map(|c| 1e3 * c)).collect::<Vec<_>>());
        let groups: Vec<usize> =
            training.iter().enumerate().flat_map(|(k, p)| std::iter::repeat_n(k, p.rows.len())).collect();

        let [known, new] = [&known_rows, &new_rows]
            .map(|rows| rows.iter().map(|row| fitted.model.shape(row)).collect::<Vec<_>>());
        let tips = |shapes: &[Shape]| shapes.iter().map(|s| fitted.measured(s.marker)).collect::<Vec<_>>();
        let reduced = tips(&new);
        let left: Vec<[f64; 3]> =
            tips(&known).iter().zip(&known_tips).map(|(a, b)| std::array::from_fn(|c| b[c] - a[c])).collect();
        let [known_features, new_features] = [features(&known, &known_rows), features(&new, &new_rows)];
        let correction = regression::kernel(&known_features, &left, &groups, &new_features)?;
        let corrected =
            reduced.iter().zip(&correction).map(|(a, b)| std::array::from_fn(|c| a[c] + b[c])).collect();
        let correction = lstm::predict(&leaving(training, &left), held)?;
        let corrected_by_lstm =
            reduced.iter().zip(&correction).map(|(a, b)| std::array::from_fn(|c| a[c] + b[c])).collect();
        let bending = |rows: &[&Row]| rows.iter().map(|row| bending(&row.strokes)).collect::<Vec<_>>();
        let without_weight = |row: &&Row| simplest.measured(simplest.model.shape(row).marker);
        let predictions: [Vec<[f64; 3]>; 8] = [
            new_rows.iter().map(without_weight).collect(),
            reduced,
            corrected,
            corrected_by_lstm,
            regression::cubic(&known_strokes, &known_tips, &groups, &new_strokes)?,
            regression::cubic(&bending(&known_rows), &known_tips, &groups, &bending(&new_rows))?,
            regression::kernel(&known_strokes, &known_tips, &groups, &new_strokes)?,
            lstm::predict(training, held)?,
        ];
        let error =
            |tips: &Vec<[f64; 3]>| tips.iter().zip(&measured).map(|(a, b)| distance(*a, *b)).collect();
        let mut errors: Vec<Vec<f64>> = predictions.iter().map(error).collect();
        let mut rows_without_equilibrium = 0;
        let mut twin = None;
        if let Some(robot) = robot {
            // The best of the methods above, and the model alone, on the rows that the twin goes to.
            let thinned = [CORRECTED, MODEL].map(|method| {
                let mut all = errors[method].iter().copied();
                let of_pattern =
                    |pattern: &Pattern| all.by_ref().take(pattern.rows.len()).collect::<Vec<_>>();
                let by_pattern = held.iter().map(of_pattern);
                by_pattern.flat_map(|errors| errors.into_iter().step_by(TWIN_EVERY)).collect()
            });
            let (own, more, n_failed) = twin_errors(robot, &fitted, training, held)?;
            errors.extend(thinned.into_iter().chain(more));
            rows_without_equilibrium = n_failed;
            twin = Some(own);
        }
        Ok(Self {
            patterns: held.iter().map(|pattern| pattern.label.clone()).collect(),
            fitted,
            twin,
            errors,
            rows_without_equilibrium,
        })
    }
}

/// The twin's own parameters; the tip's distance for every method that uses the twin [mm]; rows without equilibrium.
fn twin_errors(
    robot: &Robot,
    fitted: &Fitted,
    training: &[Pattern],
    held: &[Pattern],
) -> Result<(Fitted, Vec<Vec<f64>>, usize)> {
    let own = robot.fit(fitted, training, TWIN_EVERY)?;
    let (known, new) = (every(training, LEARN_EVERY), every(held, TWIN_EVERY));
    let (known_rows, new_rows) = (known.concat(), new.concat());
    let shapes = |rows: &[&Row]| rows.iter().map(|row| own.model.shape(row)).collect::<Vec<_>>();
    let measured = |row: &&Row| own.of_robot(row.tip.into());

    let (given, _) = robot.predict(fitted, &new)?;
    let (uncorrected, n_failed) = robot.predict(&own, &new)?;
    let left = robot.predict(&own, &known)?.0.into_iter().zip(&known_rows);
    let left: Vec<[f64; 3]> = left.map(|(marker, row)| (measured(row) - marker).into()).collect();
    let groups: Vec<usize> =
        known.iter().enumerate().flat_map(|(k, rows)| std::iter::repeat_n(k, rows.len())).collect();
    let [known_features, new_features] = [&known_rows, &new_rows].map(|rows| features(&shapes(rows), rows));
    let missing = regression::kernel(&known_features, &left, &groups, &new_features)?;
    let desired: Vec<Vector3<f64>> =
        uncorrected.iter().zip(missing).map(|(marker, missing)| marker + Vector3::from(missing)).collect();
    let (corrected, n_not_led) = robot.lead(&own, &new, &desired)?;
    let tips: Vec<Vector3<f64>> = new_rows.iter().map(measured).collect();
    let (led, _) = robot.lead(&own, &new, &tips)?;

    let by = [(fitted, given), (&own, uncorrected), (&own, corrected), (&own, led)];
    let off = |(fitted, markers): &(&Fitted, Vec<Vector3<f64>>)| -> Vec<f64> {
        let each = new_rows.iter().zip(markers);
        each.map(|(row, marker)| distance(fitted.measured(*marker), row.tip.map(|c| 1e3 * c))).collect()
    };
    let errors = by.iter().map(off).collect();
    Ok((own, errors, n_failed + n_not_led))
}

/// The patterns with what a model leaves of each tip [mm] in the tip's place.
fn leaving(patterns: &[Pattern], left: &[[f64; 3]]) -> Vec<Pattern> {
    let mut left = left.iter();
    let mut patterns = patterns.to_vec();
    for (row, left) in patterns.iter_mut().flat_map(|pattern| &mut pattern.rows).zip(&mut left) {
        row.tip = left.map(|c| 1e-3 * c);
    }
    patterns
}

/// Every `n`-th row of each pattern.
fn every(patterns: &[Pattern], n: usize) -> Vec<Vec<&Row>> {
    patterns.iter().map(|pattern| pattern.rows.iter().step_by(n).collect()).collect()
}

fn rows_of(patterns: &[Pattern]) -> Vec<&Row> {
    patterns.iter().flat_map(|pattern| &pattern.rows).collect()
}

/// Coordinates for the regression of what the model leaves: marker, axis, tensions, strokes and their directions.
fn features(shapes: &[Shape], rows: &[&Row]) -> Vec<Vec<f64>> {
    let feature = |(shape, row): (&Shape, &&Row)| {
        [shape.marker.as_slice(), shape.axis.as_slice(), &shape.tensions, &row.strokes, &row.directions]
            .concat()
    };
    shapes.iter().zip(rows).map(feature).collect()
}

/// How the strokes of each segment bend it, the mean of its three tendons taken off: two numbers a segment [mm], with
/// tendons at 0°, 120° and 240° (Clarke coordinates: Grassmann et al. 2024).
fn bending(strokes: &[f64; N_TENDONS]) -> Vec<f64> {
    let along = |three: &[f64], shift: f64| -> f64 {
        let part = |k: usize| (std::f64::consts::TAU * k as f64 / 3.0 - shift).cos();
        (0..3).map(|k| 1e3 * three[k] * part(k) * 2.0 / 3.0).sum()
    };
    strokes
        .chunks(3)
        .flat_map(|three| [along(three, 0.0), along(three, std::f64::consts::FRAC_PI_2)])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_strokes_bend_nothing_and_an_arc_is_found() {
        // Tendons of a segment that bends by 2 mm towards 30° shorten by 2 cos(30° - angle), apart from the mean of
        // them.
        let angle = std::f64::consts::FRAC_PI_6;
        let mut strokes = [3e-3; N_TENDONS];
        for (k, stroke) in strokes[3..6].iter_mut().enumerate() {
            *stroke += 2e-3 * (angle - std::f64::consts::TAU * k as f64 / 3.0).cos();
        }
        let expected = [0.0, 0.0, 2.0 * angle.cos(), 2.0 * angle.sin(), 0.0, 0.0];
        // Rounding of numbers of order one.
        let off = |(found, expected): (f64, f64)| (found - expected).abs();
        assert!(bending(&strokes).into_iter().zip(expected).map(off).fold(0.0, f64::max) < 1e-12);
    }

    #[test]
    fn folds_are_even_and_the_same_every_time() {
        let fold_of = folds(66);
        assert_eq!(fold_of, folds(66));
        for fold in 0..N_FOLDS {
            let n = fold_of.iter().filter(|of| **of == fold).count();
            assert!((13..=14).contains(&n), "{n} patterns in fold {fold}");
        }
        assert_ne!(fold_of[..5], [0, 1, 2, 3, 4]);
    }
}
