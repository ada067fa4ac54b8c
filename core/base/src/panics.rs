//! Panics of other people's code that damaged files lead to: caught, and not printed.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// Whether a panic of this thread is caught and becomes an error of its own.
    static IS_EXPECTED: Cell<bool> = const { Cell::new(false) };
}

/// Result of `work`; none where it panics, of which nothing is printed. The first call wraps the program's
/// panic hook, which goes on printing all other panics.
pub(crate) fn caught<T>(work: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let printed = take_hook();
        set_hook(Box::new(move |panic| {
            if !IS_EXPECTED.get() {
                printed(panic);
            }
        }));
    });
    IS_EXPECTED.set(true);
    let result = catch_unwind(AssertUnwindSafe(work));
    IS_EXPECTED.set(false);
    result.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_caught_and_others_continue() {
        assert_eq!(caught(|| 3), Some(3));
        assert_eq!(caught(|| assert_eq!(1, 2, "a page of a damaged file")), None);
        assert!(!IS_EXPECTED.get());
        assert!(catch_unwind(|| caught(|| 4)).is_ok_and(|found| found == Some(4)));
    }
}
