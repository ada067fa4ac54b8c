//! A delay is the simplest memory: how much later than a stroke the tip is where it brings it.
//!
//! Servos, tracker and a viscous body put the tip behind the strokes. So the regression of strokes on the tip is
//! fitted to the tip d later, and the d with the least errors is the delay, between samples by the parabola through
//! the least three.

use hysteron_base::BadInput;

use super::path_point::PathPoint;
use super::{Axes, Demonstration, StaticRegression};

/// Samples between the delays that are tried first.
const COARSE: usize = 4;
/// Part by which a delay must lower the mean square error to be one [-]: a hundredth of the error itself.
const MIN_GAIN: f64 = 0.02;

/// A path that is `delay` samples ahead of itself; its last point is repeated after its end.
pub fn ahead(path: &[PathPoint], delay: f64) -> Vec<PathPoint> {
    let last = path.len().saturating_sub(1);
    let (whole, part) = (delay.floor() as usize, delay.fract());
    let at = |i: usize| {
        if i + whole >= last && delay > 0.0 {
            return PathPoint { rate: [0.0; 3], ..path[last] };
        }
        let (from, to) = (path[(i + whole).min(last)], path[(i + whole + 1).min(last)]);
        let between = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|c| a[c] + part * (b[c] - a[c]));
        PathPoint { position: between(from.position, to.position), rate: between(from.rate, to.rate) }
    };
    (0..path.len()).map(at).collect()
}

/// The delay of the tip behind the strokes, up to `most` samples [samples]; 0 where none lowers the errors. The
/// regression is fitted to `training` and the delay chosen on `validation`, each with its smoothed paths.
pub(super) fn fit_delay(
    axes: Axes,
    training: (&[Demonstration], &[Vec<PathPoint>]),
    validation: (&[Demonstration], &[Vec<PathPoint>]),
    most: usize,
) -> Result<f64, BadInput> {
    let error = |delay: usize| -> Result<f64, BadInput> {
        let shifted = |paths: &[Vec<PathPoint>]| -> Vec<Vec<PathPoint>> {
            paths.iter().map(|path| ahead(path, delay as f64)).collect()
        };
        let regression = StaticRegression::new(axes, training.0, &shifted(training.1))?;
        let squares = regression.squares(validation.0, &shifted(validation.1));
        Ok(squares.iter().sum())
    };
    let mut tried = std::collections::BTreeMap::new();
    for delay in (0..=most).step_by(COARSE) {
        tried.insert(delay, error(delay)?);
    }
    let best = |tried: &std::collections::BTreeMap<usize, f64>| {
        tried.iter().min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(delay, _)| *delay)
    };
    let around = best(&tried);
    for delay in around.saturating_sub(COARSE)..=(around + COARSE).min(most) {
        if let std::collections::btree_map::Entry::Vacant(vacant) = tried.entry(delay) {
            vacant.insert(error(delay)?);
        }
    }
    let found = best(&tried);
    if tried[&found] > (1.0 - MIN_GAIN) * tried[&0] {
        return Ok(0.0);
    }
    let neighbours =
        found.checked_sub(1).and_then(|before| Some((*tried.get(&before)?, *tried.get(&(found + 1))?)));
    let Some((before, after)) = neighbours else { return Ok(found as f64) };
    let bend = before - 2.0 * tried[&found] + after;
    let part = if bend > 0.0 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 };
    Ok(found as f64 + part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inverse::DataOrigin;

    /// A tip that is where strokes would bring it `delay` samples ago.
    fn late(delay: f64, n: usize, phase: f64) -> (Demonstration, Vec<PathPoint>) {
        let stroke = |t: f64| [(0.031 * t + phase).sin(), (0.043 * t).cos()].map(|v| 4e-3 * v);
        let tip: Vec<[f64; 3]> = (0..n)
            .map(|i| {
                let [a, b] = stroke(i as f64 - delay);
                [3.0 * a, 3.0 * b + 50.0 * a * a, 0.0]
            })
            .collect();
        let path = tip.iter().map(|&position| PathPoint { position, rate: [0.0; 3] }).collect();
        let one = Demonstration {
            name: String::new(),
            hash: String::new(),
            origin: DataOrigin::Real,
            robot: String::new(),
            family: String::new(),
            step: 0.01,
            axes: Axes::Planar,
            gap: vec![false; n],
            tip,
            n_tendons: 2,
            strokes: (0..n).flat_map(|i| stroke(i as f64)).collect(),
            jacobian: Vec::new(),
        };
        (one, path)
    }

    #[test]
    fn a_delay_is_found_between_samples_and_none_where_there_is_none() {
        for delay in [0.0, 3.0, 7.4, 18.7] {
            let (training, validation) = (late(delay, 900, 0.0), late(delay, 700, 1.0));
            let of = |one: &(Demonstration, Vec<PathPoint>)| (vec![one.0.clone()], vec![one.1.clone()]);
            let (training, validation) = (of(&training), of(&validation));
            let found =
                fit_delay(Axes::Planar, (&training.0, &training.1), (&validation.0, &validation.1), 50);
            let found = found.unwrap_or(f64::NAN);
            // Errors are a parabola of the delay to first order; a tenth of a sample.
            assert!((found - delay).abs() < 0.1, "{found} for {delay}");
        }
    }

    #[test]
    fn a_path_ahead_of_itself_stands_still_at_its_end() {
        let (_, path) = late(0.0, 10, 0.0);
        let moved = ahead(&path, 2.5);
        let middle = 0.5 * (path[3].position[0] + path[4].position[0]);
        assert!((moved[1].position[0] - middle).abs() < 1e-15);
        assert_eq!(moved[9].position, path[9].position);
        assert_eq!(ahead(&path, 0.0), path);
    }
}
