//! A fill as a process: all groups of holes attempt their steps together.
//!
//! [`LiveFill`] runs it in the background. [`fill_rim_sets`](crate::fill::fill_rim_sets) with
//! [`ScheduledOptions`] repeats such a run, each group on its own,
//! with bit-identical results.

mod events;
mod group;
mod state;

use std::borrow::Cow;
use std::fmt::Display;
use std::sync::Arc;

use rayon::prelude::*;

use crate::cancel::is_cancelled;
use crate::fill::assemble::Assembly;
use crate::fill::attributes::Look;
use crate::fill::context::FillContext;
use crate::fill::defects::defects_between_groups;
use crate::fill::estimate::memory_of;
use crate::fill::hole::PlannedHole;
use crate::fill::plan::Plan;
use crate::fill::prepared::{PreparedFill, ScheduledOptions};
use crate::fill::{Controls, ControlsError, FillError, FillOptions};
use crate::memory::require;
use crate::mesh::{LoopId, Mesh};
use crate::runner::{
    Process, Refused, RunControls, RunSettings, Runner, Snapshot, StartError, Wake,
};
use crate::solver::FASTEST;
use crate::warning::Warning;

pub use events::{FillEvent, GroupStatus};
pub(super) use group::{GroupProcess, GroupProgress};
pub use state::{FillState, GroupState};

/// A fill running in the background.
pub type LiveFill = Runner<FillProcess>;
/// A stored state of a fill. Positions and connectivities take 24 bytes a vertex and 12 a patch
/// face of each group, and about 24 a vertex and 72 a face of the filled mesh for each
/// triangulation of a patch.
pub type FillSnapshot = Snapshot<FillState>;

impl RunControls for Controls {
    const FIXED: &'static [&'static str] = &[];
    const FASTEST: &'static [(&'static str, &'static str)] = FASTEST;
    type Error = ControlsError;

    fn validate(&self) -> Result<(), ControlsError> {
        self.options().map(|_| ())
    }
}

impl Runner<FillProcess> {
    /// Starts a fill of a mesh. `prepare` makes its first patches, with the options of `controls`, on the
    /// background thread; its error comes back as [`Event::Failed`](crate::runner::Event::Failed). `wake` is
    /// called from that thread whenever there is something to [poll](Self::poll).
    ///
    /// # Errors
    /// Invalid controls, or no thread is left.
    pub fn spawn<E: Display>(
        mesh: Arc<Mesh>,
        controls: Controls,
        settings: RunSettings,
        wake: Wake,
        prepare: impl FnOnce(&Mesh) -> Result<PreparedFill<'_>, E> + Send + 'static,
    ) -> Result<Self, StartError<ControlsError>> {
        controls.validate().map_err(StartError::Options)?;
        let set_up = move || {
            let prepared = prepare(&mesh).map_err(|error| error.to_string())?;
            FillProcess::new(&mesh, prepared).map_err(|error| error.to_string())
        };
        Self::start("fill", controls, settings, wake, set_up).map_err(StartError::Thread)
    }

    /// The status of each group of holes at the last [`Self::poll`]; empty until the groups are set
    /// up.
    pub fn groups(&self) -> &[GroupStatus] {
        self.status()
    }
}

/// A fill of any number of groups of holes.
pub struct FillProcess {
    mesh: Arc<Mesh>,
    plan: Plan,
    groups: Vec<GroupProgress>,
    assembly: Arc<Assembly>,
    /// The options at the start count.
    look: Look,
    /// Holes without a patch that are not reported yet.
    failed_holes: Vec<FillError>,
    /// Warnings about patches that no flow changes, not reported yet.
    warnings: Vec<(LoopId, Warning)>,
    /// Whether the patches were checked against those of other groups since the last change.
    groups_checked: bool,
}

impl FillProcess {
    /// `mesh` is the mesh that was prepared.
    pub(super) fn new(mesh: &Arc<Mesh>, prepared: PreparedFill<'_>) -> Result<Self, FillError> {
        let PreparedFill {
            mesh: other,
            mut plan,
            options: ScheduledOptions { options, .. },
            ..
        } = prepared;
        let mesh = match other {
            Cow::Borrowed(_) => Arc::clone(mesh),
            Cow::Owned(other) => Arc::new(other),
        };
        let options = &options;
        let failed_holes = std::mem::take(&mut plan.failed);
        let of_hole = |hole: &PlannedHole| {
            let id = hole.rims.id();
            let warnings = hole.warnings.clone();
            warnings.into_iter().map(move |warning| (id, warning))
        };
        let warnings = plan.holes().iter().flat_map(of_hole).collect();
        require(memory_of(&mesh, &plan, options))?;
        let context = FillContext {
            mesh: &mesh,
            plan: &plan,
        };
        let groups = (0..plan.groups.len()).into_par_iter();
        let start = |g| GroupProgress::start(context, g, options);
        let groups: Vec<GroupProgress> = groups.map(start).collect();
        let patches = groups.iter().map(|g| Arc::clone(g.run.topology()));
        let look = Look::new(options);
        let assembly = Assembly::new(&mesh, &plan, patches.collect(), &look);
        let assembly = Arc::new(assembly?);
        let (ahead, given) = (Arc::clone(&assembly), Arc::clone(&mesh));
        rayon::spawn(move || ahead.prepare_look(&given));
        Ok(Self {
            mesh,
            plan,
            groups,
            look,
            assembly,
            failed_holes,
            warnings,
            groups_checked: false,
        })
    }

    /// Warnings about patches that cross those of other groups or are folded onto them.
    fn defects_between_groups(&mut self) -> Vec<(LoopId, Warning)> {
        let Ok(state) = self.state() else {
            return Vec::new();
        };
        let positions = state.groups.iter().map(|group| &group.positions[..]);
        let positions = self.assembly.positions(&self.mesh, positions);
        let holes = &self.assembly.holes;
        defects_between_groups(&self.assembly.topology, &positions, holes)
    }

    /// Changes all groups. Groups that cannot make the change report the reason.
    fn change(
        &mut self,
        controls: &Controls,
        change: impl Fn(&mut GroupProgress, usize, FillContext<'_>, &FillOptions) -> Result<(), String>
        + Sync,
    ) -> Vec<Refused> {
        let options = match controls.options() {
            Ok(options) => options,
            Err(error) => {
                let (part, text) = (None, error.to_string());
                return vec![Refused { part, text }];
            }
        };
        let context = FillContext {
            mesh: &self.mesh,
            plan: &self.plan,
        };
        self.groups_checked = false;
        let groups = self.groups.par_iter_mut().enumerate();
        let results = groups.map(|(g, group)| (g, change(group, g, context, &options)));
        let refused = |(g, result): (usize, Result<(), String>)| {
            let (part, text) = (Some(g), result.err()?);
            Some(Refused { part, text })
        };
        results.filter_map(refused).collect()
    }
}

impl Process for FillProcess {
    type Controls = Controls;
    type State = FillState;
    type Event = FillEvent;
    type Status = Vec<GroupStatus>;
    type Error = FillError;

    /// One attempt of every group that has not ended.
    fn advance(&mut self, clock: usize, emit: &mut dyn FnMut(FillEvent)) -> Result<(), FillError> {
        let context = FillContext {
            mesh: &self.mesh,
            plan: &self.plan,
        };
        let attempt = |group: &mut GroupProgress| {
            (!is_cancelled())
                .then(|| group.attempt(context, clock))
                .flatten()
        };
        let records: Vec<_> = self.groups.par_iter_mut().map(attempt).collect();
        for (group, record) in records.into_iter().enumerate() {
            if let Some(record) = record {
                emit(FillEvent::Step { group, record });
            }
        }
        for (g, group) in self.groups.iter_mut().enumerate() {
            group.crossing_event(g).into_iter().for_each(&mut *emit);
        }
        Ok(())
    }

    fn set_controls(&mut self, controls: &Controls) -> Vec<Refused> {
        self.change(controls, |group, _, context, options| {
            group.set_options(context, options)
        })
    }

    fn rewind(&mut self, to: &Arc<FillState>, controls: &Controls) -> Vec<Refused> {
        let refused = self.change(controls, |group, g, context, options| {
            group.rewind(context, &to.groups[g], options)
        });
        self.assembly = Arc::clone(&to.assembly);
        refused
    }

    fn stop(&mut self, _: &mut dyn FnMut(FillEvent)) {
        self.groups.iter_mut().for_each(GroupProgress::stop);
    }

    fn ended(&self) -> bool {
        self.groups.iter().all(|g| g.run.ended())
    }

    fn has_new_state(&self) -> bool {
        self.groups.iter().any(|g| g.is_new)
    }

    fn state(&mut self) -> Result<Arc<FillState>, FillError> {
        let context = FillContext {
            mesh: &self.mesh,
            plan: &self.plan,
        };
        let groups: Vec<_> = self.groups.iter_mut().map(|g| g.state(context)).collect();
        if !self.assembly.fits(groups.iter().map(|g| &g.patches)) {
            let patches = groups.iter().map(|g| Arc::clone(&g.patches));
            let assembly = Assembly::new(&self.mesh, &self.plan, patches.collect(), &self.look);
            self.assembly = Arc::new(assembly?);
        }
        Ok(Arc::new(FillState {
            groups,
            given: Arc::clone(&self.mesh),
            assembly: Arc::clone(&self.assembly),
        }))
    }

    fn status(&mut self, seconds: f64, emit: &mut dyn FnMut(FillEvent)) -> Vec<GroupStatus> {
        for error in self.failed_holes.drain(..) {
            emit(FillEvent::Failed {
                group: None,
                holes: error.hole().into_iter().collect(),
                text: error.to_string(),
            });
        }
        if self.ended() && !std::mem::replace(&mut self.groups_checked, true) {
            let found = self.defects_between_groups();
            self.warnings.extend(found);
        }
        for (hole, warning) in self.warnings.drain(..) {
            emit(FillEvent::Warned { hole, warning });
        }
        let plan = &self.plan;
        let groups = self.groups.iter_mut().enumerate();
        let statuses = groups.map(|(g, group)| {
            let holes = plan.hole_ids(g);
            group.end_events(g, &holes).into_iter().for_each(&mut *emit);
            group.status(holes, plan.closed_loops(g), plan.groups[g].radius, seconds)
        });
        statuses.collect()
    }

    fn pauses(event: &FillEvent) -> bool {
        matches!(event, FillEvent::SelfIntersection { .. })
    }
}
