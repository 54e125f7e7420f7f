//! Closed forms, and what must not depend on the frame.

use std::f64::consts::PI;

use super::*;
use crate::mesh::{DVec3, FaceId, HalfedgeId, VertexId};
use crate::shapes::{TriangleMesh, catenoid, cylinder, icosphere, sphere, torus};

pub(super) fn mesh((positions, triangles): TriangleMesh) -> Mesh {
    Mesh::from_triangles(positions, &triangles).expect("manifold")
}

pub(super) fn on_surface(mesh: &Mesh) -> Analysis {
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
    // the integral of |K| is 8 pi; the quadrature on these irregular faces misses it by half a
    // percent
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
    let none = Mesh::from_triangles(vec![DVec3::ONE], &[]).expect("empty");
    let a = on_surface(&none);
    assert_eq!((a.shape.faces, a.shape.euler, a.shape.genus), (0, 0, 0));
    assert!(a.shape.volume.is_none());
    let json = serde_json::to_string(&a).expect("plain data");
    assert!(!json.contains("null,\"area\":null"));
    assert!(vertex_curvatures(&none.topology, &none.positions)[0][0].is_nan());
    assert!(!none.topology.has_faces(VertexId(0)));
}

/// Whether each edge begins where the one before ends.
fn is_path(mesh: &Mesh, edges: &[HalfedgeId]) -> bool {
    let t = &mesh.topology;
    edges.windows(2).all(|w| t.target(w[0]) == t.origin(w[1]))
}

#[test]
fn chains_follow_sharp_edges_or_go_straight() {
    // a drum: its two rims are closed sharp edges
    let n = 12u32;
    let turn = |i: u32, z: f64| {
        let angle = f64::from(i) / f64::from(n) * 2.0 * PI;
        DVec3::new(angle.cos(), angle.sin(), z)
    };
    let mut positions: Vec<DVec3> = (0..n).map(|i| turn(i, 0.0)).collect();
    positions.extend((0..n).map(|i| turn(i, 1.0)));
    positions.extend([DVec3::ZERO, DVec3::Z]);
    let triangles = (0..n)
        .flat_map(|i| {
            let j = (i + 1) % n;
            let [a, b, c, d] = [i, j, n + j, n + i];
            [[a, b, c], [a, c, d], [b, a, 2 * n], [d, c, 2 * n + 1]]
        })
        .collect();
    let drum = mesh((positions, triangles));
    let t = &drum.topology;
    let from = |a: u32, b: u32| {
        let mut out = t.outgoing(VertexId(a));
        out.find(|&h| t.target(h) == VertexId(b)).expect("an edge")
    };
    let sharp = chain_through(&drum, from(n + 3, n + 4), 0.8).expect("inside");
    assert!(sharp.is_crease && is_path(&drum, &sharp.edges));
    assert_eq!(sharp.edges.len(), n as usize);
    let ends = [sharp.edges[0], sharp.edges[n as usize - 1]];
    assert_eq!(t.origin(ends[0]), t.target(ends[1]), "closed");
    let undirected = |edges: &[HalfedgeId]| {
        let mut all: Vec<usize> = edges.iter().map(|h| h.edge()).collect();
        all.sort_unstable();
        all
    };
    // from any edge of it, either way, the same; the lid is flat, the wall nearly so
    let other = chain_through(&drum, from(n + 9, n + 8), 0.8).expect("inside");
    assert_eq!(undirected(&sharp.edges), undirected(&other.edges));
    let report = measure_chain(&drum, &drum.positions, &sharp);
    assert!((report.dihedral.min - 90.0).abs() < 1e-9);
    // the lid's limit surface is flat, the wall's leans in at its open end
    assert!((report.normal_angle.mean - 90.0).abs() < 15.0, "{report:?}");
    let again = measure_chain(&drum, &drum.positions, &other);
    assert!((report.normal_angle.mean - again.normal_angle.mean).abs() < 1e-9);
    let walls = sharp_edges(&drum, 0.8);
    assert_eq!(walls.len(), 2);
    assert_eq!(undirected(&walls[1].edges), undirected(&sharp.edges));

    // straight on over a grid, from one side to the other
    let n = 6u32;
    let positions = (0..=n)
        .flat_map(|j| (0..=n).map(move |i| DVec3::new(f64::from(i), f64::from(j), 0.0)))
        .collect();
    let v = |i: u32, j: u32| j * (n + 1) + i;
    let triangles = (0..n)
        .flat_map(|j| (0..n).map(move |i| (i, j)))
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let grid = mesh((positions, triangles));
    let t = &grid.topology;
    let from = |a: u32, b: u32| {
        let mut out = t.outgoing(VertexId(a));
        out.find(|&h| t.target(h) == VertexId(b)).expect("an edge")
    };
    let row = chain_through(&grid, from(v(2, 3), v(3, 3)), 0.5).expect("inside");
    assert!(!row.is_crease && is_path(&grid, &row.edges));
    assert_eq!(row.edges.len(), n as usize);
    assert!(
        row.edges
            .iter()
            .all(|&h| grid.position(t.origin(h)).y == 3.0)
    );
    assert_eq!(chain_through(&grid, from(v(0, 0), v(1, 0)), 0.5), None);
}

#[test]
fn what_is_no_longer_wanted_ends() {
    let ball = mesh(icosphere(3));
    let options = AnalysisOptions {
        chains: patch_rims(&ball, &upper(&ball), false),
        ..AnalysisOptions::default()
    };
    let asked = std::cell::Cell::new(0);
    let found = analyze_while(&ball, &options, &|done, total| {
        asked.set(asked.get() + 1);
        assert!(done < total);
        done < 3
    });
    assert!(found.is_none());
    assert_eq!(asked.get(), 4);
}

/// Each row has as many fields as the head; the places named are on the surface.
#[test]
fn tables_are_whole() {
    let ball = mesh(icosphere(3));
    let reference = mesh(icosphere(4));
    let options = AnalysisOptions {
        chains: patch_rims(&ball, &upper(&ball), false),
        reference: Some(&reference),
        planes: vec![Plane {
            point: DVec3::ZERO,
            normal: DVec3::Z,
        }],
        ..AnalysisOptions::default()
    };
    let found = analyze(&ball, &options);
    let quality = &found.quality;
    let at = DVec3::from_array(quality.min_angle_at);
    assert!(at.length() > 0.8 && at.length() < 1.0);
    for (csv, rows) in [
        (measures_csv(&found), 0),
        (
            vertices_csv(&ball, Vertices::Control, &found),
            ball.vertex_count(),
        ),
        (
            sections_csv(&found.sections),
            found.sections[0].curves[0].points.len(),
        ),
    ] {
        let mut lines = csv.lines();
        let fields = lines.next().expect("a head").split(',').count();
        let mut count = 0;
        for line in lines {
            // only measures quote
            let mut commas = 0;
            let mut inside = false;
            for c in line.chars() {
                match c {
                    '"' => inside = !inside,
                    ',' if !inside => commas += 1,
                    _ => {}
                }
            }
            assert_eq!(commas + 1, fields, "{line}");
            count += 1;
        }
        assert!(rows == 0 || rows == count);
    }
    let text = report_json("ball", None, &found).expect("plain data");
    let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(value["sections"][0]["curves"][0]["closed"], true);
    assert_eq!(value["chains"][0]["smooth_by_construction"], true);
    assert_eq!(value["input"], "ball");
}
