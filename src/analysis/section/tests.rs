use std::f64::consts::TAU;

use super::*;
use crate::analysis::tests::mesh;
use crate::analysis::{Vertices, control_points};
use crate::mesh::Mesh;
use crate::shapes::{cylinder, icosphere};

fn cut(mesh: &Mesh, point: DVec3, normal: DVec3) -> Section {
    let control = control_points(mesh, Vertices::OnSurface);
    section(&mesh.topology, &control, &Plane { point, normal })
}

/// The worst difference of `f` from 0 over all points.
fn worst(s: &Section, f: impl Fn(&SectionPoint) -> f64) -> f64 {
    let points = s.curves.iter().flat_map(|c| &c.points);
    points.map(|p| f(p).abs()).fold(0.0, f64::max)
}

/// Loop's scheme reproduces quadratic graphs over a regular grid up to a constant, so that the
/// section of a paraboloid is a parabola, of known curvature, exactly.
#[test]
fn a_parabola_has_its_curvature() {
    let (n, a) = (12u32, 0.3);
    let at = |i: u32, j: u32| {
        let (x, y) = (
            f64::from(i) - 6.0 + 0.5 * f64::from(j),
            0.75f64.sqrt() * f64::from(j) - 5.0,
        );
        DVec3::new(x, y, a * (x * x + y * y))
    };
    let positions: Vec<DVec3> = (0..=n)
        .flat_map(|j| (0..=n).map(move |i| at(i, j)))
        .collect();
    let v = |i: u32, j: u32| j * (n + 1) + i;
    let triangles: Vec<[u32; 3]> = (0..n)
        .flat_map(|j| {
            (0..n).flat_map(move |i| {
                [
                    [v(i, j), v(i + 1, j), v(i, j + 1)],
                    [v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)],
                ]
            })
        })
        .collect();
    let topology = Topology::from_triangles(positions.len(), &triangles).expect("a grid");
    let plane = Plane {
        point: DVec3::new(0.3, 0.0, 1.0),
        normal: DVec3::X,
    };
    let s = section(&topology, &positions, &plane);
    assert_eq!(s.curves.len(), 1);
    assert!(!s.curves[0].closed && s.curves[0].points.len() > 40);
    let mut looked_at = 0;
    for p in &s.curves[0].points {
        let [x, y, z] = p.at;
        assert!((x - 0.3).abs() < 1e-13);
        // ghosts reach one ring into the grid
        if y.abs() < 3.0 {
            looked_at += 1;
            let slope = 1.0 + (2.0 * a * y).powi(2);
            // the parabola bends towards the upper side, where the normals are
            let error = p.curvature - 2.0 * a / slope.powf(1.5);
            assert!(error.abs() < 1e-10, "{y}: {error}");
            let error = p.averaged - 2.0 * a / slope.powf(1.5);
            assert!(error.abs() < 0.2, "{y}: {error}");
            let along =
                DVec3::from_array(p.normal) - DVec3::new(0.0, -2.0 * a * y, 1.0) / slope.sqrt();
            assert!(along.length() < 1e-10);
            assert!((z - a * (x * x + y * y)).abs() < 0.2);
        }
    }
    assert!(looked_at > 20);
}

#[test]
fn a_section_of_a_sphere_is_a_circle() {
    let errors = [4, 8].map(|frequency| {
        let ball = mesh(icosphere(frequency));
        let normal = DVec3::new(0.3, -0.5, 0.8).normalize();
        let s = cut(&ball, 0.6 * normal, normal);
        assert_eq!(s.curves.len(), 1);
        let curve = &s.curves[0];
        assert!(curve.closed);
        // counter-clockwise
        let p = |i: usize| DVec3::from_array(curve.points[i].at);
        assert!((p(1) - p(0)).dot(normal.cross(p(0))) > 0.0);
        assert!(worst(&s, |p| DVec3::from_array(p.at).dot(normal) - 0.6) < 1e-13);
        // r = sqrt(1 - 0.6²)
        assert!((curve.length / (0.8 * TAU) - 1.0).abs() < 1e-2);
        let total: f64 = curve.points.iter().map(|p| p.curvature).sum();
        let mean = total / curve.points.len() as f64;
        [
            worst(&s, |p| p.averaged * 0.8 + 1.0),
            (mean * 0.8 + 1.0).abs(),
        ]
    });
    eprintln!("{errors:?}");
    let [[coarse, coarse_mean], [fine, fine_mean]] = errors;
    assert!(coarse < 0.08 && fine < coarse, "{errors:?}");
    assert!(fine_mean < 0.3 * coarse_mean, "{errors:?}");
}

/// A plane through the vertices of valence 5, which has no curvature there, and through edges.
#[test]
fn a_plane_through_vertices_gives_one_curve() {
    let ball = mesh(icosphere(5));
    for normal in [DVec3::X, DVec3::Y, DVec3::Z] {
        let s = cut(&ball, DVec3::ZERO, normal);
        assert_eq!(s.curves.len(), 1, "{normal}");
        assert!(s.curves[0].closed);
        assert!(
            worst(&s, |p| p.averaged + 1.0) < 0.2,
            "{normal} {}",
            worst(&s, |p| p.averaged + 1.0)
        );
        assert!(s.curves[0].length < TAU && s.curves[0].length > 0.99 * TAU);
    }
    let beside = cut(&ball, 2.0 * DVec3::X, DVec3::X);
    assert!(beside.curves.is_empty());
    assert!(cut(&ball, DVec3::ZERO, DVec3::ZERO).curves.is_empty());
}

/// A cylinder of radius r along z, cut at an angle: an ellipse of half-axes r and r / cos.
#[test]
fn an_oblique_section_of_a_cylinder_is_an_ellipse() {
    let radius = 0.5;
    let tube = mesh(cylinder(radius, 4.0, 48, 1));
    let turn = 0.5f64;
    let s = cut(&tube, DVec3::ZERO, DVec3::new(turn.sin(), 0.0, turn.cos()));
    assert_eq!(s.curves.len(), 1);
    assert!(s.curves[0].closed);
    let (a, b) = (radius / turn.cos(), radius);
    let error = worst(&s, |p| {
        let [x, y, z] = p.at;
        let along = x.hypot(z) * x.signum();
        // of x = a cos t, y = b sin t
        let (sin, cos) = (y / b, along / a);
        let expected = a * b / ((a * sin).powi(2) + (b * cos).powi(2)).powf(1.5);
        p.averaged / expected + 1.0
    });
    // measured: 0.026; of the limit surface's own curvature 0.86, at the irregular vertices
    assert!(error < 0.04, "{error}");
}

#[test]
fn turning_and_moving_changes_nothing() {
    let ball = mesh(icosphere(4));
    let (point, normal) = (DVec3::new(0.2, 0.1, 0.3), DVec3::new(0.4, 1.0, -0.2));
    let turn = glam::DQuat::from_axis_angle(DVec3::new(2.0, -1.0, 2.0) / 3.0, 0.8);
    let shift = DVec3::new(30.0, -20.0, 10.0);
    let mut moved = ball.clone();
    for p in &mut moved.positions {
        *p = turn * *p + shift;
    }
    let a = cut(&ball, point, normal);
    let b = cut(&moved, turn * point + shift, turn * normal);
    assert_eq!(a.curves.len(), b.curves.len());
    for (c, d) in a.curves.iter().zip(&b.curves) {
        assert_eq!(c.points.len(), d.points.len());
        assert!((c.length - d.length).abs() < 1e-10);
        for (p, q) in c.points.iter().zip(&d.points) {
            let at = turn * DVec3::from_array(p.at) + shift;
            assert!(at.distance(DVec3::from_array(q.at)) < 1e-10);
            assert!((p.curvature - q.curvature).abs() < 1e-6);
        }
    }
}
