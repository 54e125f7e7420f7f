//! Boundary curves of an open surface under refinement.

use crate::mesh::{DVec3, Split, Topology, VertexId};

/// How boundaries are continued between their vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum BoundaryRule {
    /// By interpolating cubic B-splines, broken at corners.
    #[default]
    Spline,
    /// By the straight edges.
    Straight,
}

/// Cubic B-splines through the boundary vertices. Their control points are refined like those of a
/// crease of Loop's scheme; between two corners the spline is natural.
#[derive(Clone, Debug)]
pub struct BoundaryCurves {
    /// Control point of each vertex; of no meaning off the boundary.
    control: Vec<DVec3>,
    /// Vertices the curve passes with a kink, or straight ones throughout.
    is_corner: Vec<bool>,
    rule: BoundaryRule,
}

/// Sweeps of Gauss-Seidel for the control points; each more than halves the error.
const SWEEPS: usize = 60;

impl BoundaryCurves {
    /// Curves through the boundary vertices. A vertex where the boundary turns by more than
    /// `corner_angle` (radians) is a corner, as is one in which several loops meet.
    pub fn new(
        topology: &Topology,
        positions: &[DVec3],
        rule: BoundaryRule,
        corner_angle: f64,
    ) -> Self {
        let is_corner = (0..positions.len())
            .map(|v| match ends(topology, VertexId::from(v)) {
                Some([a, b]) => {
                    let p = positions[v];
                    let (into, out) = (p - positions[a.index()], positions[b.index()] - p);
                    into.cross(out).length().atan2(into.dot(out)) > corner_angle
                }
                None => true,
            })
            .collect();
        let mut curves = Self {
            control: positions.to_vec(),
            is_corner,
            rule,
        };
        if rule == BoundaryRule::Spline {
            curves.interpolate(topology, positions);
        }
        curves
    }

    fn interpolate(&mut self, topology: &Topology, positions: &[DVec3]) {
        let smooth: Vec<(usize, [usize; 2])> = (0..positions.len())
            .filter(|&v| !self.is_corner[v])
            .filter_map(|v| Some((v, ends(topology, VertexId::from(v))?.map(VertexId::index))))
            .collect();
        for _ in 0..SWEEPS {
            for &(v, [a, b]) in &smooth {
                let p = positions[v];
                let pull = (self.control[a] - p) + (self.control[b] - p);
                self.control[v] = p - 0.25 * pull;
            }
        }
    }

    /// The curves over the mesh after a split.
    #[must_use]
    pub fn split(&self, old: &Topology, split: &Split) -> Self {
        let mut control = self.control.clone();
        let mut is_corner = self.is_corner.clone();
        if self.rule == BoundaryRule::Spline {
            for v in (0..self.control.len()).filter(|&v| !self.is_corner[v]) {
                if let Some([a, b]) = ends(old, VertexId::from(v)) {
                    let p = self.control[v];
                    let spokes = (self.control[a.index()] - p) + (self.control[b.index()] - p);
                    control[v] = p + 0.125 * spokes;
                }
            }
        }
        for &h in &split.edges {
            let [a, b] = [old.origin(h), old.target(h)].map(|v| self.control[v.index()]);
            control.push(0.5 * (a + b));
            is_corner.push(false);
        }
        Self {
            control,
            is_corner,
            rule: self.rule,
        }
    }

    /// Where the curve passes a boundary vertex; `None` off the boundary.
    pub fn point(&self, topology: &Topology, v: VertexId) -> Option<DVec3> {
        if !topology.is_boundary_vertex(v) {
            return None;
        }
        let p = self.control[v.index()];
        match ends(topology, v) {
            Some([a, b]) if !self.is_corner[v.index()] && self.rule == BoundaryRule::Spline => {
                let spokes = (self.control[a.index()] - p) + (self.control[b.index()] - p);
                Some(p + spokes / 6.0)
            }
            _ => Some(p),
        }
    }
}

/// The neighbours before and after a vertex along its boundary; `None` if it has not just one.
fn ends(topology: &Topology, v: VertexId) -> Option<[VertexId; 2]> {
    let mut along = topology.outgoing(v).filter(|&h| topology.is_boundary(h));
    let out = along.next()?;
    if along.next().is_some() {
        return None;
    }
    let into = topology
        .outgoing(v)
        .find(|&h| topology.is_boundary(h.twin()))?;
    Some([topology.target(into), topology.target(out)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{cylinder, graph};
    use crate::mesh::split_all;

    #[test]
    fn curves_pass_the_given_vertices() {
        let (positions, triangles) = cylinder(1.0, 1.0, 12, 1);
        let old = Topology::from_triangles(positions.len(), &triangles).expect("manifold");
        let curves = BoundaryCurves::new(&old, &positions, BoundaryRule::Spline, 1.0);
        let split = split_all(&old);
        let new = Topology::from_triangles(split.vertex_count(&old), &split.triangles);
        let new = new.expect("manifold");
        let fine = curves.split(&old, &split);
        for v in (0..new.vertex_count()).map(VertexId::from) {
            let Some(p) = fine.point(&new, v) else {
                continue;
            };
            if v.index() < positions.len() {
                assert!(p.distance(positions[v.index()]) < 1e-14);
            } else {
                // twelve points to a circle: the spline is off by O(h^4)
                assert!((p.x.hypot(p.y) - 1.0).abs() < 1e-3, "{p}");
            }
        }
    }

    #[test]
    fn corners_stay_and_straight_sides_stay_straight() {
        let (positions, triangles) = graph(2.0, 5, |_, _| 0.0, 1);
        let mut topology = Topology::from_triangles(positions.len(), &triangles).expect("manifold");
        let mut curves = BoundaryCurves::new(&topology, &positions, BoundaryRule::Spline, 0.7);
        for _ in 0..2 {
            let split = split_all(&topology);
            curves = curves.split(&topology, &split);
            let n = split.vertex_count(&topology);
            topology = Topology::from_triangles(n, &split.triangles).expect("manifold");
        }
        let mut corners = 0;
        for v in (0..topology.vertex_count()).map(VertexId::from) {
            if let Some(p) = curves.point(&topology, v) {
                assert!((p.x.abs().max(p.y.abs()) - 1.0).abs() < 1e-14);
                corners += usize::from(p.x.abs().min(p.y.abs()) > 1.0 - 1e-14);
            }
        }
        assert_eq!(corners, 4);
    }
}
