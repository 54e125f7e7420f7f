//! Detection of a surface that pinches off.

use crate::mesh::{DVec3, FaceId};
use crate::solver::FlowProblem;

/// A triangle that keeps less than this fraction of its area belongs to a closing neck.
const CLOSED: f64 = 0.01;
/// The last shape in which every triangle keeps at least this fraction is stored.
const OPEN: f64 = 0.1;

/// Areas of the moving control triangles, compared with those at the start. Some energies have no
/// minimum between the rims, for example the area of a tube that is too long. Under these a neck
/// closes and the triangles around it vanish. A flow that converges keeps nearly all of their area.
#[derive(Clone, Debug)]
pub(super) struct PinchWatch {
    faces: Vec<FaceId>,
    areas: Vec<f64>,
    open: Vec<DVec3>,
}

impl PinchWatch {
    /// Starts from the positions of a problem.
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

    /// Checks the shape after a step. If a neck is closing, returns the place, relative to the
    /// problem's centre.
    pub fn check(&mut self, problem: &FlowProblem, positions: &[DVec3]) -> Option<DVec3> {
        let mut least = f64::INFINITY;
        let mut place = DVec3::ZERO;
        for (&f, &start) in self.faces.iter().zip(&self.areas) {
            let (now, middle) = area(problem, positions, f);
            // triangles without area at the start do not count
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

/// Area and centroid of a control triangle.
fn area(problem: &FlowProblem, positions: &[DVec3], f: FaceId) -> (f64, DVec3) {
    let corners = problem.topology().face_vertices(f);
    let [a, b, c] = corners.map(|v| positions[v.index()]);
    (0.5 * (b - a).cross(c - a).length(), (a + b + c) / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::cylinder;

    /// A tube whose middle moves, and its positions with the middle narrowed to a fraction of its
    /// width.
    fn tube() -> (FlowProblem, impl Fn(f64) -> Vec<DVec3>) {
        let (positions, triangles) = cylinder(1.0, 4.0, 16, 1);
        let interior: Vec<u32> = (0..positions.len() as u32)
            .filter(|&v| positions[v as usize].z.abs() < 0.8)
            .collect();
        let problem = FlowProblem::new(&positions, &triangles, &interior, 1.0).expect("a tube");
        let start = problem.clone();
        let narrowed = move |part: f64| {
            let mut x = start.positions().to_vec();
            for &v in start.interior() {
                let p = &mut x[v as usize];
                let axis = DVec3::new(-start.centre().x, -start.centre().y, p.z);
                *p = axis + part * (*p - axis);
            }
            x
        };
        (problem, narrowed)
    }

    #[test]
    fn a_closing_neck_is_found_with_the_last_open_shape() {
        let (problem, narrowed) = tube();
        let mut watch = PinchWatch::new(&problem);
        for part in [1.0, 0.5, 0.2] {
            assert_eq!(watch.check(&problem, &narrowed(part)), None);
            assert_eq!(watch.last_open(), narrowed(part));
        }
        // narrow, but not closed: the stored open shape stays
        assert_eq!(watch.check(&problem, &narrowed(0.05)), None);
        assert_eq!(watch.last_open(), narrowed(0.2));
        let place = watch.check(&problem, &narrowed(1e-3)).expect("a neck");
        let place = place + problem.centre();
        assert!(
            place.x.hypot(place.y) < 0.01 && place.z.abs() < 0.8,
            "{place}"
        );
        assert_eq!(watch.last_open(), narrowed(0.2));
    }

    #[test]
    fn triangles_without_area_at_the_start_are_ignored() {
        let (problem, narrowed) = tube();
        let collapsed = problem.clone().with_positions(&narrowed(0.0));
        let mut watch = PinchWatch::new(&collapsed);
        assert_eq!(watch.check(&collapsed, collapsed.positions()), None);
    }
}
