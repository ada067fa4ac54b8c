//! Work on the items of a list side by side, on as many threads as the program has.
//!
//! Rayon's own adaptors are compiled anew for every closure, some thousand lines of machine code each; here only the shell around
//! a closure is. An item costs a lock and a call through a pointer: what is shorter than some microseconds goes in larger parts.

use std::convert::Infallible;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

/// Threads that the program has for this.
pub fn threads() -> usize {
    rayon::current_num_threads()
}

/// `f` of every item, in the order of the items.
pub fn map<'a, T: Sync, R: Send>(items: &'a [T], f: impl Fn(&'a T) -> R + Sync) -> Vec<R> {
    map_indices(items.len(), |k| f(&items[k]))
}

/// `f` of 0 to n − 1, in that order.
pub fn map_indices<R: Send>(n: usize, f: impl Fn(usize) -> R + Sync) -> Vec<R> {
    match try_map_indices(n, |k| Ok::<R, Infallible>(f(k))) {
        Ok(found) => found,
        Err(never) => match never {},
    }
}

/// [`map`] where an item can fail: then what has not begun is left, and the first error by the order of the items is told.
///
/// # Errors
/// Those of `f`.
pub fn try_map<'a, T: Sync, R: Send, E: Send>(
    items: &'a [T],
    f: impl Fn(&'a T) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    try_map_indices(items.len(), |k| f(&items[k]))
}

fn try_map_indices<R: Send, E: Send>(
    n: usize,
    f: impl Fn(usize) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    let found: Vec<Mutex<Option<Result<R, E>>>> = (0..n).map(|_| Mutex::new(None)).collect();
    each(n, &|k| {
        let one = f(k);
        let goes_on = one.is_ok();
        if let Ok(mut place) = found[k].lock() {
            *place = Some(one);
        }
        goes_on
    });
    // A place is empty only behind an error.
    found.into_iter().filter_map(|place| place.into_inner().ok().flatten()).collect()
}

/// `f` of 0 to n − 1; after one that returns false, what has not begun is left.
fn each(n: usize, f: &(dyn Fn(usize) -> bool + Sync)) {
    let goes_on = AtomicBool::new(true);
    (0..n).into_par_iter().for_each(|k| {
        if goes_on.load(Ordering::Relaxed) && !f(k) {
            goes_on.store(false, Ordering::Relaxed);
        }
    });
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;
    use std::sync::atomic::AtomicUsize;

    #[test]
    fn results_come_in_the_order_of_the_items() {
        let items: Vec<u64> = (0..1000).collect();
        assert!(map(&items, |k| k * k).into_iter().eq((0..1000).map(|k| k * k)));
        assert!(map(&[] as &[u64], |k| *k).is_empty());
    }

    #[test]
    fn the_first_error_is_told_and_what_has_not_begun_is_left() {
        let items: Vec<usize> = (0..10_000).collect();
        let n_begun = AtomicUsize::new(0);
        let found = try_map(&items, |k| {
            n_begun.fetch_add(1, Ordering::Relaxed);
            std::thread::sleep(std::time::Duration::from_micros(20));
            if k % 5 == 3 { Err(*k) } else { Ok(*k) }
        });
        let error = found.unwrap_err();
        assert!(error % 5 == 3 && n_begun.into_inner() < items.len() / 2, "{error}");
        assert_eq!(try_map(&items, |k| if *k < 20_000 { Ok(*k) } else { Err(*k) }), Ok(items));
    }
}
