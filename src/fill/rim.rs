//! Rims of holes, and the attributes new vertices and faces inherit from them.

use crate::fill::Plan;
use crate::mesh::{BoundaryLoop, DVec3, Mesh, VertexId};
use crate::patch::{Gap, Rim};

/// The rim of a hole as the patch construction wants it.
pub fn rim_of(mesh: &Mesh, hole: &BoundaryLoop) -> Rim {
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

/// Several rims as the construction of one patch between them wants them.
pub fn gap_of(mesh: &Mesh, rims: &[&BoundaryLoop]) -> Gap {
    let mut vertices = Vec::new();
    let mut rim = Vec::new();
    for (k, one) in rims.iter().enumerate() {
        vertices.extend_from_slice(&one.vertices);
        rim.resize(vertices.len(), k);
    }
    let mut forbidden = joined_pairs(mesh, &vertices);
    forbidden.retain(|&[i, j]| rim[i as usize] != rim[j as usize]);
    Gap {
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
            // a vertex that several rims run through is there several times
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

/// The tag of the face across the rim's first edge.
pub(super) fn tag_of(mesh: &Mesh, hole: &BoundaryLoop) -> u32 {
    let face = mesh.topology.face(hole.halfedges[0].twin());
    mesh.face_tags.get(face.index()).copied().unwrap_or(0)
}

/// Colours of the filled mesh: new vertices get the mean colour of their rim.
pub(super) fn colors(mesh: &Mesh, plan: &Plan) -> Vec<[f32; 4]> {
    let mut colors = mesh.colors.clone();
    if colors.is_empty() {
        return colors;
    }
    let old_vertices = mesh.positions.len() as u32;
    for hole in &plan.holes {
        let mut rim: Vec<u32> = plan.triangles[hole.new_faces.clone()]
            .iter()
            .flatten()
            .copied()
            .filter(|&v| v < old_vertices)
            .collect();
        rim.sort_unstable();
        rim.dedup();
        let mut mean = [0.0f32; 4];
        for &v in &rim {
            for c in 0..4 {
                mean[c] += mesh.colors[v as usize][c] / rim.len() as f32;
            }
        }
        colors.extend(std::iter::repeat_n(mean, hole.new_vertices.len()));
    }
    colors
}

/// Face tags of the filled mesh: new faces get the tag of the face across the rim's first edge.
pub(super) fn face_tags(mesh: &Mesh, plan: &Plan) -> Vec<u32> {
    let mut tags = mesh.face_tags.clone();
    if !tags.is_empty() {
        for hole in &plan.holes {
            tags.extend(std::iter::repeat_n(hole.tag, hole.new_faces.len()));
        }
    }
    tags
}
