//! The controls that are active during a run.

use super::{Schedule, ScheduleEntry, ScheduleError};
use crate::options::{OptionError, OptionValue};
use crate::runner::{Change, Recording, RunControls};

/// Commands that are not controls.
const COMMANDS: [&str; 3] = ["finish", "rewind", "stop"];

/// A user command between two steps.
#[derive(Clone, Debug)]
pub(in crate::runner) enum UserCommand<C> {
    Controls(Box<C>),
    Finish,
    /// Continue from the state at that clock.
    Rewind(usize),
    Stop,
}

/// The active controls.
#[derive(Clone, Debug)]
pub(in crate::runner) struct ActiveControls<C> {
    controls: C,
    /// Whether fast mode is on until mode or time step are set again.
    finishing: bool,
}

impl<C: RunControls> ActiveControls<C> {
    pub fn new(controls: C) -> Self {
        Self {
            controls,
            finishing: false,
        }
    }

    fn effective(&self) -> C {
        let mut controls = self.controls.clone();
        if self.finishing {
            for (name, text) in C::FASTEST {
                // these are names and texts of options
                controls.set(name, text).ok();
            }
        }
        controls
    }

    /// The entries that record a command at `clock`, and the change that it makes, if any.
    pub fn take(
        &mut self,
        clock: usize,
        command: &UserCommand<C>,
    ) -> (Vec<ScheduleEntry>, Option<Change<C>>) {
        let entry = |control: &str, value: String| ScheduleEntry {
            attempt: clock,
            control: control.into(),
            value,
        };
        match command {
            UserCommand::Controls(controls) => {
                let changed = self.controls.difference(controls).into_iter();
                let entries: Vec<_> = changed.map(|(name, value)| entry(&name, value)).collect();
                if entries.is_empty() {
                    return (entries, None);
                }
                let sets_pace = |e: &ScheduleEntry| C::FASTEST.iter().any(|f| f.0 == e.control);
                self.finishing &= !entries.iter().any(sets_pace);
                self.controls = (**controls).clone();
                (entries, Some(Change::Controls(Box::new(self.effective()))))
            }
            UserCommand::Finish => {
                self.finishing = true;
                let change = Change::Controls(Box::new(self.effective()));
                (vec![entry("finish", String::new())], Some(change))
            }
            UserCommand::Rewind(to) => {
                self.finishing = false;
                let controls = Box::new(self.effective());
                let change = Change::Rewind { to: *to, controls };
                (vec![entry("rewind", to.to_string())], Some(change))
            }
            UserCommand::Stop => (vec![entry("stop", String::new())], Some(Change::Stop)),
        }
    }
}

impl Schedule {
    /// The changes of a run that starts with these controls. Consecutive entries that set controls
    /// at the same attempt are one change.
    ///
    /// # Errors
    /// The first row that names no control, has an invalid value, or changes an option that is
    /// fixed during a run.
    pub fn recording<C: RunControls>(&self, start: &C) -> Result<Recording<C>, ScheduleError> {
        let invalid = |error: C::Error| ScheduleError::Start(error.to_string());
        start.validate().map_err(invalid)?;
        let mut active = ActiveControls::new(start.clone());
        let mut changes = Vec::new();
        let mut next = start.clone();
        for (i, entry) in self.entries.iter().enumerate() {
            // the header is line 1
            let at = |error| ScheduleError::at(i + 2, error);
            let command = match entry.control.as_str() {
                "finish" => UserCommand::Finish,
                "stop" => UserCommand::Stop,
                "rewind" => UserCommand::Rewind(target(entry).map_err(at)?),
                control => {
                    set(&mut next, control, &entry.value).map_err(at)?;
                    let continues = self.entries.get(i + 1).is_some_and(|other| {
                        other.attempt == entry.attempt
                            && !COMMANDS.contains(&other.control.as_str())
                    });
                    if continues {
                        continue;
                    }
                    let remedy = "give a value that the flag of that name takes";
                    let error = |e: C::Error| at(OptionError::new(e.to_string(), remedy));
                    next.validate().map_err(error)?;
                    UserCommand::Controls(Box::new(next.clone()))
                }
            };
            let (_, change) = active.take(entry.attempt, &command);
            changes.extend(change.map(|change| (entry.attempt, change)));
        }
        Ok(Recording { changes })
    }
}

fn set<C: RunControls>(controls: &mut C, control: &str, value: &str) -> Result<(), OptionError> {
    if C::FIXED.contains(&control) {
        let problem = format!("`{control}` cannot be changed while a run is in progress");
        return Err(OptionError::new(problem, "set it for the start"));
    }
    let mut names: Vec<String> = C::entries().into_iter().map(|e| e.name).collect();
    if !names.iter().any(|name| name == control) {
        names.retain(|name| !C::FIXED.contains(&name.as_str()));
        names.extend(COMMANDS.map(str::to_owned));
        let problem = format!("unknown control `{control}`");
        return Err(OptionError::new(
            problem,
            format!("controls are {}", names.join(", ")),
        ));
    }
    controls.set(control, value)
}

fn target(entry: &ScheduleEntry) -> Result<usize, OptionError> {
    let mut to = 0usize;
    to.set(&entry.value, "")?;
    if to > entry.attempt {
        let problem = format!("after {} attempts there is no state {to}", entry.attempt);
        let remedy = "rewind to an earlier attempt";
        return Err(OptionError::new(problem, remedy));
    }
    Ok(to)
}
