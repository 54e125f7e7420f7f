//! What every flow in the background has in common: how it starts, and the states kept of it.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How a flow in the background starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveSettings {
    /// Whether it runs at once or waits to be told.
    pub playing: bool,
    /// Rounds of steps a second at most; `None` as fast as they come.
    pub pace: Option<f64>,
    /// Bytes the kept states may take.
    pub timeline_bytes: usize,
}

/// Time from the start of a round to the next one at a pace, and what is left of it.
pub(crate) fn until_next_round(pace: Option<f64>, last_round: Instant) -> Duration {
    let period = pace.map_or(0.0, |pace| 1.0 / pace.max(1e-3));
    Duration::from_secs_f64(period).saturating_sub(last_round.elapsed())
}

/// Runs the work of a background thread on a pool of its own, so that no one else has to wait for a long
/// step; `Err` is a panic's payload.
pub(crate) fn on_own_pool<T: Send>(work: impl FnOnce() -> T + Send) -> std::thread::Result<T> {
    catch_unwind(AssertUnwindSafe(|| {
        match rayon::ThreadPoolBuilder::new().build() {
            Ok(pool) => pool.install(work),
            Err(_) => work(),
        }
    }))
}

/// A state that a [`Timeline`] can keep.
pub trait Kept {
    /// Serial number, rising along the timeline.
    fn index(&self) -> usize;

    /// Bytes of what it does not share with the state kept before it.
    fn bytes(&self, before: Option<&Self>) -> usize;
}

/// Kept states of a flow, oldest first. The first and the latest are always among them; where they
/// would take more than the bytes they may, every second of the others is dropped.
#[derive(Clone, Debug)]
pub struct Timeline<S> {
    /// The states.
    pub states: Vec<Arc<S>>,
    /// Bytes they take; what states share counts once.
    pub bytes: usize,
    limit: usize,
}

impl<S: Kept> Timeline<S> {
    /// An empty one that may take `limit` bytes.
    pub fn new(limit: usize) -> Self {
        Self {
            states: Vec::new(),
            bytes: 0,
            limit,
        }
    }

    /// The kept state of that serial number.
    pub fn find(&self, index: usize) -> Option<&Arc<S>> {
        let found = self.states.binary_search_by_key(&index, |s| s.index());
        found.ok().map(|at| &self.states[at])
    }

    /// The latest state.
    pub fn latest(&self) -> Option<&Arc<S>> {
        self.states.last()
    }

    /// Adds a state and drops others if need be.
    pub fn push(&mut self, state: Arc<S>) {
        self.bytes += state.bytes(self.latest().map(AsRef::as_ref));
        self.states.push(state);
        while self.bytes > self.limit && self.states.len() > 2 {
            let last = self.states.len() - 1;
            let mut at = 0;
            self.states.retain(|_| {
                at += 1;
                (at - 1) % 2 == 0 || at - 1 == last
            });
            let before = |i: usize| i.checked_sub(1).map(|j| &*self.states[j]);
            let states = self.states.iter().enumerate();
            self.bytes = states.map(|(i, s)| s.bytes(before(i))).sum();
        }
    }
}

/// A timeline that one thread fills and another looks at, neither waiting for long.
#[derive(Debug)]
pub(crate) struct SharedTimeline<S>(Arc<Mutex<Arc<Timeline<S>>>>);

impl<S> Clone for SharedTimeline<S> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<S: Kept> SharedTimeline<S> {
    /// An empty one that may take `limit` bytes.
    pub fn new(limit: usize) -> Self {
        Self(Arc::new(Mutex::new(Arc::new(Timeline::new(limit)))))
    }

    /// The timeline as it is now.
    pub fn now(&self) -> Arc<Timeline<S>> {
        Arc::clone(&self.lock())
    }

    /// Adds a state.
    pub fn push(&self, state: Arc<S>)
    where
        Timeline<S>: Clone,
    {
        Arc::make_mut(&mut self.lock()).push(state);
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Arc<Timeline<S>>> {
        // a timeline is whole between any two of its operations
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Ten(usize);

    impl Kept for Ten {
        fn index(&self) -> usize {
            self.0
        }

        fn bytes(&self, _: Option<&Self>) -> usize {
            10
        }
    }

    #[test]
    fn the_first_and_the_latest_state_are_always_kept() {
        let mut timeline = Timeline::new(75);
        for i in 0..100 {
            timeline.push(Arc::new(Ten(i)));
            assert_eq!(timeline.states[0].0, 0);
            assert_eq!(timeline.latest().map(|s| s.0), Some(i));
            assert!(timeline.bytes <= 75);
            assert_eq!(timeline.bytes, 10 * timeline.states.len());
        }
        let kept: Vec<usize> = timeline.states.iter().map(|s| s.0).collect();
        assert!(kept.len() > 3 && kept.is_sorted());
        assert!(timeline.find(kept[1]).is_some() && timeline.find(kept[1] + 1).is_none());
        // two states stay, whatever they take
        let mut tight = Timeline::new(1);
        (0..5).for_each(|i| tight.push(Arc::new(Ten(i))));
        assert_eq!(tight.states.iter().map(|s| s.0).collect::<Vec<_>>(), [0, 4]);
    }
}
