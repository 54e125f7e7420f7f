//! The neighbourhood of some faces as a mesh of its own, cut along creases.

use crate::mesh::union_find::{find, unite};
use crate::mesh::{DVec3, FaceId, HalfedgeId, Topology, VertexId};

/// Rings of faces around the given ones: curvatures at their corners need the next faces, whose
/// stencils need the ones after.
const RINGS: usize = 2;

/// A mesh that holds the given faces and all that their limit surface depends on. Along creases it
/// is open, so that either side is continued by its own ghosts.
#[derive(Clone, Debug)]
pub(super) struct Cut {
    pub(super) topology: Topology,
    /// The given faces, in their order.
    pub(super) faces: Vec<FaceId>,
    /// The vertex of the whole mesh behind each vertex; `None` if the mesh is the whole one.
    to_mesh: Option<Vec<u32>>,
}

impl Cut {
    pub(super) fn new(topology: &Topology, faces: &[FaceId], creases: &[[VertexId; 2]]) -> Self {
        if creases.is_empty() && 2 * faces.len() >= topology.face_count() {
            return Self {
                topology: topology.clone(),
                faces: faces.to_vec(),
                to_mesh: None,
            };
        }
        let kept = with_rings(topology, faces);
        let mut local_face = vec![u32::MAX; topology.face_count()];
        for (i, f) in kept.iter().enumerate() {
            local_face[f.index()] = i as u32;
        }
        let crease = crease_edges(topology, creases);
        // a vertex for each fan of faces that no crease divides
        let mut link: Vec<u32> = (0..3 * kept.len() as u32).collect();
        for (i, &f) in kept.iter().enumerate() {
            for (k, h) in halfedges(topology, f).into_iter().enumerate() {
                let g = topology.face(h.twin());
                if !g.is_some() || local_face[g.index()] == u32::MAX || crease[h.edge()] {
                    continue;
                }
                let twin = halfedges(topology, g).iter().position(|&t| t == h.twin());
                let (Some(m), j) = (twin, 3 * local_face[g.index()]) else {
                    continue;
                };
                let corner = |c: usize| 3 * i as u32 + c as u32 % 3;
                // the edge runs from corner k to k + 1 here and from m to m + 1 there
                unite(&mut link, corner(k), j + (m as u32 + 1) % 3);
                unite(&mut link, corner(k + 1), j + m as u32);
            }
        }
        let mut to_mesh = Vec::new();
        let mut number = vec![u32::MAX; link.len()];
        let mut triangles = vec![[0; 3]; kept.len()];
        for c in 0..link.len() {
            let root = find(&mut link, c as u32) as usize;
            if root == c {
                number[c] = to_mesh.len() as u32;
                to_mesh.push(topology.face_vertices(kept[c / 3])[c % 3].0);
            }
            triangles[c / 3][c % 3] = number[root];
        }
        let cut = Topology::from_triangles(to_mesh.len(), &triangles)
            .expect("part of a manifold, with one vertex for each fan");
        Self {
            topology: cut,
            faces: faces
                .iter()
                .map(|f| FaceId(local_face[f.index()]))
                .collect(),
            to_mesh: Some(to_mesh),
        }
    }

    /// The given faces and all that share a vertex with them, ascending.
    pub(super) fn faces_around(&self) -> Vec<FaceId> {
        let mut marked = vec![false; self.topology.face_count()];
        for &f in &self.faces {
            marked[f.index()] = true;
        }
        if self.faces.len() < marked.len() {
            grow(&self.topology, &mut marked);
        }
        chosen(&marked)
    }

    /// Positions of the vertices relative to `centre`, from those of the whole mesh.
    pub(super) fn positions(&self, positions: &[DVec3], centre: DVec3) -> Vec<DVec3> {
        match &self.to_mesh {
            None => positions.iter().map(|&p| p - centre).collect(),
            Some(vertices) => vertices
                .iter()
                .map(|&v| positions[v as usize] - centre)
                .collect(),
        }
    }
}

/// The half-edges of a face from its first, second and third corner.
pub(super) fn halfedges(topology: &Topology, f: FaceId) -> [HalfedgeId; 3] {
    let h = topology.halfedge_of_face(f);
    let n = topology.next(h);
    [h, n, topology.next(n)]
}

/// The faces and [`RINGS`] more around them, ascending.
fn with_rings(topology: &Topology, faces: &[FaceId]) -> Vec<FaceId> {
    let mut marked = vec![false; topology.face_count()];
    for &f in faces {
        marked[f.index()] = true;
    }
    for _ in 0..RINGS {
        grow(topology, &mut marked);
    }
    chosen(&marked)
}

/// Marks all faces that share a vertex with a marked one.
fn grow(topology: &Topology, marked: &mut [bool]) {
    let mut touched = vec![false; topology.vertex_count()];
    for f in chosen(marked) {
        for v in topology.face_vertices(f) {
            touched[v.index()] = true;
        }
    }
    for f in (0..marked.len()).map(FaceId::from) {
        let touches = |v: VertexId| touched[v.index()];
        marked[f.index()] |= topology.face_vertices(f).into_iter().any(touches);
    }
}

fn chosen(marked: &[bool]) -> Vec<FaceId> {
    let faces = (0..marked.len()).filter(|&f| marked[f]);
    faces.map(FaceId::from).collect()
}

/// For each edge whether it is one of the creases.
fn crease_edges(topology: &Topology, creases: &[[VertexId; 2]]) -> Vec<bool> {
    let mut crease = vec![false; topology.halfedge_count() / 2];
    for &[a, b] in creases {
        let between = topology.outgoing(a).find(|&h| topology.target(h) == b);
        if let Some(h) = between {
            crease[h.edge()] = true;
        }
    }
    crease
}
