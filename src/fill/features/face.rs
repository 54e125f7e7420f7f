//! Missing faces of bodies with flat faces and sharp edges.

use super::lines::{SHARP, is_sharp};
use crate::fill::defects::FOLDED;
use crate::mesh::{BoundaryLoop, DVec3, Mesh, vector_area};

/// Largest distance of a rim from its plane, in radii of the hole. The rims of scans are not flat, and
/// coordinates in files have at least four digits.
const FLAT: f64 = 1e-3;
/// Largest angle between the plane of the rim and a face that continues it, in degrees.
const FLUSH: f64 = 10.0;

/// The sharp edges of a flat rim, by their indices, where the hole is a missing face of a body with sharp
/// edges: the plane of the rim meets each face beside it at a sharp angle or continues it, and a sharp edge
/// of the body ends at the rim. `None` for other holes, and if no edge of the rim is sharp.
pub(super) fn edges_of_missing_face(mesh: &Mesh, hole: &BoundaryLoop) -> Option<Vec<usize>> {
    let points = hole.vertices.iter().map(|&v| mesh.position(v));
    let points: Vec<DVec3> = points.collect();
    let normal = vector_area(&points).try_normalize()?;
    let distance = |p: &DVec3| (*p - hole.centroid).dot(normal).abs();
    if points.iter().any(|p| distance(p) > FLAT * hole.radius) {
        return None;
    }
    let mut creased = Vec::new();
    for (i, &h) in hole.halfedges.iter().enumerate() {
        let [a, b, c] = mesh.corners(mesh.topology.face(h.twin()));
        let angle = (b - a).cross(c - a).angle_between(normal);
        if angle > SHARP.to_radians() && angle.cos() > FOLDED {
            creased.push(i);
        } else if angle.is_nan() || angle > FLUSH.to_radians() {
            return None;
        }
    }
    let mut around = hole
        .vertices
        .iter()
        .flat_map(|&v| mesh.topology.outgoing(v));
    (!creased.is_empty() && around.any(|h| is_sharp(mesh, h))).then_some(creased)
}
