//! A plan of any number of trajectories, each drawn when it is asked for: what a set made by many machines is planned with.
//!
//! A trajectory follows from the plan's seed and its own number alone, so every machine draws the same ones, and none holds more
//! than it works on. The trajectories are those of a [`MotionPlan`](super::MotionPlan) of the same file, in its order.

use std::collections::HashSet;

use hysteron_base::schema::parse;
use hysteron_base::{BadInput, file};

use super::convert::{self, PlanHead};
use super::draw::{check_draw, one};
use super::schema::{Draw, PlanFile, TrajectoryTable};
use super::{Space, StrokeLimits, Trajectory, TrajectoryRole};
use crate::Result;

/// Most trajectories of one draw; a set of 10¹² samples has fewer.
const MAX_COUNT: i64 = 1_000_000_000;

/// A plan whose trajectories are drawn one by one.
#[derive(Debug)]
pub struct LazyPlan {
    head: PlanHead,
    single: Vec<TrajectoryTable>,
    /// Each with its number of trajectories, and that of all before it, the single ones too.
    draws: Vec<(Draw, usize, usize)>,
    n_trajectories: usize,
}

impl LazyPlan {
    /// The plan in the text of a plan file; `place` names the file in messages. Trajectories are checked when they are drawn;
    /// [`LazyPlan::check`] checks all of them.
    ///
    /// # Errors
    /// `BadInput` naming the key.
    pub fn from_toml(text: &str, place: &str) -> Result<Self> {
        Ok(Self::parsed(text).map_err(|bad| bad.within(place))?)
    }

    fn parsed(text: &str) -> std::result::Result<Self, BadInput> {
        let typed: PlanFile = parse(text)?;
        let head = convert::head(&typed, file::sha256_hex(text.as_bytes()))?;
        let single = typed.trajectory;
        let mut n_trajectories = single.len();
        let mut draws = Vec::new();
        for (i, draw) in typed.draw.into_iter().enumerate() {
            let n = check_draw(i, &draw, MAX_COUNT)?;
            draws.push((draw, n, n_trajectories));
            n_trajectories += n;
        }
        convert::check_not_empty(n_trajectories)?;
        let plan = Self { head, single, draws, n_trajectories };
        plan.check_names()?;
        Ok(plan)
    }

    /// Names are those of files, and each is there once.
    fn check_names(&self) -> std::result::Result<(), BadInput> {
        let mut names = HashSet::new();
        let again =
            |key: String, name: &str| BadInput::new(key, "a unique name", format!("\"{name}\" again"));
        for (i, (draw, n, _)) in self.draws.iter().enumerate() {
            let key = format!("draw[{}].name", i + 1);
            convert::file_name(&key, &format!("{}-{n}", draw.name))?;
            if !names.insert(&draw.name) {
                return Err(again(key, &draw.name));
            }
        }
        let mut own = HashSet::new();
        for (i, typed) in self.single.iter().enumerate() {
            let key = format!("trajectory[{}].name", i + 1);
            let name = convert::file_name(&key, &typed.name)?;
            let is_drawn = self.draws.iter().any(|(draw, n, _)| {
                let number = name.strip_prefix(&draw.name).and_then(|rest| rest.strip_prefix('-'));
                let number = number.filter(|digits| !digits.starts_with(['0', '+']));
                number.and_then(|digits| digits.parse().ok()).is_some_and(|number: usize| number <= *n)
            });
            if is_drawn || !own.insert(name) {
                return Err(again(key, &typed.name));
            }
        }
        Ok(())
    }

    /// Name of the plan.
    pub fn name(&self) -> &str {
        &self.head.name
    }

    /// Seed of its variations.
    pub fn seed(&self) -> u64 {
        self.head.seed
    }

    /// SHA-256 of the bytes of the plan file, 64 hexadecimal digits.
    pub fn hash(&self) -> &str {
        &self.head.hash
    }

    /// Its own limits, within which its trajectories are.
    pub fn limits(&self) -> StrokeLimits {
        self.head.limits
    }

    /// Angles of the tendons about the body [rad].
    pub fn angles(&self) -> &[f64] {
        &self.head.tendons.angles
    }

    /// Number of trajectories, at least one.
    pub fn n_trajectories(&self) -> usize {
        self.n_trajectories
    }

    /// Samples of all trajectories. Those of one draw have the same number, so few are drawn for it.
    ///
    /// # Errors
    /// As [`LazyPlan::trajectory`].
    pub fn n_samples(&self) -> Result<u64> {
        let mut n = 0;
        for k in 0..self.single.len() {
            n += self.trajectory(k)?.n_samples() as u64;
        }
        for (_, count, first) in &self.draws {
            n += *count as u64 * self.trajectory(*first)?.n_samples() as u64;
        }
        Ok(n)
    }

    /// The `k`-th trajectory, from 0, within the plan's limits.
    ///
    /// # Errors
    /// `BadInput` naming the key; `Stroke` and `StrokeRate` where it passes the limits.
    pub fn trajectory(&self, k: usize) -> Result<Trajectory> {
        let drawn = || {
            let (draw, n, first) = self.draws.iter().rfind(|(_, _, first)| *first <= k)?;
            (k - first < *n).then(|| one(draw, self.head.seed, k - first, *n))
        };
        let trajectory = match self.single.get(k) {
            Some(typed) => convert::trajectory(&self.head, typed)?,
            None => {
                let none = || {
                    let expected = format!("a trajectory below {}", self.n_trajectories);
                    BadInput::new(format!("plan {}", self.head.name), expected, k.to_string())
                };
                convert::trajectory(&self.head, &drawn().ok_or_else(none)?)?
            }
        };
        // Strokes for a way of the tip are held within the limits when they are found.
        if self.head.space == Space::Tendons {
            trajectory.check(&self.head.limits)?;
        }
        Ok(trajectory)
    }

    /// Draws and checks all trajectories, one after the other: their limits, and that their roles fit their amplitudes.
    ///
    /// # Errors
    /// As [`LazyPlan::trajectory`]; `BadInput` for a role that does not fit.
    pub fn check(&self) -> Result<()> {
        let mut largest: Option<f64> = None;
        for k in 0..self.n_trajectories {
            let trajectory = self.trajectory(k)?;
            if trajectory.role == TrajectoryRole::Training {
                largest = Some(
                    largest.map_or(trajectory.motion.amplitude, |most| most.max(trajectory.motion.amplitude)),
                );
            }
        }
        let Some(largest) = largest else { return Ok(()) };
        let others = |role: TrajectoryRole| role != TrajectoryRole::Training;
        let single =
            self.single.iter().enumerate().filter(|(_, one)| others(one.role)).map(|(k, _)| k..k + 1);
        let draws = self.draws.iter().filter(|(draw, _, _)| others(draw.role));
        let draws = draws.map(|(_, n, first)| *first..first + n);
        for k in single.chain(draws).flatten() {
            convert::check_role(&self.trajectory(k)?, largest)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;
    use crate::MotionPlan;

    #[test]
    fn trajectories_are_those_of_the_whole_plan() {
        for name in MotionPlan::names() {
            let text = MotionPlan::text(name).unwrap();
            let (whole, lazy) = (MotionPlan::named(name).unwrap(), LazyPlan::from_toml(text, name).unwrap());
            assert_eq!((lazy.name(), lazy.seed(), lazy.hash()), (&*whole.name, whole.seed, &*whole.hash));
            assert_eq!(lazy.n_trajectories(), whole.trajectories().len());
            let samples: usize = whole.trajectories().iter().map(Trajectory::n_samples).sum();
            assert_eq!(lazy.n_samples().unwrap(), samples as u64);
            for (k, one) in whole.trajectories().iter().enumerate().rev() {
                assert_eq!(&lazy.trajectory(k).unwrap(), one, "{name} {k}");
            }
            lazy.check().unwrap();
            assert!(lazy.trajectory(lazy.n_trajectories()).is_err());
        }
    }

    fn changed(from: &str, to: &str) -> String {
        let text = MotionPlan::text("synthetic").unwrap();
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    }

    #[test]
    fn a_plan_may_have_more_trajectories_than_memory() {
        let lazy = LazyPlan::from_toml(&changed("count = 8", "count = 900_000_000"), "plan").unwrap();
        assert_eq!(lazy.n_trajectories(), 900_000_017);
        assert_eq!(lazy.trajectory(899_999_999).unwrap().name, "wide-circle-900000000");
        assert_eq!(lazy.trajectory(900_000_000).unwrap().name, "rising-ellipse-1");
        assert!(lazy.n_samples().unwrap() > 900_000_000 * 15_000);
    }

    #[test]
    fn what_a_whole_plan_refuses_is_refused() {
        let line = "[[trajectory]]\nname = \"wide-circle-8\"\nrole = \"training\"\nfamily = \"sinusoid\"\namplitude_mm = 3\n\
                    frequency_hz = 0.1\norientation_deg = 0\nattack_s = 10\nsustain_s = 1\ndecay_s = 10\n\n[[draw]]\n";
        for (from, to) in [
            ("[[draw]]\n", line),
            ("\"rising-ellipse\"", "\"wide-circle\""),
            ("\"rising-ellipse\"", "\"rising ellipse\""),
            ("count = 8", "count = 0"),
            ("amplitude_mm = [3, 13]", "amplitude_mm = [3, 40]"),
            ("period_s = [10, 20]", "period_s = [1, 2]"),
            ("role = \"training\"", "role = \"out_of_range\""),
        ] {
            let text = changed(from, to);
            assert!(MotionPlan::from_toml(&text, "plan").is_err(), "{to}");
            let lazy = LazyPlan::from_toml(&text, "plan").and_then(|lazy| lazy.check());
            assert!(lazy.is_err(), "{to}");
        }
    }
}
