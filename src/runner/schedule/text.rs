//! Schedules as CSV text.

use std::fmt::Write as _;

use super::{Schedule, ScheduleEntry, ScheduleError};
use crate::options::OptionError;

const HEADER: &str = "attempt,control,value";

impl Schedule {
    /// Parses a schedule. A value with a comma or a quote may be quoted.
    ///
    /// # Errors
    /// The first invalid line, with its number.
    pub fn parse(text: &str) -> Result<Self, ScheduleError> {
        let mut lines = (1..).zip(text.trim_end().lines());
        if lines.next().is_none_or(|(_, l)| l.trim() != HEADER) {
            let remedy = format!("the first line is `{HEADER}`");
            let error = OptionError::new("the header is missing", remedy);
            return Err(ScheduleError::at(1, error));
        }
        let mut entries: Vec<ScheduleEntry> = Vec::new();
        for (line, text) in lines {
            let entry = entry(text).map_err(|error| ScheduleError::at(line, error))?;
            if let Some(last) = entries.last()
                && entry.attempt < last.attempt
            {
                let problem = format!("attempt {} comes after {}", entry.attempt, last.attempt);
                let error = OptionError::new(problem, "sort the rows by attempt");
                return Err(ScheduleError::at(line, error));
            }
            entries.push(entry);
        }
        Ok(Self { entries })
    }

    /// The text that parses to this schedule.
    pub fn to_csv(&self) -> String {
        let mut out = format!("{HEADER}\n");
        for entry in &self.entries {
            let value = quoted(&entry.value);
            let _ = writeln!(out, "{},{},{value}", entry.attempt, entry.control);
        }
        out
    }
}

impl TryFrom<String> for Schedule {
    type Error = ScheduleError;

    fn try_from(text: String) -> Result<Self, ScheduleError> {
        Self::parse(&text)
    }
}

impl From<Schedule> for String {
    fn from(schedule: Schedule) -> Self {
        schedule.to_csv()
    }
}

fn entry(text: &str) -> Result<ScheduleEntry, OptionError> {
    let mut parts = text.splitn(3, ',');
    let (Some(attempt), Some(control), Some(value)) = (parts.next(), parts.next(), parts.next())
    else {
        let problem = format!("`{}` has no three columns", text.trim());
        return Err(OptionError::new(problem, "write ATTEMPT,CONTROL,VALUE"));
    };
    let attempt = attempt.trim();
    let Ok(number) = attempt.parse::<usize>() else {
        let problem = format!("`{attempt}` is not a number of attempts");
        return Err(OptionError::new(problem, "write a whole number"));
    };
    Ok(ScheduleEntry {
        attempt: number,
        control: control.trim().to_owned(),
        // the value as written
        value: unquoted(value.trim()).replace('\r', " "),
    })
}

fn quoted(value: &str) -> String {
    // a typed energy may contain line breaks; its grammar treats them as spaces
    let value = value.replace(['\r', '\n'], " ");
    if value.contains([',', '"']) || value.trim() != value {
        format!("\"{}\"", value.replace('"', "\"\""))
    } else {
        value
    }
}

fn unquoted(value: &str) -> String {
    match value.strip_prefix('"').and_then(|v| v.strip_suffix('"')) {
        Some(inside) => inside.replace("\"\"", "\""),
        None => value.to_owned(),
    }
}
