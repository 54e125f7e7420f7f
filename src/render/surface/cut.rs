//! The neighbourhood of some faces as a separate mesh, cut along creases.

use crate::mesh::{DVec3, FaceId, Neighbourhood, Submesh, Topology, VertexId, edge_flags};

/// Rings of faces around the given ones. Curvatures at corners depend on the next ring of faces,
/// whose stencils depend on one more ring.
const RINGS: usize = 2;

/// A mesh of the given faces and all faces that their limit surface depends on. It is open along
/// creases, so that ghost vertices continue each side separately.
#[derive(Clone, Debug)]
pub(super) struct Cut {
    pub(super) topology: Topology,
    /// The given faces, in their order.
    pub(super) faces: Vec<FaceId>,
    /// The vertex of the whole mesh that each vertex corresponds to; `None` if this is the whole
    /// mesh.
    to_whole: Option<Vec<u32>>,
}

impl Cut {
    pub(super) fn new(topology: &Topology, faces: &[FaceId], creases: &[[VertexId; 2]]) -> Self {
        if creases.is_empty() && 2 * faces.len() >= topology.face_count() {
            return Self {
                topology: topology.clone(),
                faces: faces.to_vec(),
                to_whole: None,
            };
        }
        let is_crease = edge_flags(topology, creases);
        let corners = faces.iter().flat_map(|&f| topology.face_vertices(f));
        let kept = Neighbourhood::new(topology, corners, RINGS).faces;
        let part = Submesh::new(topology, kept, |h| is_crease[h.edge()])
            .expect("part of a manifold, with one vertex for each fan");
        Self {
            faces: faces.iter().filter_map(|&f| part.face(f)).collect(),
            topology: part.topology,
            to_whole: Some(part.to_whole),
        }
    }

    /// The given faces and all faces that share a vertex with them, in ascending order.
    pub(super) fn faces_around(&self) -> Vec<FaceId> {
        let corners = self
            .faces
            .iter()
            .flat_map(|&f| self.topology.face_vertices(f));
        Neighbourhood::new(&self.topology, corners, 1).faces
    }

    /// The vertex of the whole mesh that a vertex corresponds to.
    pub(super) fn whole(&self, v: u32) -> u32 {
        self.to_whole
            .as_ref()
            .map_or(v, |vertices| vertices[v as usize])
    }

    /// Positions of the vertices relative to `centre`, from those of the whole mesh.
    pub(super) fn positions(&self, positions: &[DVec3], centre: DVec3) -> Vec<DVec3> {
        match &self.to_whole {
            None => positions.iter().map(|&p| p - centre).collect(),
            Some(vertices) => vertices
                .iter()
                .map(|&v| positions[v as usize] - centre)
                .collect(),
        }
    }
}
