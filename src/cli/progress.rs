//! A progress line on a terminal.

use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::sync::Mutex;

use indicatif::{ProgressBar, ProgressStyle};

use crate::cli::print::are_lines_kept;
use crate::solver::StepRecord;

/// The kind of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// Filling this number of holes; steps belong to groups of holes.
    Holes(usize),
    /// Fairing a region.
    Fairing,
    /// Refining a mesh; steps belong to levels.
    Refinement,
}

impl Work {
    /// The text before the first step.
    fn start(self) -> String {
        match self {
            Self::Holes(1) => "1 hole: first patches".into(),
            Self::Holes(count) => format!("{count} holes: first patches"),
            Self::Fairing => "fairing: start".into(),
            Self::Refinement => "level 1: start".into(),
        }
    }

    /// The text after a step of a group or level. `steps` are the accepted steps of each.
    fn after(self, steps: &BTreeMap<usize, usize>, group: usize, record: &StepRecord) -> String {
        let total: usize = steps.values().sum();
        let flows = steps.len();
        let place = match self {
            Self::Holes(_) if flows == 1 => format!("1 flow, {total} steps"),
            Self::Holes(_) => format!("{flows} flows, {total} steps"),
            Self::Fairing => format!("fairing, {total} steps"),
            Self::Refinement => format!("level {group}, {} steps", record.step),
        };
        let last = match &record.rejection {
            Some(reason) => format!("rejected: {reason}"),
            None => format!("residual {:.1e}", record.residual),
        };
        format!("{place}; energy {:.6e}, {last}", record.energy)
    }
}

/// A spinner, hidden if standard error is no terminal.
pub fn spinner(quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{spinner} {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_spinner());
    let bar = ProgressBar::new_spinner().with_style(style);
    bar.enable_steady_tick(std::time::Duration::from_millis(100));
    bar
}

/// A spinner that shows the last step. It is hidden if other files are processed beside this one.
pub struct Progress {
    bar: ProgressBar,
    work: Work,
    steps: Mutex<BTreeMap<usize, usize>>,
}

impl Progress {
    /// Shows the line, unless `quiet`.
    pub fn new(work: Work, quiet: bool) -> Self {
        let bar = spinner(quiet || work == Work::Holes(0) || are_lines_kept());
        bar.set_message(work.start());
        Self {
            bar,
            work,
            steps: Mutex::new(BTreeMap::new()),
        }
    }

    /// Shows an attempted step of a group or level.
    pub fn step(&self, group: usize, record: &StepRecord) {
        if let Ok(mut steps) = self.steps.lock() {
            steps.insert(group, record.step);
            let message = self.work.after(&steps, group, record);
            self.bar.set_message(message);
        }
    }

    /// Removes the line.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::{RejectReason, StepKind};

    #[test]
    fn a_refinement_has_levels_and_no_holes() {
        let record = StepRecord {
            step: 3,
            tau: 1.0,
            energy: 2.0,
            residual: f64::NAN,
            rejection: Some(RejectReason::NoDescent),
            kind: StepKind::Factorized,
            iterations: None,
            linear_residual: None,
        };
        let steps = BTreeMap::from([(1, 5), (2, 3)]);
        let text = Work::Refinement.after(&steps, 2, &record);
        let wanted =
            "level 2, 3 steps; energy 2.000000e0, rejected: the step does not lower the energy";
        assert_eq!(text, wanted);
        let start = Work::Refinement.start();
        assert!(
            !start.contains("hole") && !start.contains("patch"),
            "{start}"
        );
        let fill = Work::Holes(4).after(&steps, 2, &record);
        assert!(fill.starts_with("2 flows, 8 steps"), "{fill}");
    }
}
