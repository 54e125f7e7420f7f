//! Curvature normals that are data, not unknowns, of scheme A.

use super::kernel;
use crate::mesh::{DVec3, FaceId};
use crate::solver::FlowProblem;
use crate::subdivision::{Elements, Rule, elements};

/// Vertices whose `h` and `k` are computed from a surface by the L2 projection with lumped mass
/// over all surrounding faces.
pub(super) struct CurvatureProjection {
    wanted: Vec<bool>,
    around: Elements,
}

impl CurvatureProjection {
    /// Selects the vertices that satisfy `wanted`.
    pub(super) fn new(problem: &FlowProblem, wanted: impl Fn(usize) -> bool) -> Self {
        let topology = problem.topology();
        let wanted: Vec<bool> = (0..topology.vertex_count()).map(wanted).collect();
        let faces: Vec<FaceId> = topology
            .faces()
            .filter(|&f| topology.face_vertices(f).iter().any(|v| wanted[v.index()]))
            .collect();
        Self {
            around: elements(topology, &faces, Rule::Twelve),
            wanted,
        }
    }

    /// Writes `2Hn` and `2Kn` of the limit surface over `positions` at the chosen vertices.
    pub(super) fn evaluate(&self, positions: &[DVec3], h: &mut [DVec3], k: &mut [DVec3]) {
        let mut area = vec![0.0; positions.len()];
        for (v, _) in self.wanted.iter().enumerate().filter(|(_, w)| **w) {
            (h[v], k[v]) = (DVec3::ZERO, DVec3::ZERO);
        }
        let mut x = Vec::new();
        for e in 0..self.around.len() {
            let vertices = self.around.vertices_of(e);
            x.clear();
            x.extend(vertices.iter().map(|&v| positions[v as usize]));
            let moments = kernel::curvature_moments(self.around.table(e), &x);
            for (&v, (a, mh, mk)) in vertices.iter().zip(moments) {
                if self.wanted[v as usize] {
                    area[v as usize] += a;
                    h[v as usize] += mh;
                    k[v as usize] += mk;
                }
            }
        }
        for v in 0..area.len() {
            if area[v] > 0.0 {
                h[v] /= area[v];
                k[v] /= area[v];
            }
        }
    }
}
