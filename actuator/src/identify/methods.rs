//! A law of friction by each of the methods in use: least squares, populations, and fuzzy networks to whose curve the law is fitted.
//!
//! # Reference
//! Wan et al. (2026), section 2.3: ANFIS, FNN, PSO and least squares on the same torques at constant speeds.

use std::sync::Mutex;

use hysteron_base::BadInput;
use hysteron_fit::{Consequents, FuzzyNetwork, GlobalMethod, GlobalOptions, search_globally};

use super::friction::{Neighbours, Regression};
use crate::law::Law;

/// How a law is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrictionMethod {
    /// Nonlinear least squares from several starts.
    LeastSquares,
    /// Particle swarms on the root mean square error.
    ParticleSwarm,
    /// Differential evolution on the same.
    DifferentialEvolution,
    /// A fuzzy network with lines as consequents for each direction, then the law by least squares of its curve.
    Anfis,
    /// The same with constants as consequents.
    FuzzyNetwork,
}

/// A law as a method found it.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodFit {
    /// Values of the law's parameters.
    pub parameters: Vec<f64>,
    /// Offset of the torque beyond friction [N m].
    pub offset: f64,
    /// Root mean square error over the iterations: by evaluation, generation or pass [N m].
    pub progress: Vec<f64>,
}

/// Members of a population for each parameter, and generations.
const MEMBERS: usize = 10;
const GENERATIONS: usize = 300;
/// Speeds of each direction at which the curve of a network is sampled, and fewest that it is fitted to.
const SAMPLES: usize = 100;
const MIN_SPEEDS: usize = 10;

impl FrictionMethod {
    /// Every method, and its name.
    pub const ALL: [(Self, &str); 5] = [
        (Self::LeastSquares, "least-squares"),
        (Self::ParticleSwarm, "pso"),
        (Self::DifferentialEvolution, "de"),
        (Self::Anfis, "anfis"),
        (Self::FuzzyNetwork, "fnn"),
    ];

    /// The method of that name.
    ///
    /// # Errors
    /// `BadInput` with the names there are.
    pub fn named(name: &str) -> Result<Self, BadInput> {
        Self::ALL.iter().find(|(_, known)| *known == name).map(|(method, _)| *method).ok_or_else(|| {
            let names: Vec<&str> = Self::ALL.iter().map(|(_, name)| *name).collect();
            BadInput::new("method", format!("one of {}", names.join(", ")), format!("{name:?}"))
        })
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(method, _)| *method == self).map_or("", |(_, name)| name)
    }
}

/// Finds the parameters of `law`, and an offset where it has none of its own, in `torque` [N m] at `velocity` [rad/s] (n_samples
/// each) by `method`. All draws come from `seed`.
///
/// # Errors
/// Those of [`super::identify_friction`]; a network needs ten samples of each direction.
pub fn identify_friction_by(
    method: FrictionMethod,
    law: &Law,
    velocity: &[f64],
    torque: &[f64],
    seed: u64,
) -> Result<MethodFit, BadInput> {
    let problem = Regression::new(law, [velocity, torque], Neighbours::ErrAlike)?;
    let heard = Mutex::new(Vec::new());
    let watch = |_: usize, error: f64| {
        // A lock that a panic has poisoned is another's business.
        heard.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push(error);
        true
    };
    let population = |method| -> Result<Vec<f64>, BadInput> {
        let options = GlobalOptions {
            method,
            members_per_parameter: MEMBERS,
            generations: GENERATIONS,
            spread: 0.0,
            seed,
            watch: &watch,
        };
        let cost = |values: &[f64]| Ok::<_, BadInput>(rms(&problem.errors(values)));
        Ok(search_globally(&problem.parameters(0.5), &options, cost)?.values)
    };
    let values = match method {
        FrictionMethod::LeastSquares => {
            let found = problem.least_squares(None, &watch)?;
            return Ok(MethodFit {
                parameters: found.parameters,
                offset: found.offset,
                progress: heard.into_inner().unwrap_or_default(),
            });
        }
        FrictionMethod::ParticleSwarm => population(GlobalMethod::SWARMS)?,
        FrictionMethod::DifferentialEvolution => population(GlobalMethod::EVOLUTION)?,
        FrictionMethod::Anfis => return by_networks(Consequents::Lines, &problem),
        FrictionMethod::FuzzyNetwork => return by_networks(Consequents::Constants, &problem),
    };
    let (parameters, offset) = problem.split(values);
    Ok(MethodFit { parameters, offset, progress: heard.into_inner().unwrap_or_default() })
}

/// Each direction has its network: none of five rules follows the jump at standstill.
fn by_networks(consequents: Consequents, problem: &Regression) -> Result<MethodFit, BadInput> {
    let (mut curve_velocity, mut curve_torque) = (Vec::new(), Vec::new());
    let mut squares: Vec<f64> = Vec::new();
    for (sign, direction) in [(1.0, "forward"), (-1.0, "reverse")] {
        let pairs = problem.velocity.iter().zip(problem.torque).filter(|(v, _)| *v * sign > 0.0);
        let pairs: Vec<(f64, f64)> = pairs.map(|(v, torque)| (v * sign, torque * sign)).collect();
        if pairs.len() < MIN_SPEEDS {
            let expected = format!("{MIN_SPEEDS} or more samples of each direction");
            let found = format!("{} {direction}", pairs.len());
            return Err(BadInput::new("speed", expected, found).hint("record both directions"));
        }
        let range = pairs.iter().fold([f64::MAX, 0.0], |[a, b]: [f64; 2], (v, _)| [a.min(*v), b.max(*v)]);
        let mut network = FuzzyNetwork::new(consequents, [0.0, range[1]], &pairs);
        let errors = network.fit(&pairs);
        squares.resize(errors.len(), 0.0);
        let share = pairs.len() as f64 / problem.velocity.len() as f64;
        squares.iter_mut().zip(errors).for_each(|(sum, error)| *sum += share * error * error);
        for k in 0..SAMPLES {
            let v = range[0] + (range[1] - range[0]) * k as f64 / (SAMPLES - 1) as f64;
            curve_velocity.push(sign * v);
            curve_torque.push(sign * network.at(v));
        }
    }
    let curve = Regression::new(problem.law, [&curve_velocity, &curve_torque], Neighbours::AreIndependent)?;
    let found = curve.least_squares(None, &|_, _| true)?;
    Ok(MethodFit {
        parameters: found.parameters,
        offset: found.offset,
        progress: squares.into_iter().map(f64::sqrt).collect(),
    })
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}
