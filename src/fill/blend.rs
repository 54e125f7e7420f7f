//! The shapes from which the flows of patches over several rims start.

use std::time::Instant;

use rayon::prelude::*;

use crate::fill::crossing::crossings;
use crate::fill::{
    FillOptions, FirstPatch, Gap, Plan, PlannedHole, gap_of, milliseconds, warm_start,
};
use crate::mesh::{FaceId, Mesh};
use crate::patch::{self, PatchMesh};

/// How much less than a film another surface must bend to be preferred, both without crossings.
const PREFERRED: f64 = 0.95;
/// A film that bends less than this for each of its rims is as good a start as any; a tube as long as wide
/// between two rims has 3π for each.
const GENTLE: f64 = 16.0;

/// The plan of these patches, in which every blend has the shape its flow starts from.
///
/// A film stretched between rims takes the shape of its warm start, and is remeshed on it: it is far
/// smaller than the surface that leaves the rims smoothly, and its triangles would end up long. Between
/// distant rims a warm start closes to a thread, and around bends it passes through itself; there the
/// patch is one that is [swept](patch::formed) from rim to rim.
pub(super) fn shaped(
    mesh: &Mesh,
    gaps: &[Gap<'_>],
    mut patches: Vec<FirstPatch>,
    options: &FillOptions,
) -> Plan {
    let plan = warm_started(mesh, gaps, &patches, options);
    each_blend(gaps, &plan, &mut patches, |gap, hole, film, ms| {
        let (Some(hole), Ok(film)) = (hole, film) else {
            return;
        };
        let start = Instant::now();
        let shape = placed(&plan, hole, std::mem::take(film));
        *film = patch::reblend(&gap_of(mesh, gap), &shape, &options.patch);
        *ms += milliseconds(start);
    });
    let plan = warm_started(mesh, gaps, &patches, options);
    each_blend(gaps, &plan, &mut patches, |gap, hole, film, ms| {
        let start = Instant::now();
        if let (Some(hole), Ok(film)) = (hole, &mut *film) {
            if hole.new_vertices.is_empty() {
                return;
            }
            *film = placed(&plan, hole, std::mem::take(film));
        }
        let judged = film.as_ref().ok().map(|film| Judged::new(mesh, gap, film));
        let is_fine = |film: &Judged| !film.crosses && film.bends < GENTLE * gap.len() as f64;
        if !judged.as_ref().is_some_and(is_fine) {
            let others = patch::formed(&gap_of(mesh, gap), &options.patch);
            let better = others
                .into_iter()
                .find(|other| Judged::new(mesh, gap, other).is_better_than(judged.as_ref()));
            if let Some(better) = better {
                *film = Ok(better);
            }
        }
        *ms += milliseconds(start);
    });
    let mut plan = Plan::new(mesh, gaps, &patches);
    for hole in plan.holes.iter_mut().filter(|hole| hole.loops.len() > 1) {
        hole.formed = true;
    }
    plan
}

/// The plan of these patches, those of groups with a blend in it at their warm starts. Where a warm start
/// fails they stay as they are; the flow will say why.
fn warm_started(
    mesh: &Mesh,
    gaps: &[Gap<'_>],
    patches: &[FirstPatch],
    options: &FillOptions,
) -> Plan {
    let mut plan = Plan::new(mesh, gaps, patches);
    for g in 0..plan.groups.len() {
        let is_blend = |&h: &usize| plan.holes[h].loops.len() > 1;
        if plan.groups[g].holes.iter().any(is_blend) {
            let start = plan.groups[g].problem(mesh, &plan, options);
            if let Ok(problem) = start.and_then(warm_start) {
                plan.place(g, &problem.to_world(problem.positions()));
            }
        }
    }
    plan
}

/// Calls `change` for the gaps of several rims (in parallel) with the hole of the plan, if there is one,
/// the patch and its milliseconds.
fn each_blend(
    gaps: &[Gap<'_>],
    plan: &Plan,
    patches: &mut [FirstPatch],
    change: impl Fn(&Gap<'_>, Option<&PlannedHole>, &mut Result<PatchMesh, patch::PatchError>, &mut f64)
    + Sync,
) {
    gaps.par_iter()
        .zip(patches)
        .filter(|(gap, _)| gap.len() > 1)
        .for_each(|(gap, (film, ms))| {
            let hole = plan.holes.iter().find(|hole| hole.id == gap[0].id);
            change(gap, hole, film, ms);
        });
}

/// A patch with the positions its new vertices have in the plan.
fn placed(plan: &Plan, hole: &PlannedHole, mut film: PatchMesh) -> PatchMesh {
    film.points.truncate(hole.edges);
    film.points
        .extend_from_slice(&plan.new_positions[hole.new_vertices.clone()]);
    film
}

/// What there is to say of a starting surface.
struct Judged {
    /// Whether it passes through itself or the mesh.
    crosses: bool,
    /// See [`patch::bending`], over the patch and the faces at its rims.
    bends: f64,
}

impl Judged {
    fn new(mesh: &Mesh, gap: &Gap<'_>, patch: &PatchMesh) -> Self {
        let topology = &mesh.topology;
        let old = mesh.vertex_count();
        let rims = gap.iter().flat_map(|l| l.vertices.iter());
        let rim: Vec<u32> = rims.map(|v| v.0).collect();
        let new = &patch.points[rim.len()..];
        let global = |v: u32| match rim.get(v as usize) {
            Some(&v) => v,
            None => (old + v as usize - rim.len()) as u32,
        };
        let own: Vec<[u32; 3]> = patch.triangles.iter().map(|t| t.map(global)).collect();
        // with the rims' faces, of which one may have two of the edges
        let halfedges = gap.iter().flat_map(|l| &l.halfedges);
        let mut faces: Vec<FaceId> = halfedges.map(|h| topology.face(h.twin())).collect();
        faces.sort_unstable();
        faces.dedup();
        let mut points = patch.points.clone();
        let mut around = patch.triangles.clone();
        let mut place: Vec<(u32, u32)> = rim.iter().copied().zip(0..).collect();
        place.sort_unstable();
        for face in faces {
            around.push(topology.face_vertices(face).map(|v| {
                if let Ok(at) = place.binary_search_by_key(&v.0, |p| p.0) {
                    return place[at].1;
                }
                points.push(mesh.position(v));
                points.len() as u32 - 1
            }));
        }
        Self {
            crosses: !crossings(mesh, &own, new, 1).is_empty(),
            bends: patch::bending(&points, &around),
        }
    }

    /// Whether to start from this one rather than from a film, if there is one.
    fn is_better_than(&self, film: Option<&Self>) -> bool {
        let gentler = |film: &Self| {
            film.crosses || !film.bends.is_finite() || self.bends < PREFERRED * film.bends
        };
        !self.crosses && film.is_none_or(gentler)
    }
}
