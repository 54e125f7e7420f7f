//! Background jobs. Each runs on its own thread. Dropping its handle cancels it.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use crate::runner::panic_text;

/// Wakes the window. Called when a result is ready.
pub use crate::runner::Wake;

/// Connects a job to its handle.
#[derive(Clone, Default)]
pub struct Reporter {
    cancelled: Arc<AtomicBool>,
    done: Arc<AtomicU32>,
    total: Arc<AtomicU32>,
}

impl Reporter {
    /// Whether the job has not been cancelled.
    pub fn is_wanted(&self) -> bool {
        !self.cancelled.load(Ordering::Relaxed)
    }

    /// Reports progress; returns [`Self::is_wanted`].
    pub fn progress(&self, done: usize, total: usize) -> bool {
        self.done.store(done as u32, Ordering::Relaxed);
        self.total.store(total as u32, Ordering::Relaxed);
        self.is_wanted()
    }
}

/// The handle of a job; dropping it cancels the job.
pub struct Job<T> {
    /// A description for the status bar.
    pub what: String,
    reporter: Reporter,
    result: Receiver<Result<T, String>>,
}

impl<T: Send + 'static> Job<T> {
    /// Starts `work` on a thread. Calls `wake` when the result is ready.
    pub fn spawn(
        what: impl Into<String>,
        wake: &Wake,
        work: impl FnOnce(&Reporter) -> T + Send + 'static,
    ) -> Self {
        let what = what.into();
        let (sender, result) = channel();
        let reporter = Reporter::default();
        let (inner, wake, name) = (reporter.clone(), Arc::clone(wake), what.clone());
        let failed = sender.clone();
        let started = std::thread::Builder::new()
            .name("meniscus-job".into())
            .spawn(move || {
                let outcome = catch_unwind(AssertUnwindSafe(|| work(&inner)));
                let outcome = outcome.map_err(|panic| {
                    format!(
                        "{name}: internal error ({}); the open document is unchanged",
                        panic_text(panic.as_ref())
                    )
                });
                // a closed channel means that the job was cancelled
                sender.send(outcome).ok();
                wake();
            });
        if let Err(error) = started {
            let text = format!("{what}: could not start a thread ({error}); close other programs");
            failed.send(Err(text)).ok();
        }
        Self {
            what,
            reporter,
            result,
        }
    }

    /// The result, if it is ready; an `Err` is a message for the user.
    pub fn poll(&self) -> Option<Result<T, String>> {
        match self.result.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err(format!("{}: ended early", self.what))),
        }
    }

    /// Finished parts and their total, if the job reports them.
    pub fn progress(&self) -> Option<(u32, u32)> {
        let total = self.reporter.total.load(Ordering::Relaxed);
        (total > 0).then(|| (self.reporter.done.load(Ordering::Relaxed), total))
    }
}

impl<T> Drop for Job<T> {
    fn drop(&mut self) {
        self.reporter.cancelled.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wait<T: Send + 'static>(job: &Job<T>) -> Result<T, String> {
        loop {
            if let Some(result) = job.poll() {
                return result;
            }
            std::thread::yield_now();
        }
    }

    #[test]
    fn results_panics_and_cancellation_come_back() {
        let wake: Wake = Arc::new(|| ());
        assert_eq!(wait(&Job::spawn("add", &wake, |_| 1 + 1)), Ok(2));
        let broken = Job::<()>::spawn("count", &wake, |_| panic!("seven"));
        let text = wait(&broken).expect_err("it panics");
        assert!(
            text.contains("seven") && text.contains("unchanged"),
            "{text}"
        );

        let (sender, receiver) = channel();
        let job = Job::spawn("loop", &wake, move |reporter| {
            let mut round = 0;
            while reporter.progress(round % 8, 8) {
                round += 1;
            }
            sender.send(()).ok();
        });
        drop(job);
        receiver.recv().expect("it ends when its handle is gone");
    }
}
