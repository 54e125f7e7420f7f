//! The guess which boundary loops are outer rims: borders an open surface is meant to have.
//!
//! How the surface arrives at a rim is measured by its *opening*, an angle. With ν the outward
//! conormal (in the surface, across the rim, away from the faces), l the edge lengths, m the edge
//! midpoints, c their centre and r the radius of the loop,
//!
//! ```text
//! opening = atan2( r |Σ l ν| , −Σ l ν·(m − c) )
//! ```
//!
//! A hole in a plane has 0° (by the divergence theorem, whatever its shape), a hole of half-angle α
//! in a sphere α, the end of a tube 90°, the border of a plane 180°. On the shared models holes reach
//! 64° (a torn one across the tail of a cow), but for a sphere cut open nearly to the equator (81°),
//! which is the only opening of its component; ends of tubes start at 88°.
//!
//! 1. Below [`HOLE_BELOW`] the surface closes in on the loop: a hole.
//! 2. A loop that faces another one in front of it is there to be joined to it: not an outer rim.
//! 3. The only loop of its component that is no hole by rule 1 is the mouth of a cup, and filled, if
//!    its opening is below [`CUP_BELOW`] (or [`FLARED_CUP_BELOW`] with much surface behind it).
//! 4. All others are outer rims.

use super::{BoundaryLoop, Components, DVec3, FaceId, Mesh};

/// Opening in degrees below which the surface closes in on a loop.
const HOLE_BELOW: f64 = 75.0;
/// Opening in degrees up to which the only mouth of a surface is filled.
const CUP_BELOW: f64 = 105.0;
/// The same where the surface is [`FLARED_CUP_AREA`] times as large as its mouth.
const FLARED_CUP_BELOW: f64 = 135.0;
/// Surface of a cup over the area of its mouth, at least; a hemisphere has 2, a cube 5.
const CUP_AREA: f64 = 1.5;
/// The same for cups that open outwards: a bust on its shoulders, not a hill in a landscape.
const FLARED_CUP_AREA: f64 = 4.0;
/// A loop around less than this part of the circle of its length is a crack, where openings are
/// mostly noise: a hole unless the opening is above [`FLARED_CUP_BELOW`].
const CRACK: f64 = 0.05;
/// Loops have a direction if their mean conormal is at least this long (a tube's end has 1).
const STRAIGHT: f64 = 0.3;
/// Cosine of the angle up to which a loop looks at another: 70° between components, 60° within
/// one. Ends of a torus of which 120° are missing just see each other.
const FACING: [f64; 2] = [0.342, 0.5];
/// Cosine of the angle up to which a tube's end looks at a hole of another component.
const FACING_HOLE: f64 = 0.7;
/// Distance of facing loops over the sum of their radii, at most; the shared models have up to 2.2.
const REACH: f64 = 4.0;

/// How a surface arrives at a boundary loop.
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

/// Sets `outer_rim` and `reason` of all loops of a mesh.
pub(super) fn guess_outer_rims(mesh: &Mesh, parts: &Components, loops: &mut [BoundaryLoop]) {
    let rims: Vec<Rim> = loops.iter().map(|one| measure(mesh, one)).collect();
    let hole: Vec<bool> = rims
        .iter()
        .map(|r| r.opening < HOLE_BELOW || (r.roundness < CRACK && r.opening < FLARED_CUP_BELOW))
        .collect();
    let mut mouths = vec![0u32; parts.count];
    for (one, _) in loops.iter().zip(&hole).filter(|x| !x.1) {
        mouths[one.component as usize] += 1;
    }
    let mut areas: Option<Vec<f64>> = None;
    for i in 0..loops.len() {
        let opening = rims[i].opening;
        let (outer_rim, reason) = if hole[i] {
            (
                false,
                format!("the surface closes in on it (opening {opening:.0}°)"),
            )
        } else if let Some(j) = faced(loops, &rims, &hole, i) {
            (false, format!("it faces loop {}", loops[j].number))
        } else if mouths[loops[i].component as usize] > 1 {
            let kind = if opening < CUP_BELOW {
                "one of several open ends"
            } else {
                "a border"
            };
            (
                true,
                format!("{kind} of its component (opening {opening:.0}°)"),
            )
        } else {
            let areas = areas.get_or_insert_with(|| component_areas(mesh, parts));
            let ratio = areas[loops[i].component as usize] / rims[i].area.length();
            let cup = (opening < CUP_BELOW && ratio > CUP_AREA)
                || (opening < FLARED_CUP_BELOW && ratio > FLARED_CUP_AREA);
            let what = if cup {
                "the only mouth of a surface that is closed otherwise"
            } else {
                "the border of an open surface"
            };
            (!cup, format!("{what} (opening {opening:.0}°)"))
        };
        loops[i].outer_rim = outer_rim;
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
