//! Filling holes from end to end: rims, first patches, groups, flows, the filled mesh.
//!
//! [`prepare`] builds the first patch of every hole and one [`FlowProblem`] for each group of holes
//! that share collar vertices; [`Plan::finish`] puts the flowed positions into the mesh.
//! [`fill_holes`] does all of it, groups in parallel.

mod blend;
mod bridge;
mod controls;
mod crossing;
mod group;
mod islands;
mod live;
mod noise;
mod partial;
mod rail;
mod refill;
mod region;
mod renewal;
mod rim;
mod run;
mod schedule;
mod scheduled;
mod select;
mod shape;
mod sheets;

use std::collections::BTreeMap;
use std::time::Instant;

use rayon::prelude::*;

use crate::energy::{Energy, Preset};
use crate::mesh::{BoundaryLoop, DVec3, LoopId, Mesh, Topology, TopologyError, VertexId};
use crate::patch::{self, PatchError, PatchMesh, PatchOptions};
use crate::solver::{End, FlowOptions, FlowProblem, Outcome, SolverError, StepRecord};

use run::Ground;
use schedule::TimedChange;
use scheduled::run_group;
use shape::Shape;

pub use bridge::{BridgeError, Stretch, bridge, stretch_at};
pub use controls::{Choice, Continuity, Controls, ControlsError, Linear, TauChoice};
pub use group::Group;
pub use islands::with_islands;
pub use live::{
    GroupState, GroupStatus, HoleLayout, Layout, LiveError, LiveEvent, LiveFill, LiveSettings,
    State, Timeline, command_line,
};
pub use partial::{PartialError, fill_part};
pub use refill::{
    Opening, RefillError, Refilled, fair, fair_scheduled, open_selection, refill, refill_scheduled,
};
pub use rim::{gap_of, rim_of};
pub use schedule::{Row, Schedule, ScheduleError};
pub use scheduled::{ScheduledFillError, fill_scheduled};
pub use select::{LoopChoice, NoSuchLoop, choose, nearest_loop};

/// What can be chosen about a fill.
#[derive(Clone, Debug)]
pub struct FillOptions {
    /// The first patch.
    pub patch: PatchOptions,
    /// Noise on the surface the flow starts from, in mean edge lengths along the normals.
    pub noise: f64,
    /// The flow.
    pub flow: FlowOptions,
    /// How patches meet the mesh.
    pub continuity: Continuity,
    /// The same for single loops.
    pub loop_continuity: BTreeMap<LoopId, Continuity>,
}

impl Default for FillOptions {
    /// Rim density, `f = H²`, scheme B, fast mode, G1.
    fn default() -> Self {
        Self {
            patch: PatchOptions::default(),
            noise: 0.0,
            flow: FlowOptions::new(Energy::preset(Preset::H2)),
            continuity: Continuity::default(),
            loop_continuity: BTreeMap::new(),
        }
    }
}

impl FillOptions {
    /// How the patch meets the mesh at a loop.
    pub fn continuity_at(&self, id: LoopId) -> Continuity {
        let own = self.loop_continuity.get(&id);
        own.copied().unwrap_or(self.continuity)
    }
}

/// Why a hole, or a whole fill, failed.
#[derive(Clone, Debug, thiserror::Error)]
pub enum FillError {
    /// No first patch could be made.
    #[error("hole {hole}: no first patch: {source}")]
    Patch {
        /// The loop.
        hole: LoopId,
        /// Why.
        source: PatchError,
    },
    /// The filled mesh is not a manifold: a defect of the program, kept from the file.
    #[error("the filled mesh would not be manifold ({0}); nothing was changed")]
    NotManifold(#[from] TopologyError),
}

impl FillError {
    /// The loop concerned, if there is one.
    pub fn hole(&self) -> Option<LoopId> {
        match self {
            Self::Patch { hole, .. } => Some(*hole),
            Self::NotManifold(_) => None,
        }
    }
}

/// Wall-clock times of the stages of one hole or group, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Timings {
    /// First patch.
    pub patch: f64,
    /// Region, elements, symbolic factorization.
    pub setup: f64,
    /// Graph Laplacian and bi-Laplacian.
    pub warm_start: f64,
    /// Steps.
    pub flow: f64,
}

impl Timings {
    /// Sum of the stages.
    pub fn total(&self) -> f64 {
        self.patch + self.setup + self.warm_start + self.flow
    }
}

/// One hole of a plan.
#[derive(Clone, Debug)]
pub struct PlannedHole {
    /// The loop; the first of its loops for a blend.
    pub id: LoopId,
    /// All loops its patch joins: one, or several for a blend.
    pub loops: Vec<LoopId>,
    /// Vertices of each of these loops.
    pub rims: Vec<Vec<VertexId>>,
    /// Edges of the rims.
    pub edges: usize,
    /// Hole radius: RMS distance of the rim from its mean, the largest of a blend's rims.
    pub radius: f64,
    /// New vertices: this range of [`Plan::new_positions`].
    pub new_vertices: std::ops::Range<usize>,
    /// New triangles: this range of [`Plan::triangles`].
    pub new_faces: std::ops::Range<usize>,
    /// The group it is solved with; `None` if it has no interior vertex.
    pub group: Option<usize>,
    /// Whether its patch has the shape its flow starts from, and needs no warm start.
    pub formed: bool,
    /// Face tag its faces inherit (0 if the mesh has none).
    pub tag: u32,
    /// Milliseconds its first patch took.
    pub patch_ms: f64,
}

/// First patches of all holes, and the flows to run on them.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Vertices of the mesh.
    pub old_vertices: usize,
    /// Holes with a patch, in the order asked for.
    pub holes: Vec<PlannedHole>,
    /// Holes that could not be given one.
    pub failed: Vec<FillError>,
    /// Positions of the new vertices; vertex `i` becomes `mesh.vertex_count() + i`.
    pub new_positions: Vec<DVec3>,
    /// New triangles over the mesh's and the new vertices.
    pub triangles: Vec<[u32; 3]>,
    /// Holes to be solved together.
    pub groups: Vec<Group>,
    /// Fairing: vertices of the mesh that flow, ascending. There are no holes and no new vertices
    /// then; `new_positions` are theirs.
    pub moved: Vec<VertexId>,
}

/// Rims to be joined by one patch: one for a hole, several for a blend or a hole with islands.
pub type Gap<'a> = Vec<&'a BoundaryLoop>;

/// Builds first patches (in parallel) and groups the holes that share collar vertices.
pub fn prepare(mesh: &Mesh, loops: &[&BoundaryLoop], options: &FillOptions) -> Plan {
    let gaps: Vec<Gap<'_>> = loops.iter().map(|&hole| vec![hole]).collect();
    prepare_gaps(mesh, &gaps, options)
}

/// [`prepare`] for gaps of any number of rims.
pub fn prepare_gaps(mesh: &Mesh, gaps: &[Gap<'_>], options: &FillOptions) -> Plan {
    let patches: Vec<FirstPatch> = gaps
        .par_iter()
        .map(|gap| {
            let start = Instant::now();
            let patch = match gap[..] {
                [hole] => patch::fill(&rim_of(mesh, hole), &options.patch),
                _ => patch::blend(&gap_of(mesh, gap), &options.patch),
            };
            (patch, milliseconds(start))
        })
        .collect();
    if gaps.iter().any(|gap| gap.len() > 1) {
        return blend::shaped(mesh, gaps, patches, options);
    }
    Plan::new(mesh, gaps, &patches)
}

/// The first patch of a gap and the milliseconds it took.
type FirstPatch = (Result<PatchMesh, PatchError>, f64);

impl Plan {
    fn new(mesh: &Mesh, gaps: &[Gap<'_>], patches: &[FirstPatch]) -> Self {
        let mut plan = Self {
            old_vertices: mesh.positions.len(),
            holes: Vec::new(),
            failed: Vec::new(),
            new_positions: Vec::new(),
            triangles: Vec::new(),
            groups: Vec::new(),
            moved: Vec::new(),
        };
        let mut filled = Vec::new();
        for (gap, (patch, patch_ms)) in gaps.iter().zip(patches) {
            match patch {
                Ok(patch) => {
                    plan.add(mesh, gap, patch, *patch_ms);
                    filled.push(&gap[..]);
                }
                Err(source) => plan.failed.push(FillError::Patch {
                    hole: gap[0].id,
                    source: *source,
                }),
            }
        }
        plan.groups = group::groups(mesh, &filled, &plan);
        for (g, group) in plan.groups.iter().enumerate() {
            for &h in &group.holes {
                plan.holes[h].group = Some(g);
            }
        }
        plan
    }

    fn add(&mut self, mesh: &Mesh, gap: &[&BoundaryLoop], patch: &PatchMesh, patch_ms: f64) {
        let rim: Vec<VertexId> = gap
            .iter()
            .flat_map(|l| l.vertices.iter().copied())
            .collect();
        let first = mesh.positions.len() + self.new_positions.len();
        let global = |v: u32| match rim.get(v as usize) {
            Some(old) => old.0,
            None => (first + v as usize - rim.len()) as u32,
        };
        let (points, faces) = (self.new_positions.len(), self.triangles.len());
        self.new_positions
            .extend_from_slice(&patch.points[rim.len()..]);
        self.triangles
            .extend(patch.triangles.iter().map(|t| t.map(global)));
        self.holes.push(PlannedHole {
            id: gap[0].id,
            loops: gap.iter().map(|l| l.id).collect(),
            rims: gap.iter().map(|l| l.vertices.clone()).collect(),
            edges: rim.len(),
            radius: gap.iter().map(|l| l.radius).fold(0.0, f64::max),
            new_vertices: points..self.new_positions.len(),
            new_faces: faces..self.triangles.len(),
            group: None,
            formed: false,
            tag: rim::tag_of(mesh, gap[0]),
            patch_ms,
        });
    }

    /// Takes a group's interior positions, in the order of its problem's interior vertices.
    pub fn place(&mut self, group: usize, positions: &[DVec3]) {
        for (&v, &p) in self.groups[group].new_vertices.iter().zip(positions) {
            self.new_positions[v as usize] = p;
        }
    }

    /// The mesh with the patches in it: the old vertices and faces first, untouched.
    ///
    /// # Errors
    /// [`FillError::NotManifold`] if a patch does not fit, which is a defect.
    pub fn finish(&self, mesh: &Mesh) -> Result<Mesh, FillError> {
        Ok(self.assemble(mesh, self.topology(mesh)?))
    }

    /// Connectivity of the filled mesh; it does not depend on where the flow takes the vertices.
    fn topology(&self, mesh: &Mesh) -> Result<Topology, TopologyError> {
        let mut triangles: Vec<[u32; 3]> =
            Vec::with_capacity(mesh.face_count() + self.triangles.len());
        triangles.extend(mesh.topology.triangles());
        triangles.extend_from_slice(&self.triangles);
        let new = if self.moved.is_empty() {
            self.new_positions.len()
        } else {
            0
        };
        Topology::from_triangles(mesh.positions.len() + new, &triangles)
    }

    /// Positions of all vertices of the filled mesh, where those of the plan are at `flowed`.
    fn positions(&self, mesh: &Mesh, flowed: &[DVec3]) -> Vec<DVec3> {
        let mut positions = Vec::with_capacity(mesh.positions.len() + flowed.len());
        positions.extend_from_slice(&mesh.positions);
        if self.moved.is_empty() {
            positions.extend_from_slice(flowed);
        }
        for (v, &p) in self.moved.iter().zip(flowed) {
            positions[v.index()] = p;
        }
        positions
    }

    fn assemble(&self, mesh: &Mesh, topology: Topology) -> Mesh {
        Mesh {
            positions: self.positions(mesh, &self.new_positions),
            topology,
            colors: rim::colors(mesh, self),
            face_tags: rim::face_tags(mesh, self),
            tags: mesh.tags.clone(),
            one_sided: mesh.one_sided.clone(),
            one_sided_tags: mesh.one_sided_tags.clone(),
        }
    }
}

/// How the flow of one group went.
#[derive(Clone, Debug)]
pub struct GroupResult {
    /// Outcome of the flow.
    pub outcome: Outcome,
    /// Every attempted step.
    pub records: Vec<StepRecord>,
    /// Stage times, patches excluded.
    pub timings: Timings,
}

/// A filled mesh and how it came about.
#[derive(Debug)]
pub struct Filled {
    /// Old vertices and faces first, bit-identical; then those of the patches.
    pub mesh: Mesh,
    /// First patches, holes and groups.
    pub plan: Plan,
    /// One result a group; an error leaves the group's holes with their warm start.
    pub groups: Vec<Result<GroupResult, SolverError>>,
    /// Wall-clock milliseconds of the whole, without reading and writing files.
    pub milliseconds: f64,
}

impl Filled {
    /// Whether every hole has a patch whose flow converged or needed none.
    pub fn complete(&self) -> bool {
        self.plan.failed.is_empty()
            && self
                .groups
                .iter()
                .all(|g| g.as_ref().is_ok_and(|g| g.outcome.end == End::Converged))
    }
}

/// Fills the given holes. `observe(group, record)` sees every step and returns whether to go on.
///
/// # Errors
/// Only if the result would not be a manifold; what fails for a single hole is in the result.
pub fn fill_holes(
    mesh: &Mesh,
    loops: &[&BoundaryLoop],
    options: &FillOptions,
    observe: &(dyn Fn(usize, &StepRecord) -> bool + Sync),
) -> Result<Filled, FillError> {
    let gaps: Vec<Gap<'_>> = loops.iter().map(|&hole| vec![hole]).collect();
    fill_gaps(mesh, &gaps, options, observe)
}

/// Fills gaps of any number of rims, each with one patch, as [`fill_holes`] does.
///
/// # Errors
/// As [`fill_holes`].
pub fn fill_gaps(
    mesh: &Mesh,
    gaps: &[Gap<'_>],
    options: &FillOptions,
    observe: &(dyn Fn(usize, &StepRecord) -> bool + Sync),
) -> Result<Filled, FillError> {
    fill_changing(mesh, gaps, options, &[], observe)
}

/// Fills gaps with changes on the way.
fn fill_changing(
    mesh: &Mesh,
    gaps: &[Gap<'_>],
    options: &FillOptions,
    changes: &[TimedChange],
    observe: &(dyn Fn(usize, &StepRecord) -> bool + Sync),
) -> Result<Filled, FillError> {
    let start = Instant::now();
    let plan = prepare_gaps(mesh, gaps, options);
    let mut filled = run_plan(mesh, gaps, plan, options, changes, observe)?;
    filled.milliseconds = milliseconds(start);
    Ok(filled)
}

/// Runs the flows of a plan and puts the patches into the mesh.
fn run_plan(
    mesh: &Mesh,
    gaps: &[Gap<'_>],
    mut plan: Plan,
    options: &FillOptions,
    changes: &[TimedChange],
    observe: &(dyn Fn(usize, &StepRecord) -> bool + Sync),
) -> Result<Filled, FillError> {
    let start = Instant::now();
    let ground = Ground {
        mesh,
        gaps,
        plan: &plan,
    };
    let (runs, topology) = rayon::join(
        || {
            (0..plan.groups.len())
                .into_par_iter()
                .map(|g| run_group(ground, g, options, changes, &|record| observe(g, record)))
                .collect::<Vec<_>>()
        },
        || plan.topology(mesh),
    );
    let mut topology = topology?;
    if runs.iter().any(|run| run.remeshed) {
        let shapes: Vec<&Shape> = runs.iter().map(|run| run.shape.as_ref()).collect();
        plan = plan.reshaped(&shapes);
        topology = plan.topology(mesh)?;
    }
    for (g, run) in runs.iter().enumerate() {
        plan.place(g, &run.positions);
    }
    let filled = plan.assemble(mesh, topology);
    Ok(Filled {
        mesh: filled,
        plan,
        groups: runs.into_iter().map(|run| run.result).collect(),
        milliseconds: milliseconds(start),
    })
}

/// Moves the interior vertices to the graph bi-Laplacian's solution, the flow's start.
///
/// # Errors
/// If the linear system cannot be solved, which needs a region without fixed vertices.
pub fn warm_start(problem: FlowProblem) -> Result<FlowProblem, SolverError> {
    let all = problem.interior().to_vec();
    warm_start_of(problem, &all)
}

/// [`warm_start`] that moves only some of the interior vertices.
fn warm_start_of(problem: FlowProblem, moved: &[u32]) -> Result<FlowProblem, SolverError> {
    let mut positions = problem.positions().to_vec();
    let interior: Vec<VertexId> = moved.iter().map(|&v| VertexId(v)).collect();
    let creases: Vec<VertexId> = problem.creases().iter().map(|&v| VertexId(v)).collect();
    patch::warm_start_with_creases(problem.topology(), &mut positions, &interior, &creases)?;
    Ok(problem.with_positions(&positions))
}

fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}
