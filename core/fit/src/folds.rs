//! Validation by parts: k-fold, with whole recordings in one part.

use hysteron_base::BadInput;

/// One split: which groups are fitted and which are tested, by number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fold {
    /// Used for the fit, ascending.
    pub training: Vec<usize>,
    /// Test groups, ascending.
    pub test: Vec<usize>,
}

/// `k` splits of `n_groups` recordings (trajectories): each is tested in exactly one. Neighbouring numbers
/// are spread over the folds, so that recordings made one after the other do not leave together. Where `k` is
/// `n_groups`, every group is the only test group once.
///
/// # Errors
/// Fewer than two folds, or more than groups.
pub fn folds(n_groups: usize, k: usize) -> Result<Vec<Fold>, BadInput> {
    if !(2..=n_groups).contains(&k) {
        let expected = format!("2 to {n_groups}, the number of recordings");
        return Err(BadInput::new("folds", expected, k.to_string()));
    }
    let fold = |f: usize| {
        let (test, training) = (0..n_groups).partition(|group| group % k == f);
        Fold { training, test }
    };
    Ok((0..k).map(fold).collect())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may stop where it stands
mod tests {
    use super::folds;

    #[test]
    fn every_group_is_tested_once_and_never_where_it_is_fitted() {
        let folds = folds(7, 3).unwrap();
        let mut tested: Vec<usize> = folds.iter().flat_map(|fold| fold.test.clone()).collect();
        tested.sort_unstable();
        assert_eq!(tested, (0..7).collect::<Vec<_>>());
        assert!(folds.iter().all(|f| f.training.len() + f.test.len() == 7));
        assert!(folds.iter().all(|f| f.test.iter().all(|g| !f.training.contains(g))));
    }

    #[test]
    fn more_folds_than_groups_are_refused() {
        assert_eq!(super::folds(3, 4).unwrap_err().place, "folds");
        assert_eq!(super::folds(3, 1).unwrap_err().place, "folds");
    }
}
