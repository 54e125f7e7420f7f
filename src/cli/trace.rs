//! The CSV trace of the steps of flows.

use std::fmt::{Display, Write as _};

use crate::fill::Filled;
use crate::solver::StepRecord;

/// A table with one line for each attempted step. Cells without a value are empty.
pub struct Trace(String);

impl Trace {
    /// An empty table. `first` is the name of the first column, which holds the owner of a step.
    pub fn new(first: &str) -> Self {
        Self(format!(
            "{first},step,tau,energy,residual,rejected,reason\n"
        ))
    }

    /// The steps of all groups of a fill, with the first loop of the group, or 0 if it has none.
    pub fn of_fill(filled: &Filled) -> Self {
        let mut trace = Self::new("loop");
        for (g, group) in filled.groups.iter().enumerate() {
            let first = filled.first_hole(g);
            let owner = first.map_or_else(|| "0".into(), |hole| hole.id().to_string());
            for record in group.iter().flat_map(|group| &group.records) {
                trace.add(&owner, record);
            }
        }
        trace
    }

    /// Adds a step of `owner`.
    pub fn add(&mut self, owner: &dyn Display, record: &StepRecord) {
        let StepRecord {
            step, tau, energy, ..
        } = record;
        let residual = (!record.is_rejected()).then(|| format!("{:e}", record.residual));
        let (residual, rejected) = (residual.unwrap_or_default(), u8::from(record.is_rejected()));
        let reason = record.rejection.as_ref().map_or("", |reason| reason.code());
        // writing to a String cannot fail
        let _ = writeln!(
            self.0,
            "{owner},{step},{tau:e},{energy:e},{residual},{rejected},{reason}"
        );
    }

    /// The table.
    pub fn text(&self) -> &str {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::{RejectReason, StepKind};

    #[test]
    fn a_rejected_step_has_a_reason_and_no_residual() {
        let accepted = StepRecord {
            step: 1,
            tau: 0.5,
            energy: 2.0,
            residual: 0.25,
            rejection: None,
            kind: StepKind::Factorized,
            iterations: None,
            linear_residual: None,
        };
        let rejected = StepRecord {
            residual: f64::NAN,
            rejection: Some(RejectReason::NotSolved {
                relative_residual: 0.1,
                iterations: 7,
            }),
            ..accepted.clone()
        };
        let mut trace = Trace::new("level");
        trace.add(&2, &accepted);
        trace.add(&2, &rejected);
        let wanted = "level,step,tau,energy,residual,rejected,reason\n\
                      2,1,5e-1,2e0,2.5e-1,0,\n2,1,5e-1,2e0,,1,gmres\n";
        assert_eq!(trace.text(), wanted);
    }
}
