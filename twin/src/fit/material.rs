//! The physical parameters of a scene from what its robot did.

use hysteron_base::{BadInput, Scene};
use hysteron_fem::Mesh;
use nalgebra::{Matrix3, Vector3};

use super::least_squares::{Fit, Options, least_squares};
use super::motion::{Motion, distance, length_of};
use super::quantity::Selected;
use crate::{Result, Twin, alignment, rollouts};

/// Where the measured tip is expected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frame {
    /// In the frame of the scene; a tip that rests elsewhere is an error.
    Checked,
    /// In the frame of the scene, wherever it rests.
    Trusted,
    /// In a frame of its own, the same for all recordings: turned and shifted as suits the twin best.
    Fitted,
}

/// How to fit.
pub struct MaterialOptions<'a> {
    /// Where the tip is expected.
    pub frame: Frame,
    /// Error of a coordinate from which on it counts linearly, if any [m].
    pub huber: Option<f64>,
    /// See [`Options::watch`].
    pub watch: &'a (dyn Fn(usize, f64) -> bool + Sync),
}

/// Root mean square errors of the tip [m].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisErrors {
    /// Along x, y and z.
    pub axes: [f64; 3],
    /// Of the distance.
    pub distance: f64,
}

/// The outcome of [`fit_material`].
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialFit {
    /// The parameters, in the order they were selected.
    pub fit: Fit,
    /// The scene with them.
    pub scene: Scene,
    /// Errors with the scene as given, and with the fitted one.
    pub errors: [AxisErrors; 2],
    /// Tips of both, in the frame of the measurement: by motion, by row [m].
    pub tips: [Vec<Vec<[f64; 3]>>; 2],
    /// Turn (row-major) and shift [m] from the scene to the frame of the measurement.
    pub frame: ([[f64; 3]; 3], [f64; 3]),
}

/// Part of the measured motion that a parameter must move the tip by, between its bounds, to count as seen [-].
const SEEN: f64 = 2e-3;
/// Distance of the resting tip from the twin's, over the robot's length, that speaks of a moved tracker [-].
const MOVED_TRACKER: f64 = 0.1;
/// Degrees of freedom of a rigid frame.
const OF_FRAME: usize = 6;

/// Fits `selected` so that the twin's tip follows the measured one through `motions`.
///
/// # Errors
/// Those of [`Twin::new`] and of the first pass through the motions; with [`Frame::Checked`], a tip that rests
/// elsewhere than the twin's.
pub fn fit_material(
    scene: &Scene,
    mesh: &Mesh,
    motions: &[Motion],
    selected: &[Selected],
    options: &MaterialOptions,
) -> Result<MaterialFit> {
    let before = follow(scene, mesh, motions)?;
    match options.frame {
        Frame::Checked => check_frame(&Twin::new(scene, mesh)?, motions, &before)?,
        Frame::Trusted => {}
        Frame::Fitted => check_axes(motions)?,
    }
    let with = |values: &[f64]| {
        let mut candidate = scene.clone();
        for (selected, value) in selected.iter().zip(values) {
            (selected.quantity.set)(&mut candidate, selected.tendon, *value);
        }
        candidate
    };
    let placed = |mut tips: Vec<Vec<[f64; 3]>>| {
        let frame = match options.frame {
            Frame::Fitted => frame_of(motions, &tips),
            _ => (Matrix3::identity(), Vector3::zeros()),
        };
        for tip in tips.iter_mut().flatten() {
            *tip = (frame.0 * Vector3::from(*tip) + frame.1).into();
        }
        (tips, frame)
    };
    let parameters: Vec<_> = selected.iter().map(|selected| selected.parameter.clone()).collect();
    let least = Options {
        huber: options.huber,
        smallest_effect: SEEN * motion_size(motions),
        n_nuisance: if options.frame == Frame::Fitted { OF_FRAME } else { 0 },
        watch: options.watch,
    };
    let fit = least_squares(&parameters, &least, |values| {
        Ok(series(motions, &placed(follow(&with(values), mesh, motions)?).0))
    })?;
    let candidate = with(&fit.values());
    let (after, (turn, shift)) = placed(follow(&candidate, mesh, motions)?);
    let (before, _) = placed(before);
    let errors = [errors(motions, &before), errors(motions, &after)];
    let turn = [0, 1, 2].map(|r| [0, 1, 2].map(|c| turn[(r, c)]));
    Ok(MaterialFit { fit, scene: candidate, errors, tips: [before, after], frame: (turn, shift.into()) })
}

/// Tips of the scene's twin through all motions: by motion, by row [m].
fn follow(scene: &Scene, mesh: &Mesh, motions: &[Motion]) -> Result<Vec<Vec<[f64; 3]>>> {
    let twin = Twin::new(scene, mesh)?;
    let sequences: Vec<_> = motions.iter().map(|motion| motion.targets.clone()).collect();
    rollouts(&twin, &twin.rest(), &sequences).into_iter().map(|done| Ok(done?.tips)).collect()
}

/// Measured and predicted tips of all rows that were measured.
fn pairs<'a>(
    motions: &'a [Motion],
    tips: &'a [Vec<[f64; 3]>],
) -> impl Iterator<Item = (&'a Motion, [f64; 3], [f64; 3])> {
    motions.iter().zip(tips).flat_map(|(motion, tips)| {
        motion.tips.iter().zip(tips).filter_map(move |(measured, tip)| Some((motion, (*measured)?, *tip)))
    })
}

/// Residuals: a series for each used coordinate of each motion [m].
fn series(motions: &[Motion], tips: &[Vec<[f64; 3]>]) -> Vec<Vec<f64>> {
    let mut series = Vec::new();
    for (motion, tips) in motions.iter().zip(tips) {
        for c in (0..3).filter(|&c| motion.axes[c]) {
            let rows = motion.tips.iter().zip(tips);
            series.push(rows.filter_map(|(measured, tip)| Some(tip[c] - measured.as_ref()?[c])).collect());
        }
    }
    series
}

fn errors(motions: &[Motion], tips: &[Vec<[f64; 3]>]) -> AxisErrors {
    let (mut sums, mut counts) = ([0.0; 3], [0.0; 3]);
    for (motion, measured, tip) in pairs(motions, tips) {
        for c in (0..3).filter(|&c| motion.axes[c]) {
            sums[c] += (tip[c] - measured[c]).powi(2);
            counts[c] += 1.0;
        }
    }
    let mean = |c: usize| if counts[c] > 0.0 { sums[c] / counts[c] } else { 0.0 };
    AxisErrors {
        axes: std::array::from_fn(|c| mean(c).sqrt()),
        distance: (0..3).map(mean).sum::<f64>().sqrt(),
    }
}

/// Root mean square distance of the measured tips from their mean [m].
fn motion_size(motions: &[Motion]) -> f64 {
    let tips: Vec<Vector3<f64>> =
        motions.iter().flat_map(|motion| &motion.tips).flatten().map(|tip| Vector3::from(*tip)).collect();
    let mean = tips.iter().sum::<Vector3<f64>>() / tips.len() as f64;
    (tips.iter().map(|tip| (tip - mean).norm_squared()).sum::<f64>() / tips.len() as f64).sqrt()
}

/// The turn and shift that bring predicted tips nearest to the measured ones.
fn frame_of(motions: &[Motion], tips: &[Vec<[f64; 3]>]) -> (Matrix3<f64>, Vector3<f64>) {
    let points = pairs(motions, tips).map(|(_, measured, tip)| (Vector3::from(tip), Vector3::from(measured)));
    let (from, to): (Vec<_>, Vec<_>) = points.unzip();
    alignment(&from, &to)
}

/// With nothing commanded, the measured tip must be near the twin's.
fn check_frame(twin: &Twin, motions: &[Motion], tips: &[Vec<[f64; 3]>]) -> Result<()> {
    for (motion, tips) in motions.iter().zip(tips) {
        let mut mean = [[0.0; 3]; 2];
        let rows: Vec<usize> =
            motion.rows_at_zero().into_iter().filter(|&row| motion.tips[row].is_some()).collect();
        for &row in &rows {
            for c in 0..3 {
                mean[0][c] += tips[row][c] / rows.len() as f64;
                mean[1][c] += motion.tips[row].map_or(0.0, |tip| tip[c]) / rows.len() as f64;
            }
        }
        let apart = distance(mean[0], mean[1]);
        if apart > MOVED_TRACKER * length_of(twin) {
            let [twins, measured] =
                mean.map(|p| format!("({:.1}, {:.1}, {:.1}) mm", 1e3 * p[0], 1e3 * p[1], 1e3 * p[2]));
            return Err(BadInput::new(
                format!("{}: tip with nothing pulled", motion.name),
                format!("near {twins}, where the twin's rests"),
                format!("{measured}, {:.1} mm off", 1e3 * apart),
            )
            .hint("was the tracker moved? --frame fit finds where it stands, --frame trust takes the tip as it is")
            .into());
        }
    }
    Ok(())
}

/// A frame needs all three coordinates.
fn check_axes(motions: &[Motion]) -> Result<()> {
    match motions.iter().find(|motion| motion.axes != [true; 3]) {
        None => Ok(()),
        Some(motion) => {
            let place = format!("{}: tip", motion.name);
            Err(BadInput::new(place, "three coordinates that vary, to fit a frame", "a constant one").into())
        }
    }
}
