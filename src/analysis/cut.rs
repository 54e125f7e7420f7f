//! A mesh cut apart along edges.

use crate::mesh::{HalfedgeId, Topology, VertexId};

/// The topology of a mesh cut along edges, faces as before.
pub(super) struct Cut {
    pub(super) topology: Topology,
    /// The vertex of the mesh each vertex of the cut one is a copy of.
    pub(super) source: Vec<u32>,
}

/// Cuts along the edges of the given half-edges: at each vertex every sector between cut (or
/// boundary) edges gets a copy. `None` if a sector touches itself, which leaves no manifold.
pub(super) fn cut(topology: &Topology, edges: &[HalfedgeId]) -> Option<Cut> {
    let mut is_cut = vec![false; topology.halfedge_count() / 2];
    for h in edges {
        is_cut[h.edge()] = true;
    }
    let mut triangles: Vec<[u32; 3]> = topology.triangles().collect();
    let mut source: Vec<u32> = (0..topology.vertex_count() as u32).collect();
    for v in (0..topology.vertex_count()).map(VertexId::from) {
        let around: Vec<HalfedgeId> = topology.outgoing(v).collect();
        let ends = |h: HalfedgeId| is_cut[h.edge()] || topology.is_boundary(h);
        let Some(first) = around.iter().position(|&h| ends(h)) else {
            continue;
        };
        // clockwise from an end on: the face right of a half-edge lies between it and the next
        let mut copy = v.0;
        let mut sectors = 0;
        for k in 0..around.len() {
            let h = around[(first + k) % around.len()];
            if ends(h) {
                sectors += 1;
                if sectors > 1 {
                    copy = source.len() as u32;
                    source.push(v.0);
                }
            }
            let f = topology.face(h.twin());
            if f.is_some() {
                for corner in &mut triangles[f.index()] {
                    if *corner == v.0 {
                        *corner = copy;
                    }
                }
            }
        }
    }
    let topology = Topology::from_triangles(source.len(), &triangles).ok()?;
    Some(Cut { topology, source })
}
