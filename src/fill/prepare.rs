//! First patches of holes.

use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use crate::fill::blend;
use crate::fill::context::FillContext;
use crate::fill::crack::with_joined_cracks;
use crate::fill::features::{self, SplitHole};
use crate::fill::hole::{DraftHole, HoleRims};
use crate::fill::options::{Features, FillOptions};
use crate::fill::part::{NewVertices, with_vertices};
use crate::fill::plan::Plan;
use crate::fill::region;
use crate::fill::result::milliseconds;
use crate::fill::rim::RimSet;
use crate::fill::warm_start::warm_start;
use crate::mesh::{BoundaryLoop, Mesh};
use crate::patch;
use crate::solver::{FlowProblem, SolverError};

/// First patches and groups of holes.
pub(super) struct Prepared {
    pub plan: Plan,
    /// The mesh with the vertices of creases that continue through holes, if there are any. The plan
    /// is one of this mesh.
    pub longer: Option<Mesh>,
}

/// Builds first patches (in parallel) and groups the holes whose support regions meet. A hole through
/// which sharp lines continue gets a patch for each part, and the two sides of a crack get one.
pub(super) fn prepare(mesh: &Mesh, rim_sets: &[RimSet<'_>], options: &FillOptions) -> Prepared {
    let rim_sets = with_joined_cracks(mesh, rim_sets);
    let draft = |rims: HoleRims| {
        let start = Instant::now();
        DraftHole {
            patch: patch::blend(&rims.geometry, options.patch),
            rims: Arc::new(rims),
            has_initial_shape: false,
            patch_ms: milliseconds(start),
        }
    };
    let split = |rims: &RimSet<'_>| match rims[..] {
        [hole] if options.features == Features::Auto => {
            features::split(mesh, hole, options.patch.density)
        }
        _ => None,
    };
    let splits: Vec<Option<SplitHole>> = rim_sets.par_iter().map(split).collect();
    let (longer, firsts) = with_creases(mesh, &splits);
    let drafts = rim_sets.par_iter().zip(splits).zip(firsts);
    let drafts = drafts.flat_map_iter(|((rims, split), first)| {
        let rims = match split {
            Some(split) if longer.is_some() => split.parts(mesh, rims[0], first),
            _ => vec![HoleRims::new(mesh, rims)],
        };
        rims.into_iter().map(&draft).collect::<Vec<_>>()
    });
    let mut drafts: Vec<DraftHole> = drafts.collect();
    let mesh = longer.as_ref().unwrap_or(mesh);
    if drafts.iter().any(|draft| draft.rims.is_blend()) {
        blend::shape(mesh, &mut drafts, options);
    }
    Prepared {
        plan: Plan::of_holes(mesh, drafts, options.patch),
        longer,
    }
}

/// The mesh with the new vertices of split holes, and the number of the first one of each. `None` if
/// there are none.
fn with_creases(mesh: &Mesh, splits: &[Option<SplitHole>]) -> (Option<Mesh>, Vec<usize>) {
    let mut next = mesh.vertex_count();
    let firsts = splits.iter().map(|split| {
        let count = split.as_ref().map_or(0, |split| split.new.points.len());
        next += count;
        next - count
    });
    let firsts = firsts.collect();
    let new: Vec<&NewVertices> = splits.iter().flatten().map(|split| &split.new).collect();
    // vertices without faces do not change a manifold
    let longer = (!new.is_empty()).then(|| with_vertices(mesh, &new).ok());
    (longer.flatten(), firsts)
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
    let options = &FillOptions {
        features: Features::Off,
        ..options.clone()
    };
    let plan = prepare(mesh, &[vec![hole]], options).plan;
    if plan.groups.is_empty() {
        return Ok(None);
    }
    let context = FillContext { mesh, plan: &plan };
    let positions = plan.start_positions(mesh, 0);
    let problem = region::problem(context, 0, &plan.groups[0].topology, &positions, options)?;
    warm_start(problem).map(Some)
}
