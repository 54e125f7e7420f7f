//! Fills up to their flows: options and first patches.

use std::borrow::Cow;
use std::time::Instant;

use crate::fill::Controls;
use crate::fill::estimate::memory_of;
use crate::fill::fairing::plan_fairing;
use crate::fill::options::FillOptions;
use crate::fill::partial::plan_part;
use crate::fill::plan::Plan;
use crate::fill::prepare::{Prepared, prepare};
use crate::fill::result::{PartialError, RefillError, milliseconds};
use crate::fill::rim::RimSet;
use crate::mesh::{BoundaryLoop, LoopId, Mesh, VertexId};
use crate::runner::{Recording, Schedule, ScheduleError};

/// The options a fill starts with, and the changes to them during the flow.
#[derive(Clone, Debug)]
pub struct ScheduledOptions {
    pub(super) options: FillOptions,
    pub(super) recording: Recording<Controls>,
}

impl ScheduledOptions {
    /// The options with which a fill repeats, bit-identically, a [live fill](crate::fill::LiveFill)
    /// that started with `controls` and recorded `schedule`.
    ///
    /// # Errors
    /// Invalid controls or an invalid schedule.
    pub fn new(controls: &Controls, schedule: &Schedule) -> Result<Self, ScheduleError> {
        let recording = schedule.recording(controls)?;
        let options = controls.options();
        let options = options.map_err(|error| ScheduleError::Start(error.to_string()))?;
        Ok(Self { options, recording })
    }

    /// The same for holes, which are filled without islands in them where no sound first patch joins these;
    /// see [`FillOptions::leaves_islands`].
    #[must_use]
    pub fn leaving_islands(mut self) -> Self {
        self.options.leaves_islands = true;
        self
    }
}

impl From<&FillOptions> for ScheduledOptions {
    /// No changes.
    fn from(options: &FillOptions) -> Self {
        Self {
            options: options.clone(),
            recording: Recording::default(),
        }
    }
}

/// A fill whose first patches are made and whose flows have not started.
pub struct PreparedFill<'a> {
    pub(super) mesh: Cow<'a, Mesh>,
    pub(super) plan: Plan,
    pub(super) options: ScheduledOptions,
    pub(super) milliseconds: f64,
}

impl<'a> PreparedFill<'a> {
    /// Makes one patch for each set of rims. The faces `strips` of bridges (ascending) flow with the patches
    /// of the holes beside them, if these are all filled (see [`release`](crate::fill::release)). Such faces
    /// are not in the result.
    pub fn new(
        mesh: &'a Mesh,
        rim_sets: &[RimSet<'_>],
        strips: &[u32],
        options: impl Into<ScheduledOptions>,
    ) -> Self {
        let start = Instant::now();
        let options = options.into();
        let Prepared { plan, mesh: other } = prepare(mesh, rim_sets, strips, &options.options);
        let mesh = other.map_or(Cow::Borrowed(mesh), Cow::Owned);
        Self::of_plan(mesh, plan, options, start)
    }

    /// Makes a patch over part of a hole: along its rim from the vertex of index `from` to that of index
    /// `to`, in the loop's direction. The patch ends at a curve through the hole that joins the two vertices
    /// and leaves the surface smoothly at both. The vertices of the curve are new and do not flow.
    ///
    /// # Errors
    /// [`PartialError`].
    ///
    /// # Panics
    /// If an index is out of range.
    pub fn part(
        mesh: &Mesh,
        hole: &BoundaryLoop,
        [from, to]: [usize; 2],
        options: impl Into<ScheduledOptions>,
    ) -> Result<Self, PartialError> {
        let start = Instant::now();
        let options = options.into();
        let (longer, plan) = plan_part(mesh, hole, [from, to], &options.options)?;
        Ok(Self::of_plan(Cow::Owned(longer), plan, options, start))
    }

    /// Prepares the flow of the inner vertices of selected faces, one flag each; see [`fair`](crate::fill::fair).
    ///
    /// # Errors
    /// The selection is empty, has no inner vertices, or has no faces around it.
    pub fn fairing(
        mesh: &'a Mesh,
        selected: &[bool],
        options: impl Into<ScheduledOptions>,
    ) -> Result<Self, RefillError> {
        let start = Instant::now();
        let plan = plan_fairing(mesh, selected)?;
        Ok(Self::of_plan(
            Cow::Borrowed(mesh),
            plan,
            options.into(),
            start,
        ))
    }

    fn of_plan(mesh: Cow<'a, Mesh>, plan: Plan, options: ScheduledOptions, start: Instant) -> Self {
        Self {
            mesh,
            plan,
            options,
            milliseconds: milliseconds(start),
        }
    }

    /// The memory in bytes that the flows and the filled mesh take.
    pub fn memory(&self) -> f64 {
        memory_of(&self.mesh, &self.plan, &self.options.options)
    }

    /// The rim edges of some loops, as vertices of the filled mesh.
    pub fn rim_edges(&self, is_wanted: impl Fn(LoopId) -> bool) -> Vec<[VertexId; 2]> {
        let topology = &self.mesh.topology;
        let rims = self.plan.holes().iter().flat_map(|hole| &hole.rims.loops);
        let wanted = rims.filter(|rim| is_wanted(rim.id));
        let halfedges = wanted.flat_map(|rim| &rim.halfedges);
        halfedges
            .map(|&h| [topology.origin(h), topology.target(h)])
            .collect()
    }
}
