//! Patches over generated loops.

use super::{Patch, PatchError, PatchOptions, Rim, RimGeometry, blend, fill, fill_excluding};
use crate::mesh::{DVec3, Topology, perimeter, self_intersections};
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
fn check(name: &str, rim: &Rim, patch: &Patch) {
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
    for h in t.edges() {
        let (a, b) = (t.origin(h).0, t.target(h).0);
        assert!(
            !rim.forbidden.contains(&[a.min(b), a.max(b)]),
            "{name}: forbidden edge ({a}, {b})"
        );
    }
}

fn fill_default(rim: &Rim) -> Patch {
    fill(rim, PatchOptions::default()).expect("a sound rim")
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
fn excluded_triangles_are_avoided() {
    for (name, rim) in loops() {
        let n = rim.points.len() as u32;
        let is_excluded = |t: [u32; 3]| t.contains(&1) && n > 5;
        let other = fill_excluding(&rim, PatchOptions::default(), &is_excluded);
        let other = other.expect("a usable rim");
        check(name, &rim, &other.relaxed);
        let flat = other.flat.expect("no edge is forbidden");
        check(name, &rim, &flat);
        // a vertex on the rim alone is a corner of one triangle at least
        let all = fill_excluding(&rim, PatchOptions::default(), &|_| false).expect("usable");
        let at = |patch: &Patch| patch.triangles.iter().filter(|t| t.contains(&1)).count();
        assert!(at(&flat) <= at(&all.flat.expect("flat")), "{name}");
    }
}

#[test]
fn flat_patches_keep_the_shape_of_their_triangulation() {
    // all vertices stay in the plane, and the area is that of the polygon
    let rim = polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0]], 0.25);
    let other = fill_excluding(&rim, PatchOptions::default(), &|_| false).expect("usable");
    let flat = other.flat.expect("no edge is forbidden");
    assert!(flat.new_points().len() > 20);
    let mut area = 0.0;
    for t in &flat.triangles {
        let [a, b, c] = t.map(|v| flat.points[v as usize]);
        let normal = (b - a).cross(c - a);
        assert!(normal.z > 0.0, "a triangle is turned over");
        area += 0.5 * normal.length();
    }
    assert!((area - 8.0).abs() < 1e-9, "{area}");
    assert!(flat.points.iter().all(|p| p.z == 0.0));
    // long rim edges, which cannot be split, do not prevent the end
    let mut rim = rim;
    rim.points.truncate(18);
    rim.opposite.truncate(18);
    let other = fill_excluding(&rim, PatchOptions { density: 4.0 }, &|_| false).expect("usable");
    check(
        "long edge",
        &rim,
        &other.flat.expect("no edge is forbidden"),
    );
}

#[test]
fn intersections_of_a_triangulation_are_avoided_where_possible() {
    for seed in 1..20 {
        let f = f64::from(seed);
        let rim = closed_curve(24, |t| {
            let r = 1.0 + 0.6 * (2.0 * t + f).cos();
            DVec3::new(r * t.cos(), r * t.sin(), 0.9 * (3.0 * t + 1.7 * f).sin())
        });
        let other = fill_excluding(&rim, PatchOptions::default(), &|_| false).expect("usable");
        let flat = other.flat.expect("no edge is forbidden");
        let pairs = self_intersections(&flat.points, &flat.triangles, None, 10);
        assert!(pairs.is_empty(), "{seed}: {pairs:?}");
        assert!(perimeter(&flat.points[..24]) > 6.0);
    }
}

#[test]
fn unusable_rims_are_named() {
    let o = PatchOptions::default();
    let (_, good) = loops().swap_remove(3);
    let mut rim = good.clone();
    rim.points.truncate(2);
    rim.opposite.truncate(2);
    assert_eq!(fill(&rim, o), Err(PatchError::TooFewEdges { edges: 2 }));
    let mut rim = good.clone();
    rim.points[4] = rim.points[3];
    let two = RimGeometry {
        rims: vec![rim, good.clone()],
        ..RimGeometry::default()
    };
    assert_eq!(
        blend(&two, o),
        Err(PatchError::Coincident { index: 3, next: 4 })
    );
    let mut rim = good.clone();
    rim.points[7].y = f64::NAN;
    assert_eq!(fill(&rim, o), Err(PatchError::NotFinite { index: 7 }));
    let line = Rim {
        points: [0.0, 1.0, 3.0, 2.0].map(|x| DVec3::X * x).to_vec(),
        opposite: vec![DVec3::Y; 4],
        forbidden: vec![[1, 3]],
    };
    assert_eq!(fill(&line, o), Err(PatchError::Collinear { edges: 4 }));
    let mut rim = good.clone();
    rim.forbidden.push([5, 4]);
    assert!(matches!(
        fill(&rim, o),
        Err(PatchError::BadForbiddenPair { .. })
    ));
    let options = PatchOptions { density: 0.0 };
    assert!(matches!(
        fill(&good, options),
        Err(PatchError::BadDensity { .. })
    ));
}

/// A closed curve without symmetry, so that no two triangulations are equally good.
fn generic_loop(n: usize) -> Rim {
    closed_curve(n, |t| {
        let r = 1.0 + 0.2 * (2.0 * t + 0.3).sin() + 0.1 * (5.0 * t + 1.1).cos();
        DVec3::new(r * t.cos(), 1.2 * r * t.sin(), 0.15 * (3.0 * t + 0.7).sin())
    })
}

#[test]
fn turned_and_scaled_rims_get_the_same_triangles() {
    let turn = glam::DQuat::from_axis_angle(DVec3::new(2.0, -1.0, 2.0) / 3.0, 0.9);
    for n in [23, 90, 200] {
        let rim = generic_loop(n);
        let patch = fill_default(&rim);
        for (scale, shift) in [(1.0, 0.0), (1000.0, 0.0), (1e-3, 0.0), (1.0, 1e3)] {
            let map = |p: &DVec3| turn * (*p * scale) + DVec3::splat(shift * scale);
            let moved = Rim {
                points: rim.points.iter().map(map).collect(),
                opposite: rim.opposite.iter().map(map).collect(),
                forbidden: Vec::new(),
            };
            let other = fill_default(&moved);
            assert_eq!(patch.triangles, other.triangles, "{n} {scale} {shift}");
            for (p, q) in patch.points.iter().zip(&other.points) {
                assert!(map(p).distance(*q) < 1e-9 * scale);
            }
        }
    }
}

#[test]
fn fills_are_repeatable() {
    for (name, rim) in loops() {
        assert_eq!(fill_default(&rim), fill_default(&rim), "{name}");
    }
}

#[test]
fn large_loops_of_any_shape() {
    // 5,000 edges: a simple projection, and one that overlaps itself everywhere
    let wavy = closed_curve(5000, |t| {
        let r = 1.0 + 0.05 * (60.0 * t).sin();
        DVec3::new(r * t.cos(), r * t.sin(), 0.05 * (40.0 * t).cos())
    });
    let coil = closed_curve(5000, |t| {
        let r = 1.0 + 0.35 * t.cos();
        DVec3::new(r * (2.0 * t).cos(), r * (2.0 * t).sin(), 0.35 * t.sin())
    });
    for (name, rim) in [("wavy", wavy), ("coil", coil)] {
        // coarse, for the sake of the test's time: the interior grows with the density's square
        let patch = fill(&rim, PatchOptions { density: 0.05 }).expect("a sound rim");
        check(name, &rim, &patch);
    }
}

/// Median edge length of the patch's inner edges against the rim's mean, and its least angle in
/// degrees.
fn measure(rim: &Rim, patch: &Patch) -> (f64, f64) {
    let n = rim.points.len();
    let perimeter: f64 = (0..n)
        .map(|i| rim.points[i].distance(rim.points[(i + 1) % n]))
        .sum();
    let mut lengths = Vec::new();
    let mut least = f64::INFINITY;
    for t in &patch.triangles {
        let p = t.map(|v| patch.points[v as usize]);
        for k in 0..3 {
            let (u, v) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            lengths.push(u.length());
            least = least.min(u.angle_between(v));
        }
    }
    lengths.sort_by(f64::total_cmp);
    let median = lengths[lengths.len() / 2];
    (median * n as f64 / perimeter, least.to_degrees())
}

#[test]
fn triangles_have_the_size_of_the_rims_edges() {
    for (name, rim) in loops() {
        if matches!(
            name,
            "triangle" | "square" | "pentagon" | "nearly collinear" | "graded"
        ) {
            continue;
        }
        let (length, angle) = measure(&rim, &fill_default(&rim));
        assert!((0.7..1.1).contains(&length), "{name}: edges {length}");
        assert!(angle > 15.0, "{name}: least angle {angle}");
        let dense = fill(&rim, PatchOptions { density: 2.0 }).expect("a sound rim");
        check(name, &rim, &dense);
        // longer beside the edges of the rim, which stay whole
        let (length, _) = measure(&rim, &dense);
        assert!(
            (0.35..0.75).contains(&length),
            "{name}: dense edges {length}"
        );
    }
}

/// The triangles of a denser patch shrink from the rim inwards: none is thin beside the edges of the rim,
/// which stay whole.
#[test]
fn dense_patches_have_no_thin_triangles() {
    for n in [6, 12, 24, 48, 120] {
        let rim = closed_curve(n, |t| DVec3::new(t.cos(), t.sin(), 0.1 * (2.0 * t).sin()));
        let edge = rim.points[0].distance(rim.points[1]);
        for density in [1.5, 2.5, 4.0] {
            let patch = fill(&rim, PatchOptions { density }).expect("a sound rim");
            check("dense", &rim, &patch);
            let name = format!("{n} edges at density {density}");
            let angle = patch.sharpest_angle();
            assert!(angle > 20.0, "{name}: {angle}");
            // most triangles in the middle have the wanted size
            let middle = patch
                .triangles
                .iter()
                .map(|t| t.map(|v| patch.points[v as usize]));
            let middle = middle.filter(|p| p.iter().all(|p| p.length() < 1.0 - 4.0 * edge));
            let lengths: Vec<f64> = middle.map(|p| p[0].distance(p[1])).collect();
            if lengths.len() > 100 {
                let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
                let wanted = edge / density;
                assert!(
                    (0.75..1.15).contains(&(mean / wanted)),
                    "{name}: {}",
                    mean / wanted
                );
            }
        }
    }
}

#[test]
fn sizes_grade_between_places_of_different_density() {
    let rim = closed_curve(240, |t| {
        // eight times as dense at t = 0 as at t = π
        let s = t - 0.77 * t.sin();
        DVec3::new(s.cos(), s.sin(), 0.0)
    });
    let patch = fill_default(&rim);
    check("graded", &rim, &patch);
    for t in &patch.triangles {
        let p = t.map(|v| patch.points[v as usize]);
        let sides = [0, 1, 2].map(|k| p[k].distance(p[(k + 1) % 3]));
        let longest = sides.iter().copied().fold(0.0, f64::max);
        let shortest = sides.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(longest < 3.5 * shortest, "{p:?}");
    }
}

#[test]
fn a_missing_cap_bulges() {
    // the rim of a cap of half-angle 60° of the unit sphere, its faces on the sphere
    let (alpha, n) = (60.0f64.to_radians(), 96u32);
    let at = |t: f64, a: f64| DVec3::new(a.sin() * t.cos(), a.sin() * t.sin(), a.cos());
    let step = TAU / f64::from(n);
    let rim = Rim {
        points: (0..n).map(|i| at(step * f64::from(i), alpha)).collect(),
        opposite: (0..n)
            .map(|i| at(step * (f64::from(i) + 0.5), alpha + 0.05))
            .collect(),
        forbidden: Vec::new(),
    };
    let patch = fill_default(&rim);
    check("cap", &rim, &patch);
    // near the sphere; the flat start is 0.5 away
    let worst = patch
        .points
        .iter()
        .map(|p| (p.length() - 1.0).abs())
        .fold(0.0, f64::max);
    assert!(worst < 0.05, "{worst}");
}

#[test]
fn tangled_loops_get_a_disc_or_an_error() {
    // random points: loops that cross themselves, touch themselves, lie in a plane or nearly on a
    // line, with edges that differ by a factor of a thousand
    let mut state = 7u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1u32 << 24) - 0.5
    };
    for round in 0..300 {
        let n = 3 + round % 60;
        let flatness = [1.0, 0.0, 1e-9][round % 3];
        let width = [1.0, 1.0, 1.0, 1e-6, 0.0][round % 5];
        let mut points: Vec<DVec3> = (0..n)
            .map(|_| DVec3::new(random(), width * random(), flatness * random()))
            .collect();
        if round % 4 == 0 && n > 6 {
            points[4] = points[1];
            points[2] = points[1] + (points[2] - points[1]) * 1e-3;
        }
        let opposite = (0..n)
            .map(|_| DVec3::new(random(), random(), random()))
            .collect();
        let rim = Rim {
            points,
            opposite,
            forbidden: Vec::new(),
        };
        match fill(&rim, PatchOptions::default()) {
            Ok(patch) => check(&format!("round {round}"), &rim, &patch),
            Err(error) => assert!(width * flatness < 1e-3, "round {round}: {error}"),
        }
    }
}

/// A rim of 2,000 edges would get half a million vertices of its own density.
#[test]
fn triangles_grow_inside_long_rims() {
    let n = 2000;
    let rim = closed_curve(n, |t| DVec3::new(t.cos(), t.sin(), 0.1 * (3.0 * t).cos()));
    let patch = fill(&rim, PatchOptions::default()).expect("a patch");
    let count = patch.new_points().len();
    // near the limit of 100,000
    assert!((50_000..140_000).contains(&count), "{count}");
    let edge = TAU / n as f64;
    let (mut at_rim, mut inside) = (0.0f64, 0.0f64);
    for t in &patch.triangles {
        let [a, b, c] = t.map(|v| patch.points[v as usize]);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        if a.truncate().length() > 1.0 - 2.0 * edge {
            at_rim = at_rim.max(longest);
        } else if a.truncate().length() < 0.2 {
            inside = inside.max(longest);
        }
    }
    assert!(at_rim < 2.5 * edge, "{}", at_rim / edge);
    assert!(inside > 3.0 * edge, "{}", inside / edge);
    assert!(patch.sharpest_angle() > 10.0, "{}", patch.sharpest_angle());
}

#[test]
fn a_patch_beyond_all_memory_is_refused() {
    let rim = closed_curve(200, |t| DVec3::new(t.cos(), t.sin(), 0.0));
    let error = fill(&rim, PatchOptions { density: 1e6 });
    assert!(cfg!(not(target_os = "linux")) || matches!(error, Err(PatchError::Memory(_))));
}
