//! Cutting a mesh open along edges.

use super::submesh::corner_fans;
use super::{FaceId, HalfedgeId, Topology, TopologyError, VertexId};

/// A mesh cut open along edges.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CutOpen {
    /// The connectivity. Faces and corners are in the order of the whole mesh. Its vertices come
    /// first, then the copies.
    pub topology: Topology,
    /// The vertex of the whole mesh that each vertex corresponds to.
    pub to_whole: Vec<u32>,
}

/// Cuts a mesh open along edges (one flag each). If the edges separate the faces around a vertex,
/// the fan of the lowest face keeps the vertex and the others get copies. At an interior end of a
/// cut there is one fan and one vertex, so a single edge with two interior ends opens nothing.
///
/// # Errors
/// The result is not a manifold. This cannot happen if the mesh is a manifold.
pub fn cut_open(topology: &Topology, cut: &[bool]) -> Result<CutOpen, TopologyError> {
    let faces: Vec<FaceId> = topology.faces().collect();
    let fans = corner_fans(topology, &faces, |h| cut[h.edge()]);
    let mut is_cut_at = vec![false; topology.vertex_count()];
    for (e, _) in cut.iter().enumerate().filter(|&(_, &is)| is) {
        let h = HalfedgeId::from(2 * e);
        for v in [topology.origin(h), topology.target(h)] {
            is_cut_at[v.index()] = true;
        }
    }
    let mut to_whole: Vec<u32> = (0..topology.vertex_count() as u32).collect();
    let mut taken = vec![false; topology.vertex_count()];
    let mut number = vec![u32::MAX; fans.len()];
    let corners = topology.triangles().flatten();
    for (c, (fan, v)) in fans.iter().zip(corners).enumerate() {
        let root = *fan as usize;
        if root == c {
            // without a cut the fans of a pinched vertex stay together
            let is_copy = std::mem::replace(&mut taken[v as usize], true) && is_cut_at[v as usize];
            number[c] = if is_copy { to_whole.len() as u32 } else { v };
            if is_copy {
                to_whole.push(v);
            }
        }
        number[c] = number[root];
    }
    let triangles: Vec<[u32; 3]> = number.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    let topology = Topology::from_triangles(to_whole.len(), &triangles)?;
    Ok(CutOpen { topology, to_whole })
}

/// For each edge whether it is between two of the given vertices.
pub fn edge_flags(topology: &Topology, ends: &[[VertexId; 2]]) -> Vec<bool> {
    let mut flags = vec![false; topology.halfedge_count() / 2];
    for &[a, b] in ends {
        if let Some(h) = edge_between(topology, a, b) {
            flags[h.edge()] = true;
        }
    }
    flags
}

/// The half-edge from a vertex to another, if they are neighbours.
pub fn edge_between(topology: &Topology, a: VertexId, b: VertexId) -> Option<HalfedgeId> {
    topology.outgoing(a).find(|&h| topology.target(h) == b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::check_topology;
    use crate::shapes::icosphere;

    /// Chains of edges on an icosahedron change the Euler number, boundary loops and vertices.
    #[test]
    fn cuts_open_what_they_separate() {
        let (positions, triangles) = icosphere(1);
        let whole = Topology::from_triangles(positions.len(), &triangles).expect("closed");
        let around: Vec<VertexId> = whole.neighbours(VertexId(0)).collect();
        let n = around.len();
        let ring: Vec<[VertexId; 2]> = (0..n).map(|i| [around[i], around[(i + 1) % n]]).collect();
        let spokes: Vec<[VertexId; 2]> = around.iter().map(|&v| [VertexId(0), v]).collect();
        let star = [ring.clone(), spokes.clone()].concat();
        for (edges, copies, loops, euler) in [
            (ring[..1].to_vec(), 0, 0, 2), // one edge opens nothing
            (ring[..2].to_vec(), 1, 1, 1), // a slit
            (ring.clone(), n, 2, 2),       // a disk out of a disk
            (spokes, n - 1, 1, 1),         // a star: its ends are single
            (star, 2 * n + n - 1, 1 + n, 1 + n),
        ] {
            let flags = edge_flags(&whole, &edges);
            assert_eq!(flags.iter().filter(|&&f| f).count(), edges.len());
            let cut = cut_open(&whole, &flags).expect("a manifold");
            check_topology(&cut.topology).expect("sound");
            assert_eq!(cut.to_whole.len(), whole.vertex_count() + copies);
            assert_eq!(cut.topology.boundary_loops().len(), loops);
            let t = &cut.topology;
            let vertices_and_faces = t.vertex_count() + t.face_count();
            assert_eq!(vertices_and_faces - t.halfedge_count() / 2, euler);
            for (there, here) in whole.triangles().zip(t.triangles()) {
                assert_eq!(here.map(|v| cut.to_whole[v as usize]), there);
            }
        }
    }

    #[test]
    fn nothing_cut_is_the_same_mesh() {
        let (positions, triangles) = icosphere(2);
        let whole = Topology::from_triangles(positions.len(), &triangles).expect("closed");
        let none = vec![false; whole.halfedge_count() / 2];
        let cut = cut_open(&whole, &none).expect("a manifold");
        assert_eq!(cut.topology, whole);
    }
}
