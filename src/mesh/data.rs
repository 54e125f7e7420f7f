//! The mesh type: an oriented manifold with positions and the attributes of its file.

use super::union_find::unite;
use super::{Attributes, DVec3, FaceId, HalfedgeId, Topology, TopologyError, VertexId};

/// An oriented manifold triangle mesh, possibly with boundary, as [`build`](super::build()) builds
/// it from a [`Soup`](super::Soup).
///
/// Vertices are those of the file in its order (without welded copies), then the copies from cuts
/// at non-manifold edges and vertices. Use an `Arc` to keep many clones.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Vertex positions in the units of the file; one per vertex of `topology`.
    pub positions: Vec<DVec3>,
    /// Connectivity.
    pub topology: Topology,
    /// What the file holds besides, such as colours and groups.
    pub attributes: Attributes,
    /// Triangles of non-orientable components (Moebius strips), which cannot be part of
    /// `topology`. They are never changed, and are written back after the others.
    pub non_orientable: Vec<[u32; 3]>,
}

impl Mesh {
    /// A mesh without attributes.
    ///
    /// # Panics
    /// If the number of positions is not the number of vertices.
    pub fn new(positions: Vec<DVec3>, topology: Topology) -> Self {
        assert_eq!(positions.len(), topology.vertex_count());
        Self {
            positions,
            topology,
            attributes: Attributes::default(),
            non_orientable: Vec::new(),
        }
    }

    /// A mesh of these triangles without attributes.
    ///
    /// # Errors
    /// As [`Topology::from_triangles`].
    pub fn from_triangles(
        positions: Vec<DVec3>,
        triangles: &[[u32; 3]],
    ) -> Result<Self, TopologyError> {
        let topology = Topology::from_triangles(positions.len(), triangles)?;
        Ok(Self::new(positions, topology))
    }

    /// The mesh with the faces of some components (numbers as in [`components`]) flipped: their
    /// second and third corners are exchanged. Boundary loops keep their numbers and run in the
    /// opposite direction.
    ///
    /// # Panics
    /// Never: a mesh with flipped components is an oriented manifold.
    #[must_use]
    pub fn with_flipped(&self, flipped: &[u32]) -> Self {
        let parts = components(&self.topology);
        let faces: Vec<[u32; 3]> = self
            .topology
            .triangles()
            .zip(&parts.of_face)
            .map(|([a, b, c], part)| {
                if flipped.contains(part) {
                    [a, c, b]
                } else {
                    [a, b, c]
                }
            })
            .collect();
        let topology = Topology::from_triangles(self.positions.len(), &faces)
            .expect("an oriented manifold stays one when whole components are flipped");
        let mut attributes = self.attributes.clone();
        for (face, part) in parts.of_face.iter().enumerate() {
            if flipped.contains(part) {
                attributes.faces.flip(face);
            }
        }
        Self {
            topology,
            attributes,
            ..self.clone()
        }
    }

    /// Number of vertices, isolated ones included.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// Number of triangles of the topology.
    pub fn face_count(&self) -> usize {
        self.topology.face_count()
    }

    /// The position of a vertex.
    #[inline]
    pub fn position(&self, v: VertexId) -> DVec3 {
        self.positions[v.index()]
    }

    /// The corner positions of a face.
    #[inline]
    pub fn corners(&self, f: FaceId) -> [DVec3; 3] {
        let [a, b, c] = self.topology.face_vertices(f);
        [self.position(a), self.position(b), self.position(c)]
    }

    /// The length of an edge.
    pub fn edge_length(&self, h: HalfedgeId) -> f64 {
        let [a, b] = [self.topology.origin(h), self.topology.target(h)];
        self.position(a).distance(self.position(b))
    }

    /// All triangles of a written file: those of the topology, then the non-orientable ones.
    pub fn all_triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.topology
            .triangles()
            .chain(self.non_orientable.iter().copied())
    }
}

/// Connected components of the faces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Components {
    /// The component of each face; components are numbered from 0 by their lowest face.
    pub of_face: Vec<u32>,
    /// Number of components.
    pub count: usize,
}

impl Components {
    /// Whether two faces belong to one component.
    pub fn are_joined(&self, faces: [u32; 2]) -> bool {
        let [a, b] = faces.map(|f| self.of_face[f as usize]);
        a == b
    }
}

/// Groups faces that are joined across edges.
pub fn components(topology: &Topology) -> Components {
    // the lowest face of a class stands for it
    let mut of_face: Vec<u32> = (0..topology.face_count() as u32).collect();
    for h in topology.edges() {
        let [f, g] = [h, h.twin()].map(|h| topology.face(h));
        if f.is_some() && g.is_some() {
            unite(&mut of_face, f.0, g.0);
        }
    }
    let mut count = 0;
    for f in 0..of_face.len() {
        let lower = of_face[f] as usize;
        if lower == f {
            of_face[f] = count;
            count += 1;
        } else {
            // has its number already
            of_face[f] = of_face[lower];
        }
    }
    Components {
        of_face,
        count: count as usize,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix;
    use crate::shapes::icosphere;

    /// Faces in any order: those joined across edges have the same number, and numbers are in the order of the
    /// lowest faces.
    #[test]
    fn components_are_numbered_by_their_lowest_faces() {
        let (positions, triangles) = icosphere(4);
        let n = positions.len() as u32;
        let mut all: Vec<([u32; 3], u32)> = (0..3)
            .flat_map(|k| triangles.iter().map(move |t| (t.map(|v| v + k * n), k)))
            .collect();
        let mut random = SplitMix::new(5);
        for i in (1..all.len()).rev() {
            all.swap(i, random.below(i + 1));
        }
        let faces: Vec<[u32; 3]> = all.iter().map(|f| f.0).collect();
        let topology = Topology::from_triangles(3 * n as usize, &faces).expect("spheres");
        let parts = components(&topology);
        let mut order: Vec<u32> = Vec::new();
        for (sphere, number) in all.iter().map(|f| f.1).zip(parts.of_face) {
            let known = order.iter().position(|&s| s == sphere).unwrap_or_else(|| {
                order.push(sphere);
                order.len() - 1
            });
            assert_eq!(number as usize, known);
        }
        assert_eq!(parts.count, 3);
    }
}
