//! Another triangulation of the same surface over the same rim.
//!
//! Both triangulations are mapped to one disc, with the rim on its circle. The map places every
//! vertex at a mean of its neighbours with positive weights, so no triangle is flipped (Tutte's
//! theorem). A new vertex moves to the point of the current surface with the same position in the
//! disc.

use std::f64::consts::TAU;

use glam::DVec2;

use crate::linear::LinearError;
use crate::mesh::{DVec3, FaceId, Topology, TopologyError, VertexId};
use crate::patch::data::Patch;
use crate::patch::fair::{Rings, Rows, solve};

/// Why a surface cannot be given another triangulation.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TransferError {
    /// A triangulation is not a disc over the rim.
    #[error("the patch is not an oriented manifold: {0}")]
    Topology(#[from] TopologyError),
    /// The map to the disc could not be solved for.
    #[error("the patch could not be mapped to a disc: {0}")]
    Linear(#[from] LinearError),
}

/// Moves the new vertices of `fresh` onto the surface of `present`, another triangulation over the
/// same rim.
///
/// # Errors
/// One of the two is not a disc over that rim.
pub fn transfer(present: &Patch, fresh: &mut Patch) -> Result<(), TransferError> {
    let rim = present.rim;
    if fresh.points.len() == rim {
        return Ok(());
    }
    let circle = circle(&present.points[..rim]);
    let from = Topology::from_triangles(present.points.len(), &present.triangles)?;
    let from_places = disc(&from, &present.points, &circle)?;
    let to = Topology::from_triangles(fresh.points.len(), &fresh.triangles)?;
    let to_places = disc(&to, &fresh.points, &circle)?;
    let mut face = FaceId(0);
    for (point, &place) in fresh.points.iter_mut().zip(&to_places).skip(rim) {
        face = locate(&from, &from_places, place, face);
        let corners = from.face_vertices(face).map(VertexId::index);
        let weights = barycentric(corners.map(|v| from_places[v]), place).map(|w| w.max(0.0));
        let sum: f64 = weights.iter().sum();
        let mixed = corners.iter().zip(weights);
        *point = mixed.fold(DVec3::ZERO, |p, (&v, w)| p + present.points[v] * (w / sum));
    }
    Ok(())
}

/// Places of the rim on the unit circle, by length along it.
fn circle(rim: &[DVec3]) -> Vec<DVec2> {
    let n = rim.len();
    let length = |i: usize| rim[i].distance(rim[(i + 1) % n]);
    let total: f64 = (0..n).map(length).sum();
    let mut along = 0.0;
    (0..n)
        .map(|i| {
            let place = DVec2::from_angle(TAU * along / total);
            along += length(i);
            place
        })
        .collect()
}

/// Places of all vertices in the disc.
fn disc(
    topology: &Topology,
    points: &[DVec3],
    circle: &[DVec2],
) -> Result<Vec<DVec2>, LinearError> {
    let rim = circle.len();
    let mut places = circle.to_vec();
    if points.len() == rim {
        return Ok(places);
    }
    let interior: Vec<VertexId> = (rim..points.len()).map(VertexId::from).collect();
    let rings = Rings::around(topology, points, &interior);
    let mut rows = Rows {
        offsets: vec![0],
        columns: Vec::new(),
        values: Vec::new(),
        rhs: Vec::new(),
        origin: DVec3::ZERO,
        is_anchored: true,
    };
    for (i, &v) in interior.iter().enumerate() {
        let (ring, diagonal, _) = rings.of(v);
        rows.columns.push(i as u32);
        rows.values.push(diagonal);
        let mut rhs = DVec2::ZERO;
        for &(k, w) in ring {
            if k.index() < rim {
                rhs += w * circle[k.index()];
            } else {
                rows.columns.push((k.index() - rim) as u32);
                rows.values.push(-w);
            }
        }
        rows.offsets.push(rows.columns.len() as u32);
        rows.rhs.push(rhs.extend(0.0));
    }
    let solution = solve(&rows, &points[rim..])?;
    places.extend(solution.iter().map(|p| p.truncate()));
    Ok(places)
}

/// Twice the signed areas of the triangles that `p` makes with the edges opposite each corner.
fn barycentric(corners: [DVec2; 3], p: DVec2) -> [f64; 3] {
    let [a, b, c] = corners.map(|q| q - p);
    [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)]
}

/// The face that contains `p`, found by a walk from `face`. If rounding, or a chord of the circle,
/// leaves `p` outside all faces, the nearest one.
fn locate(topology: &Topology, places: &[DVec2], p: DVec2, mut face: FaceId) -> FaceId {
    let least = |f: FaceId| {
        let corners = topology.face_vertices(f).map(|v| places[v.index()]);
        let weights = barycentric(corners, p);
        let i = (0..3).fold(
            0,
            |best, i| if weights[i] < weights[best] { i } else { best },
        );
        (weights[i] / weights.iter().sum::<f64>(), i)
    };
    // a walk may cycle if the triangles are not a Delaunay triangulation
    for _ in 0..places.len() {
        let (weight, i) = least(face);
        if weight >= 0.0 {
            return face;
        }
        // the half-edge opposite corner i
        let mut h = topology.halfedge_of_face(face);
        while topology.target(topology.next(h)) != topology.face_vertices(face)[i] {
            h = topology.next(h);
        }
        let beyond = topology.face(h.twin());
        if !beyond.is_some() {
            break;
        }
        face = beyond;
    }
    let all = topology.faces();
    all.max_by(|&f, &g| least(f).0.total_cmp(&least(g).0))
        .unwrap_or(face)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patch::{PatchOptions, Rim, fill};

    fn rim() -> Rim {
        let at = |i: usize, r: f64| {
            let p = DVec2::from_angle(TAU * i as f64 / 40.0) * r;
            DVec3::new(2.0 * p.x, p.y, 0.2 * p.x * p.y)
        };
        Rim {
            points: (0..40).map(|i| at(i, 1.0)).collect(),
            opposite: (0..40).map(|i| at(i, 1.2)).collect(),
            forbidden: Vec::new(),
        }
    }

    fn patch(density: f64) -> Patch {
        fill(&rim(), PatchOptions { density }).expect("a patch")
    }

    #[test]
    fn the_same_triangulation_stays_where_it_is() {
        let present = patch(1.0);
        let mut fresh = present.clone();
        transfer(&present, &mut fresh).expect("discs");
        for (a, b) in present.points.iter().zip(&fresh.points) {
            assert!(a.distance(*b) < 1e-12, "{a} {b}");
        }
    }

    /// New vertices lie on the current triangles: a surface z = f(x, y) that is linear in x and y
    /// remains linear.
    #[test]
    fn new_vertices_lie_on_the_present_surface() {
        let plane = |p: &DVec3| DVec3::new(p.x, p.y, 0.3 * p.x - 0.7 * p.y);
        for (from, to) in [(1.0, 2.0), (2.0, 0.7)] {
            let (mut present, mut fresh) = (patch(from), patch(to));
            for p in present.points.iter_mut().chain(&mut fresh.points) {
                *p = plane(p);
            }
            let untouched = fresh.points[..40].to_vec();
            transfer(&present, &mut fresh).expect("discs");
            assert_eq!(fresh.points[..40], untouched);
            for p in &fresh.points {
                assert!(p.distance(plane(p)) < 1e-12);
            }
            // no triangle is flipped
            for t in &fresh.triangles {
                let [a, b, c] = t.map(|v| fresh.points[v as usize]);
                assert!((b - a).cross(c - a).z > 0.0);
            }
        }
    }
}
