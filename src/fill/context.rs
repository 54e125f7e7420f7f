//! Data shared by the groups of a fill, and errors of changes to a group.

use crate::fill::assemble::appended_triangles;
use crate::fill::patch_topology::PatchTopology;
use crate::fill::plan::Plan;
use crate::mesh::{LoopId, Mesh};
use crate::patch::{PatchError, TransferError};
use crate::solver::SolverError;

/// Data shared by the groups of a fill.
#[derive(Clone, Copy)]
pub(super) struct FillContext<'a> {
    pub mesh: &'a Mesh,
    pub plan: &'a Plan,
}

impl FillContext<'_> {
    /// The patches of a group as [appended](appended_triangles) triangles, hole after hole.
    pub fn patch_triangles(&self, group: usize, topology: &PatchTopology) -> Vec<[u32; 3]> {
        let patches = self.plan.holes_of(group).zip(&topology.holes);
        let parts = patches.map(|(hole, patch)| {
            let rim = &hole.rims.vertices[..];
            (rim, &patch.triangles[..], patch.new_vertices)
        });
        appended_triangles(self.mesh.vertex_count(), parts)
    }
}

/// Why a change cannot be made. The group continues as before.
#[derive(Clone, Debug, thiserror::Error)]
pub(super) enum ChangeError {
    #[error(transparent)]
    Flow(#[from] SolverError),
    #[error("hole {hole}: no patch of that density: {source}")]
    Patch { hole: LoopId, source: PatchError },
    #[error("hole {hole}: {source}")]
    Transfer { hole: LoopId, source: TransferError },
}
