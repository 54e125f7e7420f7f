//! Missing faces of bodies with flat faces and sharp edges.

use glam::DMat3;

use crate::fill::sharp::{is_sharp, is_sharp_angle};
use crate::mesh::{BoundaryLoop, DVec3, HalfedgeId, Mesh, vector_area};

/// Largest distance of a rim from its plane, in radii of the hole. The rims of scans are not flat, and
/// coordinates in files have at least four digits.
const FLAT: f64 = 1e-3;
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
/// Maximum number of turns of a rim of which missing faces are the parts.
const MAX_TURNS: usize = 32;
/// Maximum number of turns of a rim around a missing corner. That of a cube has six.
const MAX_TURNS_AT_CORNER: usize = 12;
/// Cosine of the angle between two planes up to which they are perpendicular.
const SQUARE: f64 = 1e-3;
/// Maximum number of edges between missing faces.
const MAX_EDGES: usize = 4;
/// Smallest determinant of the unit normals of three faces that meet in a corner: 1 for those of a cube.
const MIN_SPREAD: f64 = 0.05;

/// A hole that consists of missing flat faces of a body with sharp edges.
pub(super) struct MissingFaces {
    /// The edges of the rim at which a missing face meets the mesh at a sharp angle, by their indices.
    pub creased: Vec<usize>,
    pub between: Between,
}

/// The edges between missing faces. Vertices of the rim are given by their indices, in ascending order.
pub(super) enum Between {
    /// From one vertex of the rim to another. There are none if a single face is missing.
    Edges(Vec<[usize; 2]>),
    /// From three vertices of the rim to a missing corner.
    Corner([usize; 3], DVec3),
}

/// The missing face of a body with sharp edges, such as a side of a box: the rim is flat, its plane meets the faces
/// beside it at sharp angles or continues them, and a sharp edge of the body ends at the rim. Or the rim is exactly
/// flat as if [cut](FlatRim::cut_edges). `None` for other holes, and if no edge of the rim is sharp.
pub(super) fn missing_face(mesh: &Mesh, hole: &BoundaryLoop) -> Option<MissingFaces> {
    let rim = FlatRim::new(mesh, hole);
    let whole: Vec<usize> = (0..hole.edges()).collect();
    let creased = rim.cut_edges().or_else(|| {
        let face = || rim.face(&whole, None).map(|face| face.creased);
        rim.ends_lines.then(face).flatten()
    })?;
    MissingFaces::new(creased, Between::Edges(Vec::new()))
}

/// Several such faces side by side, whose planes meet each other at sharp angles.
pub(super) fn missing_faces(mesh: &Mesh, hole: &BoundaryLoop) -> Option<MissingFaces> {
    let rim = FlatRim::new(mesh, hole);
    if !rim.ends_lines || rim.turns.len() > MAX_TURNS {
        return None;
    }
    let (faces, between) = rim.between_edges().or_else(|| rim.at_corner())?;
    let creased = faces.into_iter().flat_map(|face| face.creased).collect();
    MissingFaces::new(creased, between)
}

impl MissingFaces {
    fn new(creased: Vec<usize>, between: Between) -> Option<Self> {
        (!creased.is_empty()).then_some(Self { creased, between })
    }
}

/// A missing face: a flat polygon of vertices of the rim, and perhaps a corner.
struct Face {
    vertices: Vec<usize>,
    normal: DVec3,
    /// Edges of the rim at which it meets the mesh at a sharp angle.
    creased: Vec<usize>,
    /// The number of places where the polygon turns.
    turns: usize,
}

impl Face {
    fn is_sharp_to(&self, other: &Self) -> bool {
        is_sharp_angle(self.normal.angle_between(other.normal))
    }

    /// Whether it is flat not only because it is a triangle.
    fn is_evident(&self) -> bool {
        self.turns > 3
    }
}

/// The places of a closed polygon at which it turns.
fn turns(points: &[DVec3]) -> impl Iterator<Item = usize> {
    let n = points.len();
    let turn = move |k: usize| {
        let [before, at, after] = [n - 1, 0, 1].map(|step| points[(k + step) % n]);
        (at - before).angle_between(after - at)
    };
    (0..n).filter(move |&k| turn(k) > MIN_TURN.to_radians())
}

/// The rim of a hole whose parts may be flat.
struct FlatRim<'a> {
    hole: &'a BoundaryLoop,
    points: Vec<DVec3>,
    /// The normals of the faces beside the edges, of any length.
    beside: Vec<DVec3>,
    /// Whether a sharp edge of the mesh ends at the rim.
    ends_lines: bool,
    /// The vertices at which the rim turns.
    turns: Vec<usize>,
    /// Before each place of the rim, run through twice, the number of those where it leaves a plane: where four
    /// vertices in a row do not lie in one.
    bends: Vec<usize>,
}

impl<'a> FlatRim<'a> {
    fn new(mesh: &Mesh, hole: &'a BoundaryLoop) -> Self {
        let mut around = (hole.vertices.iter()).flat_map(|&v| mesh.topology.outgoing(v));
        let ends_lines = around.any(|h| is_sharp(mesh, h));
        let points: Vec<DVec3> = hole.vertices.iter().map(|&v| mesh.position(v)).collect();
        let normal = |h: &HalfedgeId| {
            let [a, b, c] = mesh.corners(mesh.topology.face(h.twin()));
            (b - a).cross(c - a)
        };
        let n = points.len();
        let limit = 4.0 * FLAT * hole.radius;
        let is_bent = |k: usize| height([0, 1, 2, 3].map(|step| points[(k + step) % n])) > limit;
        let count = |sum: &mut usize, k: usize| {
            let before = *sum;
            *sum += usize::from(is_bent(k));
            Some(before)
        };
        Self {
            hole,
            ends_lines,
            beside: hole.halfedges.iter().map(normal).collect(),
            turns: turns(&points).collect(),
            bends: (0..2 * n).scan(0, count).collect(),
            points,
        }
    }

    /// The edges at which a flat patch has creases, where the rim is exactly flat, as a cut along a plane or a face of a
    /// CAD program is. All faces beside it meet its plane at a sharp angle or at most at [`TILTED`], as the first ones of
    /// a rounding. To be no round opening, it has edges of very different length, or both kinds of faces beside it.
    fn cut_edges(&self) -> Option<Vec<usize>> {
        let normal = vector_area(&self.points).try_normalize()?;
        let distance = |p: &DVec3| (*p - self.points[0]).dot(normal).abs();
        if self
            .points
            .iter()
            .any(|p| distance(p) > EXACT * self.hole.radius)
        {
            return None;
        }
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

    /// Whether the rim may be flat from one vertex to another in its direction.
    fn may_be_flat(&self, from: usize, to: usize) -> bool {
        let n = self.points.len();
        let edges = (to + n - from) % n;
        edges < 3 || self.bends[from] == self.bends[from + edges - 2]
    }

    /// The face with these vertices of the rim, in its direction, and a corner after them. `None` if it is not
    /// flat, or neither meets a face beside the rim at a sharp angle nor continues it.
    fn face(&self, vertices: &[usize], corner: Option<DVec3>) -> Option<Face> {
        let points = vertices.iter().map(|&i| self.points[i]).chain(corner);
        let points: Vec<DVec3> = points.collect();
        let normal = vector_area(&points).try_normalize()?;
        let distance = |p: &DVec3| (*p - points[0]).dot(normal).abs();
        if points.iter().any(|p| distance(p) > FLAT * self.hole.radius) {
            return None;
        }
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

    /// The faces between edges from one vertex of the rim to another, as few as possible.
    fn between_edges(&self) -> Option<(Vec<Face>, Between)> {
        let whole: Vec<usize> = (0..self.points.len()).collect();
        let (faces, edges) = (1..=MAX_EDGES).find_map(|most| self.cut(&whole, most))?;
        Some((faces, Between::Edges(edges)))
    }

    /// Cuts a polygon of vertices of the rim into faces along at most `most` edges. Each edge cuts off one face that is
    /// [evident](Face::is_evident).
    fn cut(&self, polygon: &[usize], most: usize) -> Option<(Vec<Face>, Vec<[usize; 2]>)> {
        if let Some(face) = self.face(polygon, None) {
            return Some((vec![face], Vec::new()));
        }
        let most = most.checked_sub(1)?;
        let is_turn = |&k: &usize| self.turns.binary_search(&polygon[k]).is_ok();
        let turns: Vec<usize> = (0..polygon.len()).filter(is_turn).collect();
        let pairs = (0..turns.len()).flat_map(|j| (0..turns.len()).map(move |i| [i, j]));
        let pairs = pairs.map(|pair| pair.map(|k| turns[k]));
        pairs
            .filter(|[from, to]| from != to)
            .find_map(|[from, to]| {
                let edge = [polygon[from], polygon[to]];
                if polygon.len() == self.points.len() && !self.may_be_flat(edge[0], edge[1]) {
                    return None;
                }
                let (first, last) = (from.min(to), from.max(to));
                let inside = polygon[first..=last].to_vec();
                let outside = [&polygon[..=first], &polygon[last..]].concat();
                let (one, others) = if from < to {
                    (inside, outside)
                } else {
                    (outside, inside)
                };
                let face = self.face(&one, None).filter(Face::is_evident)?;
                let (mut faces, mut edges) = self.cut(&others, most)?;
                let has_edge = |face: &&Face| edge.iter().all(|v| face.vertices.contains(v));
                let is_sharp = faces.iter().find(has_edge)?.is_sharp_to(&face);
                faces.push(face);
                edges.push([polygon[first], polygon[last]]);
                is_sharp.then_some((faces, edges))
            })
    }

    /// Three faces that meet in a missing corner. Planes always meet in a point: the edges of the rim are straight
    /// lines of several edges, or the planes are perpendicular to each other.
    fn at_corner(&self) -> Option<(Vec<Face>, Between)> {
        let (n, count) = (self.points.len(), self.turns.len());
        if count > MAX_TURNS_AT_CORNER {
            return None;
        }
        let run = |from: usize, to: usize| -> Vec<usize> {
            let edges = (to + n - from) % n;
            (0..=edges).map(|k| (from + k) % n).collect()
        };
        let flat = |(i, j): (usize, usize)| {
            let [from, to] = [i, j].map(|k| self.turns[k]);
            let may_be_flat = self.may_be_flat(from, to);
            may_be_flat
                .then(|| self.face(&run(from, to), None))
                .flatten()
        };
        let ordered = (0..count).flat_map(|i| (0..count).map(move |j| (i, j)));
        let planes: Vec<Option<Face>> = ordered.map(flat).collect();
        let is_straight = 2 * count <= n;
        let triples =
            (0..count).flat_map(|k| (0..k).flat_map(move |j| (0..j).map(move |i| [i, j, k])));
        triples
            .map(|[i, j, k]| [(i, j), (j, k), (k, i)])
            .find_map(|runs| {
                let [a, b, c] = runs.map(|(i, j)| planes[i * count + j].as_ref());
                let planes = [a?, b?, c?];
                let [l, m, n] = planes.map(|face| face.normal);
                let is_square = [l.dot(m), m.dot(n), n.dot(l)]
                    .iter()
                    .all(|cos| cos.abs() < SQUARE);
                let across = DMat3::from_cols(l, m, n).transpose();
                if !(is_straight || is_square) || across.determinant().abs() < MIN_SPREAD {
                    return None;
                }
                let offset = planes.map(|face| face.normal.dot(self.points[face.vertices[0]]));
                let corner = across.inverse() * DVec3::from_array(offset);
                let face = |plane: &Face| {
                    let face = self.face(&plane.vertices, Some(corner));
                    face.filter(Face::is_evident)
                };
                let [a, b, c] = planes.map(face);
                let faces = vec![a?, b?, c?];
                let are_sharp = (0..3).all(|k| faces[k].is_sharp_to(&faces[(k + 1) % 3]));
                are_sharp.then(|| {
                    let ends = runs.map(|(i, _)| self.turns[i]);
                    (faces, Between::Corner(ends, corner))
                })
            })
    }
}

/// The smallest distance of one of four points from the plane of the others; less where they are almost on a line.
fn height([a, b, c, d]: [DVec3; 4]) -> f64 {
    let volume = (b - a).cross(c - a).dot(d - a).abs();
    let area = |p: DVec3, q: DVec3, r: DVec3| (q - p).cross(r - p).length();
    let areas = [area(a, b, c), area(a, b, d), area(a, c, d), area(b, c, d)];
    let lengths = [a.distance(b), b.distance(c), c.distance(d)];
    let thin = FLAT * lengths.iter().sum::<f64>().powi(2);
    volume
        / areas
            .into_iter()
            .fold(thin, f64::max)
            .max(f64::MIN_POSITIVE)
}
