//! Messages to the user: temporary toasts and a permanent log.

use std::time::{Duration, Instant};

/// Severity of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Success.
    Info,
    /// Success that needs attention.
    Warning,
    /// Failure.
    Error,
}

/// One message.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Severity.
    pub level: Level,
    /// The problem and the remedy.
    pub text: String,
    /// The time of the message.
    pub at: Instant,
    /// Whether the user has closed its toast.
    pub dismissed: bool,
    /// Whether the message no longer applies.
    pub past: bool,
}

impl Entry {
    /// The time for which the toast is shown.
    fn lifetime(&self) -> Duration {
        match self.level {
            Level::Info => Duration::from_secs(5),
            Level::Warning => Duration::from_secs(9),
            Level::Error => Duration::from_secs(15),
        }
    }
}

/// All messages of a session, oldest first.
#[derive(Debug, Default)]
pub struct Log {
    entries: Vec<Entry>,
}

/// Maximum number of stored messages.
const LIMIT: usize = 1000;

impl Log {
    /// Adds a message.
    pub fn note(&mut self, level: Level, text: impl Into<String>) {
        self.push(level, text.into());
    }

    /// Adds an informative message.
    pub fn info(&mut self, text: impl Into<String>) {
        self.push(Level::Info, text.into());
    }

    /// Adds a warning.
    pub fn warning(&mut self, text: impl Into<String>) {
        self.push(Level::Warning, text.into());
    }

    /// Adds an error.
    pub fn error(&mut self, text: impl Into<String>) {
        self.push(Level::Error, text.into());
    }

    fn push(&mut self, level: Level, text: String) {
        // a repeated message renews its toast
        if let Some(last) = self.entries.last_mut()
            && last.text == text
            && last.level == level
        {
            last.at = Instant::now();
            last.dismissed = false;
            last.past = false;
            return;
        }
        if self.entries.len() == LIMIT {
            self.entries.remove(0);
        }
        self.entries.push(Entry {
            level,
            text,
            at: Instant::now(),
            dismissed: false,
            past: false,
        });
    }

    /// Closes the toasts of all messages so far and ends them as the latest: the user has acted on them.
    pub fn settle(&mut self) {
        for entry in &mut self.entries {
            entry.dismissed = true;
            entry.past = true;
        }
    }

    /// The last message, unless it is over.
    pub fn latest(&self) -> Option<&Entry> {
        self.entries.last().filter(|entry| !entry.past)
    }

    /// All messages.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Indices of the messages with a visible toast, at most the newest four.
    pub fn toasts(&self, now: Instant) -> Vec<usize> {
        let mut shown: Vec<usize> = self
            .entries
            .iter()
            .enumerate()
            .rev()
            .filter(|(_, e)| !e.dismissed && now.duration_since(e.at) < e.lifetime())
            .map(|(i, _)| i)
            .take(4)
            .collect();
        shown.reverse();
        shown
    }

    /// Time until the next toast disappears; the window can sleep until then.
    pub fn next_change(&self, now: Instant) -> Option<Duration> {
        self.toasts(now)
            .iter()
            .map(|&i| {
                let e = &self.entries[i];
                e.lifetime().saturating_sub(now.duration_since(e.at))
            })
            .min()
    }

    /// Closes a toast.
    pub fn dismiss(&mut self, index: usize) {
        if let Some(entry) = self.entries.get_mut(index) {
            entry.dismissed = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn toasts_pass_and_the_log_stays() {
        let mut log = Log::default();
        log.info("saved");
        log.info("saved");
        log.error("no such file");
        assert_eq!(log.entries().len(), 2);
        let now = Instant::now();
        assert_eq!(log.toasts(now), [0, 1]);
        assert_eq!(log.toasts(now + Duration::from_secs(7)), [1]);
        log.dismiss(1);
        assert_eq!(log.toasts(now), [0]);
        assert!(
            log.next_change(now)
                .is_some_and(|d| d <= Duration::from_secs(5))
        );
        assert_eq!(log.entries().len(), 2);
        assert!(log.latest().is_some_and(|e| e.level == Level::Error));
        log.settle();
        assert!(log.latest().is_none() && log.toasts(now).is_empty());
        log.error("no such file");
        assert!(log.latest().is_some());
    }
}
