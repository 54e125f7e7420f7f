//! First patches of holes.

use rayon::prelude::*;

use crate::fill::blend;
use crate::fill::bridged::{Released, joined_draft, release};
use crate::fill::context::FillContext;
use crate::fill::crack::with_joined_cracks;
use crate::fill::features::{self, SplitHole};
use crate::fill::hole::{DraftHole, HoleRims};
use crate::fill::left_islands::{without_misfits, without_unsound};
use crate::fill::options::{Features, FillOptions};
use crate::fill::part::{NewVertices, with_vertices};
use crate::fill::plan::Plan;
use crate::fill::region;
use crate::fill::rim::RimSet;
use crate::fill::soundness::plan_of;
use crate::fill::warm_start::warm_start;
use crate::mesh::{BoundaryLoop, LoopId, Mesh};
use crate::solver::{FlowProblem, SolverError};

/// First patches and groups of holes.
pub(super) struct Prepared {
    pub plan: Plan,
    /// The mesh of the plan, if it is another one: with the vertices of creases that continue through holes,
    /// or without the strips of bridges.
    pub mesh: Option<Mesh>,
}

/// Builds first patches (in parallel) and groups the holes whose support regions meet. A hole through
/// which sharp lines continue gets a patch for each part, and the two sides of a crack get one. The faces
/// `strips` of bridges (ascending) are replaced with the patches of the holes beside them, see [`release`].
pub(super) fn prepare(
    mesh: &Mesh,
    rim_sets: &[RimSet<'_>],
    strips: &[u32],
    options: &FillOptions,
) -> Prepared {
    let (drafts, other) = match release(mesh, rim_sets, strips) {
        Some(released) => released_drafts(mesh, rim_sets, released, options),
        None => drafts(mesh, rim_sets, options),
    };
    let mut drafts = drafts;
    let mesh = other.as_ref().unwrap_or(mesh);
    if drafts.iter().any(|draft| draft.rims.is_blend()) {
        blend::shape(mesh, &mut drafts, options);
        if options.leaves_islands && strips.is_empty() {
            without_unsound(mesh, &mut drafts, options);
        }
    }
    Prepared {
        plan: plan_of(mesh, drafts, options.patch),
        mesh: other,
    }
}

/// The holes of a mesh, some strips of which are replaced with patches, and the mesh without them.
fn released_drafts(
    mesh: &Mesh,
    rim_sets: &[RimSet<'_>],
    released: Released,
    options: &FillOptions,
) -> (Vec<DraftHole>, Option<Mesh>) {
    let Released {
        erased,
        rims,
        parts,
    } = released;
    let plain = rims.iter().zip(&parts);
    let plain = plain.filter(|(_, parts)| parts.strips.is_empty());
    let plain: Vec<RimSet<'_>> = plain.map(|(rims, _)| rims.iter().collect()).collect();
    let (mut drafts, longer) = drafts(&erased.mesh, &plain, options);
    let joined = rims
        .par_iter()
        .zip(&parts)
        .filter(|(_, parts)| !parts.strips.is_empty());
    let joined = joined.map(|(rims, parts)| {
        let rims: RimSet<'_> = rims.iter().collect();
        let rims = HoleRims::new(&erased.mesh, &rims);
        joined_draft(mesh, rim_sets, &erased.old_vertex, parts, rims, options)
    });
    drafts.extend(joined.collect::<Vec<_>>());
    drafts.sort_by_key(|draft| draft.rims.id());
    (drafts, Some(longer.unwrap_or(erased.mesh)))
}

/// The holes with their first patches, and the mesh with the vertices of creases, if there are any.
fn drafts(
    mesh: &Mesh,
    rim_sets: &[RimSet<'_>],
    options: &FillOptions,
) -> (Vec<DraftHole>, Option<Mesh>) {
    // the rims of others that are joined are those of cracks
    let has_islands = |id: LoopId| (rim_sets.iter()).any(|rims| rims.len() > 1 && rims[0].id == id);
    let draft = |rims: HoleRims| {
        let draft = DraftHole::new(rims, options);
        if options.leaves_islands && draft.patch.is_err() && has_islands(draft.rims.id()) {
            without_misfits(mesh, draft, options)
        } else {
            draft
        }
    };
    let rim_sets = with_joined_cracks(mesh, rim_sets);
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
            Some(split) if longer.is_some() || split.new.points.is_empty() => {
                split.parts(mesh, rims[0], first)
            }
            _ => vec![HoleRims::new(mesh, rims)],
        };
        rims.into_iter().map(&draft).collect::<Vec<_>>()
    });
    let drafts = drafts.collect();
    (drafts, longer)
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
    let firsts: Vec<usize> = firsts.collect();
    if next == mesh.vertex_count() {
        return (None, firsts);
    }
    let new: Vec<&NewVertices> = splits.iter().flatten().map(|split| &split.new).collect();
    // vertices without faces do not change a manifold
    (with_vertices(mesh, &new).ok(), firsts)
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
    let plan = prepare(mesh, &[vec![hole]], &[], options).plan;
    if plan.groups.is_empty() {
        return Ok(None);
    }
    let context = FillContext { mesh, plan: &plan };
    let positions = plan.start_positions(mesh, 0);
    let problem = region::problem(context, 0, &plan.groups[0].topology, &positions, options)?;
    warm_start(problem).map(Some)
}
