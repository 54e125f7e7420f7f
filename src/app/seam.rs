//! Continuity of a patch and the mesh: measures of the limit surface along the rims.

use crate::analysis::worst_jumps;
use crate::mesh::{DVec3, FaceId, HalfedgeId, Topology, VertexId, edge_flags};

/// The maximum over all rims of two measures, defined as in the continuity report.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seam {
    /// Maximum angle between the normals of the two sides along the G0 rims, in degrees; `None`
    /// without such rims. It is 0 on G1 rims, which lie inside one smooth surface.
    pub angle: Option<f64>,
    /// Maximum difference of the mean curvatures, averaged over the two faces at an edge of a G1
    /// rim, in 1 / length; `None` without such rims.
    pub jump: Option<f64>,
}

/// Measures the rims of the flowing faces: those from `first` on, and `others` in ascending order.
/// `sharp` are the edges of G0 rims.
pub fn seam(
    topology: &Topology,
    positions: &[DVec3],
    first: usize,
    others: &[u32],
    sharp: &[[VertexId; 2]],
) -> Seam {
    let flows = |f: FaceId| f.index() >= first || others.binary_search(&f.0).is_ok();
    let is_rim = |h: &HalfedgeId| {
        let beyond = topology.face(h.twin());
        beyond.is_some() && !flows(beyond)
    };
    let patch = (first..topology.face_count()).map(FaceId::from);
    let flowing = others.iter().copied().map(FaceId).chain(patch);
    let is_sharp = edge_flags(topology, sharp);
    let (creased, smooth): (Vec<_>, Vec<_>) = flowing
        .flat_map(|f| topology.face_halfedges(f))
        .filter(is_rim)
        .partition(|h| is_sharp[h.edge()]);
    Seam {
        angle: worst_jumps(topology, positions, &creased, true).map(|worst| worst.normal_angle),
        jump: worst_jumps(topology, positions, &smooth, false).map(|worst| worst.curvature_step),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{measure_chain, patch_rims};
    use crate::mesh::Mesh;
    use crate::shapes::icosphere;

    /// A unit sphere whose upper half is scaled by `height`. The faces from `first` on are the
    /// upper half.
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
        // H = -1 on both sides up to the discretisation error (2 pi / 5 / 24)^2
        assert!(smooth.jump.expect("a rim") < 0.01, "{smooth:?}");
        // ghost vertices at a jagged rim rotate its normals by about one edge, 360 / (5 * 24)
        // degrees
        let creased = seam(&topology, &round, first, &[], &rim);
        assert_eq!(creased.jump, None);
        assert!(creased.angle.expect("a rim") < 6.0, "{creased:?}");

        // a lid scaled to zero is a disc perpendicular to the half sphere
        let (topology, flat, first, rim) = cut_sphere(1e-9);
        let angle = seam(&topology, &flat, first, &[], &rim)
            .angle
            .expect("a rim");
        assert!((80.0..=100.0).contains(&angle), "{angle}");
    }

    #[test]
    fn the_report_has_the_same_figures() {
        let (topology, positions, first, rim) = cut_sphere(0.6);
        let mesh = Mesh::new(positions, topology);
        let is_patch: Vec<bool> = (0..mesh.face_count()).map(|f| f >= first).collect();
        for sharp in [&rim[..], &[]] {
            let is_crease = !sharp.is_empty();
            let chains = patch_rims(&mesh, &is_patch, is_crease);
            assert_eq!(chains.len(), 1);
            let report = measure_chain(&mesh, &mesh.positions, &chains[0]);
            let found = seam(&mesh.topology, &mesh.positions, first, &[], sharp);
            let angle = is_crease.then_some(report.normal_angle.max);
            let jump = (!is_crease).then_some(report.curvature_step.max);
            assert_eq!(found, Seam { angle, jump });
        }
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
