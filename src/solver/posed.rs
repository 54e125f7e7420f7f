//! Where on a surface the flow of an energy is not well posed, face by face.

use crate::energy::{Energy, WellPosed, scan_well_posedness};
use crate::mesh::{DVec3, FaceId, Topology};
use crate::solver::survey::each_point;
use crate::subdivision::{Rule, TableCache, elements};

/// What the flow is on each of `faces`: the worst class over the quadrature points of the limit
/// surface. `length` is the size of the region, as of [`scan_well_posedness`].
pub fn ill_posed_faces(
    topology: &Topology,
    positions: &[DVec3],
    faces: &[FaceId],
    energy: &Energy,
    length: f64,
) -> Vec<WellPosed> {
    let mut classes = vec![WellPosed::Strict; faces.len()];
    if energy.is_uniformly_parabolic() {
        return classes;
    }
    // elements come in an order of their own
    let mut place: Vec<(FaceId, usize)> = faces.iter().enumerate().map(|(i, &f)| (f, i)).collect();
    place.sort_unstable();
    let local = elements(topology, faces, Rule::Three, &mut TableCache::default());
    for e in 0..local.len() {
        let mut samples = Vec::with_capacity(3);
        each_point(&local, e, positions, |_, p| samples.push([p.mean, p.gauss]));
        let scan = scan_well_posedness(energy, &samples, length, TOLERANCE);
        let found = place.binary_search_by_key(&local.faces[e], |(f, _)| f.0);
        if let (Ok(at), Some(worst)) = (found, scan.worst) {
            classes[place[at].1] = worst.class;
        }
    }
    classes
}

/// Symbols smaller than this, relative to their scale, count as zero.
pub(super) const TOLERANCE: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::shapes::{self, TriangleMesh};

    fn classes((positions, triangles): TriangleMesh, energy: &str) -> Vec<WellPosed> {
        let topology = Topology::from_triangles(positions.len(), &triangles).expect("a manifold");
        // backwards, so that an order of the elements' own would be found out
        let faces: Vec<FaceId> = (0..topology.face_count()).rev().map(FaceId::from).collect();
        let energy = Energy::parse(energy, &BTreeMap::new()).expect("an energy");
        ill_posed_faces(&topology, &positions, &faces, &energy, 1.0)
    }

    #[test]
    fn known_surfaces_have_known_classes() {
        for (energy, wanted) in [
            ("H^2", WellPosed::Strict),
            ("K^2", WellPosed::Strict),
            ("-H^2", WellPosed::IllPosed),
            ("K", WellPosed::Stationary),
            ("sqrt(-K)", WellPosed::Undefined),
        ] {
            let all = classes(shapes::icosphere(3), energy);
            assert!(
                all.iter().all(|&class| class == wanted),
                "{energy}: {all:?}"
            );
        }
        // K^2 does not smooth along the asymptotic directions of a saddle
        let saddle = classes(shapes::catenoid(1.0, 1.0, 24, 1), "K^2");
        assert!(saddle.iter().all(|&class| class == WellPosed::Degenerate));
    }

    /// A graph with convex and saddle-like parts: each face gets its own class.
    #[test]
    fn classes_belong_to_their_faces() {
        let (positions, triangles) = shapes::graph(2.0, 16, |x, y| 0.5 * (x * x * x + y * y), 2);
        let found = classes((positions.clone(), triangles.clone()), "K^2");
        for (class, t) in found.iter().rev().zip(&triangles) {
            let x = t.map(|v| positions[v as usize].x).iter().sum::<f64>() / 3.0;
            // K has the sign of x; near the boundary ghosts flatten the surface
            if x > 0.3 && x < 0.7 {
                assert_eq!(*class, WellPosed::Strict);
            } else if x < -0.3 && x > -0.7 {
                assert_eq!(*class, WellPosed::Degenerate);
            }
        }
    }
}
