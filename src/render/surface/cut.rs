//! The neighbourhood of some faces as a mesh of its own, cut along creases.

use crate::mesh::{DVec3, FaceId, Topology, VertexId, corner_fans, edge_flags};

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
        // a vertex for each fan of faces that no crease divides
        let fans = corner_fans(topology, &kept, &edge_flags(topology, creases));
        // the kept faces are in ascending order
        let local = |f| FaceId::from(kept.partition_point(|&k| k < f));
        let mut to_mesh = Vec::new();
        let mut number = vec![u32::MAX; fans.len()];
        let mut triangles = vec![[0; 3]; kept.len()];
        for c in 0..fans.len() {
            let root = fans[c] as usize;
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
            faces: faces.iter().map(|&f| local(f)).collect(),
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
