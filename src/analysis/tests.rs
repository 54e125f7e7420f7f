//! Closed forms, and what must not depend on the frame.

use std::f64::consts::PI;

use super::*;
use crate::mesh::shapes::{Shape, catenoid, cylinder, icosphere, sphere, torus};
use crate::mesh::{DVec3, FaceId, Topology, VertexId};

fn mesh((positions, triangles): Shape) -> Mesh {
    let topology = Topology::from_triangles(positions.len(), &triangles).expect("manifold");
    Mesh::new(positions, topology)
}

fn on_surface(mesh: &Mesh) -> Analysis {
    let options = AnalysisOptions {
        vertices: Vertices::OnSurface,
        ..AnalysisOptions::default()
    };
    analyze(mesh, &options)
}

#[test]
fn a_sphere_s_integrals_converge() {
    let errors = [4, 8].map(|frequency| {
        let s = on_surface(&mesh(icosphere(frequency))).shape;
        assert_eq!(
            (s.euler, s.genus, s.components, s.boundary_loops),
            (2, 0, 1, 0)
        );
        [
            s.area / (4.0 * PI) - 1.0,
            s.volume.expect("closed") / (4.0 / 3.0 * PI) - 1.0,
            s.energies.willmore / (4.0 * PI) - 1.0,
        ]
    });
    for (coarse, fine) in errors[0].iter().zip(&errors[1]) {
        assert!(
            fine.abs() < 1e-3 && fine.abs() < 0.5 * coarse.abs(),
            "{coarse} {fine}"
        );
    }
}

#[test]
fn total_curvature_is_topological() {
    let ring = on_surface(&mesh(torus(2.0, 0.8, 600, 1))).shape;
    assert_eq!((ring.euler, ring.genus), (0, 1));
    // the integral of |K| is 8 pi; the quadrature on these irregular faces misses it by half a percent
    let missed = ring.energies.total_curvature.abs() / (8.0 * PI);
    assert!(missed < 0.01, "{missed}");
    let ball = on_surface(&mesh(sphere(400, 2))).shape;
    assert!((ball.energies.total_curvature / (4.0 * PI) - 1.0).abs() < 5e-3);
}

#[test]
fn curvatures_of_known_surfaces() {
    let tube = on_surface(&mesh(cylinder(0.5, 2.0, 40, 1))).curvature;
    assert!(
        (tube.mean.average + 1.0).abs() < 0.02,
        "{}",
        tube.mean.average
    );
    assert!(tube.gauss.average.abs() < 0.05);
    assert!((tube.k2.average + 2.0).abs() < 0.05 && tube.k1.average.abs() < 0.05);
    let neck = on_surface(&mesh(catenoid(0.5, 0.6, 48, 1))).curvature;
    // principal curvatures are up to 2; measured: 0.023
    assert!(neck.mean.average.abs() < 0.03, "{}", neck.mean.average);
    let share: f64 = neck.mean.histogram.share.iter().sum();
    assert!((share - 1.0).abs() < 1e-12);
}

#[test]
fn nothing_depends_on_the_frame() {
    let plain = mesh(sphere(200, 3));
    let turn = glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -2.0) / 3.0, 1.1);
    let mut moved = plain.clone();
    for p in &mut moved.positions {
        *p = turn * (2.0 * *p) + DVec3::splat(100.0);
    }
    let (a, b) = (on_surface(&plain), on_surface(&moved));
    assert!((b.shape.area / a.shape.area - 4.0).abs() < 1e-10);
    let volumes = (
        a.shape.volume.expect("closed"),
        b.shape.volume.expect("closed"),
    );
    assert!((volumes.1 / volumes.0 - 8.0).abs() < 1e-9);
    let energies = (a.shape.energies.willmore, b.shape.energies.willmore);
    assert!((energies.0 - energies.1).abs() < 1e-8 * energies.0);
    assert!((a.quality.min_angle - b.quality.min_angle).abs() < 1e-9);
}

/// Faces of the upper half.
fn upper(mesh: &Mesh) -> Vec<bool> {
    (0..mesh.face_count())
        .map(|f| {
            mesh.corners(FaceId::from(f))
                .iter()
                .map(|p| p.z)
                .sum::<f64>()
                > 0.0
        })
        .collect()
}

#[test]
fn a_smooth_rim_is_smooth_and_a_crease_is_not() {
    let ball = mesh(icosphere(6));
    let half = upper(&ball);
    let smooth = patch_rims(&ball, &half, false);
    assert_eq!(smooth.len(), 1);
    let report = measure_chain(&ball, &ball.positions, &smooth[0]);
    assert!(report.smooth_by_construction && report.edges > 20);
    assert!(report.gap.max < 1e-14 && report.normal_angle.max < 1e-5);
    assert!(report.dihedral.max > 5.0);

    // the upper half squeezed to half its height meets the lower one at the equator in an angle
    let mut kinked = ball.clone();
    for p in &mut kinked.positions {
        if p.z > 0.0 {
            p.z = 0.0;
        }
    }
    let crease = patch_rims(&kinked, &half, true);
    let one_sided = measure_chain(&kinked, &kinked.positions, &crease[0]);
    assert!(one_sided.is_crease);
    assert!(
        one_sided.normal_angle.mean > 30.0,
        "{:?}",
        one_sided.normal_angle
    );
}

#[test]
fn sharp_edges_of_a_cube() {
    let corners: Vec<DVec3> = (0..8)
        .map(|i| DVec3::new(f64::from(i & 1), f64::from((i >> 1) & 1), f64::from(i >> 2)))
        .collect();
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles = quads
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    let cube = mesh((corners, triangles));
    let chains = sharp_edges(&cube, 1.0);
    assert_eq!(chains.len(), 1);
    assert_eq!(chains[0].edges.len(), 12);
    let report = measure_chain(&cube, &cube.positions, &chains[0]);
    assert!(report.is_crease);
    // each side is flat, so its normals are those of the faces
    assert!(
        (report.normal_angle.min - 90.0).abs() < 1e-9,
        "{:?}",
        report.normal_angle
    );
    assert!((report.dihedral.max - 90.0).abs() < 1e-9);
}

#[test]
fn an_isolated_vertex_and_no_triangle_are_fine() {
    let none = Mesh::new(
        vec![DVec3::ONE],
        Topology::from_triangles(1, &[]).expect("empty"),
    );
    let a = on_surface(&none);
    assert_eq!((a.shape.faces, a.shape.euler, a.shape.genus), (0, 0, 0));
    assert!(a.shape.volume.is_none());
    let json = serde_json::to_string(&a).expect("plain data");
    assert!(!json.contains("null,\"area\":null"));
    assert!(vertex_curvatures(&none.topology, &none.positions)[0][0].is_nan());
    assert!(!none.topology.halfedge_of_vertex(VertexId(0)).is_some());
}
