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
mod rows;
#[cfg(test)]
mod tests;
mod text;

pub(super) use course::{Change, Course, Item, TimedChange};

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
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Schedule {
    /// Ascending attempts.
    pub rows: Vec<Row>,
}

/// Why a schedule cannot be followed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
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

/// Something wrong with a value, without its place.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Fault {
    problem: String,
    remedy: String,
}

impl Fault {
    fn new(problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self {
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }

    fn at(self, line: usize) -> ScheduleError {
        ScheduleError::Line {
            line,
            problem: self.problem,
            remedy: self.remedy,
        }
    }
}
