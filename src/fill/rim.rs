//! Rims of holes, as input of the construction of patches.

use crate::mesh::{BoundaryLoop, DVec3, Mesh, VertexId};
use crate::patch::{Rim, RimGeometry};

/// Rims to be joined by one patch: one for a hole, several for a blend or a hole with islands.
pub type RimSet<'a> = Vec<&'a BoundaryLoop>;

/// The rim of a hole.
pub(super) fn rim_of(mesh: &Mesh, hole: &BoundaryLoop) -> Rim {
    let topology = &mesh.topology;
    let points: Vec<DVec3> = hole.vertices.iter().map(|&v| mesh.position(v)).collect();
    let opposite = hole
        .halfedges
        .iter()
        .map(|&h| mesh.position(topology.target(topology.next(h.twin()))))
        .collect();
    let n = hole.vertices.len() as u32;
    let mut forbidden = joined_pairs(mesh, &hole.vertices);
    forbidden.retain(|&[i, j]| j - i != 1 && (i + n) - j != 1);
    Rim {
        points,
        opposite,
        forbidden,
    }
}

/// The rims that one patch joins.
pub(super) fn rim_geometry(mesh: &Mesh, rims: &[&BoundaryLoop]) -> RimGeometry {
    let mut vertices = Vec::new();
    let mut rim = Vec::new();
    for (k, one) in rims.iter().enumerate() {
        vertices.extend_from_slice(&one.vertices);
        rim.resize(vertices.len(), k);
    }
    let mut forbidden = joined_pairs(mesh, &vertices);
    forbidden.retain(|&[i, j]| rim[i as usize] != rim[j as usize]);
    RimGeometry {
        rims: rims.iter().map(|one| rim_of(mesh, one)).collect(),
        forbidden,
        pieces: rims.iter().map(|one| one.component).collect(),
    }
}

/// Pairs (i < j) of indices into `vertices` that an edge of the mesh joins.
fn joined_pairs(mesh: &Mesh, vertices: &[VertexId]) -> Vec<[u32; 2]> {
    let indices = vertices.iter().enumerate();
    let mut index: Vec<(u32, u32)> = indices.map(|(i, v)| (v.0, i as u32)).collect();
    index.sort_unstable();
    let mut pairs = Vec::new();
    for (i, &v) in vertices.iter().enumerate() {
        for w in mesh.topology.neighbours(v) {
            let mut at = index.partition_point(|e| e.0 < w.0);
            // a vertex on several rims has several entries
            while at < index.len() && index[at].0 == w.0 {
                if (i as u32) < index[at].1 {
                    pairs.push([i as u32, index[at].1]);
                }
                at += 1;
            }
        }
    }
    pairs
}
