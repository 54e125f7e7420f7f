//! Tangential relaxation: vertices slide along the surface towards the mean of their neighbours.

use std::sync::Arc;

use crate::mesh::{DVec3, FaceId, Topology, VertexId};
use crate::solver::FlowProblem;
use crate::solver::assembly::EnergySum;

/// Maximum fraction of a step's gain that relaxation may give back, so that the energy still falls.
const GIVEN_BACK: f64 = 0.5;

/// Number of passes over the triangles in which moves are undone; each may degrade other triangles.
const GUARD_PASSES: usize = 4;

/// Proposes tangential moves of the moving vertices.
pub(super) struct Relaxation {
    topology: Arc<Topology>,
    /// Faces with a moving vertex.
    faces: Vec<FaceId>,
    trial: Vec<DVec3>,
}

impl Relaxation {
    pub(super) fn new(problem: &FlowProblem) -> Self {
        let topology = Arc::clone(problem.topology());
        let moves = |v: &VertexId| problem.ring()[v.index()] == 0;
        let faces = topology
            .faces()
            .filter(|&f| topology.face_vertices(f).iter().any(moves))
            .collect();
        Self {
            topology,
            faces,
            trial: Vec::new(),
        }
    }

    /// `x + weight (mean of neighbours − x)` without its normal part, at the moving `vertices`,
    /// each moved by at most `reach`. Vertices that would make a triangle sharper than the
    /// currently sharpest one do not move. Returns `None` if that is not enough.
    pub(super) fn propose(
        &mut self,
        positions: &[DVec3],
        vertices: &[u32],
        normals: &[DVec3],
        weight: f64,
        reach: f64,
    ) -> Option<&[DVec3]> {
        self.trial.clear();
        self.trial.extend_from_slice(positions);
        for (&v, n) in vertices.iter().zip(normals) {
            let p = positions[v as usize];
            let (mut sum, mut count) = (DVec3::ZERO, 0.0);
            for w in self.topology.neighbours(VertexId(v)) {
                sum += positions[w.index()] - p;
                count += 1.0;
            }
            let step = weight * (sum / count).reject_from_normalized(*n);
            self.trial[v as usize] = p + step.clamp_length_max(reach);
        }
        let sharpness = |x: &[DVec3], f: FaceId| {
            sharpest_cosine(self.topology.face_vertices(f).map(|v| x[v.index()]))
        };
        let cosines = self.faces.iter().map(|&f| sharpness(positions, f));
        let sharpest = cosines.fold(-1.0, f64::max);
        for _ in 0..GUARD_PASSES {
            let mut degraded = false;
            for &f in &self.faces {
                if sharpness(&self.trial, f) > sharpest {
                    degraded = true;
                    for v in self.topology.face_vertices(f) {
                        self.trial[v.index()] = positions[v.index()];
                    }
                }
            }
            if !degraded {
                return Some(&self.trial);
            }
        }
        None
    }
}

/// The cosine of the smallest angle of any triangle; 1 if there is none.
pub fn sharpest_cosine(corners: [DVec3; 3]) -> f64 {
    let mut sharpest = -1.0f64;
    for i in 0..3 {
        let [a, b] = [1, 2].map(|k| corners[(i + k) % 3] - corners[i]);
        let cosine = a.dot(b) / (a.length_squared() * b.length_squared()).sqrt();
        sharpest = if cosine < 1.0 {
            sharpest.max(cosine)
        } else {
            1.0
        };
    }
    sharpest
}

/// Whether a slide to energy `new` may follow a step from `before` to `after`.
pub(super) fn may_slide(before: EnergySum, after: EnergySum, new: EnergySum) -> bool {
    let bound = after.value + GIVEN_BACK * (before.value - after.value).max(0.0);
    new.value.is_finite() && new.value <= bound + 1e-12 * after.scale
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    #[test]
    fn angles_of_triangles() {
        let height = DVec3::new(0.5, 0.75f64.sqrt(), 0.0);
        let equilateral = [DVec3::ZERO, DVec3::X, height];
        assert!((sharpest_cosine(equilateral) - 0.5).abs() < 1e-15);
        assert!((sharpest_cosine([DVec3::ZERO, DVec3::X, DVec3::Y]) - 0.5f64.sqrt()).abs() < 1e-15);
        assert_eq!(sharpest_cosine([DVec3::ZERO, DVec3::X, DVec3::X]), 1.0);
    }

    /// In a plane, sliding is the only motion: it keeps the plane and improves the triangles.
    #[test]
    fn vertices_slide_in_the_plane_and_no_triangle_gets_sharper_than_the_sharpest() {
        let (positions, triangles) = shapes::plane(2.0, 14, 3);
        let interior: Vec<u32> = (0..positions.len() as u32)
            .filter(|&v| positions[v as usize].abs().max_element() < 0.6)
            .collect();
        let problem = FlowProblem::new(&positions, &triangles, &interior, 1.0).expect("a square");
        let mut relaxation = Relaxation::new(&problem);
        let normals = vec![DVec3::Z; interior.len()];
        let mut x = problem.positions().to_vec();
        let worst = |relaxation: &Relaxation, x: &[DVec3]| {
            let faces = relaxation.faces.iter();
            let corners = faces.map(|&f| relaxation.topology.face_vertices(f));
            let cosines = corners.map(|c| sharpest_cosine(c.map(|v| x[v.index()])));
            cosines.fold(-1.0, f64::max)
        };
        let start = worst(&relaxation, &x);
        for weight in [1.0, 0.5, 1.0] {
            let before = worst(&relaxation, &x);
            if let Some(moved) = relaxation.propose(&x, &interior, &normals, weight, 1.0) {
                x.copy_from_slice(moved);
            }
            assert!(worst(&relaxation, &x) <= before);
            assert!(x.iter().all(|p| p.z == 0.0));
        }
        assert!(worst(&relaxation, &x) < start);
    }

    #[test]
    fn a_slide_may_give_back_half_a_step() {
        let sum = |value| EnergySum { value, scale: 1.0 };
        let (before, after) = (sum(2.0), sum(1.0));
        assert!(may_slide(before, after, sum(1.5)) && may_slide(before, after, sum(0.5)));
        assert!(!may_slide(before, after, sum(1.6)) && !may_slide(before, after, sum(f64::NAN)));
    }
}
