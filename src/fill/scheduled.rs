//! Running the groups of a fill to their ends, with changes on the way.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::fill::context::{ChangeError, FillContext};
use crate::fill::group_flow::GroupFlow;
use crate::fill::patch_topology::PatchTopology;
use crate::fill::schedule::{Change, TimedChange};
use crate::fill::{FillOptions, GroupResult};
use crate::mesh::DVec3;
use crate::solver::{SolverError, StepRecord};

/// A group that was run to its end.
pub(super) struct Ran {
    pub result: Result<GroupResult, SolverError>,
    pub topology: Arc<PatchTopology>,
    pub positions: Vec<DVec3>,
}

/// Runs a group to its end.
///
/// Attempts are counted by a clock that all groups share: where a group has ended before a change,
/// its clock goes on while those of others take their steps.
pub(super) fn run_group(
    ground: FillContext<'_>,
    group: usize,
    options: &FillOptions,
    changes: &[TimedChange],
    observe: &dyn Fn(&StepRecord) -> bool,
) -> Ran {
    let mut replay = Replay {
        ground,
        run: GroupFlow::start(ground, group, options),
        clock: 0,
        wanted: targets(changes),
        kept: BTreeMap::new(),
        records: Vec::new(),
    };
    replay.keep(0, 0);
    for change in changes {
        if !replay.run_until(change.attempt, observe) {
            break;
        }
        replay.apply(&change.change);
    }
    replay.run_until(usize::MAX, observe);
    let Replay {
        mut run, records, ..
    } = replay;
    Ran {
        result: run.outcome().map(|(outcome, timings)| GroupResult {
            outcome,
            records,
            timings,
        }),
        positions: run.positions(),
        topology: Arc::clone(run.topology()),
    }
}

/// The attempts after which shapes will be wanted again.
fn targets(changes: &[TimedChange]) -> BTreeSet<usize> {
    let rewinds = changes.iter().filter_map(|c| match c.change {
        Change::Rewind { to, .. } => Some(to),
        _ => None,
    });
    rewinds.collect()
}

/// A shape to go back to.
struct Kept {
    shape: Arc<PatchTopology>,
    positions: Vec<DVec3>,
    step: usize,
}

struct Replay<'a> {
    ground: FillContext<'a>,
    run: GroupFlow,
    clock: usize,
    wanted: BTreeSet<usize>,
    kept: BTreeMap<usize, Kept>,
    records: Vec<StepRecord>,
}

impl Replay<'_> {
    /// Keeps the present shape as that after the attempts `first..=last` that are wanted.
    fn keep(&mut self, first: usize, last: usize) {
        for &attempt in self.wanted.range(first..=last) {
            let kept = Kept {
                shape: Arc::clone(self.run.topology()),
                positions: self.run.positions(),
                step: self.run.steps(),
            };
            self.kept.insert(attempt, kept);
        }
    }

    /// Attempts steps until the clock stands at `attempt`. `false` if the observer ends the flow.
    fn run_until(&mut self, attempt: usize, observe: &dyn Fn(&StepRecord) -> bool) -> bool {
        while self.clock < attempt {
            let Some(record) = self.run.attempt(self.ground) else {
                break;
            };
            self.clock += 1;
            self.keep(self.clock, self.clock);
            let go_on = observe(&record);
            self.records.push(record);
            if !go_on {
                self.run.stop();
                return false;
            }
        }
        if attempt != usize::MAX && self.clock < attempt {
            self.keep(self.clock + 1, attempt);
            self.clock = attempt;
        }
        true
    }

    fn apply(&mut self, change: &Change) {
        let result = match change {
            Change::Stop => {
                self.run.stop();
                Ok(())
            }
            Change::Options(options) => self.run.change(self.ground, options),
            Change::Rewind { to, options } => self.rewind(*to, options),
        };
        if let Err(error) = result {
            self.run.warn(refusal(&error));
        }
    }

    fn rewind(&mut self, to: usize, options: &FillOptions) -> Result<(), ChangeError> {
        self.clock += 1;
        let Some(kept) = self.kept.get(&to) else {
            return Ok(());
        };
        let result = self.run.rewind(
            self.ground,
            &kept.shape,
            &kept.positions,
            kept.step,
            options,
        );
        self.keep(self.clock, self.clock);
        result
    }
}

/// What is said of a change that a group does not take part in.
pub(super) fn refusal(error: &ChangeError) -> String {
    format!("a change was refused and the flow went on as before: {error}")
}
