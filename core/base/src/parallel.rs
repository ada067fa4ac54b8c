//! Maps over lists on all threads of the program; a failing item gives the same error on any number of threads.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

/// Threads that the program has for this.
pub fn threads() -> usize {
    rayon::current_num_threads()
}

/// `f` of every item, in the order of the items.
pub fn map<'a, T: Sync, R: Send>(items: &'a [T], f: impl Fn(&'a T) -> R + Sync + Send) -> Vec<R> {
    items.par_iter().map(f).collect()
}

/// `f` of 0 to n − 1, in that order.
pub fn map_indices<R: Send>(n: usize, f: impl Fn(usize) -> R + Sync + Send) -> Vec<R> {
    (0..n).into_par_iter().map(f).collect()
}

/// [`map`] where an item can fail: after a failure nothing new is begun, and of the errors the one of the first item is
/// returned. (Rayon's own collection returns the error that came first in time.)
///
/// # Errors
/// Those of `f`.
pub fn try_map<'a, T: Sync, R: Send, E: Send>(
    items: &'a [T],
    f: impl Fn(&'a T) -> Result<R, E> + Sync + Send,
) -> Result<Vec<R>, E> {
    let has_failed = AtomicBool::new(false);
    let attempt = |item| {
        let result = (!has_failed.load(Ordering::Relaxed)).then(|| f(item));
        if matches!(result, Some(Err(_))) {
            has_failed.store(true, Ordering::Relaxed);
        }
        result
    };
    // An item without a result comes after a failure.
    items.par_iter().map(attempt).collect::<Vec<_>>().into_iter().flatten().collect()
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
    fn the_first_error_is_reported_and_the_remaining_work_is_skipped() {
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
