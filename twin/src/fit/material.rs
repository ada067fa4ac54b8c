//! The physical parameters of a scene from what its robot did, coarse to fine.
//!
//! A few steps of every recording decide where to begin; some more find the minimum, its uncertainty, and which way
//! gravity points; all that are asked for correct it by one step of Gauss and Newton.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use hysteron_base::Scene;
use hysteron_fit::{
    Fit, Identifiability, IdentifiedParameter, Options, Parameter, Prior, TOLERANCE, least_squares, minimum,
    polished,
};

use super::comparison::{AxisErrors, FitBody, MotionComparison, TipFrame, check_axes};
use super::hints::{Hint, hints, steepest};
use super::quantity::Selected;
use super::sampling::{FitSamples, Stepping, courses};
use crate::Result;
use crate::motion::RobotMotion;

/// How far a fit has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitProgress {
    /// Steps of the twin so far; how many there will be is not known before the search has ended.
    pub steps: usize,
    /// Least root mean square of the residuals so far [m].
    pub rms: f64,
}

/// How to fit.
pub struct MaterialOptions<'a> {
    /// Where the tip is expected.
    pub frame: TipFrame,
    /// How it goes through the motions.
    pub stepping: Stepping,
    /// Error of a coordinate from which on it counts linearly, if any [m].
    pub huber: Option<f64>,
    /// Largest tension that the drives of the robot can make, where that is less than the scene allows [N].
    pub tension_max: Option<f64>,
    /// Called with the progress of the fit; false ends it.
    pub watch: &'a (dyn Fn(FitProgress) -> bool + Sync),
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
    /// Steps of the fit, by motion.
    pub courses: Vec<FitSamples>,
    /// Tips of both, in the frame of the measurement: by motion, by step [m].
    pub tips: [Vec<Vec<[f64; 3]>>; 2],
    /// Turn (row-major) and shift [m] from the frame of the scene's tracker to that of the measurement.
    pub frame: ([[f64; 3]; 3], [f64; 3]),
    /// Root mean square distance of the measured tips from their mean [m].
    pub measured_spread: f64,
    /// Largest tension of every primary tendon with the fitted scene [N].
    pub tensions: Vec<f64>,
    /// Other explanations of the errors that are left, the best first.
    pub hints: Vec<Hint>,
}

/// Part of the measured motion that a parameter must move the tip by, between its bounds, to count as
/// observable [-].
const SEEN: f64 = 2e-3;
/// Degrees of freedom of a rigid frame.
const OF_FRAME: usize = 6;
/// Steps of a motion that decide where to begin, and with which the minimum is found. Longer steps would not be
/// cheaper:
/// from 0.3 mm on, a step with friction costs as much as its length.
const BEGINNING: usize = 30;
const ON_THE_WAY: usize = 100;
/// Tolerance of a search that others follow [-].
const ROUGH: f64 = 1e-3;
/// Places of friction, between its bounds, from which a fit also begins, next to the scene's [-].
const OTHER_STARTS: [f64; 2] = [0.05, 0.5];
/// Quantities of friction.
const FRICTION: [&str; 5] = ["coefficient", "coulomb", "sheath_exponent", "sheath_coulomb", "backlash"];
/// Times that gravity may turn to another axis of the scene.
const MAX_TURNS: usize = 3;

/// Fits `selected` so that the twin's tip follows the measured one through `motions`, without auxiliary
/// tendons: their effect is what a fit is to explain. Where the direction of gravity is selected, all axes of
/// the scene are tried.
///
/// # Errors
/// Those of [`courses`], [`FitBody::twin`] and the first pass through the motions; with [`TipFrame::Checked`], a tip that
/// rests elsewhere than the twin's, unless the tracker's frame is fitted.
pub fn fit_material(
    scene: &Scene,
    body: FitBody,
    motions: &[RobotMotion],
    selected: &[Selected],
    options: &MaterialOptions,
) -> Result<MaterialFit> {
    let is_tracked = selected.iter().any(|selected| selected.quantity.name.starts_with("tracker"));
    match options.frame {
        TipFrame::Checked if !is_tracked => {
            let twin = body.twin(&Scene { auxiliary: None, ..scene.clone() })?;
            motions.iter().try_for_each(|motion| motion.check_registration(&twin))?;
        }
        TipFrame::Checked | TipFrame::Trusted => {}
        TipFrame::Fitted => check_axes(motions)?,
    }
    let steps = AtomicUsize::new(0);
    let tension_max = |tendon: &hysteron_base::Tendon| {
        options.tension_max.map_or(tendon.tension.max, |most| most.min(tendon.tension.max))
    };
    let fine = MotionComparison::new(
        body,
        motions,
        courses(motions, &options.stepping)?,
        options.frame,
        scene.tendons.iter().map(tension_max).collect(),
        &steps,
    );
    Levels::new(fine, scene, selected, options)?.run()
}

/// A fit on its way: what it starts from, and its courses from coarse to fine.
struct Levels<'a> {
    /// The scene as given.
    given: &'a Scene,
    /// With gravity along the axis from which it leans.
    scene: Scene,
    selected: Vec<Selected>,
    options: &'a MaterialOptions<'a>,
    beginning: MotionComparison<'a>,
    coarse: MotionComparison<'a>,
    fine: MotionComparison<'a>,
    best: Mutex<f64>,
}

impl<'a> Levels<'a> {
    fn new(
        fine: MotionComparison<'a>,
        scene: &'a Scene,
        selected: &[Selected],
        options: &'a MaterialOptions,
    ) -> Result<Self> {
        let n_steps =
            |courses: &[FitSamples]| courses.iter().map(|course| course.samples.len()).sum::<usize>();
        let beginning = |most: usize| -> Vec<FitSamples> {
            fine.courses.iter().map(|course| course.beginning(most)).collect()
        };
        let (coarse, beginning) = (beginning(ON_THE_WAY), beginning(BEGINNING));
        // Little more is worth no level of its own.
        let is_most = 2 * n_steps(&coarse) > n_steps(&fine.courses);
        let coarse = if is_most { fine.courses.clone() } else { coarse };
        let mut levels = Self {
            given: scene,
            scene: Scene { auxiliary: None, ..scene.clone() },
            selected: selected.to_vec(),
            options,
            beginning: fine.along(beginning),
            coarse: fine.along(coarse),
            fine,
            best: Mutex::new(f64::INFINITY),
        };
        if levels.has("gravity") && levels.scene.gravity == [0.0; 3] {
            levels.turn_gravity(super::quantity::along_axes(scene)[4]);
        }
        Ok(levels)
    }

    fn has(&self, name: &str) -> bool {
        self.selected.iter().any(|selected| selected.quantity.name == name)
    }

    /// Makes gravity lean from another direction.
    fn turn_gravity(&mut self, gravity: [f64; 3]) {
        self.scene.gravity = gravity;
        for selected in self.selected.iter_mut().filter(|selected| selected.quantity.name == "gravity") {
            let start = selected.value_of(&self.scene).unwrap_or(0.0);
            let Parameter { bounds, prior, .. } = &mut selected.parameter;
            *prior = prior.map(|prior| Prior { center: start, ..prior });
            selected.parameter.start = bounds.clamp(start);
        }
    }

    /// `scene` with these values.
    fn with(&self, scene: &Scene, values: &[f64]) -> Scene {
        let mut candidate = Scene { gravity: self.scene.gravity, ..scene.clone() };
        if !self.has("gravity") {
            candidate.gravity = scene.gravity;
        }
        for (selected, value) in self.selected.iter().zip(values) {
            (selected.quantity.set)(&mut candidate, selected.component, *value);
        }
        candidate
    }

    fn parameters(&self, starts: &[f64]) -> Vec<Parameter> {
        let parameter = |(selected, start): (&Selected, &f64)| Parameter {
            start: selected.parameter.bounds.clamp(*start),
            ..selected.parameter.clone()
        };
        self.selected.iter().zip(starts).map(parameter).collect()
    }

    fn residuals(&self, on: &MotionComparison, values: &[f64]) -> Result<Vec<Vec<f64>>> {
        on.residuals(&self.with(&self.scene, values))
    }

    /// Runs `search` with the options of a search on `on`.
    fn watched<T>(&self, on: &MotionComparison, search: impl FnOnce(&Options) -> Result<T>) -> Result<T> {
        let watch = |_: usize, rms: f64| {
            let Ok(mut best) = self.best.lock() else { return false };
            *best = best.min(rms);
            (self.options.watch)(FitProgress { steps: on.steps.load(Ordering::Relaxed), rms: *best })
        };
        search(&Options {
            huber: self.options.huber,
            smallest_effect: SEEN * on.motion_size(),
            n_nuisance: if self.options.frame == TipFrame::Fitted { OF_FRAME } else { 0 },
            tolerance: if on.courses == self.fine.courses { TOLERANCE } else { ROUGH },
            watch: &watch,
        })
    }

    fn run(mut self) -> Result<MaterialFit> {
        let before = self.fine.answer(self.given)?;
        let start = self.begin()?;
        let mut fit = self.search(&start)?;
        for _ in 0..MAX_TURNS {
            let Some(gravity) = self.other_gravity(&fit)? else { break };
            let last = (self.scene.gravity, self.selected.clone());
            let values = fit.values();
            self.turn_gravity(gravity);
            let start: Vec<f64> = (self.selected.iter().zip(&values))
                .map(|(s, value)| if s.quantity.name == "gravity" { s.parameter.start } else { *value })
                .collect();
            let other = self.search(&start)?;
            if other.rms[1] >= fit.rms[1] {
                (self.scene.gravity, self.selected) = last;
                break;
            }
            fit = other;
        }
        // An assumption that cannot be tried explains nothing.
        let hints = hints(&self.beginning, &self.with(&self.scene, &fit.values()), &self.selected, &fit)
            .unwrap_or_default();
        self.polish(&mut fit)?;
        let scene = self.with(self.given, &fit.values());
        let after = self.fine.answer(&scene)?;
        let (tips_before, _) = self.fine.placed(self.given, &before);
        let (tips_after, frame) = self.fine.placed(&scene, &after);
        let turn = [0, 1, 2].map(|r| [0, 1, 2].map(|c| frame.turn[(r, c)]));
        Ok(MaterialFit {
            errors: [&tips_before, &tips_after].map(|tips| self.fine.errors(tips)),
            measured_spread: self.fine.motion_size(),
            tensions: self.fine.largest_tensions(&after),
            frame: (turn, frame.shift.into()),
            tips: [tips_before, tips_after],
            courses: self.fine.courses,
            scene,
            fit,
            hints,
        })
    }

    /// Where to begin: with friction, the best of several places on the beginnings of the motions.
    fn begin(&self) -> Result<Vec<f64>> {
        let home: Vec<f64> = self.selected.iter().map(|selected| selected.parameter.start).collect();
        let is_friction = |selected: &Selected| FRICTION.contains(&selected.quantity.name);
        if !self.selected.iter().any(is_friction) {
            return Ok(home);
        }
        let other = |place: f64| -> Vec<f64> {
            let start = |selected: &Selected| match is_friction(selected) {
                true => selected.parameter.value(place),
                false => selected.parameter.start,
            };
            self.selected.iter().map(start).collect()
        };
        let mut best = (home.clone(), f64::INFINITY);
        for start in std::iter::once(home).chain(OTHER_STARTS.map(other)) {
            let parameters = self.parameters(&start);
            let on = &self.beginning;
            let found = self
                .watched(on, |options| minimum(&parameters, options, |values| self.residuals(on, values)));
            match found {
                Ok((values, cost)) if cost < best.1 => best = (values, cost),
                Ok(_) | Err(crate::Error::NoEquilibrium { .. }) => {}
                Err(other) => return Err(other),
            }
        }
        Ok(best.0)
    }

    /// The minimum over a part of the steps, and its uncertainty.
    fn search(&self, start: &[f64]) -> Result<Fit> {
        let (parameters, on) = (self.parameters(start), &self.coarse);
        self.watched(on, |options| least_squares(&parameters, options, |values| self.residuals(on, values)))
    }

    /// Another axis of the scene for gravity: the one that it leans to as far as it may, or one where the errors
    /// would be smaller.
    fn other_gravity(&self, fit: &Fit) -> Result<Option<[f64; 3]>> {
        if !self.has("gravity") {
            return Ok(None);
        }
        let scene = self.with(&self.scene, &fit.values());
        let at_bound = |(s, estimate): &(&Selected, &IdentifiedParameter)| {
            s.quantity.name == "gravity" && estimate.identifiability == Identifiability::AtBound
        };
        if let Some((s, _)) = self.selected.iter().zip(&fit.estimates).find(at_bound) {
            return Ok(Some(super::quantity::beyond(scene.gravity, s.component)));
        }
        steepest(&self.coarse, &scene, &self.selected, fit)
    }

    /// Corrects what a part of the steps gave by all that are asked for.
    fn polish(&self, fit: &mut Fit) -> Result<()> {
        let on = &self.fine;
        if self.coarse.courses == on.courses {
            return Ok(());
        }
        let parameters = self.parameters(&fit.values());
        self.watched(on, |options| polished(&parameters, options, |values| self.residuals(on, values), fit))
    }
}
