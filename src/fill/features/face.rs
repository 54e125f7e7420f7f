//! The missing flat face of a body with sharp edges.

use crate::fill::sharp::{is_sharp, is_sharp_angle};
use crate::mesh::{BoundaryLoop, DVec3, HalfedgeId, Mesh, vector_area};

/// Largest distance of a rim from its plane, in radii of the hole. The rims of scans are not flat, and
/// coordinates in files have at least four digits.
pub(super) const FLAT: f64 = 1e-3;
/// Largest angle between the plane of the rim and a face that continues it, in degrees.
const FLUSH: f64 = 10.0;
/// Largest distance of an exactly flat rim from its plane, in radii of the hole: a few digits of single precision.
const EXACT: f64 = 1e-5;
/// Largest angle between the plane of an exactly flat rim and a face of a rounding beside it, in degrees.
const TILTED: f64 = 30.0;
/// Angle up to which such a face lies in the plane, in degrees.
const IN_PLANE: f64 = 1.0;
/// Length of the longest edge of a rim over the median above which it is not that of a round opening.
const UNEVEN: f64 = 4.0;
/// Smallest turn of a rim where an edge between two missing faces ends, in degrees.
const MIN_TURN: f64 = 10.0;

/// A missing face: a flat polygon of vertices of the rim, and perhaps a corner.
pub(super) struct Face {
    pub vertices: Vec<usize>,
    pub normal: DVec3,
    /// Edges of the rim at which it meets the mesh at a sharp angle.
    pub creased: Vec<usize>,
    /// The number of places where the polygon turns.
    turns: usize,
}

impl Face {
    pub fn is_sharp_to(&self, other: &Self) -> bool {
        is_sharp_angle(self.normal.angle_between(other.normal))
    }

    /// Whether it is flat not only because it is a triangle.
    pub fn is_evident(&self) -> bool {
        self.turns > 3
    }
}

/// The places of a closed polygon at which it turns.
pub(super) fn turns(points: &[DVec3]) -> impl Iterator<Item = usize> {
    let n = points.len();
    let turn = move |k: usize| {
        let [before, at, after] = [n - 1, 0, 1].map(|step| points[(k + step) % n]);
        (at - before).angle_between(after - at)
    };
    (0..n).filter(move |&k| turn(k) > MIN_TURN.to_radians())
}

/// The rim of a hole that may be flat, or whose parts may be.
pub(super) struct FlatRim {
    pub points: Vec<DVec3>,
    pub radius: f64,
    /// The normals of the faces beside the edges, of any length.
    beside: Vec<DVec3>,
    /// Whether a sharp edge of the mesh ends at the rim.
    pub ends_lines: bool,
}

impl FlatRim {
    pub fn new(mesh: &Mesh, hole: &BoundaryLoop) -> Self {
        let mut around = (hole.vertices.iter()).flat_map(|&v| mesh.topology.outgoing(v));
        let normal = |h: &HalfedgeId| {
            let [a, b, c] = mesh.corners(mesh.topology.face(h.twin()));
            (b - a).cross(c - a)
        };
        Self {
            points: hole.vertices.iter().map(|&v| mesh.position(v)).collect(),
            radius: hole.radius,
            beside: hole.halfedges.iter().map(normal).collect(),
            ends_lines: around.any(|h| is_sharp(mesh, h)),
        }
    }

    /// The creased edges of the rim, by their indices, if the hole is the missing face of a body with sharp edges, such
    /// as a side of a box: the rim is flat, its plane meets the faces beside it at sharp angles or continues them, and a
    /// sharp edge of the body ends at the rim. Or the rim is exactly flat as if [cut](Self::cut_edges). `None` for
    /// other holes, and if no edge of the rim is sharp.
    pub fn missing_face(&self) -> Option<Vec<usize>> {
        let creased = self.cut_edges().or_else(|| {
            let whole: Vec<usize> = (0..self.points.len()).collect();
            let face = || self.face(&whole, None).map(|face| face.creased);
            self.ends_lines.then(face).flatten()
        });
        creased.filter(|creased| !creased.is_empty())
    }

    /// The edges at which a flat patch has creases, where the rim is exactly flat, as a cut along a plane or a face of a
    /// CAD program is. All faces beside it meet its plane at a sharp angle or at most at [`TILTED`], as the first ones of
    /// a rounding. To be no round opening, it has edges of very different length, or both kinds of faces beside it.
    fn cut_edges(&self) -> Option<Vec<usize>> {
        let normal = self.normal(&self.points, EXACT)?;
        let angles = self
            .beside
            .iter()
            .map(|beside| beside.angle_between(normal));
        let angles: Vec<f64> = angles.collect();
        let is_below = |limit: f64| move |angle: &f64| *angle <= limit.to_radians();
        if !angles
            .iter()
            .all(|angle| is_sharp_angle(*angle) || is_below(TILTED)(angle))
        {
            return None;
        }
        let next = self.points.iter().cycle().skip(1);
        let lengths = self.points.iter().zip(next).map(|(p, q)| p.distance(*q));
        let mut lengths: Vec<f64> = lengths.collect();
        lengths.sort_unstable_by(f64::total_cmp);
        let is_uneven = lengths[lengths.len() - 1] >= UNEVEN * lengths[lengths.len() / 2];
        let is_mixed =
            angles.iter().any(is_below(FLUSH)) && angles.iter().any(|&angle| is_sharp_angle(angle));
        let creased = (0..angles.len()).filter(|&i| !is_below(IN_PLANE)(&angles[i]));
        (is_uneven || is_mixed).then(|| creased.collect())
    }

    /// The unit normal of a polygon. `None` if its points are farther from a plane than `limit` radii of the hole.
    fn normal(&self, points: &[DVec3], limit: f64) -> Option<DVec3> {
        let normal = vector_area(points).try_normalize()?;
        let distance = |p: &DVec3| (*p - points[0]).dot(normal).abs();
        let is_flat = points.iter().all(|p| distance(p) <= limit * self.radius);
        is_flat.then_some(normal)
    }

    /// The face with these vertices of the rim, in its direction, and a corner after them. `None` if it is not
    /// flat, or neither meets a face beside the rim at a sharp angle nor continues it.
    pub fn face(&self, vertices: &[usize], corner: Option<DVec3>) -> Option<Face> {
        let points = vertices.iter().map(|&i| self.points[i]).chain(corner);
        let points: Vec<DVec3> = points.collect();
        let normal = self.normal(&points, FLAT)?;
        let mut creased = Vec::new();
        let next = vertices.iter().cycle().skip(1);
        for (&i, &j) in vertices.iter().zip(next) {
            if j != (i + 1) % self.points.len() {
                continue;
            }
            let angle = self.beside[i].angle_between(normal);
            if is_sharp_angle(angle) {
                creased.push(i);
            } else if angle.is_nan() || angle > FLUSH.to_radians() {
                return None;
            }
        }
        Some(Face {
            vertices: vertices.to_vec(),
            normal,
            creased,
            turns: turns(&points).count(),
        })
    }
}
