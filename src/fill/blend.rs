//! Start surfaces of the flows of patches over several rims.

use std::time::Instant;

use rayon::prelude::*;

use crate::fill::assemble::appended_triangles;
use crate::fill::context::FillContext;
use crate::fill::hole::{DraftHole, HoleRims};
use crate::fill::options::FillOptions;
use crate::fill::region;
use crate::fill::result::milliseconds;
use crate::fill::self_intersection::{Obstacles, intersections};
use crate::fill::soundness::plan_of;
use crate::fill::warm_start::warm_start;
use crate::mesh::{FaceId, Mesh};
use crate::patch::{self, Patch};

/// Another surface is preferred to the membrane if its bending is below this fraction of the
/// membrane's and neither intersects itself.
const PREFERRED: f64 = 0.95;
/// A membrane whose bending per rim is below this is used without alternatives. A tube as long as
/// wide between two rims has 3π per rim.
const GENTLE: f64 = 16.0;

/// Computes the start surface of every blend.
///
/// A membrane stretched between rims is deformed to its warm start and remeshed there, because it
/// is much smaller than the warm start and its triangles would become long. Between distant rims a
/// warm start closes to a thread, and around bends it intersects itself. The patch is then
/// [lofted](patch::lofted_candidates) from rim to rim.
pub(super) fn shape(mesh: &Mesh, drafts: &mut [DraftHole], options: &FillOptions) {
    move_to_warm_start(mesh, drafts, options);
    each_blend(drafts, |rims, draft| {
        if let Ok(membrane) = draft {
            *membrane = patch::reblend(&rims.geometry, membrane, options.patch);
        }
    });
    move_to_warm_start(mesh, drafts, options);
    each_blend(drafts, |rims, draft| {
        let membrane = draft.as_ref().ok();
        let membrane = membrane.map(|patch| StartQuality::new(mesh, rims, patch));
        let is_fine = |membrane: &StartQuality| {
            !membrane.intersects && membrane.bending < GENTLE * rims.loops.len() as f64
        };
        if membrane.as_ref().is_some_and(is_fine) {
            return;
        }
        let lofted = patch::lofted_candidates(&rims.geometry, options.patch);
        let better = lofted
            .into_iter()
            .find(|patch| StartQuality::new(mesh, rims, patch).is_better_than(membrane.as_ref()));
        if let Some(better) = better {
            *draft = Ok(better);
        }
    });
    for draft in drafts.iter_mut().filter(|draft| draft.rims.is_blend()) {
        draft.has_initial_shape = true;
    }
}

/// Moves the new vertices of blends to the warm start of their group. If that fails they do not
/// move, and the flow reports the reason.
fn move_to_warm_start(mesh: &Mesh, drafts: &mut [DraftHole], options: &FillOptions) {
    let plan = plan_of(mesh, drafts.to_vec(), options.patch);
    let context = FillContext { mesh, plan: &plan };
    let mut planned: Vec<&mut DraftHole> = drafts
        .iter_mut()
        .filter(|draft| draft.patch.is_ok())
        .collect();
    // the plan may have replaced unsound patches
    for (draft, hole) in planned.iter_mut().zip(plan.holes()) {
        draft.patch = Ok(hole.patch.clone());
        draft.warnings = hole.warnings.clone();
        draft.is_checked = true;
    }
    for (g, group) in plan.groups.iter().enumerate() {
        if !plan.holes_of(g).any(|hole| hole.rims.is_blend()) {
            continue;
        }
        let start = plan.start_positions(mesh, g);
        let problem = region::problem(context, g, &group.topology, &start, options);
        let Ok(problem) = problem.and_then(warm_start) else {
            continue;
        };
        let positions = problem.to_world(problem.positions());
        for (&h, (_, own)) in group.holes.iter().zip(group.topology.split(&positions)) {
            let hole = &plan.holes()[h];
            if hole.rims.is_blend() {
                let mut patch = hole.patch.clone();
                let rim = patch.rim;
                patch.points[rim..].copy_from_slice(own);
                planned[h].patch = Ok(patch);
            }
        }
    }
}

/// Calls `change` for all blends in parallel, with their rims and patches. Strips without new vertices are
/// what they should be.
fn each_blend(
    drafts: &mut [DraftHole],
    change: impl Fn(&HoleRims, &mut Result<Patch, patch::PatchError>) + Sync,
) {
    let is_strip = |patch: &Patch| patch.new_points().is_empty();
    let blends = drafts
        .par_iter_mut()
        .filter(|draft| draft.rims.is_blend() && !draft.patch.as_ref().is_ok_and(is_strip));
    blends.for_each(|draft| {
        let start = Instant::now();
        change(&draft.rims, &mut draft.patch);
        draft.patch_ms += milliseconds(start);
    });
}

/// The measures that start surfaces are compared by.
struct StartQuality {
    /// Whether the surface intersects itself or the mesh.
    intersects: bool,
    /// See [`patch::bending`], over the patch and the faces at its rims.
    bending: f64,
}

impl StartQuality {
    fn new(mesh: &Mesh, rims: &HoleRims, patch: &Patch) -> Self {
        let topology = &mesh.topology;
        let new = patch.new_points();
        let part = (&rims.vertices[..], &patch.triangles[..], new.len());
        let own = appended_triangles(mesh.vertex_count(), [part]);
        // the faces across the rims; one face may have two rim edges
        let halfedges = rims.loops.iter().flat_map(|l| &l.halfedges);
        let mut faces: Vec<FaceId> = halfedges.map(|h| topology.face(h.twin())).collect();
        faces.sort_unstable();
        faces.dedup();
        let mut points = patch.points.clone();
        let mut around = patch.triangles.clone();
        let mut local: Vec<(u32, u32)> = rims.vertices.iter().map(|v| v.0).zip(0..).collect();
        local.sort_unstable();
        for face in faces {
            around.push(topology.face_vertices(face).map(|v| {
                if let Ok(at) = local.binary_search_by_key(&v.0, |p| p.0) {
                    return local[at].1;
                }
                points.push(mesh.position(v));
                points.len() as u32 - 1
            }));
        }
        Self {
            intersects: !intersections(mesh, &Obstacles::new(1), &own, &[], new, 1).is_empty(),
            bending: patch::bending(&points, &around),
        }
    }

    /// Whether this surface is a better start than the membrane, if there is one.
    fn is_better_than(&self, membrane: Option<&Self>) -> bool {
        let is_gentler = |membrane: &Self| {
            membrane.intersects
                || !membrane.bending.is_finite()
                || self.bending < PREFERRED * membrane.bending
        };
        !self.intersects && membrane.is_none_or(is_gentler)
    }
}
