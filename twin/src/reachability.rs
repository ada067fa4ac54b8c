//! Whether the twin of a robot reaches a curve, before anything moves.

use hysteron_base::{BadInput, Scene};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Error, Result, Stepper, Target, TipGoal, Twin, TwinTendon};

/// Goals of a whole curve from the first on that is out of reach: each costs as much as many within, as the twin is
/// bent as far as it goes.
const GOALS_BEYOND: usize = 3;
/// How exactly the place is found that is nearest to one of them, as a part of the distance [-].
const MIN_GAIN: f64 = 0.05;
/// As `hysteron reach`: enough to choose among strokes that reach a goal alike, too little to hold the tip back.
const REGULARISATION: f64 = 1e-6;

/// Reachability of a target by a robot's twin.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Reach {
    /// Name of the robot.
    pub scene: String,
    /// SHA-256 of its scene.
    pub scene_sha256: String,
    /// Distance that counts as reached [m].
    pub tolerance_m: f64,
    /// Goals along the curve that were tried: once one is out of reach, fewer.
    pub goals: usize,
    /// Those that the tip did not come so close to.
    pub out_of_reach: usize,
    /// Largest distance of the tip from its goal [m].
    pub largest_distance_m: f64,
    /// The goal at which it was, from where the tip rests [m].
    pub largest_distance_at_m: [f64; 3],
    /// Largest tension of a tendon [N].
    pub tension_max_n: f64,
    /// Where each goal is, from where the tip rests [m]; the distance that remained [m]; and where the tip came to.
    #[serde(skip)]
    pub places: Vec<(Goal, f64, Goal)>,
}

/// A place from where the tip rests [m].
pub type Goal = [f64; 3];

/// Goals along a curve.
pub struct CurveGoals<'a> {
    /// In order, each from where the tip rests [m].
    pub points: &'a [Goal],
    /// Distance between them, and between those on the approach from rest [m].
    pub spacing: f64,
    /// Coordinates that count, x, y and z in this order.
    pub n_axes: usize,
}

impl Reach {
    /// Moves the twin's tip from rest to the curve and along one lap of it. The strokes of all tendons are free within their bounds.
    /// Friction is left out: it changes which strokes lead to a place, by the motion before, and hardly which places there are.
    ///
    /// `progress` receives the goals done, of all; none is returned where it answers `false`.
    ///
    /// # Errors
    /// `BadInput` of a scene without tendons; a twin that cannot be built or stepped at rest.
    pub fn of(
        scene: &Scene,
        curve: &CurveGoals,
        tolerance: f64,
        progress: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<Option<Self>> {
        let twin = Twin::from_scene(&Scene { friction: None, auxiliary: None, ..scene.clone() })?;
        if twin.n_primary == 0 {
            return Err(BadInput::new("the scene", "at least one tendon", "none").into());
        }
        let mut probe = ReachProbe::new(&twin, curve.n_axes, tolerance)?;
        let approach = approach(curve.points[0], curve.spacing);
        let n = approach.len() + curve.points.len();
        let mut reach = Self::none(scene, tolerance);
        for (done, goal) in approach.iter().enumerate() {
            if !progress(done, n) {
                return Ok(None);
            }
            // Where the approach is out of reach, so is the curve's beginning, or the motion there leads elsewhere.
            if probe.go_to(goal)?.distance > tolerance {
                break;
            }
        }
        let mut next = 0;
        while let Some(goal) = curve.points.get(next) {
            if !progress(approach.len() + next, n) {
                return Ok(None);
            }
            reach.add(*goal, &probe.go_to(goal)?);
            // A goal out of reach takes the twin to its bounds, which takes long; some show where the others are.
            next += if reach.out_of_reach > 0 { curve.points.len().div_ceil(GOALS_BEYOND) } else { 1 };
        }
        Ok(Some(reach))
    }

    fn none(scene: &Scene, tolerance: f64) -> Self {
        Self {
            scene: scene.name.clone(),
            scene_sha256: scene.hash.clone(),
            tolerance_m: tolerance,
            goals: 0,
            out_of_reach: 0,
            largest_distance_m: 0.0,
            largest_distance_at_m: [0.0; 3],
            tension_max_n: 0.0,
            places: Vec::new(),
        }
    }

    fn add(&mut self, goal: Goal, found: &GoalResult) {
        let GoalResult { distance, tip, tension } = *found;
        self.goals += 1;
        self.out_of_reach += usize::from(distance > self.tolerance_m);
        if distance > self.largest_distance_m {
            (self.largest_distance_m, self.largest_distance_at_m) = (distance, goal);
        }
        self.tension_max_n = self.tension_max_n.max(tension);
        self.places.push((goal, distance, tip));
    }

    /// Accepts a target that is within reach.
    ///
    /// # Errors
    /// `BadInput` with how many goals are out of reach, and the farthest.
    pub fn check(&self, target: &str, hint: String) -> std::result::Result<(), BadInput> {
        if self.out_of_reach == 0 {
            return Ok(());
        }
        let [x, y, _] = self.largest_distance_at_m.map(|c| 1e3 * c);
        let found = format!(
            "{} of {} points out of reach, at ({x:.1}, {y:.1}) mm by {:.2} mm",
            self.out_of_reach,
            self.goals,
            1e3 * self.largest_distance_m
        );
        let expected = format!("a curve that {} reaches", self.scene);
        Err(BadInput::new(format!("target {target}"), expected, found).hint(hint))
    }
}

/// A goal that was tried: the distance that remained [m], where the tip came to from where it rests [m], and the largest tension [N].
struct GoalResult {
    distance: f64,
    tip: Goal,
    tension: f64,
}

/// A twin on its way from goal to goal.
struct ReachProbe<'a> {
    twin: &'a Twin,
    stepper: Stepper,
    targets: Vec<Target>,
    rest: Goal,
    n_axes: usize,
    tolerance: f64,
}

impl<'a> ReachProbe<'a> {
    fn new(twin: &'a Twin, n_axes: usize, tolerance: f64) -> Result<Self> {
        // Zeros and gravity hold the tip away from the undeformed body's.
        let at_rest: Vec<Target> = twin.tendons.iter().map(TwinTendon::resting_target).collect();
        let mut stepper = Stepper::new(twin);
        stepper.step(twin, &at_rest)?;
        let rest = twin.tip_of(stepper.state());
        let mut targets = at_rest;
        targets[..twin.n_primary].fill(Target::Free);
        Ok(Self { twin, stepper, targets, rest, n_axes, tolerance })
    }

    fn go_to(&mut self, goal: &Goal) -> Result<GoalResult> {
        let position = std::array::from_fn(|c| (c < self.n_axes).then(|| self.rest[c] + goal[c]));
        let asked = TipGoal {
            position,
            tolerance: self.tolerance,
            regularisation: REGULARISATION,
            least_gain: MIN_GAIN,
        };
        let before = self.stepper.state().clone();
        match self.stepper.reach(self.twin, &asked, &self.targets) {
            Ok(_) => {}
            // As near as an equilibrium was found.
            Err(Error::NoEquilibrium { .. }) => self.stepper.restore(self.twin, &before)?,
            Err(other) => return Err(other),
        }
        let state = self.stepper.state();
        let tip = self.twin.tip_of(state);
        let squares = (0..self.n_axes).map(|c| (tip[c] - self.rest[c] - goal[c]).powi(2));
        Ok(GoalResult {
            distance: squares.sum::<f64>().sqrt(),
            tip: std::array::from_fn(|c| tip[c] - self.rest[c]),
            tension: state.tensions[..self.twin.n_primary].iter().copied().fold(0.0, f64::max),
        })
    }
}

/// Goals from rest to the beginning of a curve, without its ends.
fn approach(start: Goal, spacing: f64) -> Vec<Goal> {
    let n = (start.iter().map(|c| c * c).sum::<f64>().sqrt() / spacing).ceil() as usize;
    (1..n).map(|i| start.map(|c| c * i as f64 / n as f64)).collect()
}
