//! The result of a fill, and errors of fills.

use std::ops::Range;
use std::time::Instant;

use crate::fill::surface_choice::GroupSurface;
use crate::memory::TooLittleMemory;
use crate::mesh::{FaceId, LoopId, Mesh, TopologyError, VertexId};
use crate::patch::PatchError;
use crate::solver::{End, Outcome, SolverError, StepRecord};
use crate::warning::Warnings;

/// Why a hole, or a whole fill, failed.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FillError {
    /// No first patch could be built.
    #[error("hole {hole}: no first patch: {source}")]
    Patch {
        /// The loop.
        hole: LoopId,
        /// The reason.
        source: PatchError,
    },
    /// The flows need more memory than is free.
    #[error("{0}; lower the density or fill fewer holes at a time")]
    Memory(#[from] TooLittleMemory),
    /// The filled mesh is not a manifold: an internal error. No file is written.
    #[error("the filled mesh would not be manifold ({0}); nothing was changed")]
    NotManifold(#[from] TopologyError),
}

impl FillError {
    /// The loop of the hole, if the error is about one.
    pub fn hole(&self) -> Option<LoopId> {
        match self {
            Self::Patch { hole, .. } => Some(*hole),
            Self::Memory(_) | Self::NotManifold(_) => None,
        }
    }
}

/// Why part of a hole cannot be filled.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PartialError {
    /// There are fewer than two edges between the ends.
    #[error(
        "there are {edges} rim edges between the two ends; a part of a hole needs at least two"
    )]
    TooShort {
        /// Number of rim edges between the ends.
        edges: usize,
    },
    /// The patch, or the mesh with it, cannot be built.
    #[error(transparent)]
    Fill(#[from] FillError),
}

/// Why a selection cannot be refilled or faired.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RefillError {
    /// No face is selected.
    #[error("no face is selected; choose other places, numbers or limits")]
    Nothing,
    /// The selection is a whole component, so no face remains to continue.
    #[error("the selection is a whole component: there is no surface to join; select fewer faces")]
    Everything,
    /// The selection is too narrow to have inner vertices.
    #[error("the {faces} selected faces have no inner vertices; select a wider region")]
    NoInside {
        /// Faces selected.
        faces: usize,
    },
    /// The fill failed.
    #[error(transparent)]
    Fill(#[from] FillError),
}

/// Wall-clock times of the stages of one hole or group, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Timings {
    /// First patch.
    pub patch: f64,
    /// Choice of the surface model.
    pub prediction: f64,
    /// Region, elements, symbolic factorization.
    pub setup: f64,
    /// Graph Laplacian and bi-Laplacian.
    pub warm_start: f64,
    /// Steps.
    pub flow: f64,
    /// Check of the result, and its repair.
    pub soundness: f64,
}

impl Timings {
    /// Sum of the stages.
    pub fn total(&self) -> f64 {
        self.patch + self.prediction + self.setup + self.warm_start + self.flow + self.soundness
    }
}

/// Milliseconds since `start`.
pub(super) fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

/// The flow of one group.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct GroupResult {
    /// The surface model.
    pub surface: GroupSurface,
    /// Outcome of the flow.
    pub outcome: Outcome,
    /// Every attempted step.
    pub records: Vec<StepRecord>,
    /// Stage times, patches excluded.
    pub timings: Timings,
}

/// A hole's part of a filled mesh.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FilledHole {
    /// The loops its patch joins: one, or several for a blend or a hole with islands.
    pub loops: Vec<LoopId>,
    /// Edges of the rims.
    pub edges: usize,
    /// Hole radius: RMS distance of the rim vertices from their mean, the maximum over several
    /// rims.
    pub radius: f64,
    /// The group it is solved with; `None` if the patch has no interior vertex.
    pub group: Option<usize>,
    /// Its new vertices in the filled mesh.
    pub vertices: Range<usize>,
    /// Its faces in the filled mesh.
    pub faces: Range<usize>,
    /// Milliseconds of the first patch.
    pub patch_ms: f64,
    /// Defects of the patch and what was done about them. Warnings about the flow are in the outcome of its
    /// group.
    pub warnings: Warnings,
    /// Tag of its faces.
    pub(super) tag: u32,
    /// The face beside the rim whose data its faces have.
    pub(super) like: FaceId,
}

impl FilledHole {
    /// The loop that represents the hole: the first of [`Self::loops`].
    pub fn id(&self) -> LoopId {
        self.loops[0]
    }
}

/// A filled mesh with reports of its holes and groups.
#[derive(Debug)]
#[non_exhaustive]
pub struct Filled {
    /// The mesh: input vertices and faces, bit-identical, then those of the patches.
    pub mesh: Mesh,
    /// Holes with a patch, in the requested order.
    pub holes: Vec<FilledHole>,
    /// Holes without one.
    pub failed: Vec<FillError>,
    /// Fairing: the input vertices that flowed, in ascending order. There are no holes then.
    pub moved: Vec<VertexId>,
    /// One result per group. After an error the holes of the group are at their warm start.
    pub groups: Vec<Result<GroupResult, SolverError>>,
    /// Wall-clock milliseconds of the fill, without reading and writing files.
    pub milliseconds: f64,
    /// The memory in bytes that the flows were expected to take.
    pub memory_estimate: u64,
}

impl Filled {
    /// Whether every hole has a patch whose flow converged or was not needed.
    pub fn complete(&self) -> bool {
        let converged = |g: &GroupResult| g.outcome.end == End::Converged;
        self.failed.is_empty() && self.groups.iter().all(|g| g.as_ref().is_ok_and(converged))
    }

    /// Number of new vertices.
    pub fn vertices_added(&self) -> usize {
        self.holes.iter().map(|hole| hole.vertices.len()).sum()
    }

    /// Number of new faces.
    pub fn faces_added(&self) -> usize {
        self.holes.iter().map(|hole| hole.faces.len()).sum()
    }

    /// The first hole of a group.
    pub fn first_hole(&self, group: usize) -> Option<&FilledHole> {
        self.holes.iter().find(|hole| hole.group == Some(group))
    }
}
