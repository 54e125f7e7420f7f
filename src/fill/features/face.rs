//! Missing faces of bodies with flat faces and sharp edges.

use glam::DMat3;

use crate::fill::sharp::{is_sharp, is_sharp_angle};
use crate::mesh::{BoundaryLoop, DVec3, HalfedgeId, Mesh, vector_area};

/// Largest distance of a rim from its plane, in radii of the hole. The rims of scans are not flat, and
/// coordinates in files have at least four digits.
const FLAT: f64 = 1e-3;
/// Largest angle between the plane of the rim and a face that continues it, in degrees.
const FLUSH: f64 = 10.0;

/// Smallest turn of a rim where an edge between two missing faces ends, in degrees.
const MIN_TURN: f64 = 10.0;
/// Maximum number of turns of a rim of which missing faces are the parts.
const MAX_TURNS: usize = 32;
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
/// beside it at sharp angles or continues them, and a sharp edge of the body ends at the rim. `None` for
/// other holes, and if no edge of the rim is sharp.
pub(super) fn missing_face(mesh: &Mesh, hole: &BoundaryLoop) -> Option<MissingFaces> {
    let rim = FlatRim::new(mesh, hole)?;
    let whole: Vec<usize> = (0..hole.edges()).collect();
    let face = rim.face(&whole, None)?;
    MissingFaces::new(vec![face], Between::Edges(Vec::new()))
}

/// Several such faces side by side, whose planes meet each other at sharp angles.
pub(super) fn missing_faces(mesh: &Mesh, hole: &BoundaryLoop) -> Option<MissingFaces> {
    let rim = FlatRim::new(mesh, hole)?;
    if rim.turns.len() > MAX_TURNS {
        return None;
    }
    let (faces, between) = rim.between_edges().or_else(|| rim.at_corner())?;
    MissingFaces::new(faces, between)
}

impl MissingFaces {
    fn new(faces: Vec<Face>, between: Between) -> Option<Self> {
        let creased: Vec<usize> = faces.into_iter().flat_map(|face| face.creased).collect();
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
    /// The vertices at which the rim turns.
    turns: Vec<usize>,
}

impl<'a> FlatRim<'a> {
    /// `None` if no sharp edge of the mesh ends at the rim.
    fn new(mesh: &Mesh, hole: &'a BoundaryLoop) -> Option<Self> {
        let mut around = (hole.vertices.iter()).flat_map(|&v| mesh.topology.outgoing(v));
        if !around.any(|h| is_sharp(mesh, h)) {
            return None;
        }
        let points: Vec<DVec3> = hole.vertices.iter().map(|&v| mesh.position(v)).collect();
        let normal = |h: &HalfedgeId| {
            let [a, b, c] = mesh.corners(mesh.topology.face(h.twin()));
            (b - a).cross(c - a)
        };
        Some(Self {
            hole,
            beside: hole.halfedges.iter().map(normal).collect(),
            turns: turns(&points).collect(),
            points,
        })
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
        (1..=MAX_EDGES).find_map(|most| {
            let (faces, edges) = self.cut(&whole, most)?;
            let is_evident = faces.iter().any(Face::is_evident);
            is_evident.then_some((faces, Between::Edges(edges)))
        })
    }

    /// Cuts a polygon of vertices of the rim into faces along at most `most` edges.
    fn cut(&self, polygon: &[usize], most: usize) -> Option<(Vec<Face>, Vec<[usize; 2]>)> {
        if let Some(face) = self.face(polygon, None) {
            return Some((vec![face], Vec::new()));
        }
        let most = most.checked_sub(1)?;
        let is_turn = |&k: &usize| self.turns.binary_search(&polygon[k]).is_ok();
        let turns: Vec<usize> = (0..polygon.len()).filter(is_turn).collect();
        let pairs = (0..turns.len()).flat_map(|j| (0..j).map(move |i| [i, j]));
        pairs
            .map(|pair| pair.map(|k| turns[k]))
            .find_map(|[from, to]| {
                let inner = polygon[from..=to].to_vec();
                let outer = [&polygon[..=from], &polygon[to..]].concat();
                let edge = [polygon[from], polygon[to]];
                // one of the edges separates one face from all others
                [[&inner, &outer], [&outer, &inner]]
                    .into_iter()
                    .find_map(|[one, others]| {
                        let face = self.face(one, None)?;
                        let (mut faces, mut edges) = self.cut(others, most)?;
                        let has_edge =
                            |face: &&Face| edge.iter().all(|v| face.vertices.contains(v));
                        let is_sharp = faces.iter().find(has_edge)?.is_sharp_to(&face);
                        faces.push(face);
                        edges.push(edge);
                        is_sharp.then_some((faces, edges))
                    })
            })
    }

    /// Three faces that meet in a missing corner.
    fn at_corner(&self) -> Option<(Vec<Face>, Between)> {
        let n = self.points.len();
        let run = |from: usize, to: usize| -> Vec<usize> {
            let edges = (to + n - from) % n;
            (0..=edges).map(|k| (from + k) % n).collect()
        };
        let count = self.turns.len();
        let flat = |(i, j): (usize, usize)| self.face(&run(self.turns[i], self.turns[j]), None);
        let ordered = (0..count).flat_map(|i| (0..count).map(move |j| (i, j)));
        let planes: Vec<Option<Face>> = ordered.map(flat).collect();
        let triples =
            (0..count).flat_map(|k| (0..k).flat_map(move |j| (0..j).map(move |i| [i, j, k])));
        triples
            .map(|[i, j, k]| [(i, j), (j, k), (k, i)])
            .find_map(|runs| {
                let [a, b, c] = runs.map(|(i, j)| planes[i * count + j].as_ref());
                let planes = [a?, b?, c?];
                let across = DMat3::from_cols(planes[0].normal, planes[1].normal, planes[2].normal)
                    .transpose();
                if across.determinant().abs() < MIN_SPREAD {
                    return None;
                }
                let offset = planes.map(|face| face.normal.dot(self.points[face.vertices[0]]));
                let corner = across.inverse() * DVec3::from_array(offset);
                let faces = planes.map(|plane| self.face(&plane.vertices, Some(corner)));
                let faces: Vec<Face> = faces.into_iter().flatten().collect();
                let are_sharp =
                    (0..faces.len()).all(|k| faces[k].is_sharp_to(&faces[(k + 1) % faces.len()]));
                (faces.len() == 3 && are_sharp && faces.iter().all(Face::is_evident)).then(|| {
                    let ends = runs.map(|(i, _)| self.turns[i]);
                    (faces, Between::Corner(ends, corner))
                })
            })
    }
}
