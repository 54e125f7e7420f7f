//! A progress line on a terminal.

use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::sync::Mutex;

use indicatif::{ProgressBar, ProgressStyle};

use crate::solver::StepRecord;

/// A spinner that shows the last step of any group; nothing where stderr is no terminal.
pub struct Progress {
    bar: ProgressBar,
    steps: Mutex<BTreeMap<usize, usize>>,
}

impl Progress {
    /// For filling `holes` holes.
    pub fn new(holes: usize, quiet: bool) -> Self {
        let bar = if quiet || holes == 0 || !std::io::stderr().is_terminal() {
            ProgressBar::hidden()
        } else {
            let style = ProgressStyle::with_template("{spinner} {msg}")
                .unwrap_or_else(|_| ProgressStyle::default_spinner());
            let bar = ProgressBar::new_spinner().with_style(style);
            bar.enable_steady_tick(std::time::Duration::from_millis(100));
            let noun = if holes == 1 { "hole" } else { "holes" };
            bar.set_message(format!("{holes} {noun}: first patches"));
            bar
        };
        Self {
            bar,
            steps: Mutex::new(BTreeMap::new()),
        }
    }

    /// A step of a group was attempted.
    pub fn step(&self, group: usize, record: &StepRecord) {
        if let Ok(mut steps) = self.steps.lock() {
            steps.insert(group, record.step);
            let total: usize = steps.values().sum();
            self.bar.set_message(format!(
                "{} flows started, {total} steps; energy {:.6e}, residual {:.1e}",
                steps.len(),
                record.energy,
                record.residual
            ));
        }
    }

    /// Takes the line away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
