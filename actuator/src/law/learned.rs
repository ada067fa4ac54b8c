//! Friction as a map fitted to data: any shape over speed, and over the torque through the gear.

use std::borrow::Cow;

use hysteron_base::BadInput;

use super::{Budget, JointFriction, LawParameter, Sliding, torque};
use crate::number::Real;

/// Fewest and most knots of speed that are laid through data.
const KNOTS: usize = 6;

/// Variables along which a [`LearnedMap`] must not fall.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Monotonicity {
    /// Nothing.
    Nowhere,
    /// The speed: no Stribeck effect.
    WithSpeed,
    /// The torque through the gear.
    WithLoad,
    /// Both.
    WithBoth,
}

/// Friction over the size of the speed and of the torque |τ_l - τ_m| through the gear, as a product of quadratic B-splines; its parameters are
/// their weights, or, of a rising map, by how much each weight is above the greatest of its neighbours before. It is smooth, lies between the least and the largest weight, rises where the weights do, and is constant beyond the
/// outer knots. All of it counts as dry: a viscous part is a slope like any other.
///
/// # Reference
/// de Boor (1978), A practical guide to splines, chapters IX and XI.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnedMap {
    /// Knots of the speed, ascending, two or more [rad/s].
    speeds: Vec<f64>,
    /// Knots of the torque through the gear, ascending; none where friction does not depend on it [N m].
    loads: Vec<f64>,
    monotonicity: Monotonicity,
}

impl LearnedMap {
    /// A map with these knots; without `loads` of the speed alone.
    ///
    /// # Errors
    /// `BadInput` for fewer than two knots, negative or not finite ones, or knots that do not ascend.
    pub fn new(speeds: Vec<f64>, loads: Vec<f64>) -> Result<Self, BadInput> {
        for (name, knots) in [("knots of the speed", &speeds), ("knots of the load", &loads)] {
            let may_be_none = knots.is_empty() && name.ends_with("load");
            let ascend =
                knots.windows(2).all(|pair| pair[0] < pair[1]) && knots.iter().all(|x| x.is_finite());
            if !(may_be_none || knots.len() >= 2 && ascend && knots[0] >= 0.0) {
                let expected = "two or more finite numbers from 0 on, ascending";
                return Err(BadInput::new(name, expected, format!("{knots:?}")));
            }
        }
        Ok(Self { speeds, loads, monotonicity: Monotonicity::Nowhere })
    }

    /// The same, which does not fall along `rising`: its parameters then are increments, none of them negative, and every map that
    /// does not fall at its weights can be had.
    pub fn monotone(self, monotonicity: Monotonicity) -> Self {
        Self { monotonicity, ..self }
    }

    /// Weights of the splines, by speed and then by load, from the parameters [N m].
    pub fn weights<'p, T: Real>(&self, p: &'p [T]) -> Cow<'p, [T]> {
        let with_speed = matches!(self.monotonicity, Monotonicity::WithSpeed | Monotonicity::WithBoth);
        let with_load = matches!(self.monotonicity, Monotonicity::WithLoad | Monotonicity::WithBoth);
        if !(with_speed || with_load) {
            return Cow::Borrowed(p);
        }
        let n_loads = self.n_loads();
        let mut weights = p.to_vec();
        for k in 0..weights.len() {
            let slower = (with_speed && k >= n_loads).then(|| weights[k - n_loads]);
            let lighter = (with_load && !k.is_multiple_of(n_loads)).then(|| weights[k - 1]);
            let before = match (slower, lighter) {
                (Some(a), Some(b)) => Some(if a.value() >= b.value() { a } else { b }),
                (one, other) => one.or(other),
            };
            weights[k] = before.map_or(p[k], |before| before + p[k]);
        }
        Cow::Owned(weights)
    }

    /// A map of the speed alone, with as many samples of `velocity` [rad/s] between any two knots.
    ///
    /// # Errors
    /// `BadInput` where the speeds do not differ.
    pub fn of_speeds(velocity: &[f64]) -> Result<Self, BadInput> {
        let mut sizes: Vec<f64> = velocity.iter().map(|v| v.abs()).filter(|v| *v > 0.0).collect();
        sizes.sort_by(f64::total_cmp);
        let Some(last) = sizes.len().checked_sub(1) else {
            return Err(BadInput::new("speed", "motion", "none"));
        };
        let mut knots: Vec<f64> = (0..KNOTS).map(|k| sizes[k * last / (KNOTS - 1)]).collect();
        knots.dedup();
        Self::new(knots, Vec::new())
            .map_err(|_| BadInput::new("speed", "speeds that differ", format!("{} rad/s alone", sizes[0])))
    }

    /// Weights of the torques through the gear: one where friction does not depend on them.
    fn n_loads(&self) -> usize {
        if self.loads.is_empty() { 1 } else { self.loads.len() + 1 }
    }
}

impl JointFriction for LearnedMap {
    fn parameters(&self) -> Vec<LawParameter> {
        let n_loads = self.n_loads();
        let of = |k: usize| {
            let (speed, load) = (k / n_loads + 1, k % n_loads + 1);
            let map = if self.monotonicity == Monotonicity::Nowhere { "map" } else { "map_rise" };
            let name = match n_loads {
                1 => format!("{map}_{speed}_n_m"),
                _ => format!("{map}_{speed}_{load}_n_m"),
            };
            LawParameter { name: name.into(), ..torque("") }
        };
        (0..(self.speeds.len() + 1) * n_loads).map(of).collect()
    }

    fn budget<T: Real>(&self, p: &[T], at: &Sliding<T>) -> Budget<T> {
        let n_loads = self.n_loads();
        let (row, by_speed) = basis(&self.speeds, at.velocity.abs());
        let through = (at.load_torque - at.motor_torque).abs();
        let zero = T::from(0.0);
        let (column, by_load) = match n_loads {
            1 => (0, [T::from(1.0), zero, zero]),
            _ => basis(&self.loads, through),
        };
        let weights = self.weights(p);
        let mut dry = zero;
        for (i, by_speed) in by_speed.into_iter().enumerate() {
            for (j, by_load) in by_load.into_iter().enumerate().take(n_loads) {
                dry = dry + weights[(row + i) * n_loads + column + j] * by_speed * by_load;
            }
        }
        Budget { dry, viscous: zero }
    }
}

/// Number of the first of three quadratic B-splines that are not zero at `x`, and their values; `x` is taken into the knots.
fn basis<T: Real>(knots: &[f64], x: T) -> (usize, [T; 3]) {
    let last = knots.len() - 1;
    let x = match x.value() {
        value if value <= knots[0] => T::from(knots[0]),
        value if value >= knots[last] => T::from(knots[last]),
        _ => x,
    };
    let k = (knots.partition_point(|knot| *knot <= x.value()).max(1) - 1).min(last - 1);
    // The outer knots count three times.
    let [before, low, high, after] =
        [k.saturating_sub(1), k, k + 1, (k + 2).min(last)].map(|knot| knots[knot]);
    let share = |from: f64, to: f64| (x - T::from(from)) / T::from(to - from);
    let one = T::from(1.0);
    let (near, wide, next) = (share(low, high), share(before, high), share(low, after));
    let values = [(one - wide) * (one - near), wide * (one - near) + (one - next) * near, next * near];
    (k, values)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;
    use crate::friction::Stribeck;
    use crate::identify::identify_friction;
    use crate::law::{Law, LoadDependent};
    use hysteron_base::Bounds;
    use hysteron_fit::{Fit, Options, Parameter, ParameterScale, TOLERANCE, least_squares};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn splines_sum_to_one_and_reproduce_a_line() {
        let knots = [0.1, 0.3, 1.0, 1.5];
        // A line is the spline whose weights are the means of neighbouring knots (Greville).
        let greville = [0.1, 0.2, 0.65, 1.25, 1.5];
        for x in [0.1, 0.12, 0.3, 0.77, 1.2, 1.5] {
            let (k, values) = basis(&knots, x);
            assert!((values.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            let line: f64 = values.iter().zip(&greville[k..]).map(|(b, g)| b * g).sum();
            assert!((line - x).abs() < 1e-14, "{x}: {line}");
        }
        assert_eq!(basis(&knots, 9.0), basis(&knots, 1.5));
    }

    /// Torques of Stribeck's law with noise.
    fn measured(law: &Stribeck, seed: u64) -> [Vec<f64>; 2] {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let speed = |rng: &mut ChaCha8Rng| {
            let v: f64 = rng.random_range(0.02..2.0);
            if rng.random_range(0.0..1.0) < 0.5 { -v } else { v }
        };
        let velocity: Vec<f64> = (0..3000).map(|_| speed(&mut rng)).collect();
        let torque = velocity.iter().map(|v| law.torque(*v) + rng.random_range(-0.02..0.02)).collect();
        [velocity, torque]
    }

    #[test]
    fn a_map_learns_a_stribeck_curve_and_its_slope() {
        let truth = Stribeck::new(0.4, 0.55, 0.5, 0.2).unwrap();
        let [velocity, torque] = measured(&truth, 3);
        let law = LearnedMap::of_speeds(&velocity).unwrap();
        let found = identify_friction(&Law::LearnedMap(law.clone()), &velocity, &torque, None).unwrap();
        for k in 0..=18 {
            let v = 0.1 + 0.1 * f64::from(k);
            let at = Sliding::at(v);
            let error = law.torque(&found.parameters, &at) - truth.torque(v);
            // Seven weights from 3000 samples with a noise of 0.0115: 6e-4; the spline bends where Stribeck's law does to 4e-3.
            assert!(error.abs() < 5e-3, "{v}: {error}");
            if (3..=16).contains(&k) {
                let x = v / truth.stribeck_velocity;
                let slope = truth.viscous - 0.15 * 2.0 * x / truth.stribeck_velocity * (-x * x).exp();
                let error = law.by_velocity(&found.parameters, &at) - slope;
                assert!(error.abs() < 0.06, "{v}: slope {error}");
            }
        }
        // Standard errors are those of the noise: as far as the curve is a spline, weights scatter within them.
        let other = measured(&truth, 4);
        let again = identify_friction(&Law::LearnedMap(law), &other[0], &other[1], None).unwrap();
        let off = found.fit.estimates.iter().zip(&again.fit.estimates).filter(|(a, b)| {
            let error = a.standard_error.unwrap().hypot(b.standard_error.unwrap());
            (a.value - b.value).abs() > 3.0 * error
        });
        assert_eq!(off.count(), 0);
    }

    /// The map whose torques at `states` are nearest to `torque` [N m] (n_samples each), where torques through the gear differ too.
    fn fitted(map: &LearnedMap, states: &[Sliding], torque: &[f64]) -> Fit {
        let largest = torque.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        let of = |p: LawParameter| {
            let bounds = Bounds { min: largest * p.bounds[0], max: largest * p.bounds[1] };
            let start = 0.15 * bounds.max;
            Parameter { name: p.name.into_owned(), start, bounds, scale: ParameterScale::Linear, prior: None }
        };
        let parameters: Vec<Parameter> = map.parameters().into_iter().map(of).collect();
        let options = Options {
            huber: None,
            smallest_effect: 1e-5 * largest,
            n_nuisance: 0,
            tolerance: TOLERANCE,
            watch: &|_, _| true,
        };
        let residuals = |p: &[f64]| {
            let errors = states.iter().zip(torque).map(|(at, torque)| map.torque(p, at) - torque);
            Ok::<_, BadInput>(vec![errors.collect()])
        };
        least_squares(&parameters, &options, residuals).unwrap()
    }

    #[test]
    fn a_map_of_speed_and_load_learns_friction_that_grows_with_the_load() {
        let truth = (LoadDependent::named("m3").unwrap(), [0.1, 0.05, 0.2]);
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let at = |rng: &mut ChaCha8Rng| Sliding {
            velocity: rng.random_range(-2.0..2.0),
            motor_torque: rng.random_range(-1.0..1.0),
            load_torque: rng.random_range(-1.0..1.0),
        };
        let states: Vec<Sliding> = (0..6000).map(|_| at(&mut rng)).collect();
        let noise = |rng: &mut ChaCha8Rng| rng.random_range(-0.01..0.01);
        let torque: Vec<f64> =
            states.iter().map(|at| truth.0.torque(&truth.1, at) + noise(&mut rng)).collect();
        let map = LearnedMap::new(vec![0.0, 0.7, 2.0], vec![0.0, 0.8, 2.0]).unwrap();
        let found = fitted(&map, &states, &torque).values();
        for load_torque in [0.2, 0.6, 0.9] {
            for velocity in [-1.5, 0.3, 1.8] {
                let at = Sliding { velocity, motor_torque: -0.3, load_torque };
                let error = map.torque(&found, &at) - truth.0.torque(&truth.1, &at);
                // Lines in both are such a map exactly; 16 weights from 6000 samples with a noise of 0.006.
                assert!(error.abs() < 3e-3, "{at:?}: {error}");
            }
        }
    }

    #[test]
    fn a_rising_map_does_not_follow_noise_downwards() {
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let truth = |v: f64| 0.3 + 0.2 * v.tanh();
        let velocity: Vec<f64> = (0..60).map(|k| 0.05 * f64::from(k + 1)).collect();
        let torque: Vec<f64> = velocity.iter().map(|v| truth(*v) + rng.random_range(-0.1..0.1)).collect();
        let fitted = |monotonicity: Monotonicity| {
            let map = LearnedMap::of_speeds(&velocity).unwrap().monotone(monotonicity);
            let law = Law::LearnedMap(map.clone());
            let found = identify_friction(&law, &velocity, &torque, None).unwrap();
            let curve: Vec<f64> = (velocity.iter())
                .map(|v| map.torque(&found.parameters, &Sliding::at(*v)) + found.offset)
                .collect();
            let square: f64 = velocity.iter().zip(&curve).map(|(v, f)| (f - truth(*v)).powi(2)).sum();
            (curve.windows(2).all(|pair| pair[1] >= pair[0] - 1e-12), square)
        };
        let [free, monotone] = [Monotonicity::Nowhere, Monotonicity::WithSpeed].map(fitted);
        assert!(!free.0 && monotone.0, "{free:?} {monotone:?}");
        assert!(monotone.1 < free.1, "{free:?} {monotone:?}");
    }

    #[test]
    fn where_the_truth_rises_a_rising_map_is_the_free_one() {
        // Concave in the sum of both: it rises along both, and its slope along one falls with the other.
        let truth = |v: f64, load: f64| 0.1 + 0.2 * (v + load) / (1.0 + 0.5 * (v + load));
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let (mut states, mut torque) = (Vec::new(), Vec::new());
        for _ in 0..6000 {
            let (v, load): (f64, f64) = (rng.random_range(0.0..2.0), rng.random_range(0.0..2.0));
            let sign = if rng.random_range(0.0..1.0) < 0.5 { -1.0 } else { 1.0 };
            states.push(Sliding { velocity: sign * v, motor_torque: load, load_torque: 0.0 });
            torque.push(sign * truth(v, load) + rng.random_range(-0.01..0.01));
        }
        let free = LearnedMap::new(vec![0.0, 0.7, 2.0], vec![0.0, 0.8, 2.0]).unwrap();
        let maps = [Monotonicity::Nowhere, Monotonicity::WithLoad, Monotonicity::WithBoth]
            .map(|r| free.clone().monotone(r));
        let weights = maps.each_ref().map(|map| {
            let found = fitted(map, &states, &torque);
            assert!(found.estimates[0].name.starts_with("map"), "{}", found.estimates[0].name);
            map.weights(&found.values()).into_owned()
        });
        let errors = [1, 2]
            .map(|k| weights[k].iter().zip(&weights[0]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max));
        // The same minimum, to the tolerance of the searches, a thousandth of the noise of the weights at the corners.
        assert!(errors.iter().all(|error| *error < 2e-3), "{errors:?}");
    }

    #[test]
    fn knots_that_cannot_be_are_refused() {
        for knots in [vec![], vec![1.0], vec![0.0, 1.0, 1.0], vec![-1.0, 1.0], vec![0.0, f64::NAN]] {
            let bad = LearnedMap::new(knots.clone(), Vec::new()).unwrap_err();
            assert_eq!(bad.place, "knots of the speed", "{knots:?}");
            let of_loads = LearnedMap::new(vec![0.0, 1.0], knots.clone()).err().map(|bad| bad.place);
            let refused = (!knots.is_empty()).then_some("knots of the load");
            assert_eq!(of_loads.as_deref(), refused, "{knots:?}");
        }
        assert_eq!(LearnedMap::of_speeds(&[0.4, -0.4]).unwrap_err().place, "speed");
        assert_eq!(LearnedMap::of_speeds(&[0.0]).unwrap_err().place, "speed");
    }
}
