//! The classification of boundary loops: outer boundaries are intended borders of an open surface;
//! the other loops are holes.
//!
//! The *opening* of a loop is an angle. It measures how the surface meets the loop. Let ν be the
//! outward conormal (in the surface, across the loop, away from the faces), l the edge lengths, m
//! the edge midpoints, c their centre and r the radius of the loop:
//!
//! ```text
//! opening = atan2( r |Σ l ν| , −Σ l ν·(m − c) )
//! ```
//!
//! A hole in a plane has 0° (by the divergence theorem, whatever its shape), a hole of half-angle α
//! in a sphere α, the end of a tube 90°, the border of a plane 180°. On the test models holes
//! reach 64° (a torn one across the tail of a cow). The exception is a sphere cut open nearly to the
//! equator (81°), the only loop of its component. Ends of tubes start at 88°.
//!
//! 1. Below [`HOLE_BELOW`] the surface narrows towards the loop, which is a hole. Loops that are
//!    small relative to their component ([`SMALL`]) and cracks ([`CRACK`]) are holes too.
//! 2. A loop that faces another loop in front of it is to be joined to it and is not an outer
//!    boundary.
//! 3. The only loop of its component that is not a hole by rule 1 is the mouth of a cup if its
//!    opening is below [`CUP_BELOW`] (or [`FLARED_CUP_BELOW`] with much surface behind it). It is
//!    filled.
//! 4. All others are outer boundaries.

use super::{BoundaryLoop, Components, DVec3, FaceId, Mesh};

/// A loop whose area is below this fraction of the area of its component is a hole, although the
/// surface continues straight there (up to [`CUP_BELOW`]). The tip of an ear is such a loop; the
/// end of a pipe of 50 radii is not.
const SMALL: f64 = 0.01;
/// Opening in degrees below which the surface narrows towards a loop.
const HOLE_BELOW: f64 = 75.0;
/// Opening in degrees up to which the only mouth of a surface is filled.
const CUP_BELOW: f64 = 105.0;
/// The same if the surface is [`FLARED_CUP_AREA`] times as large as its mouth.
const FLARED_CUP_BELOW: f64 = 135.0;
/// Minimum surface area of a cup over the area of its mouth. A hemisphere has 2, a cube 5.
const CUP_AREA: f64 = 1.5;
/// The same for cups that open outwards, such as a bust with shoulders, but not a hill in a
/// landscape.
const FLARED_CUP_AREA: f64 = 4.0;
/// A loop with less than this fraction of the area of a circle of the same length is a crack.
/// Openings of cracks are mostly noise, so a crack is a hole unless its opening is above
/// [`FLARED_CUP_BELOW`].
const CRACK: f64 = 0.05;
/// Loops have a direction if their mean conormal is at least this long (a tube's end has 1).
const STRAIGHT: f64 = 0.3;
/// Cosine of the maximum angle at which a loop faces another: 70° between components, 60° within
/// one. The ends of a torus of which 120° are missing just face each other.
const FACING: [f64; 2] = [0.342, 0.5];
/// Cosine of the maximum angle at which the end of a tube faces a hole of another component.
const FACING_HOLE: f64 = 0.7;
/// Maximum distance of facing loops over the sum of their radii. The test models have up to 2.2.
const REACH: f64 = 4.0;

/// Why a small loop of a large component is no hole: a patch would be folded at its rim.
const LEADS_AWAY: &str = "the surface leads away from it";

/// Measures of the surface at a boundary loop.
#[derive(Clone, Copy, Debug)]
struct Rim {
    /// Opening in degrees, 0 to 180.
    opening: f64,
    /// Mean outward conormal; shorter than 1.
    ahead: DVec3,
    centre: DVec3,
    /// Area vector of the loop.
    area: DVec3,
    /// Area over that of the circle of the same length.
    roundness: f64,
}

/// Sets `is_outer_boundary` and `reason` of all loops of a mesh.
pub(super) fn classify_loops(mesh: &Mesh, parts: &Components, loops: &mut [BoundaryLoop]) {
    if loops.is_empty() {
        return;
    }
    let rims: Vec<Rim> = loops.iter().map(|one| measure(mesh, one)).collect();
    let areas = component_areas(mesh, parts);
    // surface area behind each loop over the area of its mouth
    let depth: Vec<f64> = loops
        .iter()
        .zip(&rims)
        .map(|(one, r)| areas[one.component as usize] / r.area.length())
        .collect();
    let hole: Vec<bool> = rims
        .iter()
        .zip(&depth)
        .map(|(r, d)| {
            r.opening < HOLE_BELOW
                || (r.opening < CUP_BELOW && d * SMALL > 1.0)
                || (r.opening < FLARED_CUP_BELOW && r.roundness < CRACK)
        })
        .collect();
    let mut mouths = vec![0u32; parts.count];
    for (one, _) in loops.iter().zip(&hole).filter(|x| !x.1) {
        mouths[one.component as usize] += 1;
    }
    for i in 0..loops.len() {
        let opening = rims[i].opening;
        // such as a fold or a crumpled place of a scan
        let leads_away = depth[i] * SMALL > 1.0 && opening >= CUP_BELOW;
        let (is_outer_boundary, reason) = if hole[i] {
            let what = if opening < HOLE_BELOW {
                "the surface narrows towards it"
            } else if rims[i].roundness < CRACK {
                "a crack"
            } else {
                "small relative to its component"
            };
            (false, format!("{what} (opening {opening:.0}°)"))
        } else if let Some(j) = faced(loops, &rims, &hole, i) {
            (false, format!("it faces loop {}", loops[j].id))
        } else if mouths[loops[i].component as usize] > 1 {
            let kind = if opening < CUP_BELOW {
                "one of several open ends of its component"
            } else if leads_away {
                LEADS_AWAY
            } else {
                "a boundary of its component"
            };
            (true, format!("{kind} (opening {opening:.0}°)"))
        } else {
            let cup = (opening < CUP_BELOW && depth[i] > CUP_AREA)
                || (opening < FLARED_CUP_BELOW && depth[i] > FLARED_CUP_AREA);
            let what = if cup {
                "the only opening of a surface that is closed otherwise"
            } else if leads_away {
                LEADS_AWAY
            } else {
                "the boundary of an open surface"
            };
            (!cup, format!("{what} (opening {opening:.0}°)"))
        };
        loops[i].is_outer_boundary = is_outer_boundary;
        loops[i].reason = reason;
    }
}

fn measure(mesh: &Mesh, one: &BoundaryLoop) -> Rim {
    let topology = &mesh.topology;
    let edges = || {
        one.halfedges.iter().map(|&h| {
            let apex = topology.target(topology.next(h.twin()));
            [topology.origin(h), topology.target(h), apex].map(|v| mesh.position(v) - one.centroid)
        })
    };
    let centre = edges()
        .map(|[a, b, _]| a.midpoint(b) * a.distance(b))
        .sum::<DVec3>()
        / one.perimeter.max(f64::MIN_POSITIVE);
    let (mut ahead, mut inwards, mut area) = (DVec3::ZERO, 0.0, DVec3::ZERO);
    for [a, b, apex] in edges() {
        let edge = (b - a).normalize_or_zero();
        let into_face = apex - a;
        let conormal = -(into_face - edge * into_face.dot(edge)).normalize_or_zero();
        let weighted = conormal * a.distance(b);
        ahead += weighted;
        inwards -= weighted.dot(a.midpoint(b) - centre);
        area += 0.5 * (a - centre).cross(b - centre);
    }
    let circle = one.perimeter * one.perimeter / (4.0 * std::f64::consts::PI);
    Rim {
        opening: (one.radius * ahead.length()).atan2(inwards).to_degrees(),
        ahead: ahead / one.perimeter.max(f64::MIN_POSITIVE),
        centre: one.centroid + centre,
        area,
        roundness: area.length() / circle.max(f64::MIN_POSITIVE),
    }
}

/// The nearest loop that loop `i` faces.
fn faced(loops: &[BoundaryLoop], rims: &[Rim], hole: &[bool], i: usize) -> Option<usize> {
    if rims[i].ahead.length() < STRAIGHT {
        return None;
    }
    let sight = |from: usize, to: usize| {
        let way = (rims[to].centre - rims[from].centre).normalize_or_zero();
        rims[from].ahead.normalize_or_zero().dot(way)
    };
    let distance = |j: usize| rims[i].centre.distance(rims[j].centre);
    (0..loops.len())
        .filter(|&j| j != i && distance(j) <= REACH * (loops[i].radius + loops[j].radius))
        .filter(|&j| {
            let same = loops[i].component == loops[j].component;
            if hole[j] {
                // a tube standing above a hole in another surface
                let axis = rims[j]
                    .area
                    .normalize_or_zero()
                    .dot(rims[i].ahead.normalize_or_zero());
                !same && sight(i, j) >= FACING_HOLE && axis.abs() >= FACING_HOLE
            } else {
                rims[j].ahead.length() >= STRAIGHT
                    && sight(i, j).min(sight(j, i)) >= FACING[usize::from(same)]
            }
        })
        .min_by(|&j, &k| distance(j).total_cmp(&distance(k)))
}

fn component_areas(mesh: &Mesh, parts: &Components) -> Vec<f64> {
    let mut areas = vec![0.0; parts.count];
    for (f, &part) in parts.of_face.iter().enumerate() {
        let [a, b, c] = mesh.corners(FaceId::from(f));
        areas[part as usize] += 0.5 * (b - a).cross(c - a).length();
    }
    areas
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::boundary_loops;
    use glam::DMat3;
    use std::f64::consts::{PI, TAU};

    /// The surface of revolution of (radius, height) pairs, in `n` sectors; a radius of 0 at either
    /// end closes it.
    fn revolve(profile: &[[f64; 2]], n: u32) -> Mesh {
        let mut positions = Vec::new();
        let mut rings: Vec<Vec<u32>> = Vec::new();
        for &[r, z] in profile {
            let count = if r > 0.0 { n } else { 1 };
            let first = positions.len() as u32;
            positions.extend((0..count).map(|i| {
                let (s, c) = (TAU * f64::from(i) / f64::from(n)).sin_cos();
                DVec3::new(r * c, r * s, z)
            }));
            rings.push((0..n).map(|i| first + i % count).collect());
        }
        let mut triangles = Vec::new();
        for pair in rings.windows(2) {
            for i in 0..n as usize {
                let j = (i + 1) % n as usize;
                let [a, b, c, d] = [pair[0][i], pair[0][j], pair[1][i], pair[1][j]];
                triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
        triangles.retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
        Mesh::from_triangles(positions, &triangles).expect("manifold")
    }

    fn arc(from: f64, to: f64) -> Vec<[f64; 2]> {
        (0..=24)
            .map(|i| from + (to - from) * f64::from(i) / 24.0)
            .map(|angle| [angle.sin().max(0.0), angle.cos()])
            .map(|[r, z]| if r < 1e-12 { [0.0, z] } else { [r, z] })
            .collect()
    }

    fn tube(low: f64, high: f64) -> Vec<[f64; 2]> {
        (0..=20)
            .map(|i| [0.5, low + (high - low) * f64::from(i) / 20.0])
            .collect()
    }

    fn without(mesh: &Mesh, hole: impl Fn(DVec3) -> bool) -> Mesh {
        let kept: Vec<[u32; 3]> = mesh
            .topology
            .triangles()
            .filter(|t| !t.iter().all(|&v| hole(mesh.positions[v as usize])))
            .collect();
        Mesh::from_triangles(mesh.positions.clone(), &kept).expect("manifold")
    }

    fn moved(mesh: &Mesh, turn: DMat3, shift: DVec3) -> Mesh {
        let positions = mesh.positions.iter().map(|&p| turn * p + shift).collect();
        Mesh::new(positions, mesh.topology.clone())
    }

    fn together(parts: &[Mesh]) -> Mesh {
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for part in parts {
            let first = positions.len() as u32;
            positions.extend(&part.positions);
            triangles.extend(part.topology.triangles().map(|t| t.map(|v| v + first)));
        }
        Mesh::from_triangles(positions, &triangles).expect("manifold")
    }

    fn outer(mesh: &Mesh) -> Vec<bool> {
        boundary_loops(mesh)
            .iter()
            .map(|l| l.is_outer_boundary)
            .collect()
    }

    fn openings(mesh: &Mesh) -> Vec<f64> {
        boundary_loops(mesh)
            .iter()
            .map(|one| measure(mesh, one).opening)
            .collect()
    }

    #[test]
    fn opening_is_the_angle_of_a_cap() {
        // the sphere without a cap of half-angle α, in rings through the rim's circle of latitude
        for degrees in [20.0f64, 60.0, 90.0, 120.0] {
            let mesh = revolve(&arc(degrees.to_radians(), PI), 96);
            let opening = openings(&mesh)[0];
            // the first ring of triangles is a chord of 1/48 of the remaining arc
            let chord = (180.0 - degrees) / 48.0;
            assert!(
                (opening - degrees - chord).abs() < 0.5,
                "{degrees}: {opening}"
            );
        }
        let disc = revolve(&[[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [2.0, 0.0]], 60);
        assert!(openings(&disc)[0] > 179.999);
        let holed = without(&disc, |p| p.length() < 1.1);
        assert!(openings(&holed)[0] < 1e-6);
        assert_eq!(outer(&holed), [false, true]);
    }

    #[test]
    fn ends_of_tubes_are_outer_boundaries_and_windows_are_holes() {
        let pipe = revolve(&tube(0.0, 3.0), 40);
        assert_eq!(outer(&pipe), [true, true]);
        let window = without(&pipe, |p| p.x > 0.3 && (p.z - 1.5).abs() < 0.5);
        let mut found = outer(&window);
        found.sort_unstable();
        assert_eq!(found, [false, true, true]);
        let flared: Vec<[f64; 2]> = (-10..=10)
            .map(|i| 0.12 * f64::from(i))
            .map(|z| [z.cosh(), z])
            .collect();
        assert_eq!(outer(&revolve(&flared, 60)), [true, true]);
    }

    #[test]
    fn facing_ends_are_filled_in_any_frame() {
        let left = revolve(&tube(-2.0, -0.5), 32);
        let right = moved(&left, DMat3::from_rotation_x(0.5 * PI), DVec3::ZERO);
        let both = together(&[left, right]);
        assert_eq!(outer(&both), [true, false, true, false]);
        let turn = DMat3::from_rotation_y(1.1) * DMat3::from_rotation_z(0.3) * 1e3;
        for shift in [DVec3::ZERO, DVec3::splat(1e6)] {
            assert_eq!(
                outer(&moved(&both, turn, shift)),
                [true, false, true, false]
            );
        }
        // side by side, or far away, there is nothing to join
        let beside = moved(
            &revolve(&tube(-2.0, -0.5), 32),
            DMat3::IDENTITY,
            DVec3::X * 2.0,
        );
        let parallel = together(&[revolve(&tube(-2.0, -0.5), 32), beside]);
        assert_eq!(outer(&parallel), [true; 4]);
        let far = revolve(&tube(9.0, 11.0), 32);
        assert_eq!(
            outer(&together(&[revolve(&tube(-2.0, -0.5), 32), far])),
            [true; 4]
        );
    }

    #[test]
    fn a_small_loop_whose_lip_is_turned_outwards_is_no_boundary_of_an_open_surface() {
        // a ball whose mouth is rolled outwards by more than a quarter turn
        let mut profile = arc(0.1, PI);
        profile.reverse();
        let [r, z] = profile[profile.len() - 1];
        profile.extend([[r + 0.02, z + 0.03], [r + 0.06, z + 0.02]]);
        let flask = revolve(&profile, 40);
        let one = &boundary_loops(&flask)[0];
        assert!(one.is_outer_boundary);
        assert!(one.reason.starts_with(LEADS_AWAY), "{}", one.reason);
    }

    #[test]
    fn bowls_are_open_unless_they_face_each_other() {
        let bowl = revolve(&arc(0.0, 50f64.to_radians()), 60);
        assert_eq!(outer(&bowl), [true]);
        let other = moved(&bowl, DMat3::from_rotation_x(PI), DVec3::ZERO);
        assert_eq!(outer(&together(&[bowl, other])), [false, false]);
    }

    #[test]
    fn a_cup_is_closed_and_so_is_most_of_a_sphere() {
        let cup = [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 0.7], [1.0, 1.4]];
        assert_eq!(outer(&revolve(&cup, 24)), [false]);
        for degrees in [30.0f64, 60.0, 80.0] {
            assert_eq!(outer(&revolve(&arc(degrees.to_radians(), PI), 60)), [false]);
        }
        // a tube standing above a hole in a plate
        let plate = revolve(&[[0.8, 0.0], [1.2, 0.0], [2.0, 0.0]], 40);
        let above = together(&[plate, revolve(&tube(0.5, 2.0), 32)]);
        assert_eq!(outer(&above), [false, true, false, true]);
    }
}
