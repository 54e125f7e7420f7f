//! Watching for a surface that pinches off.

use crate::mesh::{DVec3, FaceId};
use crate::solver::FlowProblem;

/// A triangle that keeps less than this part of its area belongs to a neck that is closing.
const CLOSED: f64 = 0.01;
/// The last shape whose triangles all keep at least this part is the one to go back to.
const OPEN: f64 = 0.1;

/// Areas of the control triangles that move, compared with what they were at the start. Under an
/// energy without a minimum between the rims (the area of a tube that is too long) a neck closes and
/// the triangles around it vanish; a flow that converges keeps nearly all of their area.
#[derive(Clone, Debug)]
pub(super) struct PinchWatch {
    faces: Vec<FaceId>,
    areas: Vec<f64>,
    open: Vec<DVec3>,
}

impl PinchWatch {
    /// From the starting positions of a problem on.
    pub fn new(problem: &FlowProblem) -> Self {
        let is_moving = |f: &FaceId| {
            let corners = problem.topology().face_vertices(*f);
            corners.iter().any(|v| problem.ring()[v.index()] == 0)
        };
        let faces: Vec<FaceId> = problem
            .active_faces()
            .iter()
            .copied()
            .filter(is_moving)
            .collect();
        let open = problem.positions().to_vec();
        let areas = faces.iter().map(|&f| area(problem, &open, f).0).collect();
        Self { faces, areas, open }
    }

    /// Looks at the shape after a step. If a neck is closing, the place, relative to the problem's
    /// centre.
    pub fn look(&mut self, problem: &FlowProblem, positions: &[DVec3]) -> Option<DVec3> {
        let mut least = f64::INFINITY;
        let mut place = DVec3::ZERO;
        for (&f, &start) in self.faces.iter().zip(&self.areas) {
            let (now, middle) = area(problem, positions, f);
            // triangles without area at the start say nothing
            let kept = if start > 0.0 { now / start } else { 1.0 };
            if kept < least {
                (least, place) = (kept, middle);
            }
        }
        if least >= OPEN {
            self.open.copy_from_slice(positions);
        }
        (least < CLOSED).then_some(place)
    }

    /// The last shape with all necks open.
    pub fn last_open(&self) -> &[DVec3] {
        &self.open
    }
}

/// Area and middle of a control triangle.
fn area(problem: &FlowProblem, positions: &[DVec3], f: FaceId) -> (f64, DVec3) {
    let corners = problem.topology().face_vertices(f);
    let [a, b, c] = corners.map(|v| positions[v.index()]);
    (0.5 * (b - a).cross(c - a).length(), (a + b + c) / 3.0)
}
