//! Holes that have to be solved together.

use std::sync::Arc;

use crate::fill::hole::PlannedHole;
use crate::fill::patch_topology::{HoleTopology, PatchTopology};
use crate::mesh::union_find::{find, unite};
use crate::mesh::{FaceId, Mesh, NeighbourhoodSearch};
use crate::solver::SUPPORT_RINGS;

/// Holes whose support regions share vertices. Creases (G0) are not considered: their holes have no
/// support region, but may get one during the flow.
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
/// region; holes whose regions meet are one group. Holes without interior vertices need no flow
/// and belong to no group.
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
        for v in region.vertices() {
            let before = std::mem::replace(&mut owner[v.index()], h as u32);
            if before != u32::MAX {
                unite(&mut parent, before, h as u32);
            }
        }
        support.push(region.faces);
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
