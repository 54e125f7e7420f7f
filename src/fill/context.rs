//! Data shared by the groups of a fill, and errors of changes to a group.

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
