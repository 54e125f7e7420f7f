//! Holes that have to be solved together.

use crate::fill::{FillOptions, Plan, region};
use crate::mesh::union_find::{find, unite};
use crate::mesh::{BoundaryLoop, FaceId, Mesh, VertexId};
use crate::solver::{FlowProblem, SUPPORT_RINGS, SolverError};

/// Holes whose collars share vertices. Creases (G0) are not asked for: they have no collar, but may
/// get one while the flow runs.
#[derive(Clone, Debug)]
pub struct Group {
    /// Indices into [`Plan::holes`].
    pub holes: Vec<usize>,
    /// Indices into [`Plan::new_positions`] of the interior vertices, in the problem's order.
    pub new_vertices: Vec<u32>,
    /// Hole radius: the largest of the group.
    pub radius: f64,
    /// Faces of the mesh in the collar of each hole, sorted.
    pub(super) collars: Vec<Vec<FaceId>>,
}

/// Collars are found around every rim by breadth-first search; holes whose collars meet are one
/// group. Holes without interior vertices need no flow and belong to none.
pub(super) fn groups(mesh: &Mesh, gaps: &[&[&BoundaryLoop]], plan: &Plan) -> Vec<Group> {
    let count = gaps.len();
    let mut owner = vec![u32::MAX; mesh.positions.len()];
    let mut parent: Vec<u32> = (0..count as u32).collect();
    let mut collars: Vec<Vec<FaceId>> = Vec::with_capacity(count);
    let mut face_owner = vec![u32::MAX; mesh.topology.face_count()];
    for (h, gap) in gaps.iter().enumerate() {
        if plan.holes[h].new_vertices.is_empty() {
            collars.push(Vec::new());
            continue;
        }
        let mut faces = Vec::new();
        let rims = gap.iter().flat_map(|l| l.vertices.iter().copied());
        let mut front: Vec<VertexId> = rims.collect();
        let mut claim = |v: VertexId, parent: &mut [u32]| -> bool {
            match owner[v.index()] {
                u32::MAX => {
                    owner[v.index()] = h as u32;
                    true
                }
                o if o as usize == h => false,
                o => {
                    unite(parent, o, h as u32);
                    // walk on as far as this hole's own rings reach, once
                    owner[v.index()] = h as u32;
                    true
                }
            }
        };
        front.retain(|&v| claim(v, &mut parent));
        // faces that touch a vertex of ring ≤ SUPPORT_RINGS - 1 (the rim is ring 1)
        for _ in 1..SUPPORT_RINGS {
            let mut next = Vec::new();
            for &v in &front {
                for half in mesh.topology.outgoing(v) {
                    let face = mesh.topology.face(half);
                    if face.is_some() && face_owner[face.index()] != h as u32 {
                        face_owner[face.index()] = h as u32;
                        faces.push(face);
                    }
                    let w = mesh.topology.target(half);
                    if claim(w, &mut parent) {
                        next.push(w);
                    }
                }
            }
            front = next;
        }
        faces.sort_unstable();
        collars.push(faces);
    }

    let mut group_of_root = vec![usize::MAX; count];
    let mut groups: Vec<Group> = Vec::new();
    for h in 0..count {
        if plan.holes[h].new_vertices.is_empty() {
            continue;
        }
        let root = find(&mut parent, h as u32) as usize;
        if group_of_root[root] == usize::MAX {
            group_of_root[root] = groups.len();
            groups.push(Group {
                holes: Vec::new(),
                new_vertices: Vec::new(),
                radius: 0.0,
                collars: Vec::new(),
            });
        }
        let group = &mut groups[group_of_root[root]];
        let hole = &plan.holes[h];
        group.holes.push(h);
        group.radius = group.radius.max(hole.radius);
        group
            .new_vertices
            .extend(hole.new_vertices.clone().map(|v| v as u32));
        group.collars.push(std::mem::take(&mut collars[h]));
    }
    groups
}

impl Group {
    /// The flow of this group's patch vertices from their current places in the plan.
    ///
    /// # Errors
    /// As [`FlowProblem::new`].
    pub fn problem(
        &self,
        mesh: &Mesh,
        plan: &Plan,
        options: &FillOptions,
    ) -> Result<FlowProblem, SolverError> {
        let (shape, positions) = plan.shape_of(self);
        region::problem(mesh, plan, self, &shape, &positions, options)
    }
}
