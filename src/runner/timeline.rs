//! The stored states of a run, in bounded memory.

use std::ops::Deref;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use crate::runner::{Schedule, ScheduleEntry};

/// A state that a [`Timeline`] can store.
pub trait TimelineState {
    /// Memory that it does not share with the state stored before it, in bytes.
    fn bytes(&self, before: Option<&Self>) -> usize;
}

/// A state with its place in the run.
#[derive(Debug)]
pub struct Snapshot<S> {
    /// Serial number, unique in a run, ascending along the timeline.
    pub serial: usize,
    /// The run's clock at this state: the number of actions before it.
    pub clock: usize,
    /// The state.
    pub state: Arc<S>,
    /// The changes before it.
    pub(super) entries: Arc<Vec<ScheduleEntry>>,
    /// The changes with which the run ended at this state, if it did.
    pub(super) end: OnceLock<Arc<Vec<ScheduleEntry>>>,
}

impl<S> Deref for Snapshot<S> {
    type Target = S;

    fn deref(&self) -> &S {
        &self.state
    }
}

impl<S> Snapshot<S> {
    /// Whether the run ended at this state.
    pub fn ended(&self) -> bool {
        self.end.get().is_some()
    }

    /// The schedule that repeats the run up to this state.
    pub fn schedule(&self) -> Schedule {
        let mut entries = self.end.get().unwrap_or(&self.entries).to_vec();
        if !self.ended() {
            entries.push(ScheduleEntry {
                attempt: self.clock,
                control: "stop".into(),
                value: String::new(),
            });
        }
        Schedule { entries }
    }
}

/// Stored states, oldest first. The first and the latest are always among them. When the limit is
/// reached, every second one of the others is discarded.
#[derive(Debug)]
pub struct Timeline<S> {
    /// The states.
    pub states: Vec<Arc<Snapshot<S>>>,
    /// Their size in bytes; shared data counts once.
    pub bytes: usize,
    limit: usize,
}

impl<S> Clone for Timeline<S> {
    fn clone(&self) -> Self {
        Self {
            states: self.states.clone(),
            ..*self
        }
    }
}

impl<S: TimelineState> Timeline<S> {
    /// An empty timeline of at most `limit` bytes.
    pub(super) fn new(limit: usize) -> Self {
        Self {
            states: Vec::new(),
            bytes: 0,
            limit,
        }
    }

    /// The stored state with that serial number.
    pub fn find(&self, serial: usize) -> Option<&Arc<Snapshot<S>>> {
        let found = self.states.binary_search_by_key(&serial, |s| s.serial);
        found.ok().map(|at| &self.states[at])
    }

    /// The latest state.
    pub fn latest(&self) -> Option<&Arc<Snapshot<S>>> {
        self.states.last()
    }

    fn push(&mut self, state: Arc<Snapshot<S>>) {
        self.bytes += state.bytes(self.latest().map(|s| &*s.state));
        self.states.push(state);
        while self.bytes > self.limit && self.states.len() > 2 {
            let last = self.states.len() - 1;
            let mut at = 0;
            self.states.retain(|_| {
                at += 1;
                (at - 1) % 2 == 0 || at - 1 == last
            });
            let before = |i: usize| i.checked_sub(1).map(|j| &*self.states[j].state);
            let states = self.states.iter().enumerate();
            self.bytes = states.map(|(i, s)| s.bytes(before(i))).sum();
        }
    }
}

/// A timeline that one thread fills and another reads; neither blocks for long.
pub(super) struct SharedTimeline<S>(Arc<Mutex<Arc<Timeline<S>>>>);

impl<S> Clone for SharedTimeline<S> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<S: TimelineState> SharedTimeline<S> {
    /// An empty timeline of at most `limit` bytes.
    pub fn new(limit: usize) -> Self {
        Self(Arc::new(Mutex::new(Arc::new(Timeline::new(limit)))))
    }

    /// A snapshot of the timeline.
    pub fn now(&self) -> Arc<Timeline<S>> {
        Arc::clone(&self.lock())
    }

    /// Adds a state.
    pub fn push(&self, state: Arc<Snapshot<S>>) {
        Arc::make_mut(&mut self.lock()).push(state);
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Arc<Timeline<S>>> {
        // a timeline is valid between any two of its operations
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Ten;

    impl TimelineState for Ten {
        fn bytes(&self, _: Option<&Self>) -> usize {
            10
        }
    }

    fn state(serial: usize) -> Arc<Snapshot<Ten>> {
        Arc::new(Snapshot {
            serial,
            clock: serial,
            state: Arc::new(Ten),
            entries: Arc::default(),
            end: OnceLock::new(),
        })
    }

    fn serials(timeline: &Timeline<Ten>) -> Vec<usize> {
        timeline.states.iter().map(|s| s.serial).collect()
    }

    #[test]
    fn the_first_and_the_latest_state_are_always_stored() {
        let mut timeline = Timeline::new(75);
        for i in 0..100 {
            timeline.push(state(i));
            assert_eq!(timeline.states[0].serial, 0);
            assert_eq!(timeline.latest().map(|s| s.serial), Some(i));
            assert!(timeline.bytes <= 75);
            assert_eq!(timeline.bytes, 10 * timeline.states.len());
        }
        let stored = serials(&timeline);
        assert!(stored.len() > 3 && stored.is_sorted());
        assert!(timeline.find(stored[1]).is_some() && timeline.find(stored[1] + 1).is_none());
        // always keep two states, whatever their size
        let mut tight = Timeline::new(1);
        (0..5).for_each(|i| tight.push(state(i)));
        assert_eq!(serials(&tight), [0, 4]);
    }
}
