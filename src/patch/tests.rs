//! Patches over generated loops.

use super::{PatchError, PatchMesh, PatchOptions, Rim, fill};
use crate::mesh::{DVec3, HalfedgeId, Topology};
use std::f64::consts::TAU;

/// A rim whose existing faces continue outwards, away from the loop's mean.
fn rim_of(points: Vec<DVec3>) -> Rim {
    let n = points.len();
    let centre = points.iter().sum::<DVec3>() / n as f64;
    let opposite = (0..n)
        .map(|i| {
            let (a, b) = (points[i], points[(i + 1) % n]);
            let middle = a.midpoint(b);
            middle + (middle - centre).normalize_or(DVec3::X) * a.distance(b)
        })
        .collect();
    Rim {
        points,
        opposite,
        forbidden: Vec::new(),
    }
}

fn closed_curve(n: usize, f: impl Fn(f64) -> DVec3) -> Rim {
    rim_of((0..n).map(|i| f(TAU * i as f64 / n as f64)).collect())
}

fn polygon(corners: &[[f64; 2]], step: f64) -> Rim {
    let mut points = Vec::new();
    for (i, &[x, y]) in corners.iter().enumerate() {
        let a = DVec3::new(x, y, 0.0);
        let [x, y] = corners[(i + 1) % corners.len()];
        let b = DVec3::new(x, y, 0.0);
        let pieces = (a.distance(b) / step).round() as i32;
        points.extend((0..pieces).map(|k| a.lerp(b, f64::from(k) / f64::from(pieces))));
    }
    rim_of(points)
}

/// The loops every test runs over.
fn loops() -> Vec<(&'static str, Rim)> {
    let circle = |n| closed_curve(n, |t| DVec3::new(t.cos(), t.sin(), 0.0));
    vec![
        ("triangle", circle(3)),
        ("square", circle(4)),
        ("pentagon", circle(5)),
        ("circle", circle(61)),
        (
            "ellipse",
            closed_curve(40, |t| DVec3::new(3.0 * t.cos(), t.sin(), 0.0)),
        ),
        (
            "saddle",
            closed_curve(80, |t| DVec3::new(t.cos(), t.sin(), 0.7 * (2.0 * t).cos())),
        ),
        (
            "deep saddle",
            closed_curve(120, |t| DVec3::new(t.cos(), t.sin(), 3.0 * (2.0 * t).cos())),
        ),
        (
            "star",
            closed_curve(100, |t| {
                let r = 1.0 + 0.6 * (5.0 * t).cos();
                DVec3::new(r * t.cos(), r * t.sin(), 0.0)
            }),
        ),
        (
            "zigzag",
            closed_curve(90, |t| {
                let k = (t / TAU * 90.0).round();
                let r = 1.0 + 0.05 * (k % 2.0);
                DVec3::new(r * t.cos(), r * t.sin(), 0.03 * (k % 3.0))
            }),
        ),
        (
            "knotted outline",
            // a curve that overlaps itself in every projection: two turns of a helix
            closed_curve(120, |t| {
                let r = 1.0 + 0.35 * t.cos();
                DVec3::new(r * (2.0 * t).cos(), r * (2.0 * t).sin(), 0.35 * t.sin())
            }),
        ),
        (
            "L",
            polygon(
                &[[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]],
                0.08,
            ),
        ),
        (
            "spiral",
            polygon(
                &[
                    [0., 0.],
                    [5., 0.],
                    [5., 5.],
                    [1., 5.],
                    [1., 2.],
                    [3., 2.],
                    [3., 3.],
                    [2., 3.],
                    [2., 4.],
                    [4., 4.],
                    [4., 1.],
                    [0., 1.],
                ],
                0.25,
            ),
        ),
        (
            "nearly collinear",
            closed_curve(30, |t| DVec3::new(t.cos(), 1e-5 * t.sin(), 0.0)),
        ),
        (
            "graded",
            rim_of(
                (0..60)
                    .map(|i| {
                        let x = f64::from(i) / 60.0;
                        let t = TAU * (x + 0.12 * (TAU * x).sin());
                        DVec3::new(t.cos(), t.sin(), 0.2 * (3.0 * t).sin())
                    })
                    .collect(),
            ),
        ),
    ]
}

/// The patch is an oriented disc with exactly the rim, unchanged, as its boundary.
fn check(name: &str, rim: &Rim, patch: &PatchMesh) {
    let n = rim.points.len();
    assert_eq!(patch.points[..n], rim.points[..], "{name}: rim moved");
    assert!(patch.points.iter().all(|p| p.is_finite()), "{name}");
    let t = Topology::from_triangles(patch.points.len(), &patch.triangles)
        .unwrap_or_else(|e| panic!("{name}: {e}"));
    let euler = t.vertex_count() + t.face_count();
    assert_eq!(euler, t.halfedge_count() / 2 + 1, "{name}: not a disc");
    let boundary = t.boundary_loops();
    assert_eq!(boundary.len(), 1, "{name}: boundary loops");
    assert_eq!(boundary[0].len(), n, "{name}: boundary length");
    for &h in &boundary[0] {
        let (from, to) = (t.origin(h).index(), t.target(h).index());
        assert_eq!(from, (to + 1) % n, "{name}: rim order");
    }
    for h in (0..t.halfedge_count()).step_by(2).map(HalfedgeId::from) {
        let (a, b) = (t.origin(h).0, t.target(h).0);
        assert!(
            !rim.forbidden.contains(&[a.min(b), a.max(b)]),
            "{name}: forbidden edge ({a}, {b})"
        );
    }
}

fn fill_default(rim: &Rim) -> PatchMesh {
    fill(rim, &PatchOptions::default()).expect("a sound rim")
}

#[test]
fn every_loop_gets_a_disc() {
    for (name, rim) in loops() {
        check(name, &rim, &fill_default(&rim));
    }
}

#[test]
fn three_edges_make_one_face() {
    let (_, rim) = loops().swap_remove(0);
    assert_eq!(fill_default(&rim).triangles, [[0, 1, 2]]);
}

#[test]
fn forbidden_edges_are_avoided() {
    // both diagonals of the square, and every second chord of the others
    for (name, mut rim) in loops() {
        let n = rim.points.len() as u32;
        for i in 0..n {
            for j in i + 2..n {
                if (i, j) != (0, n - 1) && (n == 4 || (i + j) % 2 == 0) {
                    rim.forbidden.push([i, j]);
                }
            }
        }
        check(name, &rim, &fill_default(&rim));
    }
}

#[test]
fn unusable_rims_are_named() {
    let o = PatchOptions::default();
    let (_, good) = loops().swap_remove(3);
    let mut rim = good.clone();
    rim.points.truncate(2);
    rim.opposite.truncate(2);
    assert_eq!(fill(&rim, &o), Err(PatchError::TooFewEdges { edges: 2 }));
    let mut rim = good.clone();
    rim.points[4] = rim.points[3];
    assert_eq!(
        fill(&rim, &o),
        Err(PatchError::Coincident { index: 3, next: 4 })
    );
    let mut rim = good.clone();
    rim.points[7].y = f64::NAN;
    assert_eq!(fill(&rim, &o), Err(PatchError::NotFinite { index: 7 }));
    let line = closed_curve(12, |t| DVec3::new(1.0, 2.0, 3.0) * t.cos());
    assert!(matches!(
        fill(&line, &o),
        Err(PatchError::Collinear { .. } | PatchError::Coincident { .. })
    ));
    let mut rim = good.clone();
    rim.forbidden.push([5, 4]);
    assert!(matches!(
        fill(&rim, &o),
        Err(PatchError::BadForbiddenPair { .. })
    ));
    let options = PatchOptions { density: 0.0 };
    assert!(matches!(
        fill(&good, &options),
        Err(PatchError::BadDensity { .. })
    ));
}
