//! Runs the groups of a fill to their ends, with scheduled changes.

use std::sync::Arc;

use crate::fill::context::FillContext;
use crate::fill::patch_topology::PatchTopology;
use crate::fill::process::{GroupProcess, GroupProgress};
use crate::fill::{Controls, FillOptions, GroupResult};
use crate::mesh::{DVec3, LoopId};
use crate::runner::{Recording, replay};
use crate::solver::{SolverError, StepRecord};
use crate::warning::Warning;

/// The result of a group that was run to its end.
pub(super) struct GroupOutcome {
    pub result: Result<GroupResult, SolverError>,
    pub patch_warnings: Vec<(LoopId, Warning)>,
    pub topology: Arc<PatchTopology>,
    pub positions: Vec<DVec3>,
}

/// Runs a group to its end, independently of the others.
pub(super) fn run_group(
    context: FillContext<'_>,
    group: usize,
    options: &FillOptions,
    recording: &Recording<Controls>,
    observe: &dyn Fn(&StepRecord) -> bool,
) -> GroupOutcome {
    let group = GroupProgress::start(context, group, options);
    let mut process = GroupProcess { context, group };
    let mut records = Vec::new();
    let Ok(_) = replay(&mut process, recording, &mut |record| {
        let goes_on = observe(&record);
        records.push(record);
        goes_on
    });
    let state = process.group.state(context);
    let mut run = process.group.run;
    let surface = run.surface();
    GroupOutcome {
        patch_warnings: run.patch_warnings().to_vec(),
        result: run.outcome().map(|(outcome, timings)| GroupResult {
            surface,
            outcome,
            records,
            timings,
        }),
        positions: state.positions.to_vec(),
        topology: Arc::clone(&state.patches),
    }
}
