//! Chains of edges along which continuity is measured.

use crate::analysis::quality::dihedral;
use crate::mesh::{FaceId, HalfedgeId, Mesh, VertexId};

/// Edges to be measured together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EdgeChain {
    /// What it is, for people: "rim 1", "sharp edges".
    pub name: String,
    /// One half-edge of each edge. Boundary edges are left out of the measures.
    pub edges: Vec<HalfedgeId>,
    /// Whether the surface is made up of its two sides separately there (a rim of G0): positions
    /// and normals are then one-sided limits. Otherwise one limit surface runs through.
    pub is_crease: bool,
}

/// The rims between faces of `is_patch` and others, one chain for each connected rim.
pub fn patch_rims(mesh: &Mesh, is_patch: &[bool], is_crease: bool) -> Vec<EdgeChain> {
    let topology = &mesh.topology;
    let inside = |f: FaceId| f.is_some() && is_patch.get(f.index()).copied().unwrap_or(false);
    let on_rim = |h: HalfedgeId| {
        let (f, g) = (topology.face(h), topology.face(h.twin()));
        f.is_some() && g.is_some() && inside(f) && !inside(g)
    };
    connected(mesh, on_rim)
        .into_iter()
        .enumerate()
        .map(|(i, edges)| EdgeChain {
            name: format!("rim {}", i + 1),
            edges,
            is_crease,
        })
        .collect()
}

/// The edges at which neighbouring triangles differ by more than `angle` (radians), in connected
/// chains, as creases.
pub fn sharp_edges(mesh: &Mesh, angle: f64) -> Vec<EdgeChain> {
    let topology = &mesh.topology;
    let sharp = |h: HalfedgeId| {
        h.0.is_multiple_of(2)
            && !topology.is_boundary(h)
            && !topology.is_boundary(h.twin())
            && dihedral(mesh, h) > angle
    };
    connected(mesh, sharp)
        .into_iter()
        .enumerate()
        .map(|(i, edges)| EdgeChain {
            name: format!("sharp edges {}", i + 1),
            edges,
            is_crease: true,
        })
        .collect()
}

/// The chosen half-edges in groups that hang together by vertices, each in index order.
fn connected(mesh: &Mesh, chosen: impl Fn(HalfedgeId) -> bool) -> Vec<Vec<HalfedgeId>> {
    let topology = &mesh.topology;
    let is_chosen: Vec<bool> = (0..topology.halfedge_count())
        .map(|h| chosen(HalfedgeId::from(h)))
        .collect();
    let mut seen = vec![false; topology.vertex_count()];
    let mut groups = Vec::new();
    for first in (0..is_chosen.len()).filter(|&h| is_chosen[h]) {
        let start = topology.origin(HalfedgeId::from(first));
        if std::mem::replace(&mut seen[start.index()], true) {
            continue;
        }
        let mut group = Vec::new();
        let mut stack: Vec<VertexId> = vec![start];
        while let Some(v) = stack.pop() {
            for out in topology.outgoing(v) {
                for h in [out, out.twin()] {
                    if is_chosen[h.index()] {
                        group.push(h);
                        let w = topology.target(out);
                        if !std::mem::replace(&mut seen[w.index()], true) {
                            stack.push(w);
                        }
                    }
                }
            }
        }
        group.sort_unstable();
        group.dedup();
        groups.push(group);
    }
    groups
}
