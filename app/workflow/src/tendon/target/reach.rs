//! Whether the twin of a robot reaches a target's curve, before anything moves.

use hysteron_base::{BadInput, Scene};
use hysteron_control::TargetPath;
use hysteron_twin::{Error, Stepper, Target, TipGoal, Twin};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Context;
use crate::shared::error::Cancelled;
use crate::shared::run::resting;

/// Smallest distance of the goals along the curve, and on the way to it [m]; larger on a long curve, which then has
/// so many goals.
const SPACING: f64 = 1e-3;
const MAX_GOALS: f64 = 150.0;
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

impl Reach {
    /// Moves the twin's tip from rest to the curve and along one lap of it; x and y count, and z where the target
    /// gives it. The strokes of all tendons are free within their bounds. Friction is left out: it changes which
    /// strokes lead to a place, by the way there, and hardly which places there are.
    pub fn of(target: &TargetPath, scene: &Scene, tolerance: f64, context: &Context) -> anyhow::Result<Self> {
        let twin = Twin::from_scene(&Scene { friction: None, auxiliary: None, ..scene.clone() })?;
        if twin.n_primary == 0 {
            return Err(BadInput::new("the scene", "at least one tendon", "none").into());
        }
        let targets: Vec<Target> = (0..twin.tendons.len())
            .map(|j| if j < twin.n_primary { Target::Free } else { resting(&twin.tendons[j]) })
            .collect();
        let mut stepper = Stepper::new(&twin);
        // Zeros and gravity hold the tip away from the undeformed body's.
        let at_rest: Vec<Target> = twin.tendons.iter().map(resting).collect();
        stepper.step(&twin, &at_rest)?;
        let rest = twin.tip_of(stepper.state());
        let spacing = SPACING.max(target.outline.length() / MAX_GOALS);
        let curve = target.outline.evenly(spacing);
        let way = way_to(curve[0], spacing);
        let mut reach = Self::none(scene, tolerance);
        context.listen();
        let bar = context.progress("goals", way.len() + curve.len(), 0);
        let is_asked = |c: usize| c < 2 || !target.is_planar;
        let mut go_to = |goal: &Goal| -> anyhow::Result<(f64, Goal, f64)> {
            if context.is_cancelled() {
                return Err(Cancelled::new("; nothing was written").into());
            }
            let position = std::array::from_fn(|c| is_asked(c).then(|| rest[c] + goal[c]));
            let asked = TipGoal { position, tolerance, regularisation: REGULARISATION, least_gain: MIN_GAIN };
            let before = stepper.state().clone();
            match stepper.reach(&twin, &asked, &targets) {
                Ok(_) => {}
                // As near as an equilibrium was found.
                Err(Error::NoEquilibrium { .. }) => stepper.restore(&twin, &before)?,
                Err(other) => return Err(other.into()),
            }
            let state = stepper.state();
            let tip = twin.tip_of(state);
            let squares = (0..3).filter(|c| is_asked(*c)).map(|c| (tip[c] - rest[c] - goal[c]).powi(2));
            let tension = state.tensions[..twin.n_primary].iter().copied().fold(0.0, f64::max);
            Ok((squares.sum::<f64>().sqrt(), std::array::from_fn(|c| tip[c] - rest[c]), tension))
        };
        for goal in &way {
            // Where the way is out of reach, so is the curve's beginning, or the way there leads elsewhere.
            if go_to(goal)?.0 > tolerance {
                break;
            }
            bar.inc(1);
        }
        let mut next = 0;
        while let Some(goal) = curve.get(next) {
            let (distance, tip, tension) = go_to(goal)?;
            reach.add(*goal, distance, tip, tension);
            // A goal out of reach takes the twin to its bounds, which takes long; some show where the others are.
            next += if reach.out_of_reach > 0 { curve.len().div_ceil(GOALS_BEYOND) } else { 1 };
            bar.set_position((way.len() + next.min(curve.len())) as u64);
        }
        bar.finish();
        Ok(reach)
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

    fn add(&mut self, goal: Goal, distance: f64, tip: Goal, tension: f64) {
        self.goals += 1;
        self.out_of_reach += usize::from(distance > self.tolerance_m);
        if distance > self.largest_distance_m {
            (self.largest_distance_m, self.largest_distance_at_m) = (distance, goal);
        }
        self.tension_max_n = self.tension_max_n.max(tension);
        self.places.push((goal, distance, tip));
    }

    /// Refuses a target of which a part is out of reach.
    pub fn check(&self, target: &TargetPath, hint: String) -> Result<(), BadInput> {
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
        Err(BadInput::new(format!("target {}", target.name), expected, found).hint(hint))
    }
}

/// Goals from rest to the beginning of a curve, without its ends.
fn way_to(start: Goal, spacing: f64) -> Vec<Goal> {
    let n = (start.iter().map(|c| c * c).sum::<f64>().sqrt() / spacing).ceil() as usize;
    (1..n).map(|i| start.map(|c| c * i as f64 / n as f64)).collect()
}
