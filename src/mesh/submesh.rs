//! A part of a mesh as a separate mesh, with the map back to the whole.

use super::union_find::{find, unite};
use super::{FaceId, HalfedgeId, Topology, TopologyError};

/// Some faces of a whole mesh as a separate mesh, cut open along edges.
#[derive(Clone, Debug)]
pub struct Submesh {
    /// Connectivity. Faces are in the order of `faces`, corners as in the whole mesh.
    pub topology: Topology,
    /// The face of the whole mesh that corresponds to each face, in ascending order.
    pub faces: Vec<FaceId>,
    /// The vertex of the whole mesh that each vertex corresponds to or is a copy of.
    pub to_whole: Vec<u32>,
}

impl Submesh {
    /// The part of `whole` that consists of `faces`, which must ascend. At each vertex every fan of
    /// faces between cut or boundary edges gets its own vertex; `is_cut` must be the same for both
    /// half-edges of an edge. A cut that ends inside opens nothing at its end.
    ///
    /// # Errors
    /// The part is not a manifold. This cannot happen if the mesh is a manifold.
    pub fn new(
        whole: &Topology,
        faces: Vec<FaceId>,
        is_cut: impl Fn(HalfedgeId) -> bool,
    ) -> Result<Self, TopologyError> {
        let fans = corner_fans(whole, &faces, is_cut);
        let mut to_whole = Vec::new();
        let mut number = vec![u32::MAX; fans.len()];
        let mut triangles = vec![[0; 3]; faces.len()];
        for (c, &fan) in fans.iter().enumerate() {
            if fan as usize == c {
                number[c] = to_whole.len() as u32;
                to_whole.push(whole.face_vertices(faces[c / 3])[c % 3].0);
            }
            triangles[c / 3][c % 3] = number[fan as usize];
        }
        Ok(Self {
            topology: Topology::from_triangles(to_whole.len(), &triangles)?,
            faces,
            to_whole,
        })
    }

    /// The face of this mesh that corresponds to a face of the whole mesh, if there is one.
    pub fn face(&self, whole: FaceId) -> Option<FaceId> {
        self.faces.binary_search(&whole).ok().map(FaceId::from)
    }

    /// The values at this mesh's vertices, taken from those of the whole mesh.
    pub fn gather<T: Copy>(&self, of_whole: &[T]) -> Vec<T> {
        self.to_whole
            .iter()
            .map(|&v| of_whole[v as usize])
            .collect()
    }
}

/// The fans of the corners of `faces`, which must ascend: corner `k` of the `i`-th face is number
/// `3i + k`, and each gets the lowest number in its fan. A fan continues across an edge if both its
/// faces are among `faces` and it is not cut.
pub(super) fn corner_fans(
    topology: &Topology,
    faces: &[FaceId],
    is_cut: impl Fn(HalfedgeId) -> bool,
) -> Vec<u32> {
    // a table of places pays off for a good part of the mesh
    let table = (8 * faces.len() >= topology.face_count()).then(|| {
        let mut place = vec![None; topology.face_count()];
        for (i, f) in faces.iter().enumerate() {
            place[f.index()] = Some(i as u32);
        }
        place
    });
    let place = |f: FaceId| match &table {
        Some(place) if f.is_some() => place[f.index()].map(|i| i as usize),
        Some(_) => None,
        None => faces.binary_search(&f).ok(),
    };
    let mut link: Vec<u32> = (0..3 * faces.len() as u32).collect();
    for (i, &f) in faces.iter().enumerate() {
        for (k, h) in topology.face_halfedges(f).into_iter().enumerate() {
            let g = topology.face(h.twin());
            let Some(j) = place(g) else { continue };
            if is_cut(h) {
                continue;
            }
            let sides = topology.face_halfedges(g);
            let m = sides.iter().position(|&t| t == h.twin()).unwrap_or(0);
            // the edge runs from corner k to k + 1 here and from m to m + 1 there
            let here = |c: usize| (3 * i + c % 3) as u32;
            let there = |c: usize| (3 * j + c % 3) as u32;
            unite(&mut link, here(k), there(m + 1));
            unite(&mut link, here(k + 1), there(m));
        }
    }
    (0..link.len() as u32).map(|c| find(&mut link, c)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::check_topology;
    use crate::shapes::icosphere;

    #[test]
    fn faces_and_vertices_lead_back() {
        let (positions, triangles) = icosphere(4);
        let whole = Topology::from_triangles(positions.len(), &triangles).expect("closed");
        let faces: Vec<FaceId> = whole.faces().filter(|f| f.0 % 5 < 3).collect();
        for cut in [false, true] {
            let part = Submesh::new(&whole, faces.clone(), |_| cut).expect("a manifold");
            check_topology(&part.topology).expect("sound");
            assert_eq!(part.topology.vertex_count() == 3 * faces.len(), cut);
            assert_eq!(part.topology.boundary_loops().len() == faces.len(), cut);
            let there = part.gather(&positions);
            for (f, &g) in part.topology.faces().zip(&faces) {
                let corners = part.topology.face_vertices(f);
                assert_eq!(
                    corners.map(|v| part.to_whole[v.index()]),
                    whole.face_vertices(g).map(|v| v.0)
                );
                assert_eq!(
                    there[corners[0].index()],
                    positions[whole.face_vertices(g)[0].index()]
                );
                assert_eq!(part.face(g), Some(f));
            }
            assert_eq!(part.face(FaceId(3)), None);
        }
    }
}
