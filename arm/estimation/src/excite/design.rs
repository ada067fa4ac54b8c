//! The exciting trajectory whose regressor has the smallest condition number, within all limits.

use hysteron_base::{BadInput, Bounds, rng};
use hysteron_fit::{GlobalMethod, GlobalOptions, Parameter, ParameterScale, search_globally};
use rand::RngExt as _;

use super::{Fourier, Information, MotionLimits, torque_use};
use hysteron_arm_dynamics::{Data, Model};

/// Times on which torques are checked at the end, for each sample of the search.
const FINER: usize = 5;
/// Reductions of amplitudes until torques keep their limits; each halves the interval.
const BISECTIONS: usize = 12;

/// How to search.
pub struct ExcitationOptions<'a> {
    /// Duration of the motion, after which it repeats [s].
    pub period: f64,
    /// Harmonics of the series, at least two.
    pub harmonics: usize,
    /// Most generations of the swarm.
    pub generations: usize,
    /// Seed of all random draws.
    pub seed: u64,
    /// Called with the generation and the best condition number; false ends the search.
    pub watch: &'a (dyn Fn(usize, f64) -> bool + Sync),
}

/// An exciting trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct Excitation {
    /// The motion.
    pub motion: Fourier,
    /// Parameters that torques can identify.
    pub n_parameters: usize,
    /// Condition number of their regressor over a drawn series within the same limits, before the search [-].
    pub condition_before: f64,
    /// And over the motion [-].
    pub condition: f64,
    /// Generations passed.
    pub generations: usize,
}

/// Searches the Fourier series of least condition number by particle swarm. The same robot, options and seed give the same
/// motion on any number of threads.
///
/// # Errors
/// `BadInput` for a period that is not positive, fewer than two harmonics, or limits within which no motion is found that
/// shows all parameters.
pub fn exciting_trajectory(
    model: &Model,
    limits: &MotionLimits,
    options: &ExcitationOptions,
) -> Result<Excitation, BadInput> {
    let shape = (options.period, options.harmonics);
    if !(options.period > 0.0 && options.period.is_finite()) {
        return Err(BadInput::new("period", "a finite time > 0 s", options.period.to_string()));
    }
    if !(2..=20).contains(&options.harmonics) {
        return Err(BadInput::new("harmonics", "2 to 20", options.harmonics.to_string()));
    }
    let information = Information::of(model, limits, options.seed);
    let n = Fourier::numbers_of_joint(options.harmonics);
    let parameters: Vec<Parameter> = (0..n * model.n_joints())
        .map(|k| Parameter {
            name: format!("number {k}"),
            start: 0.5,
            bounds: if k % n == 0 { Bounds { min: 0.0, max: 1.0 } } else { Bounds { min: -1.0, max: 1.0 } },
            scale: ParameterScale::Linear,
            prior: None,
        })
        .collect();
    let of = |numbers: &[f64]| {
        let mut data = Data::new(model, 0.0);
        let motion = within_torques(model, &mut data, Fourier::within(numbers, shape, limits), limits)?;
        let condition = information.condition(model, &mut data, &motion, motion.n_samples());
        Some((motion, condition))
    };
    let mut stream = rng(options.seed, "arm/excite/before");
    // The first series drawn that torques allow.
    let before = (0..100).find_map(|_| {
        let drawn: Vec<f64> =
            parameters.iter().map(|p| stream.random_range(p.bounds.min..p.bounds.max)).collect();
        of(&drawn)
    });
    let search = GlobalOptions {
        method: GlobalMethod::SWARM,
        members_per_parameter: 1,
        generations: options.generations,
        spread: 1e-6,
        seed: options.seed,
        watch: &|generation, cost| (options.watch)(generation, cost.exp()),
    };
    let cost = |numbers: &[f64]| {
        Ok::<f64, BadInput>(of(numbers).map_or(f64::INFINITY, |(_, condition)| condition.ln()))
    };
    let found = search_globally(&parameters, &search, cost)?;
    let (Some((_, condition_before)), Some((motion, condition))) = (before, of(&found.values)) else {
        return Err(no_motion("torques that hold the arm"));
    };
    if !condition.is_finite() {
        return Err(no_motion("a motion that shows all parameters"));
    }
    let n_parameters = information.n_parameters();
    Ok(Excitation { motion, n_parameters, condition_before, condition, generations: found.generations })
}

fn no_motion(expected: &str) -> BadInput {
    BadInput::new("limits", expected, "none within them")
        .hint("wider limits, a longer period, or more harmonics")
}

/// The motion with amplitudes reduced until torques keep their limits; `None` where gravity alone breaks them.
fn within_torques(
    model: &Model,
    data: &mut Data<f64>,
    motion: Fourier,
    limits: &MotionLimits,
) -> Option<Fourier> {
    let n_samples = FINER * motion.n_samples();
    let mut keeps = |factor: f64| torque_use(model, data, &motion.scaled(factor), limits, n_samples) <= 1.0;
    if keeps(1.0) {
        return Some(motion);
    }
    if !keeps(0.0) {
        return None;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if keeps(middle) { low = middle } else { high = middle }
    }
    Some(motion.scaled(low))
}
