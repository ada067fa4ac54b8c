//! Which trajectories a fit is validated on: some of every kind of motion.
//!
//! The plan of a motion gives its kind. A recording without plan is classified by the shape of its strokes:
//! along one line, around a loop, along the sides of a polygon, or along another curve.

use nalgebra::{DMatrix, SymmetricEigen};
use rand::Rng;
use rand::seq::{IndexedRandom, SliceRandom};

/// Kind of motion, as far as its strokes show it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionKind {
    /// No stroke changes.
    Rest,
    /// All strokes change in one proportion: a sinusoid in one plane.
    Line,
    /// Around and around: a circle or an ellipse, of any size.
    Loop,
    /// In a few directions.
    Polygon,
    /// Another curve.
    Curve,
}

/// A second direction of less than this part of the first one's variance is none [-].
const FLAT: f64 = 0.02;
/// Slower than this part of the largest speed a motion has no direction that counts [-].
const SLOW: f64 = 0.2;
/// Mean |cos| between place and direction: 0 on a circle, up to 0.3 where it grows and shrinks within a turn, 2/π
/// where both have nothing to do with each other.
const ROUND: f64 = 0.33;
/// Directions are counted in bins of 10°; a polygon of up to four corners has most of its way in four pairs of
/// neighbours, a circle a quarter of it.
const BINS: usize = 36;
const SIDES: usize = 4;
const ON_SIDES: f64 = 0.5;
/// Steps that a motion is looked at in: enough for its shape, long enough that a servo's ticks do not decide a
/// direction.
const LOOKS: usize = 600;

impl MotionKind {
    /// That of strokes (n_samples × n_tendons).
    pub fn of(strokes: &[f64], n_tendons: usize) -> Self {
        let n = strokes.len() / n_tendons.max(1);
        let stride = (n / LOOKS).max(1);
        let rows: Vec<&[f64]> = strokes.chunks_exact(n_tendons.max(1)).step_by(stride).collect();
        let is_still = |k: usize| rows.iter().all(|row| row[k] == rows[0][k]);
        if (0..n_tendons).all(is_still) {
            return Self::Rest;
        }
        let Some((points, flat)) = in_plane(&rows, n_tendons) else { return Self::Rest };
        if flat < FLAT {
            return Self::Line;
        }
        let moves: Vec<([f64; 2], [f64; 2])> = points
            .windows(2)
            .map(|pair| {
                let middle = [0, 1].map(|c| 0.5 * (pair[0][c] + pair[1][c]));
                (middle, [0, 1].map(|c| pair[1][c] - pair[0][c]))
            })
            .collect();
        let length = |v: &[f64; 2]| v[0].hypot(v[1]);
        let fastest = moves.iter().map(|(_, step)| length(step)).fold(0.0, f64::max);
        let (mut along, mut total, mut bins) = (0.0, 0.0, [0.0; BINS]);
        for (place, step) in moves.iter().filter(|(_, step)| length(step) > SLOW * fastest) {
            let far = length(place).max(f64::MIN_POSITIVE);
            along += (place[0] * step[0] + place[1] * step[1]).abs() / far;
            total += length(step);
            let turn = (step[1].atan2(step[0]) / std::f64::consts::TAU + 1.0).fract();
            bins[((turn * BINS as f64) as usize).min(BINS - 1)] += length(step);
        }
        if on_sides(bins) > ON_SIDES * total {
            Self::Polygon
        } else if along < ROUND * total {
            Self::Loop
        } else {
            Self::Curve
        }
    }

    /// Its name, as a family of plans would be called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rest => "rest",
            Self::Line => "line",
            Self::Loop => "loop",
            Self::Polygon => "polygon",
            Self::Curve => "curve",
        }
    }
}

/// Strokes along the two directions that change most, each over its deviation, and the second variance over the
/// first; none where nothing changes.
fn in_plane(rows: &[&[f64]], n_tendons: usize) -> Option<(Vec<[f64; 2]>, f64)> {
    let n = rows.len() as f64;
    let mean: Vec<f64> = (0..n_tendons).map(|k| rows.iter().map(|row| row[k]).sum::<f64>() / n).collect();
    let off = |row: &[f64], k: usize| row[k] - mean[k];
    let covariance = DMatrix::from_fn(n_tendons, n_tendons, |a, b| {
        rows.iter().map(|row| off(row, a) * off(row, b)).sum::<f64>() / n
    });
    let eigen = SymmetricEigen::new(covariance);
    let mut order: Vec<usize> = (0..n_tendons).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let variance = |k: usize| order.get(k).map_or(0.0, |&k| eigen.eigenvalues[k].max(0.0));
    if variance(0).is_nan() || variance(0) <= 0.0 {
        return None;
    }
    let along = |row: &[f64], k: usize| -> f64 {
        let Some(&column) = order.get(k) else { return 0.0 };
        let sum: f64 = (0..n_tendons).map(|j| off(row, j) * eigen.eigenvectors[(j, column)]).sum();
        sum / variance(k).sqrt().max(f64::MIN_POSITIVE)
    };
    let flat = variance(1) / variance(0);
    Some((
        rows.iter().map(|row| [along(row, 0), if flat < FLAT { 0.0 } else { along(row, 1) }]).collect(),
        flat,
    ))
}

/// The part of `bins` in the four pairs of neighbours that hold most.
fn on_sides(mut bins: [f64; BINS]) -> f64 {
    let mut sum = 0.0;
    for _ in 0..SIDES {
        let pair = |k: usize| bins[k] + bins[(k + 1) % BINS];
        let best = (0..BINS).max_by(|&a, &b| pair(a).total_cmp(&pair(b))).unwrap_or(0);
        sum += pair(best);
        bins[best] = 0.0;
        bins[(best + 1) % BINS] = 0.0;
    }
    sum
}

/// One of every so many trajectories of a kind is validated on, and at least one.
const ONE_OF: usize = 6;

/// Draws which trajectories to validate on, given their kinds: a sixth of every kind that has more than one, or the
/// last of all where no kind has.
pub fn draw_validation(kinds: &[String], stream: &mut impl Rng) -> Vec<usize> {
    let mut names: Vec<&String> = kinds.iter().collect();
    names.sort();
    names.dedup();
    let mut drawn = Vec::new();
    for name in names {
        let members: Vec<usize> = (0..kinds.len()).filter(|&k| kinds[k] == *name).collect();
        // The only one of its kind is needed to learn from.
        if members.len() > 1 {
            drawn.extend(members.sample(stream, (members.len() / ONE_OF).max(1)).copied());
        }
    }
    if drawn.is_empty() {
        drawn.extend(kinds.len().checked_sub(1));
    }
    drawn.sort_unstable();
    drawn
}

/// Deals trajectories of these kinds out to `n` folds: those of a kind to different ones, as far as there are enough.
pub fn deal_folds(kinds: &[String], n: usize, stream: &mut impl Rng) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..kinds.len()).collect();
    order.shuffle(stream);
    // Those of a kind come one after the other, and so into different folds.
    order.sort_by_key(|&k| &kinds[k]);
    let mut folds = vec![Vec::new(); n];
    order.iter().enumerate().for_each(|(place, &k)| folds[place % n].push(k));
    folds.iter_mut().for_each(|fold| fold.sort_unstable());
    folds
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;
    use crate::MotionPlan;
    use hysteron_base::rng;

    /// Strokes as a servo would report them, in whole ticks of 15 µm, row by row.
    fn ticked(commands: &hysteron_base::Recording) -> Vec<f64> {
        let strokes = commands.strokes();
        let tick = |value: f64| (value / 15e-6).round() * 15e-6;
        (0..commands.n_samples()).flat_map(|i| strokes.iter().map(move |s| tick(s[i]))).collect()
    }

    #[test]
    fn a_kind_is_the_same_for_all_sizes_and_orientations_of_a_family() {
        let expected = |family: &str| match family {
            "sinusoid" => MotionKind::Line,
            "circle" | "ellipse" => MotionKind::Loop,
            "square" => MotionKind::Polygon,
            _ => MotionKind::Curve,
        };
        for name in ["quick", "paper", "synthetic"] {
            for trajectory in MotionPlan::named(name).unwrap().trajectories() {
                let commands = trajectory.commands().unwrap();
                let family = commands.meta().extra["plan.family"].clone();
                let found = MotionKind::of(&ticked(&commands), 4);
                assert_eq!(found, expected(&family), "{} of {name}, a {family}", trajectory.name);
            }
        }
        assert_eq!(MotionKind::of(&[1e-3; 400], 4), MotionKind::Rest);
    }

    #[test]
    fn eighteen_recordings_of_three_kinds_are_validated_on_one_of_each() {
        let kinds: Vec<String> =
            ["line", "loop", "polygon"].iter().flat_map(|kind| vec![(*kind).to_owned(); 6]).collect();
        let drawn = draw_validation(&kinds, &mut rng(1, "split"));
        let of: Vec<&str> = drawn.iter().map(|&k| &kinds[k][..]).collect();
        assert_eq!(of, ["line", "loop", "polygon"]);
        assert_eq!(drawn, draw_validation(&kinds, &mut rng(1, "split")));
        // Of twelve alike two; the only one of its kind stays; without a pair, the last.
        let alike = [vec!["line".to_owned(); 12], vec!["loop".to_owned()]].concat();
        let drawn = draw_validation(&alike, &mut rng(1, "split"));
        assert!(drawn.len() == 2 && !drawn.contains(&12), "{drawn:?}");
        assert_eq!(draw_validation(&["a".to_owned(), "b".to_owned()], &mut rng(1, "split")), [1]);
    }
}
