//! The changes of a run and their times, as rows of a CSV file.
//!
//! ```text
//! attempt,control,value
//! 12,energy,H^2+K^2
//! 20,rewind,8
//! 31,finish,
//! ```
//!
//! `attempt` is the clock of the run when the change acts: the number of attempted steps before it,
//! accepted or not. A rewind counts as one attempt. All groups of holes of a fill share the clock;
//! it also advances for a group that has ended. In a refinement, each started level and each
//! finished level also counts as one.
//!
//! Controls have the names of the command-line flags. There are also
//!
//! - `rewind N`: continue from the state after attempt N, with the current controls;
//! - `finish`: continue in fast mode with an adaptive time step, until `mode`, `tau` or `growth` is
//!   changed or the run is rewound;
//! - `stop`: end here.

mod controls;
mod text;

pub(super) use controls::{ActiveControls, UserCommand};

use crate::options::OptionError;

/// A change of one control.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScheduleEntry {
    /// Attempted steps (accepted or not) before it acts.
    pub attempt: usize,
    /// The name of the control.
    pub control: String,
    /// Its new value, as on the command line.
    pub value: String,
}

/// Changes in the order in which they act.
///
/// Files contain it as CSV text.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Schedule {
    /// Ascending attempts.
    pub entries: Vec<ScheduleEntry>,
}

/// Why a schedule is invalid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ScheduleError {
    /// An invalid line.
    #[error("schedule, line {line}: {problem}; {remedy}")]
    Line {
        /// Counted from 1, the header included.
        line: usize,
        /// What is wrong.
        problem: String,
        /// How to correct it.
        remedy: String,
    },
    /// The initial controls are invalid.
    #[error("{0}")]
    Start(String),
}

impl ScheduleError {
    fn at(line: usize, error: OptionError) -> Self {
        Self::Line {
            line,
            problem: error.problem,
            remedy: error.remedy,
        }
    }
}
