//! First patches of holes.

use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use crate::fill::blend;
use crate::fill::context::FillContext;
use crate::fill::hole::{DraftHole, HoleRims};
use crate::fill::options::FillOptions;
use crate::fill::plan::Plan;
use crate::fill::region;
use crate::fill::result::milliseconds;
use crate::fill::rim::RimSet;
use crate::fill::warm_start::warm_start;
use crate::mesh::{BoundaryLoop, Mesh};
use crate::patch;
use crate::solver::{FlowProblem, SolverError};

/// Builds first patches (in parallel) and groups the holes whose support regions meet.
pub(super) fn prepare(mesh: &Mesh, rim_sets: &[RimSet<'_>], options: &FillOptions) -> Plan {
    let draft = |rims: &RimSet<'_>| {
        let start = Instant::now();
        let rims = HoleRims::new(mesh, rims);
        DraftHole {
            patch: patch::blend(&rims.geometry, options.patch),
            rims: Arc::new(rims),
            has_initial_shape: false,
            patch_ms: milliseconds(start),
        }
    };
    let mut drafts: Vec<DraftHole> = rim_sets.par_iter().map(draft).collect();
    if drafts.iter().any(|draft| draft.rims.is_blend()) {
        blend::shape(mesh, &mut drafts, options);
    }
    Plan::of_holes(mesh, drafts, options.patch)
}

/// The problem from which the flow of a single hole starts: its patch and support region at the
/// warm start, to run [`Flow`](crate::solver::Flow) on. `None` if the hole has no patch with
/// interior vertices.
///
/// # Errors
/// As [`FlowProblem::new`], and if the warm start cannot be solved for.
pub fn flow_problem(
    mesh: &Mesh,
    hole: &BoundaryLoop,
    options: &FillOptions,
) -> Result<Option<FlowProblem>, SolverError> {
    let plan = prepare(mesh, &[vec![hole]], options);
    if plan.groups.is_empty() {
        return Ok(None);
    }
    let context = FillContext { mesh, plan: &plan };
    let positions = plan.start_positions(mesh, 0);
    let problem = region::problem(context, 0, &plan.groups[0].topology, &positions, options)?;
    warm_start(problem).map(Some)
}
