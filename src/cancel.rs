//! Cancellation of work whose result nobody needs any more.
//!
//! The threads of a background run share a [`Cancel`]. Long stages poll it by [`is_cancelled`] and then
//! return early with any valid result or an error, because a cancelled run shows none. On threads that
//! share none nothing is cancelled.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    static SHARED: RefCell<Option<Arc<Cancel>>> = const { RefCell::new(None) };
}

/// A request to end the work of some threads.
#[derive(Debug, Default)]
pub(crate) struct Cancel {
    requested: AtomicBool,
    #[cfg(test)]
    polls: tests::Polls,
}

impl Cancel {
    /// Requests the end.
    pub fn request(&self) {
        self.requested.store(true, Ordering::Relaxed);
    }

    /// Whether the end was requested.
    pub fn is_requested(&self) -> bool {
        #[cfg(test)]
        if self.polls.is_last() {
            self.request();
        }
        self.requested.load(Ordering::Relaxed)
    }

    /// Does some work on a thread pool of its own whose threads share this request.
    pub fn install<R: Send>(self: &Arc<Self>, work: impl FnOnce() -> R + Send) -> R {
        let shared = Arc::clone(self);
        let share = move || SHARED.set(Some(Arc::clone(&shared)));
        let start = share.clone();
        let pool = rayon::ThreadPoolBuilder::new().start_handler(move |_| start());
        let Ok(pool) = pool.build() else {
            share();
            return work();
        };
        pool.install(work)
    }
}

/// Whether the work of this thread was cancelled.
pub(crate) fn is_cancelled() -> bool {
    SHARED.with_borrow(|shared| shared.as_ref().is_some_and(|cancel| cancel.is_requested()))
}

#[cfg(test)]
pub(crate) mod tests {
    use std::sync::atomic::AtomicUsize;

    use super::*;

    /// The number of polls, and the poll that finds the work cancelled.
    #[derive(Debug)]
    pub(super) struct Polls {
        count: AtomicUsize,
        last: usize,
    }

    impl Default for Polls {
        fn default() -> Self {
            Self {
                count: AtomicUsize::new(0),
                last: usize::MAX,
            }
        }
    }

    impl Polls {
        pub fn is_last(&self) -> bool {
            self.count.fetch_add(1, Ordering::Relaxed) + 1 >= self.last
        }
    }

    /// Does some work that is cancelled from its poll number `last` on. Returns the number of polls too.
    pub(crate) fn cancelled_at<R: Send>(
        last: usize,
        work: impl FnOnce() -> R + Send,
    ) -> (R, usize) {
        let cancel = Arc::new(Cancel {
            polls: Polls {
                last,
                ..Polls::default()
            },
            ..Cancel::default()
        });
        let result = cancel.install(work);
        (result, cancel.polls.count.load(Ordering::Relaxed))
    }

    /// Some work polls at least `least` times, and less often if it is cancelled half way.
    #[track_caller]
    pub(crate) fn is_polled<R: Send>(least: usize, work: impl Fn() -> R + Sync) {
        let (_, all) = cancelled_at(usize::MAX, &work);
        assert!(all >= least, "{all} polls, at least {least} expected");
        let (_, polls) = cancelled_at(all / 2, &work);
        assert!(
            polls < all,
            "{polls} polls after a request at {} of {all}",
            all / 2
        );
    }

    #[test]
    fn only_threads_of_the_work_are_cancelled() {
        let sum = || {
            let parts = rayon::join(is_cancelled, is_cancelled);
            usize::from(parts.0) + usize::from(parts.1)
        };
        assert_eq!(cancelled_at(usize::MAX, sum), (0, 2));
        assert_eq!(cancelled_at(1, sum), (2, 2));
        assert!(!is_cancelled());
    }
}
