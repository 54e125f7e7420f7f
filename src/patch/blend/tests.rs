//! Patches over several generated rims.

use std::f64::consts::TAU;

use super::curve::RimCurve;
use super::loft::{loft_candidates, loft_surface};
use super::spine::{Cubic, Spine};
use super::{bending, blend, bridges, layout, lofted_candidates, reblend};
use crate::mesh::{DVec3, Mesh, Topology, check_mesh, self_intersections};
use crate::patch::surface::Surface;
use crate::patch::{Patch, PatchError, PatchOptions, Rim, RimGeometry};
use crate::random::SplitMix;

/// The mouth of a round tube that goes away along `axis`, its faces looking outwards.
fn mouth(centre: DVec3, axis: DVec3, radius: f64, n: usize) -> Rim {
    let axis = axis.normalize();
    let u = axis.any_orthonormal_vector();
    let v = axis.cross(u);
    let points: Vec<DVec3> = (0..n)
        .map(|i| {
            let (sin, cos) = (TAU * i as f64 / n as f64).sin_cos();
            centre + radius * (cos * u - sin * v)
        })
        .collect();
    let edge = TAU * radius / n as f64;
    let opposite = (0..n)
        .map(|i| points[i].midpoint(points[(i + 1) % n]) + edge * axis)
        .collect();
    Rim {
        points,
        opposite,
        forbidden: Vec::new(),
    }
}

/// The rim of a round hole in a plane that looks along `normal`, or of a round island in it.
fn flat(centre: DVec3, normal: DVec3, radius: f64, n: usize, island: bool) -> Rim {
    let mut rim = mouth(centre, if island { normal } else { -normal }, radius, n);
    let outwards = if island { -1.0 } else { 1.0 };
    for i in 0..n {
        let middle = rim.points[i].midpoint(rim.points[(i + 1) % n]);
        let step = (middle - centre) * (outwards / radius) * (TAU * radius / n as f64);
        rim.opposite[i] = middle + step;
    }
    rim
}

fn gap(rims: Vec<Rim>) -> RimGeometry {
    RimGeometry {
        forbidden: Vec::new(),
        pieces: (0..rims.len() as u32).collect(),
        rims,
    }
}

const O: DVec3 = DVec3::ZERO;
const X: DVec3 = DVec3::X;
const Y: DVec3 = DVec3::Y;
const Z: DVec3 = DVec3::Z;

/// Configurations that can be joined without a self-intersection.
fn joinable() -> Vec<(&'static str, RimGeometry)> {
    let three = [O, X, Y].map(|at| flat(0.3 * at - 0.1 * (X + Y), Z, 0.1, 9, true));
    let mut islands = three.to_vec();
    islands.push(flat(O, Z, 1.0, 50, false));
    vec![
        (
            "tubes",
            gap(vec![mouth(X, X, 0.5, 32), mouth(-X, -X, 0.5, 32)]),
        ),
        (
            "two radii",
            gap(vec![mouth(Z, Z, 0.2, 12), mouth(O, -Z, 2.0, 70)]),
        ),
        (
            "corner",
            gap(vec![mouth(X, X, 0.5, 24), mouth(Y, Y, 0.45, 37)]),
        ),
        (
            "side by side",
            gap(vec![mouth(X, Z, 0.5, 24), mouth(-X, Z, 0.5, 20)]),
        ),
        (
            "six axes",
            gap([X, -X, Y, -Y, Z, -Z]
                .map(|d| mouth(d, d, 0.45, 28))
                .to_vec()),
        ),
        (
            "tube onto plane",
            gap(vec![
                mouth(0.6 * Z, Z, 0.4, 32),
                flat(O, Z, 0.75, 60, false),
            ]),
        ),
        (
            "thin ring",
            gap(vec![flat(O, Z, 1.0, 60, false), flat(O, Z, 0.9, 54, true)]),
        ),
        ("islands", gap(islands)),
        (
            "triangles",
            gap(vec![mouth(X, X, 0.5, 3), mouth(-X, -X, 0.5, 3)]),
        ),
    ]
}

/// Checks that the patch is a sphere with the gap's rims as holes.
fn check(name: &str, gap: &RimGeometry, patch: &Patch) -> Topology {
    let rims: Vec<DVec3> = gap.rims.iter().flat_map(|r| r.points.clone()).collect();
    assert_eq!(patch.points[..rims.len()], rims, "{name}");
    let topology = Topology::from_triangles(patch.points.len(), &patch.triangles)
        .unwrap_or_else(|e| panic!("{name}: {e}"));
    check_mesh(&Mesh::new(patch.points.clone(), topology.clone()))
        .unwrap_or_else(|e| panic!("{name}: {e}"));
    let edges = topology.halfedge_count() / 2;
    let euler = patch.points.len() + patch.triangles.len() + gap.rims.len();
    assert_eq!(euler, edges + 2, "{name}");
    let mut first = 0;
    for rim in &gap.rims {
        let n = rim.points.len();
        for i in 0..n {
            let (a, b) = ((first + i) as u32, (first + (i + 1) % n) as u32);
            let has = |t: &[u32; 3]| (0..3).any(|k| t[k] == a && t[(k + 1) % 3] == b);
            assert_eq!(
                patch.triangles.iter().filter(|t| has(t)).count(),
                1,
                "{name}"
            );
        }
        first += n;
    }
    topology
}

#[test]
fn rims_are_joined_by_a_sphere_with_holes() {
    for (name, gap) in joinable() {
        for density in [0.6, 1.0, 2.0] {
            let patch = blend(&gap, PatchOptions { density }).expect(name);
            check(name, &gap, &patch);
            if name == "side by side" {
                // in one plane, and the patch has to go around both: flat, and folded over
                continue;
            }
            let cuts = self_intersections(&patch.points, &patch.triangles, None, 1);
            assert!(cuts.is_empty(), "{name} {density}");
        }
    }
}

#[test]
fn all_of_them_are_seen_from_somewhere() {
    for (name, gap) in joinable() {
        assert!(layout::triangulate(&gap.rims).is_some(), "{name}");
    }
}

/// The patch along bridges alone.
fn bridged(gap: &RimGeometry) -> Patch {
    let mut surface: Surface = bridges::surface(&gap.rims, &[]);
    super::split_double_edges(&mut surface);
    surface.compact()
}

#[test]
fn bridges_do_it_as_well() {
    for (name, gap) in joinable() {
        check(name, &gap, &bridged(&gap));
    }
}

#[test]
fn between_equal_circles_bridges_find_the_cylinder() {
    // the least area without twist: 2 n triangles of a prism
    let (n, height) = (24, 0.4);
    let gap = gap(vec![mouth(O, -Z, 1.0, n), mouth(height * Z, Z, 1.0, n)]);
    let side = 2.0 * (TAU / (2 * n) as f64).sin();
    for patch in [bridged(&gap), {
        let triangles = layout::triangulate(&gap.rims).expect("seen");
        let points = gap.points().collect();
        Patch {
            rim: 2 * n,
            points,
            triangles,
        }
    }] {
        let area: f64 = patch
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| patch.points[v as usize]);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum();
        let prism = n as f64 * side * height;
        assert!((area / prism - 1.0).abs() < 0.02, "{area} {prism}");
    }
}

#[test]
fn any_rims_whatever_get_a_manifold_patch() {
    let mut random = SplitMix::new(3);
    for round in 0..12 {
        let rims = (0..2 + round % 4)
            .map(|_| {
                let centre = random.direction() * random.range(0.0, 1.5);
                let n = 3 + random.below(25);
                mouth(centre, random.direction(), random.range(0.2, 0.8), n)
            })
            .collect();
        let mut gap = gap(rims);
        check("bridged", &gap, &bridged(&gap));
        // one component: it cannot be flipped relative to itself
        gap.pieces.fill(0);
        match blend(&gap, PatchOptions::default()) {
            Ok(patch) => {
                check("random", &gap, &patch);
            }
            Err(error) => assert!(matches!(error, PatchError::OneSided { .. }), "{error}"),
        }
    }
}

/// More rims than a number has bits.
#[test]
fn many_rims_of_which_one_is_inside_out_are_refused_or_joined() {
    let turn = TAU * 0.618_034;
    let tubes = (0..70).map(|k| {
        let z = 1.0 - (2.0 * f64::from(k) + 1.0) / 70.0;
        let (sin, cos) = (turn * f64::from(k)).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let direction = DVec3::new(r * cos, r * sin, z);
        mouth(direction, direction, 0.1, 6)
    });
    let mut gap = gap(tubes.collect());
    gap.rims[69].points.reverse();
    for pieces in [(0..70).collect(), vec![0; 70]] {
        gap.pieces = pieces;
        match blend(&gap, PatchOptions::default()) {
            Ok(patch) => {
                check("one inside out", &gap, &patch);
            }
            Err(error) => {
                let rim = match error {
                    PatchError::InsideOut { rim } | PatchError::OneSided { rim } => rim,
                    other => panic!("{other}"),
                };
                assert!(rim < 70);
            }
        }
    }
}

#[test]
fn a_piece_inside_out_is_named() {
    let outwards = mouth(-X, -X, 0.5, 32);
    let mut inwards = mouth(X, X, 0.5, 30);
    inwards.points.reverse();
    let mut gap = gap(vec![outwards.clone(), inwards.clone()]);
    let error = |gap: &RimGeometry| blend(gap, PatchOptions::default()).err();
    assert_eq!(error(&gap), Some(PatchError::InsideOut { rim: 1 }));
    gap.pieces.fill(5);
    assert_eq!(error(&gap), Some(PatchError::OneSided { rim: 1 }));
    // it is valid if all components are flipped
    gap.rims[0].points.reverse();
    assert_eq!(error(&gap), None);
}

#[test]
fn rims_that_meet_are_refused() {
    let gap = gap(vec![mouth(X, X, 1.0, 8), mouth(X, X, 1.0, 8)]);
    let error = blend(&gap, PatchOptions::default());
    assert!(matches!(
        error,
        Err(PatchError::RimsTouch { rims: [0, 1], .. })
    ));
}

#[test]
fn turning_and_scaling_changes_nothing_else() {
    let turn = glam::DQuat::from_axis_angle(DVec3::new(2.0, 1.0, -2.0) / 3.0, 0.7);
    let map = |p: DVec3| turn * (1e-3 * p) + DVec3::new(0.5, -0.25, 0.125);
    let unmap = |p: DVec3| turn.inverse() * (p - DVec3::new(0.5, -0.25, 0.125)) * 1e3;
    // unequal ones, so that rounding has no tie to break
    let plain = gap(vec![mouth(X, X, 0.5, 31), mouth(Y + 0.1 * Z, Y, 0.4, 22)]);
    let mut mapped = plain.clone();
    for rim in &mut mapped.rims {
        for p in rim.points.iter_mut().chain(&mut rim.opposite) {
            *p = map(*p);
        }
    }
    let one = blend(&plain, PatchOptions::default()).expect("a patch");
    let two = blend(&mapped, PatchOptions::default()).expect("a patch");
    assert_eq!(one.triangles, two.triangles);
    for (p, q) in one.points.iter().zip(&two.points) {
        assert!(p.distance(unmap(*q)) < 1e-9);
    }
}

#[test]
fn vertices_are_graded_from_rim_to_rim() {
    let gap = gap(vec![mouth(O, -Z, 0.5, 16), mouth(2.0 * Z, Z, 0.5, 64)]);
    let patch = blend(&gap, PatchOptions::default()).expect("a patch");
    let mean_edge = |low: f64, high: f64| {
        let (mut sum, mut count) = (0.0, 0);
        for t in &patch.triangles {
            for k in 0..3 {
                let [a, b] = [t[k], t[(k + 1) % 3]].map(|v| patch.points[v as usize]);
                if (low..high).contains(&a.midpoint(b).z) {
                    sum += a.distance(b);
                    count += 1;
                }
            }
        }
        sum / f64::from(count)
    };
    let thirds = [(0.0, 0.5), (0.75, 1.25), (1.5, 2.0)].map(|(a, b)| mean_edge(a, b));
    assert!(
        thirds[0] > 1.3 * thirds[1] && thirds[1] > 1.3 * thirds[2],
        "{thirds:?}"
    );
}

#[test]
fn cubics_follow_arcs_and_their_frames_do_not_twist() {
    let quarter = Cubic::turning(X, Y, Y, -X, 1.0);
    let spine = Spine::new(quarter);
    for i in 0..=20 {
        let t = f64::from(i) / 20.0;
        let p = quarter.at(t);
        assert!((p.length() - 1.0).abs() < 3e-4, "{p}");
        let step = 1e-6;
        let slope = (quarter.at(t + step) - quarter.at(t - step)) / (2.0 * step);
        assert!(slope.distance(quarter.slope(t)) < 1e-8);
        // a plane curve turns about the plane's normal, and its frames as far as its tangent
        let frame = spine.frame(t);
        assert!((frame * Z).distance(Z) < 1e-12);
        assert!((frame * Y).distance(quarter.slope(t).normalize()) < 1e-3);
        assert!((frame.determinant() - 1.0).abs() < 1e-12);
    }
    let rate = quarter.turning_rate(0.0);
    assert!(rate.cross(Z).length() < 1e-12 && rate.z > 0.0);
}

#[test]
fn the_direction_of_a_rim_is_found() {
    let tube = RimCurve::new(&mouth(X, X, 0.5, 32));
    assert!(tube.axis(1.0).distance(-X) < 1e-9);
    assert_eq!(tube.side(), RimCurve::new(&mouth(-Z, -Z, 0.3, 20)).side());
    assert!(tube.centre.distance(X) < 1e-12 && (tube.radius - 0.5).abs() < 1e-12);
    // a hole in a plane leads nowhere by itself
    let hole = RimCurve::new(&flat(O, Z, 1.0, 40, false));
    assert_eq!(hole.side(), 0.0);
    assert!(hole.axis(1.0).distance(Z) < 1e-12 && hole.axis(-1.0).distance(-Z) < 1e-12);
    let point = hole.at(0.3);
    assert!(((point.smooth + point.rest).length() - 1.0).abs() < 1e-2);
    assert!(point.conormal.distance(-point.smooth.normalize()) < 0.01);
    // raggedness is set apart, the shape is not
    let mut ragged = mouth(O, Z, 1.0, 40);
    for (i, p) in ragged.points.iter_mut().enumerate() {
        *p += if i % 2 == 0 { 0.05 * Z } else { -0.05 * Z };
    }
    let curve = RimCurve::new(&ragged);
    for i in 0..40 {
        let at = curve.at(curve.place[i] + 1e-12);
        assert!((at.smooth + at.rest).distance(ragged.points[i]) < 1e-9);
        assert!(at.smooth.z.abs() < 0.005 && (at.smooth.length() - 1.0).abs() < 0.01);
    }
}

#[test]
fn bending_is_that_of_the_cylinder_and_the_sphere() {
    // ∫ 6 H² over a cylinder of length l is 3π l / r
    let bends = |n: usize| {
        let gap = gap(vec![mouth(O, -Z, 0.5, n), mouth(2.0 * Z, Z, 0.5, n)]);
        let (a, b) = (RimCurve::new(&gap.rims[0]), RimCurve::new(&gap.rims[1]));
        let way = &loft_candidates(&a, &b, a.side())[0];
        let size = TAU * 0.5 / n as f64;
        let sheet = loft_surface([&a, &b], way, [size, size]);
        for p in &sheet.points {
            assert!((p.truncate().length() - 0.5).abs() < 2e-3, "{n} {p}");
        }
        bending(&sheet.points, &sheet.triangles)
    };
    let exact = 1.5 * TAU * 2.0 / 0.5;
    for n in [24, 96] {
        let found = bends(n);
        assert!((found / exact - 1.0).abs() < 0.03, "{n}: {found} {exact}");
    }
    // ∫ 6 H² - 4 K over a sphere is 8π
    let (positions, triangles) = crate::shapes::icosphere(16);
    let found = bending(&positions, &triangles);
    assert!((found / (4.0 * TAU) - 1.0).abs() < 0.03, "{found}");
    let fold = [O, X, Y, DVec3::new(0.3, 0.3, 0.01)];
    assert_eq!(bending(&fold, &[[0, 1, 2], [1, 0, 3]]), f64::INFINITY);
}

#[test]
fn a_u_turn_is_swept_as_half_a_torus() {
    let gap = gap(vec![mouth(X, Z, 0.4, 28), mouth(-X, Z, 0.4, 28)]);
    let patch = &lofted_candidates(&gap, PatchOptions::default())[0];
    check("u", &gap, patch);
    // a cubic follows half a circle to 2 % of its radius, here up to 1.4
    for p in &patch.points {
        let around = (p.x.hypot(p.z) - 1.0).hypot(p.y);
        assert!((around - 0.4).abs() < 0.03 && p.z < 1e-9, "{around} {p}");
    }
}

#[test]
fn swept_surfaces_cross_nothing_where_films_do() {
    let three = [O, X, Y].map(|at| mouth(at, Z, 0.25, 18));
    let layouts = [
        ("u", vec![mouth(X, Z, 0.5, 24), mouth(-X, Z, 0.5, 24)]),
        (
            "far",
            vec![mouth(5.0 * Z, Z, 0.5, 16), mouth(-5.0 * Z, -Z, 0.4, 24)],
        ),
        (
            "s",
            vec![mouth(X + Z, Z, 0.5, 24), mouth(-X - Z, -Z, 0.5, 24)],
        ),
        ("tripod", three.to_vec()),
    ];
    for (name, rims) in layouts {
        let gap = gap(rims);
        let found = lofted_candidates(&gap, PatchOptions::default());
        assert!(!found.is_empty(), "{name}");
        let bends = found.iter().map(|p| bending(&p.points, &p.triangles));
        assert!(bends.collect::<Vec<_>>().is_sorted(), "{name}");
        for patch in &found {
            check(name, &gap, patch);
            assert!(patch.sharpest_angle() > 15.0, "{name}");
            assert!(self_intersections(&patch.points, &patch.triangles, None, 1).is_empty());
        }
    }
    // nothing to sweep between
    assert!(
        lofted_candidates(
            &gap(vec![mouth(X, X, 1.0, 8), mouth(X, X, 1.0, 8)]),
            PatchOptions::default()
        )
        .is_empty()
    );
    assert!(lofted_candidates(&gap(vec![mouth(X, X, 1.0, 8)]), PatchOptions::default()).is_empty());
}

/// A surface that runs away would take vertices without end.
#[test]
fn a_patch_that_has_grown_out_of_all_proportion_stays() {
    let gap = gap(vec![mouth(O, -Z, 1.0, 16), mouth(Z, Z, 1.0, 16)]);
    let options = PatchOptions::default();
    let mut patch = blend(&gap, options).expect("joined");
    let again = reblend(&gap, &patch, options);
    assert!(again.points.len() < 2 * patch.points.len());
    for p in &mut patch.points[32..] {
        *p *= 1e4;
    }
    let same = reblend(&gap, &patch, options);
    assert_eq!(
        (&same.points, &same.triangles),
        (&patch.points, &patch.triangles)
    );
}

/// The surface between them is folded onto itself, where flips make long edges again.
#[test]
fn rims_beside_each_other_in_a_plane_get_a_patch_of_limited_size() {
    let rim = |x: f64| flat(DVec3::new(x, 0.0, 0.0), DVec3::Z, 3.2, 8, false);
    let gap = gap(vec![rim(0.0), rim(30.0)]);
    let patch = blend(&gap, PatchOptions::default()).expect("a patch");
    assert!(patch.points.len() < 10_000, "{}", patch.points.len());
}
