//! Holes that have to be solved together, and the region of each group.

use crate::fill::{Plan, sheets};
use crate::mesh::union_find::{find, unite};
use crate::mesh::{BoundaryLoop, DVec3, FaceId, Mesh, TopologyError, VertexId};
use crate::solver::{COLLAR_RINGS, FlowProblem, SolverError};

/// Holes whose collars share vertices.
#[derive(Clone, Debug)]
pub struct Group {
    /// Indices into [`Plan::holes`].
    pub holes: Vec<usize>,
    /// Indices into [`Plan::new_positions`] of the interior vertices, in the problem's order.
    pub new_vertices: Vec<u32>,
    /// Hole radius: the largest of the group.
    pub radius: f64,
    /// Faces of the mesh in the collar.
    faces: Vec<FaceId>,
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
        // faces that touch a vertex of ring ≤ COLLAR_RINGS - 1 (the rim is ring 1)
        for _ in 1..COLLAR_RINGS {
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
                faces: Vec::new(),
            });
        }
        let group = &mut groups[group_of_root[root]];
        let hole = &plan.holes[h];
        group.holes.push(h);
        group.radius = group.radius.max(hole.radius);
        group
            .new_vertices
            .extend(hole.new_vertices.clone().map(|v| v as u32));
        group.faces.append(&mut collars[h]);
    }
    for group in &mut groups {
        group.faces.sort_unstable();
        group.faces.dedup();
    }
    groups
}

impl Group {
    /// The flow of this group's patch vertices from their current places in the plan.
    ///
    /// # Errors
    /// As [`FlowProblem::new`].
    pub fn problem(&self, mesh: &Mesh, plan: &Plan) -> Result<FlowProblem, SolverError> {
        let old = mesh.positions.len();
        let mut local = vec![u32::MAX; old + plan.new_positions.len()];
        let mut positions: Vec<DVec3> = Vec::new();
        let mut triangles: Vec<[u32; 3]> = Vec::new();
        for (i, &v) in self.new_vertices.iter().enumerate() {
            local[old + v as usize] = i as u32;
            positions.push(plan.new_positions[v as usize]);
        }
        let mut collar: Vec<VertexId> = self
            .faces
            .iter()
            .flat_map(|&f| mesh.topology.face_vertices(f))
            .collect();
        collar.sort_unstable();
        collar.dedup();
        let interior: Vec<u32> = (0..positions.len() as u32).collect();
        let mut number = |v: u32| {
            let slot = &mut local[v as usize];
            if *slot == u32::MAX {
                *slot = positions.len() as u32;
                positions.push(mesh.positions[v as usize]);
            }
            *slot
        };
        for &h in &self.holes {
            for t in &plan.triangles[plan.holes[h].new_faces.clone()] {
                triangles.push(t.map(&mut number));
            }
        }
        // patches without interior vertices close holes in this collar
        for hole in plan.holes.iter().filter(|h| h.new_vertices.is_empty()) {
            let faces = &plan.triangles[hole.new_faces.clone()];
            let touches = |t: &[u32; 3]| {
                t.iter()
                    .any(|v| collar.binary_search(&VertexId(*v)).is_ok())
            };
            if faces.iter().any(touches) {
                triangles.extend(faces.iter().map(|t| t.map(&mut number)));
            }
        }
        for &f in &self.faces {
            triangles.push(mesh.topology.face_vertices(f).map(|v| number(v.0)));
        }
        match FlowProblem::new(&positions, &triangles, &interior, self.radius) {
            Err(SolverError::Topology(TopologyError::NonManifoldVertex { .. })) => {
                sheets::separate(&mut positions, &mut triangles);
                FlowProblem::new(&positions, &triangles, &interior, self.radius)
            }
            problem => problem,
        }
    }
}
