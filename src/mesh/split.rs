//! Splitting triangles at the midpoints of their edges.

use super::{FaceId, HalfedgeId, Topology, VertexId};

/// Triangles after a split of their marked edges, with the origin of triangles and vertices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Split {
    /// The triangles: those of face 0, then those of face 1, …
    pub triangles: Vec<[u32; 3]>,
    /// The face that each triangle is a part of.
    pub parent: Vec<u32>,
    /// The even half-edge of the edge that each new vertex splits. New vertices follow the old
    /// ones, in the order of the edges.
    pub edges: Vec<HalfedgeId>,
}

impl Split {
    /// Number of vertices, old and new.
    pub fn vertex_count(&self, old: &Topology) -> usize {
        old.vertex_count() + self.edges.len()
    }
}

/// Cuts every triangle into four at the midpoints of its edges. Of face `f` come the triangles `4f`
/// to `4f + 2` at its corners, in its order, and `4f + 3` in the middle.
pub fn split_all(topology: &Topology) -> Split {
    split_faces(topology, &vec![true; topology.face_count()])
}

/// Cuts the triangles `chosen` into four, and their neighbours so that the mesh stays conforming. A
/// triangle with one halved edge is cut in two, one with two or three halved edges in four. The
/// latter may halve more edges (red-green refinement: Bank, Sherman and Weiser 1983).
///
/// # Panics
/// If there is not one flag per face.
pub fn split_faces(topology: &Topology, chosen: &[bool]) -> Split {
    assert_eq!(chosen.len(), topology.face_count(), "one flag per face");
    let marked = marked_edges(topology, chosen);
    let mut edges = Vec::new();
    let mut middle = vec![u32::MAX; marked.len()];
    for (e, _) in marked.iter().enumerate().filter(|&(_, &is)| is) {
        middle[e] = (topology.vertex_count() + edges.len()) as u32;
        edges.push(HalfedgeId::from(2 * e));
    }
    let mut triangles = Vec::with_capacity(4 * topology.face_count());
    let mut parent = Vec::with_capacity(4 * topology.face_count());
    for f in topology.faces() {
        let sides = topology.face_halfedges(f);
        let corners = sides.map(|h| topology.origin(h).0);
        let halves = sides.map(|h| middle[h.edge()]);
        let parts = triangles.len();
        match halves.map(|m| m != u32::MAX) {
            [false, false, false] => triangles.push(corners),
            [true, true, true] => {
                let ([a, b, c], [ab, bc, ca]) = (corners, halves);
                triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
            }
            flags => {
                let k = flags.iter().position(|&m| m).unwrap_or(0);
                let [a, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
                triangles.extend([[a, halves[k], c], [halves[k], b, c]]);
            }
        }
        parent.extend(std::iter::repeat_n(f.0, triangles.len() - parts));
    }
    Split {
        triangles,
        parent,
        edges,
    }
}

/// The edges of the chosen faces, and of all faces with two halved edges, repeatedly.
fn marked_edges(topology: &Topology, chosen: &[bool]) -> Vec<bool> {
    let mut marked = vec![false; topology.halfedge_count() / 2];
    let mut stack: Vec<FaceId> = (0..chosen.len())
        .filter(|&f| chosen[f])
        .map(FaceId::from)
        .collect();
    while let Some(f) = stack.pop() {
        for h in topology.face_halfedges(f) {
            if std::mem::replace(&mut marked[h.edge()], true) {
                continue;
            }
            let g = topology.face(h.twin());
            if g.is_some()
                && topology
                    .face_halfedges(g)
                    .iter()
                    .filter(|s| marked[s.edge()])
                    .count()
                    == 2
            {
                stack.push(g);
            }
        }
    }
    marked
}

/// The ends of a half-edge and the corners opposite it on both sides (`None` beyond a boundary).
pub fn edge_diamond(topology: &Topology, h: HalfedgeId) -> ([VertexId; 2], [Option<VertexId>; 2]) {
    let opposite =
        |h: HalfedgeId| (!topology.is_boundary(h)).then(|| topology.target(topology.next(h)));
    (
        [topology.origin(h), topology.target(h)],
        [opposite(h), opposite(h.twin())],
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::check_topology;
    use crate::shapes::icosphere;

    fn sphere() -> Topology {
        let (positions, triangles) = icosphere(2);
        Topology::from_triangles(positions.len(), &triangles).expect("closed")
    }

    #[test]
    fn all_faces_in_four() {
        let old = sphere();
        let split = split_all(&old);
        assert_eq!(split.triangles.len(), 4 * old.face_count());
        assert_eq!(split.edges.len(), old.halfedge_count() / 2);
        let new = Topology::from_triangles(split.vertex_count(&old), &split.triangles);
        let new = new.expect("closed");
        assert_eq!(check_topology(&new), Ok(()));
        for v in 0..new.vertex_count() {
            let valence = new.valence(VertexId::from(v));
            if v < old.vertex_count() {
                assert_eq!(valence, old.valence(VertexId::from(v)));
            } else {
                assert_eq!(valence, 6);
            }
        }
        for (f, t) in old.triangles().enumerate() {
            assert_eq!([0, 1, 2].map(|k| split.triangles[4 * f + k][k]), t);
            assert_eq!(split.parent[4 * f..4 * f + 4], [f as u32; 4]);
        }
    }

    #[test]
    fn a_part_stays_conforming() {
        let old = sphere();
        for first in [0, 7, 33] {
            for step in [1, 3, 5, 80] {
                let chosen: Vec<bool> = (0..old.face_count())
                    .map(|f| f >= first && (f - first) % step == 0)
                    .collect();
                let split = split_faces(&old, &chosen);
                let new = Topology::from_triangles(split.vertex_count(&old), &split.triangles);
                let new = new.expect("conforming");
                assert_eq!(check_topology(&new), Ok(()));
                assert!(new.boundary_loops().is_empty());
                let parts = |f: usize| split.parent.iter().filter(|&&p| p == f as u32).count();
                for f in 0..old.face_count() {
                    assert!([1, 2, 4].contains(&parts(f)));
                    assert!(!chosen[f] || parts(f) == 4);
                }
            }
        }
        assert_eq!(
            split_faces(&old, &vec![false; old.face_count()]).triangles,
            old.triangles().collect::<Vec<_>>()
        );
    }
}
