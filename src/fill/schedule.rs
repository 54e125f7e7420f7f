//! What was changed on the way of a fill, and when: rows of a CSV file.

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

/// Why a schedule cannot be used.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ScheduleError {
    /// A line that cannot be read.
    #[error("schedule, line {line}: {problem}; {remedy}")]
    Line {
        /// Counted from 1.
        line: usize,
        /// What is wrong.
        problem: String,
        /// What to write instead.
        remedy: String,
    },
}
