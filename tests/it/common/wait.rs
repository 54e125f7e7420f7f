//! Waiting for conditions.

use std::time::{Duration, Instant};

/// Time between two checks of a condition.
const INTERVAL: Duration = Duration::from_millis(5);

/// Calls `found` until it returns something; panics after two minutes.
pub fn wait_for<T>(what: &str, found: impl FnMut() -> Option<T>) -> T {
    let found = wait_at_most(Duration::from_mins(2), found);
    found.unwrap_or_else(|| panic!("waited in vain for {what}"))
}

/// Calls `found` until it returns something or the time is over.
pub fn wait_at_most<T>(limit: Duration, mut found: impl FnMut() -> Option<T>) -> Option<T> {
    let begun = Instant::now();
    loop {
        let value = found();
        if value.is_some() || begun.elapsed() > limit {
            return value;
        }
        std::thread::sleep(INTERVAL);
    }
}
