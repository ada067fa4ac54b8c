//! The physical parameters of a scene from what its robot did.

use hysteron_base::{BadInput, Scene};
use hysteron_fem::Mesh;
use nalgebra::{Matrix3, Vector3};

use super::course::{Course, Stepping, courses};
use super::least_squares::{Fit, Options, least_squares};
use super::quantity::Selected;
use crate::motion::Motion;
use crate::{Result, Target, Twin, alignment, rollouts};

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
    /// How it goes through the motions.
    pub stepping: Stepping,
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
    /// What was stepped through, by motion.
    pub courses: Vec<Course>,
    /// Tips of both, in the frame of the measurement: by motion, by step [m].
    pub tips: [Vec<Vec<[f64; 3]>>; 2],
    /// Turn (row-major) and shift [m] from the scene to the frame of the measurement.
    pub frame: ([[f64; 3]; 3], [f64; 3]),
}

/// Part of the measured motion that a parameter must move the tip by, between its bounds, to count as seen [-].
const SEEN: f64 = 2e-3;
/// Degrees of freedom of a rigid frame.
const OF_FRAME: usize = 6;

/// Fits `selected` so that the twin's tip follows the measured one through `motions`. Auxiliary tendons are left out:
/// what they stand in for is what a fit is to explain.
///
/// # Errors
/// Those of [`courses`], [`Twin::new`] and the first pass through the motions; with [`Frame::Checked`], a tip that
/// rests elsewhere than the twin's.
pub fn fit_material(
    scene: &Scene,
    mesh: &Mesh,
    motions: &[Motion],
    selected: &[Selected],
    options: &MaterialOptions,
) -> Result<MaterialFit> {
    let bare = Scene { auxiliary: None, ..scene.clone() };
    match options.frame {
        Frame::Checked => {
            let twin = Twin::new(&bare, mesh)?;
            motions.iter().try_for_each(|motion| motion.check_registration(&twin))?;
        }
        Frame::Trusted => {}
        Frame::Fitted => check_axes(motions)?,
    }
    let courses = courses(motions, &options.stepping)?;
    let targets: Vec<_> = courses.iter().map(|course| course.targets.clone()).collect();
    let before = follow(&bare, mesh, &targets)?;
    let with = |scene: &Scene, values: &[f64]| {
        let mut candidate = scene.clone();
        for (selected, value) in selected.iter().zip(values) {
            (selected.quantity.set)(&mut candidate, selected.tendon, *value);
        }
        candidate
    };
    let placed = |mut tips: Vec<Vec<[f64; 3]>>| {
        let frame = match options.frame {
            Frame::Fitted => frame_of(&courses, &tips),
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
        smallest_effect: SEEN * motion_size(&courses),
        n_nuisance: if options.frame == Frame::Fitted { OF_FRAME } else { 0 },
        watch: options.watch,
    };
    let follow_with = |values: &[f64]| follow(&with(&bare, values), mesh, &targets);
    let fit = least_squares(&parameters, &least, |values| {
        Ok(series(motions, &courses, &placed(follow_with(values)?).0))
    })?;
    let (after, (turn, shift)) = placed(follow_with(&fit.values())?);
    let (before, _) = placed(before);
    let errors = [&before, &after].map(|tips| errors(motions, &courses, tips));
    let turn = [0, 1, 2].map(|r| [0, 1, 2].map(|c| turn[(r, c)]));
    let scene = with(scene, &fit.values());
    Ok(MaterialFit { fit, scene, errors, courses, tips: [before, after], frame: (turn, shift.into()) })
}

/// Tips of the scene's twin under all sequences of targets: by motion, by step [m].
fn follow(scene: &Scene, mesh: &Mesh, targets: &[Vec<Vec<Target>>]) -> Result<Vec<Vec<[f64; 3]>>> {
    let twin = Twin::new(scene, mesh)?;
    rollouts(&twin, &twin.rest(), targets).into_iter().map(|done| Ok(done?.tips)).collect()
}

/// Measured and predicted tips of the steps that are compared.
fn compared<'a>(course: &'a Course, tips: &'a [[f64; 3]]) -> impl Iterator<Item = ([f64; 3], [f64; 3])> + 'a {
    course.tips.iter().zip(tips).filter_map(|(measured, tip)| Some(((*measured)?, *tip)))
}

/// Residuals: a series for each used coordinate of each motion [m].
fn series(motions: &[Motion], courses: &[Course], tips: &[Vec<[f64; 3]>]) -> Vec<Vec<f64>> {
    let mut series = Vec::new();
    for ((motion, course), tips) in motions.iter().zip(courses).zip(tips) {
        for c in (0..3).filter(|&c| motion.axes[c]) {
            series.push(compared(course, tips).map(|(measured, tip)| tip[c] - measured[c]).collect());
        }
    }
    series
}

fn errors(motions: &[Motion], courses: &[Course], tips: &[Vec<[f64; 3]>]) -> AxisErrors {
    let (mut sums, mut counts) = ([0.0; 3], [0.0; 3]);
    for ((motion, course), tips) in motions.iter().zip(courses).zip(tips) {
        for (measured, tip) in compared(course, tips) {
            for c in (0..3).filter(|&c| motion.axes[c]) {
                sums[c] += (tip[c] - measured[c]).powi(2);
                counts[c] += 1.0;
            }
        }
    }
    let mean = |c: usize| if counts[c] > 0.0 { sums[c] / counts[c] } else { 0.0 };
    AxisErrors {
        axes: std::array::from_fn(|c| mean(c).sqrt()),
        distance: (0..3).map(mean).sum::<f64>().sqrt(),
    }
}

/// Root mean square distance of the compared tips from their mean [m].
fn motion_size(courses: &[Course]) -> f64 {
    let tips: Vec<Vector3<f64>> =
        courses.iter().flat_map(|course| &course.tips).flatten().map(|tip| Vector3::from(*tip)).collect();
    let mean = tips.iter().sum::<Vector3<f64>>() / tips.len() as f64;
    (tips.iter().map(|tip| (tip - mean).norm_squared()).sum::<f64>() / tips.len() as f64).sqrt()
}

/// The turn and shift that bring predicted tips nearest to the measured ones.
fn frame_of(courses: &[Course], tips: &[Vec<[f64; 3]>]) -> (Matrix3<f64>, Vector3<f64>) {
    let pairs = courses.iter().zip(tips).flat_map(|(course, tips)| compared(course, tips));
    let (to, from): (Vec<_>, Vec<_>) = pairs.map(|(a, b)| (Vector3::from(a), Vector3::from(b))).unzip();
    alignment(&from, &to)
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
