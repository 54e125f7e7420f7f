//! Files that are processed at the same time.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use crate::memory::free_memory;

/// What such files share: the memory, and the order in which they are concluded.
#[derive(Default)]
pub struct SideBySide {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// Bytes that are promised to the shares.
    promised: f64,
    shares: usize,
    /// The number of files that are concluded, which are the first ones.
    concluded: usize,
}

/// A file among others.
#[derive(Clone, Copy)]
pub struct Place<'a> {
    /// The others.
    pub all: &'a SideBySide,
    /// Its number, counted from 0.
    pub number: usize,
}

/// Memory that is promised until this is dropped.
pub struct Share<'a> {
    all: &'a SideBySide,
    bytes: f64,
}

impl SideBySide {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait_while(&self, condition: impl FnMut(&mut State) -> bool) -> MutexGuard<'_, State> {
        let state = self.changed.wait_while(self.state(), condition);
        state.unwrap_or_else(PoisonError::into_inner)
    }

    /// A share of `bytes` of memory. If they do not fit beside the other shares, it waits for these to
    /// end. A thread that holds a share must not request another, or wait for other files.
    pub fn memory(&self, bytes: f64) -> Share<'_> {
        let is_short = |state: &mut State| {
            // what is promised counts in full, although a part may be taken already
            let needed = state.promised + bytes;
            state.shares > 0 && free_memory().is_some_and(|free| needed > free as f64)
        };
        let mut state = self.wait_while(is_short);
        state.promised += bytes;
        state.shares += 1;
        Share { all: self, bytes }
    }

    /// Counts one more file as concluded.
    pub fn conclude(&self) {
        self.state().concluded += 1;
        self.changed.notify_all();
    }

    /// Lets no file wait for its turn any more, because none is concluded after this.
    pub fn end(&self) {
        self.state().concluded = usize::MAX;
        self.changed.notify_all();
    }
}

impl Place<'_> {
    /// Waits until all files before this one are concluded.
    pub fn wait_for_turn(self) {
        drop(self.all.wait_while(|state| state.concluded < self.number));
    }
}

impl Drop for Share<'_> {
    fn drop(&mut self) {
        let mut state = self.all.state();
        state.promised -= self.bytes;
        state.shares -= 1;
        drop(state);
        self.all.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn what_does_not_fit_waits_for_its_turn() {
        let all = SideBySide::default();
        let order = Mutex::new(Vec::new());
        let note = |what| order.lock().expect("a list").push(what);
        // more than any machine has; alone it does not wait
        let first = all.memory(1e30);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let _second = all.memory(1.0);
                note("second");
            });
            scope.spawn(|| {
                let place = Place {
                    all: &all,
                    number: 1,
                };
                place.wait_for_turn();
                note("turn");
            });
            note("first");
            drop(first);
            all.conclude();
        });
        let mut order = order.into_inner().expect("a list");
        assert_eq!(order.remove(0), "first");
        order.sort_unstable();
        assert_eq!(order, ["second", "turn"]);
    }
}
