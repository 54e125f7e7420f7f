//! The engine for work that advances in steps: a fill, a refinement.
//!
//! A [`Process`] does the work. [`Runner`] runs it on a background thread for an interactive
//! caller. The caller sends commands and receives events from a lossless channel. States go to a
//! [`Timeline`]. No call of the caller waits for the work. Every command that changes the result is
//! recorded. [`replay()`] runs a process with the commands of a [`Recording`] on the calling thread;
//! the result is bit-identical. A [`Schedule`] is the text of a recording.
//!
//! Commands act between two steps. New controls wait for the next step, so several changes before
//! it count as one. All other commands act at once. The clock of a run counts its actions:
//! attempted steps, accepted or not, and rewinds. In a refinement it also counts started and
//! finished levels.

mod channels;
mod handle;
mod replay;
mod schedule;
#[cfg(test)]
mod tests;
mod timeline;
mod worker;

use std::sync::Arc;

use crate::options::Options;

pub use channels::Event;
pub use handle::{Runner, StartError};
pub use replay::{Change, Recording, replay};
pub use schedule::{Schedule, ScheduleEntry, ScheduleError};
pub use timeline::{Snapshot, Timeline, TimelineState};

/// Called from the background thread whenever there are events to [poll](Runner::poll).
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// How a background run starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunSettings {
    /// Whether it runs immediately or waits for a command.
    pub playing: bool,
    /// Maximum number of steps per second; `None` for no limit.
    pub pace: Option<f64>,
    /// Maximum size of the timeline, bytes.
    pub timeline_bytes: usize,
}

/// The controls of a run: options that the user may change while it runs.
pub trait RunControls: Options {
    /// Options that take effect only at the start.
    const FIXED: &'static [&'static str];
    /// The options, by name and text, with which a run reaches its end in the fewest steps.
    const FASTEST: &'static [(&'static str, &'static str)];
    /// Why controls are invalid.
    type Error: std::error::Error + Send + Sync + 'static;

    /// Checks the values.
    ///
    /// # Errors
    /// The first invalid option.
    fn validate(&self) -> Result<(), Self::Error>;
}

/// A part of a process that keeps its previous controls or state.
#[derive(Clone, Debug)]
pub struct Refused {
    /// The part; `None` for the whole process.
    pub part: Option<usize>,
    /// The reason, as text.
    pub text: String,
}

/// Work that advances in steps. Between two steps its controls can be changed, and an earlier state
/// can be restored.
///
/// `emit` receives the events of a call, in order.
pub trait Process: Sized {
    /// Settings that the user may change.
    type Controls: RunControls;
    /// The data stored after each step.
    type State;
    /// The events of the process.
    type Event;
    /// A summary of the current state.
    type Status: Clone + Default;
    /// Why the whole process cannot start or continue.
    type Error: std::fmt::Display;

    /// Takes the next step; does nothing after the end.
    ///
    /// # Errors
    /// The process cannot continue; its state is that of the last step.
    fn advance(
        &mut self,
        clock: usize,
        emit: &mut dyn FnMut(Self::Event),
    ) -> Result<(), Self::Error>;

    /// Continues with other controls. A part that cannot use them keeps its previous ones.
    fn set_controls(&mut self, controls: &Self::Controls) -> Vec<Refused>;

    /// Continues from an earlier state, with these controls. A part that cannot do so stays
    /// unchanged.
    fn rewind(&mut self, to: &Arc<Self::State>, controls: &Self::Controls) -> Vec<Refused>;

    /// Ends at the current state.
    fn stop(&mut self, emit: &mut dyn FnMut(Self::Event));

    /// Whether no step is left.
    fn ended(&self) -> bool;

    /// Whether the state differs from the one returned last.
    fn has_new_state(&self) -> bool;

    /// The current state.
    ///
    /// # Errors
    /// As [`Self::advance`].
    fn state(&mut self) -> Result<Arc<Self::State>, Self::Error>;

    /// The current status; `seconds` is the time per step. Emits once which parts have ended.
    fn status(&mut self, seconds: f64, emit: &mut dyn FnMut(Self::Event)) -> Self::Status;

    /// Whether the run pauses after this event so that the user can decide.
    fn pauses(_event: &Self::Event) -> bool {
        false
    }
}

/// The message of a caught panic.
pub fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    panic
        .downcast_ref::<&str>()
        .map(|s| (*s).to_owned())
        .or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "unknown panic".into())
}
