//! Fills from end to end: first patches, flows, the filled mesh.

use std::borrow::Cow;
use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use crate::fill::Controls;
use crate::fill::assemble::Assembly;
use crate::fill::attributes::Look;
use crate::fill::context::FillContext;
use crate::fill::defects::defects_between_groups;
use crate::fill::estimate::memory_of;
use crate::fill::options::FillOptions;
use crate::fill::partial::plan_part;
use crate::fill::plan::Plan;
use crate::fill::prepare::prepare;
use crate::fill::result::{FillError, Filled, PartialError, milliseconds};
use crate::fill::rim::RimSet;
use crate::fill::scheduled::run_group;
use crate::memory::require;
use crate::mesh::{BoundaryLoop, LoopId, Mesh, VertexId};
use crate::runner::{Recording, Schedule, ScheduleError};
use crate::solver::StepRecord;

/// A callback for every attempted step, with (group, record). Returns whether the flow of the group
/// continues.
pub type Observer<'a> = &'a (dyn Fn(usize, &StepRecord) -> bool + Sync);

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

/// Fills holes and blends: one patch for each set of rims.
///
/// # Errors
/// The result would not be a manifold, or the flows need more memory than is free. Failures of single
/// holes are in the result.
pub fn fill_rim_sets(
    mesh: &Mesh,
    rim_sets: &[RimSet<'_>],
    options: impl Into<ScheduledOptions>,
    observe: Observer<'_>,
) -> Result<Filled, FillError> {
    PreparedFill::new(mesh, rim_sets, &[], options).run(observe)
}

/// As [`fill_rim_sets`]; the faces `strips` of bridges (ascending) flow with the patches of the holes beside
/// them, if these are all filled (see [`release`](crate::fill::release)). They are not in the result.
///
/// # Errors
/// As [`fill_rim_sets`].
pub fn fill_bridged(
    mesh: &Mesh,
    rim_sets: &[RimSet<'_>],
    strips: &[u32],
    options: impl Into<ScheduledOptions>,
    observe: Observer<'_>,
) -> Result<Filled, FillError> {
    PreparedFill::new(mesh, rim_sets, strips, options).run(observe)
}

/// Fills the part of a hole along its rim from the vertex of index `from` to that of index `to`, in
/// the loop's direction. The patch ends at a curve through the hole that joins the two vertices and
/// leaves the surface smoothly at both. The vertices of the curve are new and do not flow.
///
/// # Errors
/// [`PartialError`].
///
/// # Panics
/// If an index is out of range.
pub fn fill_part(
    mesh: &Mesh,
    hole: &BoundaryLoop,
    from: usize,
    to: usize,
    options: impl Into<ScheduledOptions>,
    observe: Observer<'_>,
) -> Result<Filled, PartialError> {
    let options = options.into();
    let start = Instant::now();
    let (longer, plan) = plan_part(mesh, hole, [from, to], &options.options)?;
    let mut filled = run_plan(&longer, plan, &options, observe)?;
    filled.milliseconds = milliseconds(start);
    Ok(filled)
}

/// A fill whose first patches are made and whose flows have not started.
pub struct PreparedFill<'a> {
    mesh: Cow<'a, Mesh>,
    plan: Plan,
    options: ScheduledOptions,
    milliseconds: f64,
}

impl<'a> PreparedFill<'a> {
    /// Makes one patch for each set of rims, or for several with the strips of bridges between them.
    pub fn new(
        mesh: &'a Mesh,
        rim_sets: &[RimSet<'_>],
        strips: &[u32],
        options: impl Into<ScheduledOptions>,
    ) -> Self {
        let start = Instant::now();
        let options = options.into();
        let prepared = prepare(mesh, rim_sets, strips, &options.options);
        Self {
            mesh: prepared.mesh.map_or(Cow::Borrowed(mesh), Cow::Owned),
            plan: prepared.plan,
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

    /// Runs the flows and inserts the patches into the mesh.
    ///
    /// # Errors
    /// As [`fill_rim_sets`].
    pub fn run(self, observe: Observer<'_>) -> Result<Filled, FillError> {
        let mut filled = run_plan(&self.mesh, self.plan, &self.options, observe)?;
        filled.milliseconds += self.milliseconds;
        Ok(filled)
    }
}

/// Runs the flows of a plan and inserts the patches into the mesh.
pub(super) fn run_plan(
    mesh: &Mesh,
    plan: Plan,
    options: &ScheduledOptions,
    observe: Observer<'_>,
) -> Result<Filled, FillError> {
    let start = Instant::now();
    let context = FillContext { mesh, plan: &plan };
    let ScheduledOptions { options, recording } = options;
    let memory = memory_of(mesh, &plan, options);
    require(memory)?;
    let look = Look::new(options);
    let topologies = plan.groups.iter().map(|g| Arc::clone(&g.topology));
    let (runs, assembly) = rayon::join(
        || {
            let groups = (0..plan.groups.len()).into_par_iter();
            let run = |g| run_group(context, g, options, recording, &|record| observe(g, record));
            groups.map(run).collect::<Vec<_>>()
        },
        || Assembly::new(mesh, &plan, topologies.collect(), &look),
    );
    let mut assembly = assembly?;
    if !assembly.fits(runs.iter().map(|run| &run.topology)) {
        let topologies = runs.iter().map(|run| Arc::clone(&run.topology));
        assembly = Assembly::new(mesh, &plan, topologies.collect(), &look)?;
    }
    let positions = runs.iter().map(|run| &run.positions[..]);
    let (filled, without_texture) = assembly.mesh(mesh, positions);
    let between = defects_between_groups(&filled.topology, &filled.positions, &assembly.holes);
    let of_patches = runs
        .iter()
        .flat_map(|run| run.patch_warnings.iter().cloned());
    for (id, warning) in of_patches.chain(between).chain(without_texture) {
        if let Some(hole) = assembly.holes.iter_mut().find(|hole| hole.id() == id) {
            hole.warnings.push(warning);
        }
    }
    Ok(Filled {
        mesh: filled,
        holes: assembly.holes,
        failed: plan.failed,
        moved: assembly.moved,
        groups: runs.into_iter().map(|run| run.result).collect(),
        milliseconds: milliseconds(start),
        memory_estimate: memory as u64,
    })
}
