//! How well a chain follows the finite elements that it was made from: equilibria of both under the same random targets.

use rand::RngExt;

use super::body::Chain;
use super::errors::{ErrorSpread, Validation};
use crate::coreact::distance;
use crate::model::{Target, Twin};
use crate::stepper::Stepper;
use crate::{Error, Result};

/// Displacements and tensions below which errors are not relative any more: of the body's length, and of the strongest tension.
const LEAST_SHARE: f64 = 0.025;
/// Steps from one equilibrium to the next where friction makes the way matter.
const WALK: usize = 60;

/// Targets of a validation.
#[derive(Debug, Clone, Copy, PartialEq)]
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
    /// Compares equilibria under random targets with those of the finite elements, and keeps the errors. `heard` is told after
    /// each; the answer is false to stop early.
    ///
    /// # Errors
    /// Targets that the twin refuses.
    pub fn validate(
        &mut self,
        twin: &Twin,
        options: &ValidationOptions,
        mut heard: impl FnMut(usize) -> bool,
    ) -> Result<()> {
        self.validation = None;
        let (fine_twin, coarse_twin) =
            (Twin { chain: None, ..twin.clone() }, twin.clone().with_chain(self.clone()));
        let fresh = || (Stepper::new(&fine_twin), Stepper::new(&coarse_twin));
        let (mut fine, mut coarse) = fresh();
        let mut compared = Vec::new();
        let mut refused = [0; 2];
        let mut from: Vec<Target> = twin.tendons.iter().map(|tendon| tendon.resting_target()).collect();
        for k in 0..options.count {
            let to = targets(twin, options, k);
            let steps = if twin.friction.is_empty() { 1 } else { WALK };
            let mut failed = [false; 2];
            for step in 1..=steps {
                let between = mix(&from, &to, step as f64 / steps as f64);
                failed[0] |= has_none(fine.step(&fine_twin, &between))?;
                failed[1] |= has_none(coarse.step(&coarse_twin, &between))?;
            }
            from = to;
            if failed[0] || failed[1] {
                refused[usize::from(!failed[0])] += 1;
                // Both go on from the same place.
                (fine, coarse) = fresh();
                from = twin.tendons.iter().map(|tendon| tendon.resting_target()).collect();
            } else {
                compared.push(compare((&fine_twin, &fine), (&coarse_twin, &coarse)));
            }
            if !heard(k + 1) {
                break;
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

fn compare((fine_twin, fine): (&Twin, &Stepper), (coarse_twin, coarse): (&Twin, &Stepper)) -> Compared {
    let (state, other) = (fine.state(), coarse.state());
    let tip = fine_twin.tip_of(state);
    let n = fine_twin.tendons.len();
    let tensions = state.tensions[..n].iter().zip(&other.tensions);
    Compared {
        tip: distance(tip, coarse_twin.tip_of(other)),
        moved: distance(tip, fine_twin.tip_of(&fine_twin.rest())),
        tension: tensions.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max),
        strongest: state.tensions[..n].iter().fold(0.0, |max, t| t.abs().max(max)),
        turn: fine_twin.tip_rotation_of(state).angle_to(&coarse_twin.tip_rotation_of(other)),
        strain: coarse_twin.chain.as_ref().map_or(0.0, |chain| chain.strain_of(other)),
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

/// True where a step has found no equilibrium.
fn has_none<T>(step: Result<T>) -> Result<bool> {
    match step {
        Ok(_) => Ok(false),
        Err(Error::NoEquilibrium { .. }) => Ok(true),
        Err(error) => Err(error),
    }
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
        let mut calls = 0;
        let heard = |k| {
            calls = k;
            true
        };
        chain.validate(&twin, &options, heard).expect("good targets");
        let validation = chain.validation.clone().expect("a validation");
        assert_eq!((calls, validation.count, validation.refused), (4, 4, [0; 2]));
        for spread in [validation.tip, validation.tensions, validation.turn] {
            // A turn by 13 degrees in 40 mm at most: what is left out is of fourth order.
            assert!(spread.median > 0.0 && spread.largest < 1e-3, "{validation:?}");
            assert!(spread.median <= spread.percentile_99 && spread.percentile_99 <= spread.largest);
        }
        let mut again = Chain::new(&twin).expect("a chain");
        again.validate(&twin, &options, |_| true).expect("good targets");
        assert_eq!(again.validation, chain.validation);
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
