//! `TapePool`: tapes and gradients that are used again, for passes whose sizes repeat.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::network::Transformer;
use super::shape::TransformerShape;
use super::tape::TransformerTape;
use crate::{Float, TrainableModel};

/// Tapes of finished passes, and gradients that have been used. They have megabytes: to allocate and clear a tape for each of a
/// training's updates takes a third of its time, a gradient a thirtieth.
#[derive(Debug)]
pub struct TapePool<T> {
    tapes: Mutex<Vec<TransformerTape<T>>>,
    gradients: Mutex<Vec<Vec<Vec<T>>>>,
}

impl<T> Default for TapePool<T> {
    fn default() -> Self {
        Self { tapes: Mutex::default(), gradients: Mutex::default() }
    }
}

/// A tape for one pass; goes back to its pool, where it has one.
#[derive(Debug)]
pub(super) struct PooledTape<'a, T> {
    /// There until it is dropped.
    tape: Option<TransformerTape<T>>,
    pool: Option<&'a TapePool<T>>,
}

impl<'a, T: Float> PooledTape<'a, T> {
    /// From `pool`, or a new one.
    pub fn of(
        pool: Option<&'a TapePool<T>>,
        shape: &TransformerShape,
        (steps, rows): (usize, usize),
    ) -> Self {
        match pool {
            Some(pool) => pool.lend(shape, (steps, rows)),
            None => Self { tape: Some(TransformerTape::new(shape, steps, rows)), pool: None },
        }
    }
}

impl<T> Deref for PooledTape<'_, T> {
    type Target = TransformerTape<T>;

    fn deref(&self) -> &TransformerTape<T> {
        self.tape.as_ref().unwrap_or_else(|| unreachable!("there until it is dropped"))
    }
}

impl<T> DerefMut for PooledTape<'_, T> {
    fn deref_mut(&mut self) -> &mut TransformerTape<T> {
        self.tape.as_mut().unwrap_or_else(|| unreachable!("there until it is dropped"))
    }
}

impl<T> Drop for PooledTape<'_, T> {
    fn drop(&mut self) {
        if let (Some(pool), Some(tape)) = (self.pool, self.tape.take()) {
            held(&pool.tapes).push(tape);
        }
    }
}

impl<T: Float> TapePool<T> {
    /// A tape with room for `rows` sequences of up to `steps` steps; its contents may be of another pass.
    ///
    /// # Panics
    /// As [`TransformerTape::new`].
    pub(super) fn lend(&self, shape: &TransformerShape, (steps, rows): (usize, usize)) -> PooledTape<'_, T> {
        let kept = {
            let mut tapes = held(&self.tapes);
            let room = |tape: &TransformerTape<T>| tape.room(shape, rows).unwrap_or(0);
            let longest = (0..tapes.len()).max_by_key(|at| room(&tapes[*at]));
            let alike = longest.filter(|at| room(&tapes[*at]) > 0).map(|at| tapes.swap_remove(at));
            // One that is too short goes: passes become longer as a training goes on.
            alike.filter(|tape| room(tape) >= steps)
        };
        let tape = kept.unwrap_or_else(|| TransformerTape::new(shape, steps, rows));
        PooledTape { tape: Some(tape), pool: Some(self) }
    }

    /// Result of `pass` on such a tape.
    ///
    /// # Panics
    /// As [`TransformerTape::new`].
    pub fn with<R>(
        &self,
        shape: &TransformerShape,
        size: (usize, usize),
        pass: impl FnOnce(&mut TransformerTape<T>) -> R,
    ) -> R {
        pass(&mut self.lend(shape, size))
    }

    /// Zeros of the shape of the parameters, for a gradient that goes back by [`Self::give_back`].
    pub fn zeros(&self, network: &Transformer<T>) -> Vec<Vec<T>> {
        let fits =
            |used: &Vec<Vec<T>>| used.iter().map(Vec::len).eq(network.parameters().iter().map(Vec::len));
        let Some(mut used) = held(&self.gradients).pop().filter(fits) else { return network.zeros() };
        used.iter_mut().for_each(|values| values.fill(T::default()));
        used
    }

    /// A gradient from [`Self::zeros`] that is no longer used.
    pub fn give_back(&self, gradient: Vec<Vec<T>>) {
        held(&self.gradients).push(gradient);
    }

    /// The sum of gradients from [`Self::zeros`], in order.
    pub fn sum(&self, parts: impl IntoIterator<Item = Vec<Vec<T>>>) -> Vec<Vec<T>> {
        let add = |mut sum: Vec<Vec<T>>, part: Vec<Vec<T>>| {
            for (sum, part) in sum.iter_mut().zip(&part) {
                sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += *part);
            }
            self.give_back(part);
            sum
        };
        parts.into_iter().reduce(add).unwrap_or_default()
    }
}

/// Lock of a list; its tapes or gradients are those that no pass uses.
fn held<T>(list: &Mutex<Vec<T>>) -> MutexGuard<'_, Vec<T>> {
    list.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::super::{TemporalForm, Transformer};
    use super::*;

    #[test]
    fn a_tape_is_used_again_and_what_stood_on_it_changes_nothing() {
        let shape = TransformerShape {
            width: 8,
            layers: 2,
            tokens: 4,
            ..TransformerShape::published(3, &[2, 1], TemporalForm::Streaming)
        };
        let network = Transformer::<f64>::new(&shape, 5).unwrap();
        let (steps, rows) = (7, 2);
        let inputs = |phase: f64| -> Vec<f64> {
            (0..steps * rows * shape.inputs).map(|k| (0.7 * k as f64 + phase).sin()).collect()
        };
        let pass = |tape: &mut TransformerTape<f64>, phase: f64| {
            let mut gradient = network.zeros();
            let outputs = tape.forward(&network, 0..steps, &inputs(phase)).to_vec();
            tape.clear_gradients();
            tape.backward(&network, 0..steps, &outputs, &mut gradient);
            tape.weight_gradients(&network, steps, &mut gradient);
            (outputs, gradient)
        };
        let pool = TapePool::default();
        let size = (steps, rows);
        let first = pool.with(&shape, size, |tape| pass(tape, 0.0));
        let second = pool.with(&shape, size, |tape| pass(tape, 1.0));
        assert_eq!(held(&pool.tapes).len(), 1);
        // One with more room serves too, one with less is given up.
        pool.with(&shape, (steps - 1, rows), |tape| assert_eq!(tape.room(&shape, rows), Some(steps)));
        pool.with(&shape, (steps + 1, rows), |tape| assert_eq!(tape.room(&shape, rows), Some(steps + 1)));
        assert_eq!(held(&pool.tapes).len(), 1);
        let fresh = || TransformerTape::new(&shape, steps, rows);
        assert_eq!([first, second], [pass(&mut fresh(), 0.0), pass(&mut fresh(), 1.0)]);
        // Two passes at the same time have two; another size has one of its own.
        pool.with(&shape, size, |_| pool.with(&shape, size, |_| ()));
        pool.with(&shape, (steps, 1), |tape| assert_eq!(tape.rows(), 1));
        assert_eq!(held(&pool.tapes).len(), 3);
    }

    #[test]
    fn a_gradient_is_used_again_from_zero_on_and_never_for_another_network() {
        let shape = TransformerShape {
            width: 8,
            layers: 1,
            tokens: 2,
            ..TransformerShape::published(3, &[2], TemporalForm::Streaming)
        };
        let network = Transformer::<f64>::new(&shape, 1).unwrap();
        let pool = TapePool::default();
        let filled = |value: f64| {
            let mut gradient = pool.zeros(&network);
            assert_eq!(gradient, network.zeros());
            gradient.iter_mut().flatten().for_each(|d| *d = value);
            gradient
        };
        let sum = pool.sum([filled(1.0), filled(2.0), filled(4.0)]);
        assert!(sum.iter().flatten().all(|d| *d == 7.0));
        pool.give_back(sum);
        assert_eq!(held(&pool.gradients).len(), 3);
        filled(1.0);
        assert_eq!(held(&pool.gradients).len(), 2);
        let wider = Transformer::<f64>::new(&TransformerShape { width: 16, ..shape }, 1).unwrap();
        assert_eq!(pool.zeros(&wider), wider.zeros());
    }
}
