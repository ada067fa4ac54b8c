//! A scene's twin compared with a recording: the residuals of a fit.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use hysteron_base::{BadInput, Scene};
use hysteron_fem::Mesh;
use nalgebra::{Matrix3, Vector3};

use super::sampling::FitSamples;
use crate::chain::Chain;
use crate::motion::RobotMotion;
use crate::{Registration, Result, Target, Twin, alignment, rollouts};

/// Where the measured tip is expected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TipFrame {
    /// In the frame of the scene's tracker; a tip that rests elsewhere is an error.
    Checked,
    /// In the frame of the scene's tracker, wherever it rests.
    Trusted,
    /// In a frame of its own, the same for all recordings: turned and shifted as suits the twin best.
    Fitted,
}

/// Root mean square errors of the tip [m].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisErrors {
    /// Along x, y and z.
    pub axes: [f64; 3],
    /// Of the distance.
    pub distance: f64,
}

/// Answers of the twin that are kept: those around which a Jacobian is taken, and its own.
const KEPT: usize = 24;
/// Part of the largest tension allowed from which on a simulated one counts as too large [-].
const STRAINED: f64 = 0.8;
/// Residual of a tension at its largest, and of one that differs from the recorded one by a tenth of the
/// largest recorded, as an error of the tip: this part of its motion [-].
const TENSION_WEIGHT: f64 = 0.02;

/// Tips and tensions of a scene's twin, by motion.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TwinResponse {
    /// Tip in the frame of the scene, by step [m].
    pub tips: Vec<Vec<[f64; 3]>>,
    /// Tension of every primary tendon, by step [N].
    pub tensions: Vec<Vec<Vec<f64>>>,
}

/// The body of a robot, whatever its parameters are.
#[derive(Debug, Clone, Copy)]
pub struct FitBody<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The chain that moves in its place, if any.
    pub chain: Option<&'a Chain>,
}

impl FitBody<'_> {
    /// The twin of a scene.
    ///
    /// # Errors
    /// Those of [`Twin::new`] and of [`Chain::of`].
    pub fn twin(&self, scene: &Scene) -> Result<Twin> {
        let twin = Twin::new(scene, self.mesh)?;
        match self.chain {
            Some(chain) => chain.of(&twin).map(|chain| twin.with_chain(chain)),
            None => Ok(twin),
        }
    }
}

/// Motions, what of them is compared, and how.
pub(super) struct MotionComparison<'a> {
    pub body: FitBody<'a>,
    pub motions: &'a [RobotMotion],
    pub courses: Vec<FitSamples>,
    pub frame: TipFrame,
    /// Largest tension that the robot's drives can make, by primary tendon [N].
    pub tension_max: Vec<f64>,
    /// Counts steps, for who watches.
    pub steps: &'a AtomicUsize,
    known: Mutex<Vec<(Scene, Arc<TwinResponse>)>>,
    /// A twin on the body, from which others with other numbers are made.
    twin: Arc<Mutex<Option<Twin>>>,
}

impl<'a> MotionComparison<'a> {
    pub fn new(
        body: FitBody<'a>,
        motions: &'a [RobotMotion],
        courses: Vec<FitSamples>,
        frame: TipFrame,
        tension_max: Vec<f64>,
        steps: &'a AtomicUsize,
    ) -> Self {
        Self {
            body,
            motions,
            courses,
            frame,
            tension_max,
            steps,
            known: Mutex::default(),
            twin: Arc::default(),
        }
    }

    /// The same with other courses.
    pub fn along(&self, courses: Vec<FitSamples>) -> Self {
        let (frame, tension_max) = (self.frame, self.tension_max.clone());
        let twin = self.twin.clone();
        Self { twin, ..Self::new(self.body, self.motions, courses, frame, tension_max, self.steps) }
    }

    /// The twin of `scene`; attached to the body anew only where one with other numbers will not do.
    fn twin(&self, scene: &Scene) -> Result<Twin> {
        let known = self.twin.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if let Some(twin) = known.and_then(|twin| twin.with_numbers_of(scene)) {
            return Ok(twin);
        }
        let twin = self.body.twin(scene)?;
        *self.twin.lock().unwrap_or_else(PoisonError::into_inner) = Some(twin.clone());
        Ok(twin)
    }

    /// Tips and tensions of the twin of `scene`; the tracker's frame has no effect on them and costs nothing.
    ///
    /// # Errors
    /// Those of [`Twin::new`] and of a rollout.
    pub fn answer(&self, scene: &Scene) -> Result<Arc<TwinResponse>> {
        let scene = Scene { auxiliary: None, tracker: Default::default(), ..scene.clone() };
        let find = |known: &Vec<(Scene, Arc<TwinResponse>)>| {
            known.iter().find(|(other, _)| *other == scene).map(|(_, answer)| answer.clone())
        };
        if let Some(answer) = self.known.lock().ok().and_then(|known| find(&known)) {
            return Ok(answer);
        }
        let targets: Vec<Vec<Vec<Target>>> =
            self.courses.iter().map(|course| course.targets.clone()).collect();
        let twin = self.twin(&scene)?;
        let mut answer = TwinResponse { tips: Vec::new(), tensions: Vec::new() };
        for done in rollouts(&twin, &twin.rest(), &targets) {
            let done = done?;
            self.steps.fetch_add(done.tips.len(), Ordering::Relaxed);
            answer.tips.push(done.tips);
            answer.tensions.push(done.tensions);
        }
        let answer = Arc::new(answer);
        if let Ok(mut known) = self.known.lock() {
            if known.len() == KEPT {
                known.remove(0);
            }
            known.push((scene, answer.clone()));
        }
        Ok(answer)
    }

    /// The tips of `answer` in the frame of the tracker of `scene`, and with [`TipFrame::Fitted`] in the frame
    /// that suits best; with that frame.
    pub fn placed(&self, scene: &Scene, answer: &TwinResponse) -> (Vec<Vec<[f64; 3]>>, Registration) {
        let tracker = Registration::new(&scene.tracker);
        let mut tips = answer.tips.clone();
        tips.iter_mut().flatten().for_each(|tip| *tip = tracker.point(*tip));
        if self.frame != TipFrame::Fitted {
            return (tips, Registration { turn: Matrix3::identity(), shift: Vector3::zeros() });
        }
        let pairs = self.courses.iter().zip(&tips).flat_map(|(course, tips)| compared(course, tips));
        let (to, from): (Vec<_>, Vec<_>) = pairs.map(|(a, b)| (Vector3::from(a), Vector3::from(b))).unzip();
        let (turn, shift) = alignment(&from, &to);
        let frame = Registration { turn, shift };
        tips.iter_mut().flatten().for_each(|tip| *tip = frame.point(*tip));
        (tips, frame)
    }

    /// Residuals of `scene`: a series for each used coordinate of each motion, then one for the tensions of each [m].
    ///
    /// # Errors
    /// Those of [`Self::answer`].
    pub fn residuals(&self, scene: &Scene) -> Result<Vec<Vec<f64>>> {
        let answer = self.answer(scene)?;
        let (tips, _) = self.placed(scene, &answer);
        let mut series = Vec::new();
        for ((motion, course), tips) in self.motions.iter().zip(&self.courses).zip(&tips) {
            for c in (0..3).filter(|&c| motion.axes[c]) {
                series.push(compared(course, tips).map(|(measured, tip)| tip[c] - measured[c]).collect());
            }
        }
        let unit = TENSION_WEIGHT * self.motion_size();
        for ((motion, course), tensions) in self.motions.iter().zip(&self.courses).zip(&answer.tensions) {
            series.push(self.strains(course, tensions).map(|strain| unit * strain).collect());
            let Some(largest) = motion.largest_tension() else { continue };
            for j in (0..self.tension_max.len()).filter(|&j| motion.measured_tension(0, j).is_some()) {
                let error = |(step, tensions): (usize, &Vec<f64>)| {
                    let measured = motion.measured_tension(course.samples[step], j)?;
                    Some(unit * (tensions[j] - measured) / (0.1 * largest))
                };
                series.push(compared_steps(course, tensions).filter_map(error).collect());
            }
        }
        Ok(series)
    }

    /// How far the tensions of the compared steps are on the way from much to too much, 0 to 1 and beyond [-].
    fn strains<'b>(
        &'b self,
        course: &'b FitSamples,
        tensions: &'b [Vec<f64>],
    ) -> impl Iterator<Item = f64> + 'b {
        compared_steps(course, tensions).map(|(_, tensions)| {
            let strain = |(tension, most): (&f64, &f64)| {
                ((tension / most - STRAINED) / (1.0 - STRAINED)).max(0.0).powi(2)
            };
            tensions.iter().zip(&self.tension_max).map(strain).sum::<f64>().sqrt()
        })
    }

    /// Largest tension of every primary tendon [N].
    pub fn largest_tensions(&self, answer: &TwinResponse) -> Vec<f64> {
        let steps = || answer.tensions.iter().flatten();
        (0..self.tension_max.len()).map(|j| steps().map(|tensions| tensions[j]).fold(0.0, f64::max)).collect()
    }

    /// Root mean square errors of tips where they were recorded.
    pub fn errors(&self, tips: &[Vec<[f64; 3]>]) -> AxisErrors {
        let (mut sums, mut counts) = ([0.0; 3], [0.0; 3]);
        for ((motion, course), tips) in self.motions.iter().zip(&self.courses).zip(tips) {
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
    pub fn motion_size(&self) -> f64 {
        let tips: Vec<Vector3<f64>> = self
            .courses
            .iter()
            .flat_map(|course| &course.tips)
            .flatten()
            .map(|tip| Vector3::from(*tip))
            .collect();
        let mean = tips.iter().sum::<Vector3<f64>>() / tips.len() as f64;
        (tips.iter().map(|tip| (tip - mean).norm_squared()).sum::<f64>() / tips.len() as f64).sqrt()
    }
}

/// Measured and predicted tips of the steps that are compared.
fn compared<'a>(
    course: &'a FitSamples,
    tips: &'a [[f64; 3]],
) -> impl Iterator<Item = ([f64; 3], [f64; 3])> + 'a {
    course.tips.iter().zip(tips).filter_map(|(measured, tip)| Some(((*measured)?, *tip)))
}

/// Number and values of the steps that are compared.
fn compared_steps<'a, T>(
    course: &'a FitSamples,
    values: &'a [T],
) -> impl Iterator<Item = (usize, &'a T)> + 'a {
    values.iter().enumerate().filter(|(step, _)| course.tips[*step].is_some())
}

/// A frame needs all three coordinates.
///
/// # Errors
/// A motion that lacks one.
pub(super) fn check_axes(motions: &[RobotMotion]) -> Result<()> {
    match motions.iter().find(|motion| motion.axes != [true; 3]) {
        None => Ok(()),
        Some(motion) => {
            let place = format!("{}: tip", motion.name);
            Err(BadInput::new(place, "three coordinates that vary, to fit a frame", "a constant one").into())
        }
    }
}
