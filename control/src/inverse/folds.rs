//! Cross-validation: demonstrations, and which of them are left out together.

use hysteron_base::{BadInput, rng};

use super::dataset::check_alike;
use super::{DataOrigin, Dataset, Demonstration};
use crate::split::deal_folds;

/// Demonstrations of one robot, in folds of whole trajectories.
#[derive(Debug, Clone, PartialEq)]
pub struct Folds {
    all: Vec<Demonstration>,
    /// Numbers of those that a fold validates on.
    left_out: Vec<Vec<usize>>,
}

impl Folds {
    /// One split, as [`Dataset::new`] makes it.
    ///
    /// # Errors
    /// As there.
    pub fn single(all: Vec<Demonstration>, held_out: &[String], seed: u64) -> Result<Self, BadInput> {
        check_alike(&all)?;
        let held_out = Dataset::held_out(&all, held_out, seed)?;
        let left_out = (0..all.len()).filter(|&k| held_out.contains(&all[k].name)).collect();
        Ok(Self { all, left_out: vec![left_out] })
    }

    /// At most `n` folds, in which every real demonstration is left out once, or every synthetic one where none is real; kinds of
    /// motion are spread over them. One split, as [`Folds::single`], where only one demonstration could be left out.
    ///
    /// # Errors
    /// As [`Dataset::new`].
    pub fn new(all: Vec<Demonstration>, n: usize, seed: u64) -> Result<Self, BadInput> {
        check_alike(&all)?;
        let is_real = all.iter().any(|one| one.origin == DataOrigin::Real);
        let is_usable = |one: &Demonstration| !is_real || one.origin == DataOrigin::Real;
        let usable: Vec<usize> = (0..all.len()).filter(|&k| is_usable(&all[k])).collect();
        let n = n.min(usable.len());
        if n < 2 {
            return Self::single(all, &[], seed);
        }
        let kinds: Vec<String> = usable.iter().map(|&k| all[k].kind()).collect();
        let dealt = deal_folds(&kinds, n, &mut rng(seed, "inverse/folds"));
        let left_out = dealt.into_iter().map(|fold| fold.into_iter().map(|k| usable[k]).collect()).collect();
        Ok(Self { all, left_out })
    }

    /// Number of folds; 1 for a single split.
    pub fn len(&self) -> usize {
        self.left_out.len()
    }

    /// False: there is a fold.
    pub fn is_empty(&self) -> bool {
        self.left_out.is_empty()
    }

    /// All demonstrations.
    pub fn all(&self) -> &[Demonstration] {
        &self.all
    }

    /// All demonstrations, to add what a twin says of them.
    pub fn all_mut(&mut self) -> &mut [Demonstration] {
        &mut self.all
    }

    /// Those that some fold validates on.
    pub fn validated(&self) -> impl Iterator<Item = &Demonstration> {
        let is_left_out = |k: &usize| self.left_out.iter().any(|part| part.contains(k));
        (0..self.all.len()).filter(is_left_out).map(|k| &self.all[k])
    }

    /// The data of a fold: those that it leaves out to validate on, the others to learn from.
    pub fn fold(&self, number: usize) -> Dataset {
        self.dataset(&self.left_out[number])
    }

    /// All of them to learn from, and none to validate on.
    pub fn whole(&self) -> Dataset {
        self.dataset(&[])
    }

    fn dataset(&self, left_out: &[usize]) -> Dataset {
        let pick = |is_left_out: bool| {
            let numbers = (0..self.all.len()).filter(move |k| left_out.contains(k) == is_left_out);
            numbers.map(|k| self.all[k].clone()).collect()
        };
        let Demonstration { step, n_tendons, axes, .. } = self.all[0];
        Dataset { training: pick(false), validation: pick(true), step, n_tendons, axes }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;
    use crate::inverse::Axes;

    fn demonstration(name: String, family: &str, origin: DataOrigin) -> Demonstration {
        Demonstration {
            name,
            hash: String::new(),
            origin,
            robot: String::new(),
            family: family.to_owned(),
            step: 0.01,
            axes: Axes::Planar,
            tip: vec![[0.0; 3]; 3],
            gap: vec![false; 3],
            n_tendons: 1,
            strokes: vec![0.0; 3],
            jacobian: Vec::new(),
        }
    }

    #[test]
    fn every_real_demonstration_is_left_out_once_and_kinds_are_spread() {
        let mut all: Vec<Demonstration> = ["circle", "square", "rose"]
            .iter()
            .flat_map(|kind| {
                (0..3).map(move |k| demonstration(format!("{kind}-{k}"), kind, DataOrigin::Real))
            })
            .collect();
        all.push(demonstration("twin".to_owned(), "circle", DataOrigin::Synthetic));
        let folds = Folds::new(all, 3, 1).unwrap();
        let mut seen = Vec::new();
        for k in 0..folds.len() {
            let data = folds.fold(k);
            let kinds: Vec<&str> = data.validation.iter().map(|one| &one.family[..]).collect();
            assert_eq!(kinds, ["circle", "square", "rose"]);
            assert!(data.training.len() == 7 && data.training.iter().any(|one| one.name == "twin"));
            seen.extend(data.validation.into_iter().map(|one| one.name));
        }
        seen.sort();
        seen.dedup();
        assert_eq!((folds.len(), seen.len(), folds.validated().count()), (3, 9, 9));
        assert!(folds.whole().training.len() == 10 && folds.whole().validation.is_empty());
    }

    #[test]
    fn few_demonstrations_have_few_folds_and_synthetic_ones_are_left_out_only_alone() {
        let of = |origin: DataOrigin, n: usize| -> Vec<Demonstration> {
            (0..n).map(|k| demonstration(format!("{origin:?} {k}"), "", origin)).collect()
        };
        let (real, twin) = (DataOrigin::Real, DataOrigin::Synthetic);
        assert_eq!(Folds::new(of(real, 2), 5, 1).unwrap().len(), 2);
        assert_eq!(Folds::new(of(twin, 9), 3, 1).unwrap().len(), 3);
        let mixed = [of(real, 1), of(twin, 4)].concat();
        let folds = Folds::new(mixed, 3, 1).unwrap();
        assert_eq!(folds.len(), 1);
        assert!(Folds::new(of(real, 1), 3, 1).is_err());
    }
}
