//! The minimum of a cost anywhere between the bounds: differential evolution and particle swarm. Only this module knows
//! `basin`.
//!
//! Both draw from a seed alone and evaluate a generation in parallel, so the outcome does not depend on the number of
//! threads.
//!
//! # Reference
//! Storn and Price (1997), differential evolution; Kennedy and Eberhart (1995), particle swarm optimisation.

use std::sync::atomic::{AtomicBool, Ordering};

use basin::{
    BoxBounds, ConstraintSet, ConstraintSolveError, Constraints, CostFunction, De, DeMutation, Executor,
    GlobalBestPso, PopulationProgress, PsoBoundaryHandling, Solver, State, StepOutcome,
};

use hysteron_base::BadInput;

use crate::evaluation_error::{Erased, EvaluationError, aside};
use crate::{Failure, Parameter};

/// How a population is moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GlobalMethod {
    /// Best member plus a weighted difference of two others, binomial crossover (DE/best/1/bin).
    DifferentialEvolution {
        /// Weight of the difference, above 0 [-].
        weight: f64,
        /// Probability that a coordinate is taken from the donor, 0 to 1 [-].
        crossover: f64,
    },
    /// Inertia-weight swarms about their best particles, with the coefficients of Standard PSO 2006, one after the other; together they have
    /// the evaluations of one swarm of all members.
    ParticleSwarm {
        /// How many: a swarm that has come together finds nothing else, so several small ones find more of many minima.
        swarms: usize,
        /// Part of a particle's speed that it has after a bound has thrown it back, 0 to 1 [-].
        restitution: f64,
    },
}

impl GlobalMethod {
    /// Differential evolution with weight 0.7 and crossover 0.9.
    pub const EVOLUTION: Self = Self::DifferentialEvolution { weight: 0.7, crossover: 0.9 };

    /// One swarm, whose particles stop at bounds.
    pub const SWARM: Self = Self::ParticleSwarm { swarms: 1, restitution: 0.0 };

    /// Ten swarms of two members for each ten, whose particles come back from bounds with half their speed.
    pub const SWARMS: Self = Self::ParticleSwarm { swarms: 10, restitution: 0.5 };
}

/// When and how long to search.
pub struct GlobalOptions<'a> {
    /// How the population is moved.
    pub method: GlobalMethod,
    /// Members for each parameter.
    pub members_per_parameter: usize,
    /// Most generations.
    pub generations: usize,
    /// Difference of the costs of a population, relative to the best, below which the search has converged [-].
    pub spread: f64,
    /// Seed of all draws.
    pub seed: u64,
    /// Called with the generation and the best cost; false ends the search.
    pub watch: &'a (dyn Fn(usize, f64) -> bool + Sync),
}

/// The outcome.
#[derive(Debug, Clone, PartialEq)]
pub struct GlobalSearch {
    /// Best values found, in the order of the parameters [SI].
    pub values: Vec<f64>,
    /// Their cost; infinite where it has no value anywhere that was looked at.
    pub cost: f64,
    /// Generations passed.
    pub generations: usize,
    /// Evaluations of the cost.
    pub evaluations: usize,
    /// True if the costs of the population came together.
    pub is_converged: bool,
}

/// Stands for the cost where there is none: `basin` stops the program where no member of a population has a finite one.
const NO_VALUE: f64 = f64::MAX;

/// A cost over places between bounds, 0 to 1 each.
struct UnitCubeCost<'a> {
    parameters: &'a [Parameter],
    cost: Erased<'a, f64>,
    bounds: [Vec<f64>; 2],
}

impl UnitCubeCost<'_> {
    /// The same problem.
    fn again(&self) -> Self {
        Self { parameters: self.parameters, cost: self.cost, bounds: self.bounds.clone() }
    }

    fn values(&self, places: &[f64]) -> Vec<f64> {
        self.parameters.iter().zip(places).map(|(parameter, place)| parameter.value(*place)).collect()
    }
}

impl Constraints for UnitCubeCost<'_> {
    type Set = ConstraintSet<BoxBounds<Vec<f64>>>;

    fn constraints(&self) -> <Self::Set as basin::ConstraintDescription>::Borrowed<'_> {
        let [low, high] = &self.bounds;
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(low), Some(high)))
    }
}

impl CostFunction for UnitCubeCost<'_> {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = EvaluationError;

    /// Where the cost has no value it is [`NO_VALUE`].
    fn cost(&self, places: &Vec<f64>) -> Result<f64, EvaluationError> {
        match (self.cost)(&self.values(places)) {
            Err(error) if error.is_local() => Ok(NO_VALUE),
            Ok(cost) if cost.is_nan() => Ok(NO_VALUE),
            found => found.map(|cost| cost.min(NO_VALUE)),
        }
    }
}

/// Searches the minimum of `cost` between the bounds of `parameters`; their starts do not count.
///
/// # Errors
/// Bounds that are none; those of `cost` that are not local.
pub fn search_globally<F, E>(
    parameters: &[Parameter],
    options: &GlobalOptions,
    cost: F,
) -> Result<GlobalSearch, E>
where
    F: Fn(&[f64]) -> Result<f64, E> + Sync,
    E: Failure,
{
    aside(cost, |cost| searched(parameters, options, cost))
}

fn searched(
    parameters: &[Parameter],
    options: &GlobalOptions,
    cost: Erased<f64>,
) -> Result<GlobalSearch, EvaluationError> {
    parameters.iter().try_for_each(Parameter::check)?;
    let n = parameters.len();
    if n == 0 {
        return Ok(GlobalSearch {
            values: vec![],
            cost: cost(&[])?,
            generations: 0,
            evaluations: 1,
            is_converged: true,
        });
    }
    let problem = UnitCubeCost { parameters, cost, bounds: [vec![0.0; n], vec![1.0; n]] };
    let members = (n * options.members_per_parameter).max(6);
    match options.method {
        GlobalMethod::DifferentialEvolution { weight, crossover } => {
            let solver = De::new(options.seed)
                .with_mutation(DeMutation::Best1)
                .with_f(weight)
                .with_cr(crossover)
                .with_pop_size(members);
            evolve(problem, solver, options)
        }
        GlobalMethod::ParticleSwarm { swarms, restitution } => {
            let own = (2 * members / swarms.max(1)).clamp(6, members);
            let generations = (options.generations * members / (own * swarms.max(1))).max(1);
            let mut best: Option<GlobalSearch> = None;
            for swarm in 0..swarms.max(1) as u64 {
                let before =
                    best.as_ref().map_or((0, f64::INFINITY), |found| (found.generations, found.cost));
                let is_ended = AtomicBool::new(false);
                let watch = |generation: usize, cost: f64| {
                    let continues = (options.watch)(before.0 + generation, cost.min(before.1));
                    is_ended.store(!continues, Ordering::Relaxed);
                    continues
                };
                let seed = options.seed.wrapping_add(swarm.wrapping_mul(NEXT_SEED));
                let solver = GlobalBestPso::<Vec<f64>>::new(seed)
                    .with_swarm_size(own)
                    .with_boundary_handling(PsoBoundaryHandling::Reflect { damping: restitution });
                let found = evolve(
                    problem.again(),
                    solver,
                    &GlobalOptions { generations, watch: &watch, ..*options },
                )?;
                best = Some(best.map_or(found.clone(), |before| before.or_better(found)));
                if is_ended.load(Ordering::Relaxed) {
                    break;
                }
            }
            best.ok_or_else(|| BadInput::new("swarms", "one or more", "none").into())
        }
    }
}

/// Between the seeds of one swarm and the next: the golden ratio's bits, which no two small seeds differ by.
const NEXT_SEED: u64 = 0x9e37_79b9_7f4a_7c15;

impl GlobalSearch {
    /// The better of two, with the effort of both.
    fn or_better(self, other: Self) -> Self {
        let [generations, evaluations] =
            [self.generations + other.generations, self.evaluations + other.evaluations];
        let best = if other.cost < self.cost { other } else { self };
        Self { generations, evaluations, ..best }
    }
}

fn evolve<S>(
    problem: UnitCubeCost,
    solver: S,
    options: &GlobalOptions,
) -> Result<GlobalSearch, EvaluationError>
where
    for<'a> S:
        Solver<UnitCubeCost<'a>, PopulationProgress<Vec<f64>>, Error = ConstraintSolveError<EvaluationError>>,
{
    let parameters = problem.parameters;
    let members =
        Executor::new(problem, solver, PopulationProgress::empty()).max_iter(options.generations as u64);
    let mut members = members.into_stepper().map_err(evaluation)?;
    let mut is_converged = false;
    while !is_converged && matches!(members.step().map_err(evaluation)?, StepOutcome::Continue) {
        let state = members.state();
        let (worst, best) = (state.costs().iter().copied().fold(0.0, f64::max), state.best_cost());
        is_converged = best < NO_VALUE && worst - best <= options.spread * best.abs();
        if !(options.watch)(state.iter() as usize, best) {
            break;
        }
    }
    let state = members.state();
    let cost = if state.best_cost() < NO_VALUE { state.best_cost() } else { f64::INFINITY };
    Ok(GlobalSearch {
        values: parameters.iter().zip(state.best_param()).map(|(p, place)| p.value(*place)).collect(),
        cost,
        generations: state.iter() as usize,
        evaluations: members.counts().cost_evals as usize,
        is_converged,
    })
}

fn evaluation(error: ConstraintSolveError<EvaluationError>) -> EvaluationError {
    match error {
        ConstraintSolveError::Evaluation(error) => error,
        // The bounds are ours: from 0 to 1.
        _ => BadInput::new("bounds", "an interval for each parameter", "one that is none").into(),
    }
}
