//! Boundary curves and creases of a surface under refinement.

use std::collections::BTreeSet;

use crate::mesh::{DVec3, Split, Topology, VertexId};
use crate::options::choices;

/// How boundaries and creases are interpolated between their vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum BoundaryRule {
    /// By interpolating cubic B-splines, broken at corners.
    #[default]
    Spline,
    /// By the straight edges.
    Straight,
}

choices!(BoundaryRule: Spline "spline", Straight "straight");

/// The position of a vertex relative to the curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// Not on a curve.
    Off,
    /// On the smooth part of a curve, between these neighbours.
    Between([u32; 2]),
    /// A corner: the curve has a kink or ends, several curves meet, or the curves are straight
    /// lines.
    Corner,
}

/// Cubic B-splines through the vertices of boundaries and creases. Their control points are refined
/// like those of a crease of Loop's scheme. Between two corners the spline is natural.
#[derive(Clone, Debug)]
pub struct BoundaryCurves {
    /// Control point of each vertex; meaningless for vertices off the curves.
    control: Vec<DVec3>,
    place: Vec<Place>,
    /// The edges of the curves, with the lower vertex index first.
    edges: BTreeSet<[u32; 2]>,
    rule: BoundaryRule,
}

/// Gauss-Seidel sweeps for the control points. Each sweep more than halves the error.
const SWEEPS: usize = 60;

impl BoundaryCurves {
    /// Interpolates the vertices of the boundary and of the edges flagged in `creases` (one flag
    /// per edge). A vertex is a corner if a curve turns there by more than `corner_angle`
    /// (radians), or if the number of curve edges at it is not two.
    pub fn new(
        topology: &Topology,
        positions: &[DVec3],
        creases: &[bool],
        rule: BoundaryRule,
        corner_angle: f64,
    ) -> Self {
        let edges: BTreeSet<[u32; 2]> = topology
            .edges()
            .filter(|&h| creases[h.edge()] || topology.is_boundary_edge(h))
            .map(|h| pair(topology.origin(h).0, topology.target(h).0))
            .collect();
        let mut curves = Self {
            control: positions.to_vec(),
            place: places(&edges, positions, rule, corner_angle),
            edges,
            rule,
        };
        curves.interpolate(positions);
        curves
    }

    fn interpolate(&mut self, positions: &[DVec3]) {
        let smooth: Vec<(usize, [u32; 2])> = self
            .place
            .iter()
            .enumerate()
            .filter_map(|(v, &place)| match place {
                Place::Between(ends) => Some((v, ends)),
                _ => None,
            })
            .collect();
        for _ in 0..SWEEPS {
            for &(v, [a, b]) in &smooth {
                let p = positions[v];
                let pull = (self.control[a as usize] - p) + (self.control[b as usize] - p);
                self.control[v] = p - 0.25 * pull;
            }
        }
    }

    /// The curves on the mesh after a split.
    #[must_use]
    pub fn split(&self, old: &Topology, split: &Split) -> Self {
        let mut next = self.clone();
        for (v, &place) in self.place.iter().enumerate() {
            if let Place::Between(ends) = place {
                next.control[v] += 0.125 * self.spokes(v, ends);
            }
        }
        for &h in &split.edges {
            let ends = [old.origin(h).0, old.target(h).0];
            let [a, b] = ends.map(|v| self.control[v as usize]);
            let middle = next.control.len() as u32;
            next.control.push(0.5 * (a + b));
            if !next.edges.remove(&pair(ends[0], ends[1])) {
                next.place.push(Place::Off);
                continue;
            }
            next.place.push(match self.rule {
                BoundaryRule::Spline => Place::Between(ends),
                BoundaryRule::Straight => Place::Corner,
            });
            for [here, there] in [ends, [ends[1], ends[0]]] {
                next.edges.insert(pair(here, middle));
                if let Place::Between(around) = &mut next.place[here as usize] {
                    for end in around.iter_mut().filter(|end| **end == there) {
                        *end = middle;
                    }
                }
            }
        }
        next
    }

    /// The point of the curve at a vertex; `None` off the curves.
    pub fn point(&self, v: VertexId) -> Option<DVec3> {
        let p = self.control[v.index()];
        match self.place[v.index()] {
            Place::Off => None,
            Place::Corner => Some(p),
            Place::Between(ends) => Some(p + self.spokes(v.index(), ends) / 6.0),
        }
    }

    /// Whether a vertex of a curve is one of its corners.
    pub fn is_corner(&self, v: VertexId) -> bool {
        self.place[v.index()] == Place::Corner
    }

    /// Sum of the differences between two control points and that of a vertex.
    fn spokes(&self, v: usize, ends: [u32; 2]) -> DVec3 {
        let p = self.control[v];
        let [a, b] = ends.map(|w| self.control[w as usize] - p);
        a + b
    }
}

fn pair(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn places(
    edges: &BTreeSet<[u32; 2]>,
    positions: &[DVec3],
    rule: BoundaryRule,
    corner_angle: f64,
) -> Vec<Place> {
    let mut count = vec![0usize; positions.len()];
    let mut ends = vec![[0u32; 2]; positions.len()];
    for &[a, b] in edges {
        for [here, there] in [[a, b], [b, a]].map(|e| e.map(|v| v as usize)) {
            if let Some(end) = ends[here].get_mut(count[here]) {
                *end = there as u32;
            }
            count[here] += 1;
        }
    }
    let turns = |v: usize, [a, b]: [u32; 2]| {
        let p = positions[v];
        let (into, out) = (p - positions[a as usize], positions[b as usize] - p);
        into.cross(out).length().atan2(into.dot(out)) > corner_angle
    };
    (0..positions.len())
        .map(|v| match count[v] {
            0 => Place::Off,
            2 if rule == BoundaryRule::Spline && !turns(v, ends[v]) => Place::Between(ends[v]),
            _ => Place::Corner,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::split_all;
    use crate::shapes::{cylinder, graph};

    fn curves(topology: &Topology, positions: &[DVec3], corner_angle: f64) -> BoundaryCurves {
        let none = vec![false; topology.halfedge_count() / 2];
        BoundaryCurves::new(
            topology,
            positions,
            &none,
            BoundaryRule::Spline,
            corner_angle,
        )
    }

    #[test]
    fn curves_pass_the_given_vertices() {
        let (positions, triangles) = cylinder(1.0, 1.0, 12, 1);
        let old = Topology::from_triangles(positions.len(), &triangles).expect("manifold");
        let coarse = curves(&old, &positions, 1.0);
        let split = split_all(&old);
        let new = Topology::from_triangles(split.vertex_count(&old), &split.triangles);
        let new = new.expect("manifold");
        let fine = coarse.split(&old, &split);
        for v in new.vertices() {
            let Some(p) = fine.point(v) else {
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
        let mut lines = curves(&topology, &positions, 0.7);
        for _ in 0..2 {
            let split = split_all(&topology);
            lines = lines.split(&topology, &split);
            let n = split.vertex_count(&topology);
            topology = Topology::from_triangles(n, &split.triangles).expect("manifold");
        }
        let mut corners = 0;
        for v in topology.vertices() {
            if let Some(p) = lines.point(v) {
                assert!((p.x.abs().max(p.y.abs()) - 1.0).abs() < 1e-14);
                corners += usize::from(p.x.abs().min(p.y.abs()) > 1.0 - 1e-14);
            }
        }
        assert_eq!(corners, 4);
    }
}
