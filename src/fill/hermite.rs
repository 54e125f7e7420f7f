//! Curves between two rim vertices that continue the mesh smoothly.

use crate::mesh::{BoundaryLoop, DVec3, Mesh};

/// Number of edges on each side of a vertex over which its directions are averaged.
const SMOOTHED: usize = 4;

/// A rim vertex with the directions of the surface there.
#[derive(Clone, Copy, Debug)]
pub(super) struct RimFrame {
    pub point: DVec3,
    /// Unit vector into the hole, in the tangent plane and across the rim.
    pub ahead: DVec3,
    /// Unit normal.
    pub normal: DVec3,
}

impl RimFrame {
    /// The frame at the vertex with that index along the loop. The directions are means over the
    /// faces at several rim edges. Directions from only the nearest two would follow every tooth of
    /// a ragged rim, and neighbouring curves would cross.
    pub fn of(mesh: &Mesh, hole: &BoundaryLoop, index: usize) -> Self {
        let topology = &mesh.topology;
        let n = hole.edges();
        let (mut ahead, mut normal) = (DVec3::ZERO, DVec3::ZERO);
        let side = SMOOTHED.min(n / 2);
        for e in (0..2 * side).map(|k| (index + n - side + k) % n) {
            let inner = hole.halfedges[e].twin();
            let apex = topology.target(topology.next(inner));
            // the face runs through the rim edge from b to a
            let [b, a] = [topology.origin(inner), topology.target(inner)].map(|v| mesh.position(v));
            let c = mesh.position(apex);
            ahead += (a - c).reject_from(b - a).normalize_or_zero();
            normal += (a - b).cross(c - b).normalize_or_zero();
        }
        Self {
            point: mesh.position(hole.vertices[index]),
            ahead: ahead.normalize_or_zero(),
            normal: normal.normalize_or_zero(),
        }
    }
}

/// The cubic Hermite curve from `a` to `b`, at t in 0..=1, with the unit direction `leave` at `a`
/// and `arrive` at `b`. Its end derivatives have the length of those of the circular arc with these
/// directions. The curve is close to that arc: the error of a quarter circle is 3e-4 of its radius.
pub(super) fn hermite_between(
    a: DVec3,
    leave: DVec3,
    b: DVec3,
    arrive: DVec3,
) -> impl Fn(f64) -> DVec3 {
    let turn = leave.angle_between(arrive);
    // NaN where a direction is missing: max ignores it
    let reach = a.distance(b) / (0.25 * turn).cos().powi(2).max(0.5);
    move |t| hermite(a, reach * leave, b, reach * arrive, t)
}

/// The cubic from `a` to `b` whose derivatives there are `leave` and `arrive`.
fn hermite(a: DVec3, leave: DVec3, b: DVec3, arrive: DVec3, t: f64) -> DVec3 {
    let s = 1.0 - t;
    let ends = (1.0 + 2.0 * t) * s * s * a + (3.0 - 2.0 * t) * t * t * b;
    ends + t * s * s * leave - t * t * s * arrive
}

/// Length of the curve, by chords.
pub(super) fn length(curve: impl Fn(f64) -> DVec3) -> f64 {
    const PIECES: i32 = 32;
    (0..PIECES)
        .map(|i| {
            let at = |i: i32| curve(f64::from(i) / f64::from(PIECES));
            at(i).distance(at(i + 1))
        })
        .sum()
}

/// Number of pieces of about `size` in a length, at least `min`.
#[allow(clippy::cast_sign_loss)] // lengths and sizes are positive
pub(super) fn pieces(length: f64, size: f64, min: usize) -> usize {
    ((length / size).round().min(1e6) as usize).max(min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_reproduced() {
        let cubic = |t: f64| {
            DVec3::new(
                1.0 - t + t * t * t,
                2.0 * t * t,
                0.5 - 3.0 * t + t * t - 2.0 * t * t * t,
            )
        };
        let slope = |t: f64| DVec3::new(-1.0 + 3.0 * t * t, 4.0 * t, -3.0 + 2.0 * t - 6.0 * t * t);
        for t in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let p = hermite(cubic(0.0), slope(0.0), cubic(1.0), slope(1.0), t);
            assert!(p.distance(cubic(t)) < 1e-15);
        }
        let arc = hermite_between(DVec3::X, DVec3::Y, DVec3::new(0.0, 1.0, 0.0), -DVec3::X);
        for i in 0..=20 {
            assert!((arc(f64::from(i) / 20.0).length() - 1.0).abs() < 3e-4);
        }
        let straight = hermite_between(DVec3::ZERO, DVec3::X, 0.7 * DVec3::X, DVec3::X);
        assert!(straight(0.5).distance(0.35 * DVec3::X) < 1e-15);
        let line = |t: f64| DVec3::new(3.0 * t, 4.0 * t, 1.0);
        assert!((length(line) - 5.0).abs() < 1e-14);
    }
}
