//! How a patch meets the mesh: figures of the limit surface along the rims.

use crate::mesh::{DVec3, FaceId, Topology, VertexId};
use crate::subdivision::{Rule, elements, limit_normal};
use crate::surface::mean_curvature;

/// The worst places along all rims.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seam {
    /// Largest angle between the normals of either side at a vertex of a G0 rim, in degrees; `None`
    /// without such rims. On a G1 rim it is 0: one smooth surface runs through.
    pub angle: Option<f64>,
    /// Largest difference of mean curvature between the faces on either side of an edge of a G1
    /// rim, in one over units of length; `None` without such rims.
    pub jump: Option<f64>,
}

/// Measures the rims of the faces that flow: those from `first` on and `others`, which are ascending.
/// `sharp` are the edges of G0 rims.
pub fn seam(
    topology: &Topology,
    positions: &[DVec3],
    first: usize,
    others: &[u32],
    sharp: &[[VertexId; 2]],
) -> Seam {
    let mut edges: Vec<[VertexId; 2]> = sharp.iter().map(|&e| ordered(e)).collect();
    edges.sort_unstable();
    let (mut smooth, mut creased) = (Vec::new(), Vec::new());
    let flows = &|f: FaceId| f.index() >= first || others.binary_search(&f.0).is_ok();
    let patch = (first..topology.face_count()).map(FaceId::from);
    for f in others.iter().copied().map(FaceId).chain(patch) {
        let mut h = topology.halfedge_of_face(f);
        for _ in 0..3 {
            let beyond = topology.face(h.twin());
            if beyond.is_some() && !flows(beyond) {
                let ends = ordered([topology.origin(h), topology.target(h)]);
                if edges.binary_search(&ends).is_ok() {
                    creased.extend(ends);
                } else {
                    smooth.push([f, beyond]);
                }
            }
            h = topology.next(h);
        }
    }
    creased.sort_unstable();
    creased.dedup();
    Seam {
        angle: angle(topology, positions, flows, &creased),
        jump: jump(topology, positions, &smooth),
    }
}

fn ordered([a, b]: [VertexId; 2]) -> [VertexId; 2] {
    if a < b { [a, b] } else { [b, a] }
}

/// Either side as if the other were not there.
fn angle(
    topology: &Topology,
    positions: &[DVec3],
    flows: &dyn Fn(FaceId) -> bool,
    vertices: &[VertexId],
) -> Option<f64> {
    let mut faces: Vec<FaceId> = vertices
        .iter()
        .flat_map(|&v| topology.outgoing(v).map(|h| topology.face(h)))
        .filter(|f| f.is_some())
        .collect();
    faces.sort_unstable_by_key(|&f| (flows(f), f));
    faces.dedup();
    let split = faces.partition_point(|&f| !flows(f));
    let side = |faces: &[FaceId]| {
        let triangles: Vec<[u32; 3]> = faces
            .iter()
            .map(|&f| topology.face_vertices(f).map(|v| v.0))
            .collect();
        Topology::from_triangles(positions.len(), &triangles).ok()
    };
    let (outer, inner) = (side(&faces[..split])?, side(&faces[split..])?);
    vertices
        .iter()
        .map(|&v| {
            let [a, b] = [&outer, &inner].map(|side| limit_normal(side, positions, v));
            a.angle_between(b).to_degrees()
        })
        .filter(|angle| angle.is_finite())
        .reduce(f64::max)
}

fn jump(topology: &Topology, positions: &[DVec3], edges: &[[FaceId; 2]]) -> Option<f64> {
    let mut faces: Vec<FaceId> = edges.iter().flatten().copied().collect();
    faces.sort_unstable();
    faces.dedup();
    let local = elements(topology, &faces, Rule::Three);
    let mut mean = vec![f64::NAN; faces.len()];
    for e in 0..local.len() {
        if let Ok(place) = faces.binary_search(&FaceId(local.faces()[e])) {
            mean[place] = mean_curvature(&local, e, positions);
        }
    }
    let of = |f: FaceId| faces.binary_search(&f).map_or(f64::NAN, |i| mean[i]);
    edges
        .iter()
        .map(|&[a, b]| (of(a) - of(b)).abs())
        .filter(|jump| jump.is_finite())
        .reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::icosphere;

    /// A sphere of radius 1 cut at its equator, the upper half scaled by `height`: the halves are
    /// faces below and from `first`.
    fn cut_sphere(height: f64) -> (Topology, Vec<DVec3>, usize, Vec<[VertexId; 2]>) {
        let (mut positions, mut triangles) = icosphere(24);
        let upper = |t: &[u32; 3]| t.iter().map(|&v| positions[v as usize].z).sum::<f64>() > 0.0;
        triangles.sort_by_key(|t| upper(t));
        let first = triangles.partition_point(|t| !upper(t));
        let topology = Topology::from_triangles(positions.len(), &triangles).expect("sphere");
        let mut rim = Vec::new();
        for h in (first..triangles.len()).flat_map(|f| {
            let h = topology.halfedge_of_face(FaceId::from(f));
            [h, topology.next(h), topology.next(topology.next(h))]
        }) {
            if topology.face(h.twin()).index() < first {
                rim.push([topology.target(h), topology.origin(h)]);
            }
        }
        for p in &mut positions {
            if p.z > 0.0 {
                p.z *= height;
            }
        }
        (topology, positions, first, rim)
    }

    #[test]
    fn a_smooth_sphere_has_no_seam_and_a_flat_lid_has_one() {
        let (topology, round, first, rim) = cut_sphere(1.0);
        let smooth = seam(&topology, &round, first, &[], &[]);
        assert_eq!(smooth.angle, None);
        // H = -1 on either side, up to the discretisation: (2 pi / 5 / 24)^2
        assert!(smooth.jump.expect("a rim") < 0.01, "{smooth:?}");
        // ghosts at a jagged rim turn its normals by about an edge, 360 / (5 * 24) degrees
        let creased = seam(&topology, &round, first, &[], &rim);
        assert_eq!(creased.jump, None);
        assert!(creased.angle.expect("a rim") < 6.0, "{creased:?}");

        // the lid flattened to nothing is a disc at right angles to the half sphere
        let (topology, flat, first, rim) = cut_sphere(1e-9);
        let angle = seam(&topology, &flat, first, &[], &rim)
            .angle
            .expect("a rim");
        assert!((80.0..=100.0).contains(&angle), "{angle}");
    }

    #[test]
    fn turning_changes_nothing_and_scaling_what_it_should() {
        let (topology, positions, first, rim) = cut_sphere(0.6);
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
        let moved: Vec<DVec3> = positions.iter().map(|&p| turn * p * 4.0).collect();
        let [a, b] = [&positions, &moved].map(|p| seam(&topology, p, first, &[], &[]));
        let [a, b] = [a.jump.expect("a rim"), b.jump.expect("a rim")];
        assert!((a - 4.0 * b).abs() < 1e-9 * a, "{a} {b}");
        let [a, b] = [&positions, &moved].map(|p| seam(&topology, p, first, &[], &rim));
        let [a, b] = [a.angle.expect("a rim"), b.angle.expect("a rim")];
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
}
