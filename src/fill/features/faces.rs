//! Missing flat faces of a body side by side.

use std::cell::Cell;

use glam::DMat3;

use super::face::{FLAT, Face, FlatRim, turns};
use crate::mesh::DVec3;

/// Maximum number of turns of a rim of which missing faces are the parts.
const MAX_TURNS: usize = 32;
/// Maximum number of turns of a rim around a missing corner. That of a cube has six.
const MAX_TURNS_AT_CORNER: usize = 12;
/// Cosine of the angle between two planes up to which they are perpendicular.
const SQUARE: f64 = 1e-3;
/// Maximum number of edges between missing faces.
const MAX_EDGES: usize = 4;
/// Maximum number of vertices of the polygons that a search tries: some hundredths of a second. A rim in few planes has
/// millions of polygons.
const MAX_VERTICES: usize = 5_000_000;
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
    /// From one vertex of the rim to another.
    Edges(Vec<[usize; 2]>),
    /// From three vertices of the rim to a missing corner.
    Corner([usize; 3], DVec3),
}

/// The missing faces side by side of which a hole consists. Each is as a [single one](FlatRim::missing_face) at which a
/// sharp edge of the body ends, and their planes meet at sharp angles. `None` for other holes, and if no edge of the
/// rim is sharp.
pub(super) fn missing_faces(rim: &FlatRim) -> Option<MissingFaces> {
    let turns: Vec<usize> = turns(&rim.points).collect();
    if !rim.ends_lines || turns.len() > MAX_TURNS {
        return None;
    }
    let search = Search::new(rim, turns);
    let (faces, between) = search.between_edges().or_else(|| search.at_corner())?;
    let creased: Vec<usize> = faces.into_iter().flat_map(|face| face.creased).collect();
    (!creased.is_empty()).then_some(MissingFaces { creased, between })
}

/// The search for flat parts of a rim.
struct Search<'a> {
    rim: &'a FlatRim,
    /// The vertices at which the rim turns.
    turns: Vec<usize>,
    /// Before each place of the rim, run through twice, the number of those where it leaves a plane: where four
    /// vertices in a row do not lie in one.
    bends: Vec<usize>,
    /// The number of vertices of the polygons that may still be tried.
    left: Cell<usize>,
}

impl<'a> Search<'a> {
    fn new(rim: &'a FlatRim, turns: Vec<usize>) -> Self {
        let n = rim.points.len();
        let limit = 4.0 * FLAT * rim.radius;
        let is_bent =
            |k: usize| height([0, 1, 2, 3].map(|step| rim.points[(k + step) % n])) > limit;
        let count = |sum: &mut usize, k: usize| {
            let before = *sum;
            *sum += usize::from(is_bent(k));
            Some(before)
        };
        let bends = (0..2 * n).scan(0, count).collect();
        Self {
            rim,
            turns,
            bends,
            left: Cell::new(MAX_VERTICES),
        }
    }

    /// Whether the rim may be flat from one vertex to another in its direction.
    fn may_be_flat(&self, from: usize, to: usize) -> bool {
        let n = self.rim.points.len();
        let edges = (to + n - from) % n;
        edges < 3 || self.bends[from] == self.bends[from + edges - 2]
    }

    /// The face with these vertices of the rim. `None` also if it is not flat between two of them, or after too
    /// many vertices.
    fn face(&self, polygon: &[usize]) -> Option<Face> {
        self.left.set(self.left.get().checked_sub(polygon.len())?);
        let n = self.rim.points.len();
        let mut runs = polygon.chunk_by(|i, j| *j == (i + 1) % n);
        let may_be_flat = runs.all(|run| self.may_be_flat(run[0], run[run.len() - 1]));
        may_be_flat.then(|| self.rim.face(polygon, None)).flatten()
    }

    /// The faces between edges from one vertex of the rim to another, as few as possible.
    fn between_edges(&self) -> Option<(Vec<Face>, Between)> {
        let whole: Vec<usize> = (0..self.rim.points.len()).collect();
        let (faces, edges) = (1..=MAX_EDGES).find_map(|most| self.cut(&whole, most))?;
        Some((faces, Between::Edges(edges)))
    }

    /// Cuts a polygon of vertices of the rim into faces along at most `most` edges. Each edge cuts off one face that is
    /// [evident](Face::is_evident).
    fn cut(&self, polygon: &[usize], most: usize) -> Option<(Vec<Face>, Vec<[usize; 2]>)> {
        if let Some(face) = self.face(polygon) {
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
                let (first, last) = (from.min(to), from.max(to));
                let inside = polygon[first..=last].to_vec();
                let outside = [&polygon[..=first], &polygon[last..]].concat();
                let (one, others) = if from < to {
                    (inside, outside)
                } else {
                    (outside, inside)
                };
                let face = self.face(&one).filter(Face::is_evident)?;
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
        let (n, count) = (self.rim.points.len(), self.turns.len());
        if count > MAX_TURNS_AT_CORNER {
            return None;
        }
        let run = |from: usize, to: usize| -> Vec<usize> {
            let edges = (to + n - from) % n;
            (0..=edges).map(|k| (from + k) % n).collect()
        };
        let flat = |(i, j): (usize, usize)| self.face(&run(self.turns[i], self.turns[j]));
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
                let offset = planes.map(|face| face.normal.dot(self.rim.points[face.vertices[0]]));
                let corner = across.inverse() * DVec3::from_array(offset);
                let face = |plane: &Face| {
                    let face = self.rim.face(&plane.vertices, Some(corner));
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
