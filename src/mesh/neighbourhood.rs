//! Rings of vertices and faces around some vertices, by breadth-first search.

use rustc_hash::FxHashSet;

use super::{FaceId, Topology, VertexId};

/// The rings around some vertices. Ring 0 are the vertices themselves; ring `k` are the neighbours
/// of ring `k − 1` that are in no ring before.
#[derive(Clone, Debug)]
pub struct Neighbourhood {
    /// The faces at a vertex of any ring but the last one, ascending, if they were looked for.
    pub faces: Vec<FaceId>,
    vertices: Vec<VertexId>,
    ends: Vec<usize>,
}

impl Neighbourhood {
    /// The rings 0 to `rings` around `seeds`.
    pub fn new(
        topology: &Topology,
        seeds: impl IntoIterator<Item = VertexId>,
        rings: usize,
    ) -> Self {
        NeighbourhoodSearch::new(topology).around(seeds, rings)
    }

    /// As [`Self::new`], at a cost that does not depend on the size of the mesh. Slower than a
    /// [`NeighbourhoodSearch`] where there is one.
    pub fn small(
        topology: &Topology,
        seeds: impl IntoIterator<Item = VertexId>,
        rings: usize,
    ) -> Self {
        let (mut vertices, mut faces) = (FxHashSet::default(), FxHashSet::default());
        let is_new_vertex = |v| vertices.insert(v);
        Self::search(topology, seeds, rings, is_new_vertex, |f| faces.insert(f))
    }

    /// As [`Self::small`], but with vertices alone.
    pub fn without_faces(
        topology: &Topology,
        seeds: impl IntoIterator<Item = VertexId>,
        rings: usize,
    ) -> Self {
        let mut vertices = FxHashSet::default();
        let is_new_vertex = |v| vertices.insert(v);
        Self::search(topology, seeds, rings, is_new_vertex, |_| false)
    }

    /// The breadth-first search. The predicates return `true` for a vertex or face at its first call
    /// and `false` later.
    fn search(
        topology: &Topology,
        seeds: impl IntoIterator<Item = VertexId>,
        rings: usize,
        mut is_new_vertex: impl FnMut(VertexId) -> bool,
        mut is_new_face: impl FnMut(FaceId) -> bool,
    ) -> Self {
        let mut vertices: Vec<VertexId> = seeds.into_iter().collect();
        vertices.retain(|&v| is_new_vertex(v));
        let mut ends = vec![vertices.len()];
        let mut faces = Vec::new();
        let mut begin = 0;
        for _ in 0..rings {
            let end = vertices.len();
            for i in begin..end {
                for h in topology.outgoing(vertices[i]) {
                    let (f, w) = (topology.face(h), topology.target(h));
                    if f.is_some() && is_new_face(f) {
                        faces.push(f);
                    }
                    if is_new_vertex(w) {
                        vertices.push(w);
                    }
                }
            }
            begin = end;
            ends.push(vertices.len());
        }
        faces.sort_unstable();
        Self {
            faces,
            vertices,
            ends,
        }
    }

    /// The vertices of all rings, ring by ring in the order in which the search reaches them.
    pub fn vertices(&self) -> &[VertexId] {
        &self.vertices
    }

    /// All rings, from ring 0 on.
    pub fn rings(&self) -> impl Iterator<Item = &[VertexId]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts
            .zip(&self.ends)
            .map(|(&start, &end)| &self.vertices[start..end])
    }
}

/// The faces that share a vertex with one of `faces`, these included, ascending. Costs what it
/// finds, not the size of the mesh.
pub fn faces_around(topology: &Topology, faces: &[FaceId]) -> Vec<FaceId> {
    let mut around: Vec<FaceId> = faces
        .iter()
        .flat_map(|&f| topology.face_vertices(f))
        .flat_map(|v| topology.outgoing(v))
        .map(|h| topology.face(h))
        .filter(|f| f.is_some())
        .collect();
    around.sort_unstable();
    around.dedup();
    around
}

/// Searches for many neighbourhoods in one mesh. The cost of a search depends on its
/// result, not on the size of the mesh.
pub struct NeighbourhoodSearch<'a> {
    topology: &'a Topology,
    /// The last search that reached each vertex and each face.
    vertex_mark: Vec<u32>,
    face_mark: Vec<u32>,
    searches: u32,
}

impl<'a> NeighbourhoodSearch<'a> {
    /// Prepares searches in a mesh.
    pub fn new(topology: &'a Topology) -> Self {
        Self {
            topology,
            vertex_mark: vec![0; topology.vertex_count()],
            face_mark: vec![0; topology.face_count()],
            searches: 0,
        }
    }

    /// As [`Neighbourhood::new`].
    pub fn around(
        &mut self,
        seeds: impl IntoIterator<Item = VertexId>,
        rings: usize,
    ) -> Neighbourhood {
        self.searches += 1;
        let search = self.searches;
        let is_new = |mark: &mut u32| std::mem::replace(mark, search) != search;
        let (vertices, faces) = (&mut self.vertex_mark, &mut self.face_mark);
        Neighbourhood::search(
            self.topology,
            seeds,
            rings,
            |v| is_new(&mut vertices[v.index()]),
            |f| is_new(&mut faces[f.index()]),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::icosphere;

    #[test]
    fn rings_of_a_regular_vertex() {
        let (positions, triangles) = icosphere(8);
        let topology = Topology::from_triangles(positions.len(), &triangles).expect("closed");
        let regular = |&v: &VertexId| {
            let around = Neighbourhood::new(&topology, [v], 3);
            around.vertices().iter().all(|&w| topology.valence(w) == 6)
        };
        let v = topology.vertices().find(regular).expect("inside a face");
        let mut search = NeighbourhoodSearch::new(&topology);
        for rings in [0, 1, 2, 3] {
            let found = search.around([v, v], rings);
            let sizes: Vec<usize> = found.rings().map(<[_]>::len).collect();
            assert_eq!(sizes, [1, 6, 12, 18][..=rings]);
            assert_eq!(found.faces.len(), 6 * rings * rings);
            assert!(found.faces.is_sorted());
            let small = Neighbourhood::small(&topology, [v, v], rings);
            assert_eq!(small.faces, found.faces);
            assert_eq!(small.vertices(), found.vertices());
            let bare = Neighbourhood::without_faces(&topology, [v, v], rings);
            assert_eq!(bare.vertices(), found.vertices());
            assert!(bare.faces.is_empty());
        }
        let first = search.around([v], 1).faces;
        assert_eq!(faces_around(&topology, &first), search.around([v], 2).faces);
        let all = search.around([v], 100);
        assert_eq!(all.faces.len(), topology.face_count());
        assert_eq!(all.vertices().len(), topology.vertex_count());
    }
}
