//! Tangential relaxation: vertices slide along the surface to where their neighbours are.

use crate::mesh::{DVec3, FaceId, Topology, VertexId};
use crate::solver::FlowProblem;
use crate::solver::assembly::EnergySum;

/// How much of what a step has gained relaxation may give back, so that the energy still falls.
const GIVEN_BACK: f64 = 0.5;

/// Proposes places of the moving vertices and remembers what is needed for that.
pub(super) struct Relaxation {
    topology: Topology,
    /// Faces with a moving vertex.
    faces: Vec<FaceId>,
    trial: Vec<DVec3>,
}

impl Relaxation {
    pub(super) fn new(problem: &FlowProblem) -> Self {
        let topology = problem.topology().clone();
        let moves = |v: &VertexId| problem.ring()[v.index()] == 0;
        let faces = (0..topology.face_count())
            .map(FaceId::from)
            .filter(|&f| topology.face_vertices(f).iter().any(moves))
            .collect();
        Self {
            topology,
            faces,
            trial: Vec::new(),
        }
    }

    /// `x + weight (mean of neighbours − x)` without its normal part, at all moving `vertices`;
    /// `None` if the smallest angle of a triangle would get smaller.
    pub(super) fn propose(
        &mut self,
        positions: &[DVec3],
        vertices: &[u32],
        normals: &[DVec3],
        weight: f64,
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
            let step = sum / count;
            self.trial[v as usize] = p + weight * (step - *n * n.dot(step));
        }
        let worst = |x: &[DVec3]| {
            let cosines = self
                .faces
                .iter()
                .map(|&f| sharpest_cosine(self.topology.face_vertices(f).map(|v| x[v.index()])));
            cosines.fold(-1.0, f64::max)
        };
        (worst(&self.trial) <= worst(positions)).then_some(&self.trial)
    }
}

/// The cosine of the smallest angle of a triangle; 1 if it has none.
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
