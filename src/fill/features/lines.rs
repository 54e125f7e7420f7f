//! Sharp lines that end at a hole.

use crate::fill::sharp::is_sharp;
use crate::mesh::{BoundaryLoop, DVec3, HalfedgeId, Mesh, dihedral_angle};

/// Sharp edges that a line consists of at least; an end of noise is shorter.
const MIN_EDGES: usize = 3;
/// Largest turn of a line at a vertex, in degrees.
const LARGEST_TURN: f64 = 30.0;
/// Largest difference of the angles between faces along a line and from one line to the other, in
/// degrees.
const LARGEST_CHANGE: f64 = 25.0;
/// Maximum number of lines that are continued into one hole.
const MAX_LINES: usize = 8;

/// The end of a sharp line at a rim.
pub(super) struct LineEnd {
    /// Index along the loop.
    pub index: usize,
    pub point: DVec3,
    /// Unit tangent of the line, into the hole.
    pub ahead: DVec3,
    /// Angle between the faces of its last edge, in radians; negative where the edge is a valley.
    angle: f64,
}

impl LineEnd {
    /// The angle, in radians, between the line and the straight way to a point.
    pub fn deviation(&self, to: DVec3) -> f64 {
        self.ahead.angle_between(to - self.point)
    }

    /// Whether the angle between the faces is that of another line, up to noise.
    pub fn is_as_sharp_as(&self, other: &Self) -> bool {
        (self.angle - other.angle).abs() <= LARGEST_CHANGE.to_radians()
    }
}

/// The ends of sharp lines at a rim, in its direction. A line that passes a vertex does not end there.
/// `None` if a sharp edge at the rim does not belong to a line, or if there are too many.
pub(super) fn line_ends(mesh: &Mesh, hole: &BoundaryLoop) -> Option<Vec<LineEnd>> {
    let mut ends: Vec<LineEnd> = Vec::new();
    for (index, &v) in hole.vertices.iter().enumerate() {
        let outgoing = mesh.topology.outgoing(v);
        let sharp: Vec<HalfedgeId> = outgoing.filter(|&h| is_sharp(mesh, h)).collect();
        if let [one, other] = sharp[..] {
            let turn = direction(mesh, one).angle_between(-direction(mesh, other));
            if turn <= LARGEST_TURN.to_radians() {
                continue;
            }
        }
        if ends.len() + sharp.len() > MAX_LINES {
            return None;
        }
        for h in sharp {
            ends.push(line_end(mesh, index, h)?);
        }
    }
    Some(ends)
}

/// The end of the line that begins with a sharp edge from a rim vertex away from the hole.
fn line_end(mesh: &Mesh, index: usize, first: HalfedgeId) -> Option<LineEnd> {
    let topology = &mesh.topology;
    let angle = signed_angle(mesh, first);
    let mut along = vec![direction(mesh, first)];
    let mut h = first;
    while along.len() < MIN_EDGES {
        let at = topology.target(h);
        let mut on = topology
            .outgoing(at)
            .filter(|&o| o != h.twin() && is_sharp(mesh, o));
        let next = on.next().filter(|_| on.next().is_none())?;
        let turn = direction(mesh, h).angle_between(direction(mesh, next));
        let change = (signed_angle(mesh, next) - angle).abs();
        if turn > LARGEST_TURN.to_radians() || change > LARGEST_CHANGE.to_radians() {
            return None;
        }
        along.push(direction(mesh, next));
        h = next;
    }
    // an edge of a curve has the direction of its middle, half an edge before the end
    let ahead = -(along[0] + 0.5 * (along[0] - along[1])).normalize_or_zero();
    Some(LineEnd {
        index,
        point: mesh.position(topology.origin(first)),
        ahead,
        angle,
    })
}

fn direction(mesh: &Mesh, h: HalfedgeId) -> DVec3 {
    let [from, to] = [mesh.topology.origin(h), mesh.topology.target(h)];
    (mesh.position(to) - mesh.position(from)).normalize_or_zero()
}

/// The angle between the faces of an edge, negative where the edge is a valley.
fn signed_angle(mesh: &Mesh, h: HalfedgeId) -> f64 {
    let [m, n] = [h, h.twin()].map(|h| {
        let [a, b, c] = mesh.corners(mesh.topology.face(h));
        (b - a).cross(c - a)
    });
    let angle = dihedral_angle(&mesh.positions, &mesh.topology, h);
    angle.copysign(m.cross(n).dot(direction(mesh, h)))
}
