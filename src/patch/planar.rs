//! Triangulations of loops that are simple in a plane.

use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use crate::mesh::{DVec3, vector_area};

/// The constrained Delaunay triangulation of the loop's projection along its vector area, if that
/// is a simple polygon (decided with exact predicates) whose perimeter is at least `least_length`
/// of the loop's own. Triangles contain the edges `i → i + 1`.
pub(super) fn constrained_delaunay(points: &[DVec3], least_length: f64) -> Option<Vec<[u32; 3]>> {
    delaunay_between(project(points, least_length)?, &[points.len()])
}

/// The constrained Delaunay triangulation of the part of the plane to the left of closed polygons,
/// whose vertices follow each other in `points`, `lengths` of each. `None` if they cross themselves
/// or each other (decided with exact predicates), or do not bound one bounded connected part.
pub(super) fn delaunay_between(
    points: Vec<Point2<f64>>,
    lengths: &[usize],
) -> Option<Vec<[u32; 3]>> {
    let n = points.len();
    let mut edges = Vec::with_capacity(n);
    for &length in lengths {
        let first = edges.len();
        edges.extend((0..length).map(|i| [first + i, first + (i + 1) % length]));
    }
    let mut is_simple = true;
    let cdt: ConstrainedDelaunayTriangulation<Point2<f64>> =
        ConstrainedDelaunayTriangulation::try_bulk_load_cdt(points, edges.clone(), |_| {
            is_simple = false;
        })
        .ok()?;
    if !is_simple || cdt.num_vertices() != n || cdt.num_constraints() != n {
        return None;
    }
    // Flood the inside from the left of the edges.
    let mut seen = vec![false; cdt.num_all_faces()];
    let mut stack = Vec::new();
    let mut outside = Vec::new();
    for ends in edges {
        let [from, to] = ends.map(FixedVertexHandle::from_index);
        // a missing edge: the constraint runs through another vertex
        let edge = cdt.get_edge_from_neighbors(from, to)?;
        stack.push(edge.face().as_inner()?);
        outside.push(edge.rev().face());
    }
    // a sphere with as many holes: Euler's formula
    let expected = (n + 2 * lengths.len()).checked_sub(4)?;
    let mut triangles = Vec::with_capacity(expected);
    stack.reverse();
    while let Some(face) = stack.pop() {
        if std::mem::replace(&mut seen[face.index()], true) {
            continue;
        }
        let mut t = face.vertices().map(|v| v.index() as u32);
        // starts at the smallest index: where the flood starts a face must not matter
        while t[0] > t[1] || t[0] > t[2] {
            t.rotate_left(1);
        }
        triangles.push(t);
        for edge in face.adjacent_edges() {
            if !edge.is_constraint_edge() {
                stack.push(edge.rev().face().as_inner()?);
            }
        }
    }
    let fits = outside.iter().all(|face| !seen[face.index()]);
    (fits && triangles.len() == expected).then_some(triangles)
}

/// Coordinates in the plane across the vector area, the loop running counter-clockwise; none if
/// the projection shortens the loop too much.
fn project(points: &[DVec3], least_length: f64) -> Option<Vec<Point2<f64>>> {
    let normal = vector_area(points).try_normalize()?;
    let origin = points[0];
    // An axis that turns with the loop, so that a rotated loop gets the same coordinates.
    let u = points
        .iter()
        .map(|&p| (p - origin).reject_from_normalized(normal))
        .fold(DVec3::ZERO, |far, d| {
            if d.length_squared() > far.length_squared() {
                d
            } else {
                far
            }
        })
        .try_normalize()?;
    let v = normal.cross(u);
    // the triangulation refuses coordinates too small to square
    let snap = |x: f64| if x.abs() < 1e-40 { 0.0 } else { x };
    let flat: Vec<_> = points
        .iter()
        .map(|&p| Point2::new(snap((p - origin).dot(u)), snap((p - origin).dot(v))))
        .collect();
    let (mut length, mut flat_length) = (0.0, 0.0);
    for i in 0..points.len() {
        let j = (i + 1) % points.len();
        length += points[i].distance(points[j]);
        flat_length += flat[i].distance_2(flat[j]).sqrt();
    }
    (flat_length >= least_length * length).then_some(flat)
}
