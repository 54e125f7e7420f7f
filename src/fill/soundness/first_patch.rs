//! Sound patches without new vertices, which no flow changes.

use crate::fill::assemble::appended_triangles;
use crate::fill::defects::{Defects, Room, defects, severity};
use crate::fill::hole::{DraftHole, HoleRims, PlannedHole};
use crate::fill::passing::passing_part;
use crate::fill::plan::Plan;
use crate::fill::repair::repaired;
use crate::fill::result::FillError;
use crate::fill::self_intersection::{CompactTriangles, Obstacles};
use crate::mesh::{Mesh, TriangleIntersections, VertexId, bounds, is_slit};
use crate::patch::{self, OtherPatches, Patch, PatchOptions};
use crate::warning::{Warning, Warnings};

/// The plan of holes. Their patches without new vertices, which no flow changes, are replaced by sound ones where
/// that is possible. Holes without a patch are [`Plan::failed`].
pub(in crate::fill) fn plan_of(mesh: &Mesh, drafts: Vec<DraftHole>, options: PatchOptions) -> Plan {
    let (mut holes, mut failed) = (Vec::new(), Vec::new());
    let obstacles = Obstacles::new(drafts.len());
    let mut loose: Vec<[u32; 3]> = Vec::new();
    for draft in drafts {
        match draft.patch {
            Ok(mut patch) => {
                let rims = draft.rims;
                let mut warnings = draft.warnings;
                if !draft.is_checked {
                    let left =
                        make_patch_sound(mesh, &obstacles, &rims, &mut patch, &loose, options);
                    warnings.extend(left);
                }
                let hole = PlannedHole {
                    rims,
                    patch,
                    has_initial_shape: draft.has_initial_shape,
                    patch_ms: draft.patch_ms,
                    warnings,
                };
                loose.extend(hole.loose_triangles());
                holes.push(hole);
            }
            Err(source) => failed.push(FillError::Patch {
                hole: draft.rims.id(),
                source,
            }),
        }
    }
    Plan::new(mesh, holes, failed, obstacles)
}

/// Replaces an unsound patch without new vertices, which no flow changes, by a sound or less unsound
/// one. `loose` are the patches of that kind before it. Returns the warnings about the defects that are left.
fn make_patch_sound(
    mesh: &Mesh,
    obstacles: &Obstacles,
    rims: &HoleRims,
    patch: &mut Patch,
    loose: &[[u32; 3]],
    options: PatchOptions,
) -> Warnings {
    let defects = |patch: &Patch| {
        let new = patch.new_points();
        let part = (&rims.vertices[..], &patch.triangles[..], new.len());
        let own = appended_triangles(mesh.vertex_count(), [part]);
        let room = Room::around(mesh, rims, &[]);
        defects(mesh, obstacles, rims, room, &own, loose, new)
    };
    if !patch.new_points().is_empty() {
        return Warnings::default();
    }
    let mut left = defects(patch);
    if let Some(found) = left {
        if found.crossings.is_none() {
            if rims.geometry.rims.iter().all(|rim| is_slit(&rim.points)) {
                return [Warning::Slit].into_iter().collect();
            }
        } else if let Some(at) = passing_part(mesh, obstacles, rims, patch) {
            let passed = Warning::PassedThrough { at };
            return found.warnings().chain([passed]).collect();
        }
    }
    let others = left.and_then(|_| other_patches(mesh, obstacles, rims, options));
    if let Some(OtherPatches { relaxed, flat }) = others {
        for other in std::iter::once(relaxed).chain(flat) {
            let after = defects(&other);
            if severity(after) < severity(left) {
                left = after;
                *patch = other;
            }
        }
    }
    if left.is_some()
        && let Some(sound) = repaired(mesh, obstacles, rims, patch, loose, &[])
    {
        *patch = sound;
    }
    if patch.new_points().is_empty() {
        left.iter().flat_map(Defects::warnings).collect()
    } else {
        Warnings::default()
    }
}

/// Other first patches of a hole; their triangulation avoids the triangles of the mesh.
pub(super) fn other_patches(
    mesh: &Mesh,
    obstacles: &Obstacles,
    rims: &HoleRims,
    options: PatchOptions,
) -> Option<OtherPatches> {
    let [rim] = &rims.geometry.rims[..] else {
        return None;
    };
    let (low, high) = bounds(rim.points.iter().copied());
    let near = obstacles.overlapping(mesh, low, high);
    let all = CompactTriangles::new(near, |v| mesh.position(VertexId(v)));
    let given = TriangleIntersections::new(&all.points, &all.triangles);
    let rim_numbers: Vec<Option<u32>> = rims.vertices.iter().map(|v| all.number(v.0)).collect();
    let crosses = |t: [u32; 3]| match t.map(|v| rim_numbers[v as usize]) {
        [Some(a), Some(b), Some(c)] => given.any([a, b, c]),
        _ => false,
    };
    patch::fill_excluding(rim, options, &crosses)
}
