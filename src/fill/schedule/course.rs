//! The controls in force on the way of a fill, and the changes they make to its groups.

use super::{Row, Schedule, ScheduleError};
use crate::fill::{Controls, ControlsError, FillOptions};
use crate::options::{OptionError, OptionValue, Options, TauChoice};
use crate::solver::Mode;

/// What a person asks for between two attempts.
#[derive(Clone, Debug)]
pub(in crate::fill) enum Item {
    Controls(Box<Controls>),
    Finish,
    /// On from the shape after that attempt.
    Rewind(usize),
    Stop,
}

/// What happens to a group before an attempt.
#[derive(Clone, Debug)]
pub(in crate::fill) enum Change {
    Options(Box<FillOptions>),
    Rewind {
        to: usize,
        options: Box<FillOptions>,
    },
    Stop,
}

/// A change and how many attempts are made before it.
#[derive(Clone, Debug)]
pub(in crate::fill) struct TimedChange {
    pub attempt: usize,
    pub change: Change,
}

/// The controls in force.
#[derive(Clone, Debug)]
pub(in crate::fill) struct Course {
    controls: Controls,
    /// Whether fast mode is on until something says otherwise.
    finishing: bool,
}

impl Course {
    pub(in crate::fill) fn new(controls: Controls) -> Self {
        Self {
            controls,
            finishing: false,
        }
    }

    /// The options in force.
    pub(in crate::fill) fn options(&self) -> Result<FillOptions, ControlsError> {
        if !self.finishing {
            return self.controls.options();
        }
        let fast = Controls {
            mode: Mode::Fast,
            tau: TauChoice::Auto,
            growth: None,
            ..self.controls.clone()
        };
        fast.options()
    }

    /// Takes an item up: the rows that record it and the change it makes, if it makes any.
    pub(in crate::fill) fn take(
        &mut self,
        attempt: usize,
        item: &Item,
    ) -> Result<(Vec<Row>, Option<Change>), ControlsError> {
        let row = |control: &str, value: String| Row {
            attempt,
            control: control.into(),
            value,
        };
        Ok(match item {
            Item::Controls(controls) => {
                let changed = self.controls.difference(controls).into_iter();
                let rows: Vec<Row> = changed.map(|(name, value)| row(&name, value)).collect();
                if rows.is_empty() {
                    return Ok((rows, None));
                }
                let change = self.set(controls)?;
                (rows, Some(change))
            }
            Item::Finish => {
                self.finishing = true;
                let change = Change::Options(Box::new(self.options()?));
                (vec![row("finish", String::new())], Some(change))
            }
            Item::Rewind(to) => {
                self.finishing = false;
                let options = Box::new(self.options()?);
                let change = Change::Rewind { to: *to, options };
                (vec![row("rewind", to.to_string())], Some(change))
            }
            Item::Stop => (vec![row("stop", String::new())], Some(Change::Stop)),
        })
    }

    fn set(&mut self, controls: &Controls) -> Result<Change, ControlsError> {
        let paced = |c: &Controls| (c.mode, c.tau, c.growth);
        let next = Self {
            finishing: self.finishing && paced(&self.controls) == paced(controls),
            controls: controls.clone(),
        };
        let options = Box::new(next.options()?);
        *self = next;
        Ok(Change::Options(options))
    }
}

impl Schedule {
    /// Finds out whether the schedule can be followed from these controls on.
    ///
    /// # Errors
    /// The first row that names no control or has a value out of range.
    pub fn check(&self, controls: &Controls) -> Result<(), ScheduleError> {
        self.resolve(controls).map(|_| ())
    }

    /// The options a fill starts with and the changes on its way. Consecutive rows that set
    /// controls at the same attempt are one change.
    ///
    /// # Errors
    /// The first row that names no control or has a value out of range.
    pub(in crate::fill) fn resolve(
        &self,
        controls: &Controls,
    ) -> Result<(FillOptions, Vec<TimedChange>), ScheduleError> {
        let start = |error: ControlsError| ScheduleError::Start(error.to_string());
        let mut course = Course::new(controls.clone());
        let options = course.options().map_err(start)?;
        let mut changes = Vec::new();
        let mut next = controls.clone();
        for (i, row) in self.rows.iter().enumerate() {
            // the header is line 1
            let line = i + 2;
            let item = match row.control.as_str() {
                "finish" => Item::Finish,
                "stop" => Item::Stop,
                "rewind" => Item::Rewind(target(row).map_err(|e| ScheduleError::at(line, e))?),
                control => {
                    next.set(control, &row.value)
                        .map_err(|e| ScheduleError::at(line, e))?;
                    let goes_on = self.rows.get(i + 1).is_some_and(|other| {
                        other.attempt == row.attempt
                            && !["finish", "stop", "rewind"].contains(&other.control.as_str())
                    });
                    if goes_on {
                        continue;
                    }
                    Item::Controls(Box::new(next.clone()))
                }
            };
            let (_, change) = course.take(row.attempt, &item).map_err(|error| {
                let remedy = "give a value that the flag of that name takes";
                ScheduleError::at(line, OptionError::new(error.to_string(), remedy))
            })?;
            changes.extend(change.map(|change| TimedChange {
                attempt: row.attempt,
                change,
            }));
        }
        Ok((options, changes))
    }
}

fn target(row: &Row) -> Result<usize, OptionError> {
    let mut to = 0;
    to.set(&row.value, "")?;
    if to > row.attempt {
        let problem = format!("after {} attempts there is no shape {to}", row.attempt);
        return Err(OptionError::new(
            problem,
            "rewind to an attempt that lies behind",
        ));
    }
    Ok(to)
}
