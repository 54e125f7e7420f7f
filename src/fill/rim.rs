//! Rims of holes, and the attributes new vertices and faces inherit from them.

use crate::fill::Plan;
use crate::mesh::{BoundaryLoop, DVec3, Mesh};
use crate::patch::Rim;

/// The rim of a hole as the patch construction wants it.
pub fn rim_of(mesh: &Mesh, hole: &BoundaryLoop) -> Rim {
    let topology = &mesh.topology;
    let points: Vec<DVec3> = hole.vertices.iter().map(|&v| mesh.position(v)).collect();
    let opposite = hole
        .halfedges
        .iter()
        .map(|&h| mesh.position(topology.target(topology.next(h.twin()))))
        .collect();
    // edges of the mesh between two rim vertices that are not rim edges
    let mut index: Vec<(u32, u32)> = hole
        .vertices
        .iter()
        .enumerate()
        .map(|(i, v)| (v.0, i as u32))
        .collect();
    index.sort_unstable();
    let n = hole.vertices.len() as u32;
    let mut forbidden = Vec::new();
    for (i, &v) in hole.vertices.iter().enumerate() {
        let i = i as u32;
        for w in topology.neighbours(v) {
            if let Ok(at) = index.binary_search_by_key(&w.0, |e| e.0) {
                let j = index[at].1;
                if i < j && j - i != 1 && (i + n) - j != 1 {
                    forbidden.push([i, j]);
                }
            }
        }
    }
    Rim {
        points,
        opposite,
        forbidden,
    }
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
