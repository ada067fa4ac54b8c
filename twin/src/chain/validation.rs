//! How well a chain follows the finite elements that it was made from: equilibria of both under the same random targets.

use hysteron_base::parallel;
use nalgebra::{UnitQuaternion, Vector3};
use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::body::Chain;
use super::errors::{ErrorSpread, Validation};
use crate::coreact::distance;
use crate::model::{Target, Twin};
use crate::stepper::Stepper;
use crate::{Error, Result};

/// Displacements and tensions below which errors are not relative any more: of the body's length, and of the strongest tension.
const LEAST_SHARE: f64 = 0.025;
/// Steps from rest to an equilibrium where friction makes the way matter.
const WALK: usize = 60;

/// Targets of a validation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ValidationOptions {
    /// Number of equilibria.
    pub count: usize,
    /// Largest stroke of a tendon that can only pull, either way [m].
    pub stroke: f64,
    /// Largest tension of an auxiliary tendon, either way [N].
    pub tension: f64,
    /// Seed of the random targets.
    pub seed: u64,
}

/// Where a body is under targets.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Equilibrium {
    /// Recorded tip [m].
    tip: [f64; 3],
    /// Rotation vector of the recorded tip since rest [rad].
    turn: [f64; 3],
    /// Tension of each tendon [N].
    tensions: Vec<f64>,
}

impl Equilibrium {
    /// Of a twin under the validation's targets number `k`, from rest; `None` where there is none.
    ///
    /// # Errors
    /// Targets that the twin refuses.
    pub fn of(twin: &Twin, options: &ValidationOptions, k: usize) -> Result<Option<Self>> {
        Ok(reached(twin, options, k)?.map(|stepper| Self::at(twin, &stepper)))
    }

    /// Those of all targets.
    ///
    /// # Errors
    /// Those of [`Self::of`].
    pub fn all(twin: &Twin, options: &ValidationOptions) -> Result<Vec<Option<Self>>> {
        parallel::map_indices(options.count, |k| Self::of(twin, options, k)).into_iter().collect()
    }

    fn at(twin: &Twin, stepper: &Stepper) -> Self {
        let state = stepper.state();
        Self {
            tip: twin.tip_of(state),
            turn: twin.tip_rotation_of(state).scaled_axis().into(),
            tensions: state.tensions[..twin.tendons.len()].to_vec(),
        }
    }

    fn rotation(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_scaled_axis(Vector3::from(self.turn))
    }
}

/// How a tendon is driven.
enum TendonDrive {
    /// By a random stroke.
    Stroke,
    /// By a random tension.
    Tension,
    /// As always: it may push, so it models something else.
    Resting,
}

impl TendonDrive {
    fn of(twin: &Twin, j: usize) -> Self {
        if j >= twin.n_primary {
            Self::Tension
        } else if twin.tendons[j].tension.min < 0.0 {
            Self::Resting
        } else {
            Self::Stroke
        }
    }
}

/// Two equilibria of one command.
struct Compared {
    tip: f64,
    moved: f64,
    tension: f64,
    strongest: f64,
    turn: f64,
    strain: f64,
}

impl Chain {
    /// Compares equilibria under random targets with those of the finite elements, [`Equilibrium::of`] the `twin` number 0, 1,
    /// ..., and keeps the errors.
    ///
    /// # Errors
    /// Targets that the twin refuses.
    pub fn validate(
        &mut self,
        twin: &Twin,
        options: &ValidationOptions,
        exact: &[Option<Equilibrium>],
    ) -> Result<()> {
        self.validation = None;
        let reduced = twin.clone().with_chain(self.clone());
        let rest = twin.tip_of(&twin.rest());
        let mut compared = Vec::new();
        let mut refused = [0; 2];
        for (k, exact) in exact.iter().enumerate() {
            match (exact, reached(&reduced, options, k)?) {
                (None, _) => refused[0] += 1,
                (_, None) => refused[1] += 1,
                (Some(exact), Some(found)) => compared.push(compare(exact, &reduced, &found, rest)),
            }
        }
        self.validation = Some(summary(&compared, refused, options, self.length()));
        Ok(())
    }

    /// Length of the chain at rest [m].
    fn length(&self) -> f64 {
        self.laws.iter().map(|law| law.rest.norm()).sum()
    }
}

/// From rest to the targets number `k`; `None` where there is no equilibrium on the way.
fn reached(twin: &Twin, options: &ValidationOptions, k: usize) -> Result<Option<Stepper>> {
    let mut stepper = Stepper::new(twin);
    let from: Vec<Target> = twin.tendons.iter().map(|tendon| tendon.resting_target()).collect();
    let to = targets(twin, options, k);
    let steps = if twin.friction.is_empty() { 1 } else { WALK };
    for step in 1..=steps {
        let between = mix(&from, &to, step as f64 / steps as f64);
        match stepper.step(twin, &between) {
            Ok(_) => (),
            Err(Error::NoEquilibrium { .. }) => return Ok(None),
            Err(error) => return Err(error),
        }
    }
    Ok(Some(stepper))
}

fn compare(exact: &Equilibrium, reduced: &Twin, found: &Stepper, rest: [f64; 3]) -> Compared {
    let other = Equilibrium::at(reduced, found);
    let tensions = exact.tensions.iter().zip(&other.tensions);
    Compared {
        tip: distance(exact.tip, other.tip),
        moved: distance(exact.tip, rest),
        tension: tensions.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max),
        strongest: exact.tensions.iter().fold(0.0, |max, t| t.abs().max(max)),
        turn: exact.rotation().angle_to(&other.rotation()),
        strain: reduced.chain.as_ref().map_or(0.0, |chain| chain.strain_of(found.state())),
    }
}

fn summary(
    compared: &[Compared],
    refused: [usize; 2],
    options: &ValidationOptions,
    length: f64,
) -> Validation {
    let strongest = compared.iter().map(|at| at.strongest).fold(f64::MIN_POSITIVE, f64::max);
    let spread = |of: &dyn Fn(&Compared) -> f64| ErrorSpread::new(compared.iter().map(of).collect());
    Validation {
        count: compared.len(),
        refused,
        stroke: options.stroke,
        tension: options.tension,
        seed: options.seed,
        tip: spread(&|at| at.tip / at.moved.max(LEAST_SHARE * length)),
        tensions: spread(&|at| at.tension / at.strongest.max(LEAST_SHARE * strongest)),
        turn: spread(&|at| at.turn),
        strain: compared.iter().map(|at| at.strain).fold(0.0, f64::max),
    }
}

/// Random targets number `k`, the same in every run.
fn targets(twin: &Twin, options: &ValidationOptions, k: usize) -> Vec<Target> {
    let mut rng = hysteron_base::rng(options.seed, &format!("chain/validation/{k}"));
    (0..twin.tendons.len())
        .map(|j| {
            let tendon = &twin.tendons[j];
            let part: f64 = rng.random_range(-1.0..1.0);
            match TendonDrive::of(twin, j) {
                TendonDrive::Stroke => Target::Stroke(tendon.stroke.clamp(options.stroke * part)),
                TendonDrive::Tension => Target::Tension(tendon.tension.clamp(options.tension * part)),
                TendonDrive::Resting => tendon.resting_target(),
            }
        })
        .collect()
}

/// Targets at part `t` of the way.
fn mix(from: &[Target], to: &[Target], t: f64) -> Vec<Target> {
    let between = |(from, to): (&Target, &Target)| match (*from, *to) {
        (Target::Stroke(a), Target::Stroke(b)) => Target::Stroke(a + t * (b - a)),
        (Target::Tension(a), Target::Tension(b)) => Target::Tension(a + t * (b - a)),
        (_, to) => to,
    };
    from.iter().zip(to).map(between).collect()
}

#[cfg(test)]
mod tests {
    use hysteron_base::MaterialLaw;
    use hysteron_fem::Order;

    use super::*;
    use crate::scenes;

    #[test]
    fn errors_are_measured_where_they_are_and_steps_beyond_them_say_so() {
        let (scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, 24);
        let twin = Twin::new(&scene, &mesh).expect("a good scene");
        let mut chain = Chain::new(&twin).expect("a chain");
        let options = ValidationOptions { count: 4, stroke: 1e-3, tension: 0.0, seed: 3 };
        let exact = Equilibrium::all(&twin, &options).expect("good targets");
        chain.validate(&twin, &options, &exact).expect("good targets");
        let validation = chain.validation.clone().expect("a validation");
        assert_eq!((validation.count, validation.refused), (4, [0; 2]));
        for spread in [validation.tip, validation.tensions, validation.turn] {
            // A turn by 13 degrees in 40 mm at most: what is left out is of fourth order.
            assert!(spread.median > 0.0 && spread.largest < 1e-3, "{validation:?}");
            assert!(spread.median <= spread.percentile_99 && spread.percentile_99 <= spread.largest);
        }
        let mut again = Chain::new(&twin).expect("a chain");
        again.validate(&twin, &options, &exact).expect("good targets");
        assert_eq!(again.validation, chain.validation);
        let missing: Vec<_> = exact.iter().skip(1).cloned().chain([None]).collect();
        again.validate(&twin, &options, &missing).expect("good targets");
        let other = again.validation.expect("a validation");
        // Equilibria of other targets are no match.
        assert_eq!((other.count, other.refused), (3, [1, 0]));
        assert!(other.tip.median > 0.1);
        let reduced = twin.clone().with_chain(chain);
        let mut stepper = Stepper::new(&reduced);
        let mut outside = |stroke: f64| {
            let targets = [stroke, 0.0, -stroke, 0.0].map(Target::Stroke);
            stepper.step(&reduced, &targets).expect("an equilibrium").outside
        };
        assert_eq!(outside(1e-4), 0.0);
        let beyond = outside(3e-3);
        assert!((0.25..5.0).contains(&beyond), "{beyond}");
    }
}
