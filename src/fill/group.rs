//! Holes that have to be solved together.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use crate::fill::hole::{HoleRims, PlannedHole};
use crate::fill::patch_topology::{HoleTopology, PatchTopology};
use crate::fill::sharp::is_sharp;
use crate::mesh::union_find::{find, unite};
use crate::mesh::{DVec3, FaceId, Mesh, NeighbourhoodSearch, VertexId};
use crate::solver::SUPPORT_RINGS;

/// Holes whose support regions share vertices, or whose rims run side by side. Creases (G0) are not
/// considered: their holes have no support region, but may get one during the flow.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// Indices into [`Plan::holes`](crate::fill::plan::Plan::holes), ascending; none in a fairing.
    pub holes: Vec<usize>,
    /// The triangulations of their first patches.
    pub topology: Arc<PatchTopology>,
    /// Hole radius: the maximum of the group.
    pub radius: f64,
    /// The faces of the mesh in the support region of each hole, sorted. A fairing has one region.
    pub support: Vec<Vec<FaceId>>,
}

/// The groups of holes. A breadth-first search around the rims of each hole finds its support
/// region; holes whose regions meet are one group, as are those whose rims run [side by
/// side](rims_side_by_side), because their patches may cross. The region of a part of a hole that is split
/// along a crease ends at sharp edges, so that the parts are in different groups. Holes without interior
/// vertices need no flow and belong to no group.
pub(super) fn groups(mesh: &Mesh, holes: &[PlannedHole]) -> Vec<Group> {
    let count = holes.len();
    let mut owner = vec![u32::MAX; mesh.positions.len()];
    let mut parent: Vec<u32> = (0..count as u32).collect();
    let mut support: Vec<Vec<FaceId>> = Vec::with_capacity(count);
    let mut search = NeighbourhoodSearch::new(&mesh.topology);
    for (h, hole) in holes.iter().enumerate() {
        if hole.patch.new_points().is_empty() {
            support.push(Vec::new());
            continue;
        }
        // the rim is ring 1
        let rings = usize::from(SUPPORT_RINGS) - 1;
        let region = search.around(hole.rims.vertices.iter().copied(), rings);
        let mut own = |v: VertexId| {
            let before = std::mem::replace(&mut owner[v.index()], h as u32);
            if before != u32::MAX {
                unite(&mut parent, before, h as u32);
            }
        };
        if hole.rims.crease.is_empty() {
            region.vertices().iter().for_each(|&v| own(v));
            support.push(region.faces);
        } else {
            let (faces, inner) = between_sharp_edges(mesh, &hole.rims, &region.faces);
            inner.into_iter().for_each(own);
            support.push(faces);
        }
    }

    for [h, k] in rims_side_by_side(holes) {
        unite(&mut parent, h, k);
    }

    let mut group_of_root = vec![usize::MAX; count];
    let mut groups: Vec<Group> = Vec::new();
    for (h, hole) in holes.iter().enumerate() {
        if hole.patch.new_points().is_empty() {
            continue;
        }
        let root = find(&mut parent, h as u32) as usize;
        if group_of_root[root] == usize::MAX {
            group_of_root[root] = groups.len();
            groups.push(Group {
                holes: Vec::new(),
                topology: Arc::default(),
                radius: 0.0,
                support: Vec::new(),
            });
        }
        let group = &mut groups[group_of_root[root]];
        group.holes.push(h);
        group.radius = group.radius.max(hole.rims.radius());
        let topology = HoleTopology::of(&hole.patch);
        Arc::make_mut(&mut group.topology).holes.push(topology);
        group.support.push(std::mem::take(&mut support[h]));
    }
    groups
}

/// Those of `faces` (sorted) to which a way leads from the faces at the rim without a sharp edge in
/// between, sorted, and their vertices that are on no sharp edge.
fn between_sharp_edges(
    mesh: &Mesh,
    rims: &HoleRims,
    faces: &[FaceId],
) -> (Vec<FaceId>, Vec<VertexId>) {
    let topology = &mesh.topology;
    let mut seen = vec![false; faces.len()];
    let rim = rims.loops.iter().flat_map(|l| &l.halfedges);
    let mut stack: Vec<FaceId> = rim.map(|h| topology.face(h.twin())).collect();
    let (mut reached, mut vertices, mut at_edges) = (Vec::new(), Vec::new(), Vec::new());
    while let Some(face) = stack.pop() {
        match faces.binary_search(&face) {
            Ok(i) if !std::mem::replace(&mut seen[i], true) => reached.push(face),
            _ => continue,
        }
        vertices.extend(topology.face_vertices(face));
        for h in topology.face_halfedges(face) {
            if is_sharp(mesh, h) {
                at_edges.extend([topology.origin(h), topology.target(h)]);
            } else if !topology.is_boundary_edge(h) {
                stack.push(topology.face(h.twin()));
            }
        }
    }
    reached.sort_unstable();
    at_edges.sort_unstable();
    vertices.sort_unstable();
    vertices.dedup();
    vertices.retain(|v| at_edges.binary_search(v).is_err());
    (reached, vertices)
}

/// Pairs of holes with new vertices whose rims run side by side: at least half of the vertices of each are less
/// than 1.5 edges, by the mean over all rims, from one of the other. Without the parts of a hole that is split
/// along a crease. Linear in the number of rim vertices where these are about an edge apart.
fn rims_side_by_side(holes: &[PlannedHole]) -> Vec<[u32; 2]> {
    let solved = (0..).zip(holes);
    let is_whole = |hole: &PlannedHole| hole.rims.crease.is_empty();
    let solved = solved.filter(|(_, hole)| !hole.patch.new_points().is_empty() && is_whole(hole));
    let rims = || {
        solved
            .clone()
            .map(|(h, hole)| (h, &hole.patch.points[..hole.patch.rim]))
    };
    let loops = rims().flat_map(|(h, _)| &holes[h as usize].rims.loops);
    let lengths = loops.map(|one| (one.perimeter, one.edges()));
    let (length, edges) = lengths.fold((0.0, 0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
    let reach = 1.5 * length / edges as f64;
    let cell = |p: DVec3| (p / reach).floor().to_array().map(|x| x as i64);
    let mut cells: FxHashMap<[i64; 3], Vec<(u32, DVec3)>> = FxHashMap::default();
    for (h, points) in rims() {
        for &p in points {
            cells.entry(cell(p)).or_default().push((h, p));
        }
    }
    // how many vertices of the first rim are near the second one
    let mut counts: FxHashMap<[u32; 2], usize> = FxHashMap::default();
    for (h, points) in rims() {
        for &p in points {
            let [x, y, z] = cell(p);
            let around = (0..27).map(|k| [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1]);
            let there = around.filter_map(|cell| cells.get(&cell)).flatten();
            let near = there.filter(|(other, q)| *other != h && p.distance(*q) < reach);
            let mut others: Vec<u32> = near.map(|(other, _)| *other).collect();
            others.sort_unstable();
            others.dedup();
            for other in others {
                *counts.entry([h, other]).or_default() += 1;
            }
        }
    }
    let runs_along = |[h, other]: [u32; 2]| {
        let count = counts.get(&[h, other]).copied().unwrap_or(0);
        2 * count >= holes[h as usize].patch.rim
    };
    let mut pairs: Vec<[u32; 2]> = counts.keys().copied().filter(|[h, k]| h < k).collect();
    pairs.retain(|&[h, k]| runs_along([h, k]) && runs_along([k, h]));
    pairs.sort_unstable();
    pairs
}
