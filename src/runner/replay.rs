//! Repeating a run on the calling thread.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::runner::{Process, Refused};

/// A change of a process between two steps.
#[derive(Clone, Debug)]
pub enum Change<C> {
    /// Continue with these controls.
    Controls(Box<C>),
    /// Continue from an earlier state.
    Rewind {
        /// The clock at that state.
        to: usize,
        /// The controls to continue with.
        controls: Box<C>,
    },
    /// End at the current state.
    Stop,
}

/// The changes of a run.
#[derive(Clone, Debug)]
pub struct Recording<C> {
    /// Each change with the clock at which it acts, ascending.
    pub changes: Vec<(usize, Change<C>)>,
}

impl<C> Default for Recording<C> {
    fn default() -> Self {
        let changes = Vec::new();
        Self { changes }
    }
}

/// Runs a process to its end, with the changes of a recording. `observe` is called with every event
/// and returns whether to continue; if not, the process stops at once. Returns the refused changes.
///
/// All parts of a process share one clock. If the process has ended before the next change, the
/// clock continues to that change.
///
/// # Errors
/// As [`Process::advance`].
pub fn replay<P: Process>(
    process: &mut P,
    recording: &Recording<P::Controls>,
    observe: &mut dyn FnMut(P::Event) -> bool,
) -> Result<Vec<Refused>, P::Error> {
    let rewinds = recording.changes.iter().filter_map(|(_, c)| match c {
        Change::Rewind { to, .. } => Some(*to),
        _ => None,
    });
    let mut replay = Replay {
        process,
        clock: 0,
        wanted: rewinds.collect(),
        stored: BTreeMap::new(),
        observe,
    };
    replay.store_state(0, 0)?;
    let mut refused = Vec::new();
    for (clock, change) in &recording.changes {
        if !replay.run_until(*clock)? {
            return Ok(refused);
        }
        refused.extend(replay.apply(change)?);
    }
    replay.run_until(usize::MAX)?;
    Ok(refused)
}

struct Replay<'a, P: Process> {
    process: &'a mut P,
    clock: usize,
    /// Clocks of the states that are needed later.
    wanted: BTreeSet<usize>,
    stored: BTreeMap<usize, Arc<P::State>>,
    observe: &'a mut dyn FnMut(P::Event) -> bool,
}

impl<P: Process> Replay<'_, P> {
    /// Stores the current state for the required clocks in `first..=last`.
    fn store_state(&mut self, first: usize, last: usize) -> Result<(), P::Error> {
        for &clock in self.wanted.range(first..=last) {
            self.stored.insert(clock, self.process.state()?);
        }
        Ok(())
    }

    /// Advances until the clock reaches `clock` or the process has ended. Returns `false` if the
    /// observer stops it.
    fn run_until(&mut self, clock: usize) -> Result<bool, P::Error> {
        while self.clock < clock && !self.process.ended() {
            self.clock += 1;
            let mut goes_on = true;
            let observe = &mut self.observe;
            self.process
                .advance(self.clock, &mut |event| goes_on &= observe(event))?;
            self.store_state(self.clock, self.clock)?;
            if !goes_on {
                self.stop();
                return Ok(false);
            }
        }
        if clock != usize::MAX && self.clock < clock {
            self.store_state(self.clock + 1, clock)?;
            self.clock = clock;
        }
        Ok(true)
    }

    fn stop(&mut self) {
        let observe = &mut self.observe;
        self.process.stop(&mut |event| {
            observe(event);
        });
    }

    fn apply(&mut self, change: &Change<P::Controls>) -> Result<Vec<Refused>, P::Error> {
        Ok(match change {
            Change::Controls(controls) => self.process.set_controls(controls),
            Change::Stop => {
                self.stop();
                Vec::new()
            }
            Change::Rewind { to, controls } => {
                self.clock += 1;
                let Some(state) = self.stored.get(to) else {
                    return Ok(Vec::new());
                };
                let refused = self.process.rewind(state, controls);
                self.store_state(self.clock, self.clock)?;
                refused
            }
        })
    }
}
