//! Limit normals of the moving vertices, the directions of scheme B.

use crate::mesh::{DVec3, Topology, VertexId};
use crate::subdivision::tangent_stencil;
use rayon::prelude::*;

/// One-rings of the moving vertices with the weights of Loop's limit tangents.
pub struct LimitNormals {
    start: Vec<u32>,
    ring: Vec<u32>,
    /// Of both tangents, for each place of each ring.
    weight: Vec<[f64; 2]>,
}

impl LimitNormals {
    /// For the given vertices; at an open boundary the mesh is continued by ghosts.
    pub fn new(topology: &Topology, vertices: &[u32]) -> Self {
        let mut start = Vec::with_capacity(vertices.len() + 1);
        let mut ring = Vec::with_capacity(6 * vertices.len());
        let mut weight = Vec::with_capacity(6 * vertices.len());
        let mut stencil = Vec::new();
        start.push(0);
        for &v in vertices {
            stencil.clear();
            tangent_stencil(topology, VertexId(v), &mut stencil);
            ring.extend(stencil.iter().map(|s| s.0));
            weight.extend(stencil.iter().map(|s| s.1));
            start.push(ring.len() as u32);
        }
        Self {
            start,
            ring,
            weight,
        }
    }

    /// Unit normals of the limit surface at the vertices.
    pub fn evaluate(&self, positions: &[DVec3], normals: &mut Vec<DVec3>) {
        let count = self.start.len() - 1;
        normals.resize(count, DVec3::ZERO);
        normals
            .par_iter_mut()
            .with_min_len(1024)
            .enumerate()
            .for_each(|(i, normal)| {
                let range = self.start[i] as usize..self.start[i + 1] as usize;
                let (mut c, mut s) = (DVec3::ZERO, DVec3::ZERO);
                for (&v, w) in self.ring[range.clone()].iter().zip(&self.weight[range]) {
                    let p = positions[v as usize];
                    c += p * w[0];
                    s += p * w[1];
                }
                *normal = c.cross(s).normalize_or_zero();
            });
    }
}
