//! What was changed on the way of a fill, and when: rows of a CSV file.
//!
//! ```text
//! attempt,control,value
//! 12,energy,H^2+K^2
//! 20,rewind,8
//! 31,finish,
//! ```
//!
//! `attempt` counts steps attempted before the change acts, accepted or not. All groups of holes
//! attempt their steps together, so that the count is the same for all; one that has ended waits.
//! A rewind counts as an attempt of its own. Controls are named as the flags of `meniscus fill`,
//! and beside them there are
//!
//! - `rewind N`: on from the shape after attempt N, with the controls of now;
//! - `finish`: on in fast mode with an adaptive time step, until `mode`, `tau` or `growth` is
//!   changed or the fill rewound;
//! - `stop`: the end.

mod course;
#[cfg(test)]
mod tests;
mod text;

pub(super) use course::{Change, Course, Item, TimedChange};

use crate::options::OptionError;

/// A change of one control.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// Attempted steps (accepted or not) before it acts; a rewind counts as one.
    pub attempt: usize,
    /// What is changed.
    pub control: String,
    /// Its new value, as on the command line.
    pub value: String,
}

/// Changes in the order in which they act.
///
/// In files it stands as its CSV text.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Schedule {
    /// Ascending attempts.
    pub rows: Vec<Row>,
}

/// Why a schedule cannot be followed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ScheduleError {
    /// A line that is wrong.
    #[error("schedule, line {line}: {problem}; {remedy}")]
    Line {
        /// Counted from 1, the header included.
        line: usize,
        /// What is wrong.
        problem: String,
        /// What to write instead.
        remedy: String,
    },
    /// The controls it starts from are mistaken.
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
