//! The first patch over a hole.

use std::cell::RefCell;
use std::collections::HashSet;

use super::data::{Patch, PatchOptions, Rim};
use super::error::{PatchError, is_collinear, validate};
use super::frame::Frame;
use super::grading::{require_memory, set_grading};
use super::remesh::{remesh, rim_valences, split_chords, subdivide};
use super::slit::{stitch, with_zero_edges, without_zero_edges};
use super::surface::Surface;
use super::triangulate::{soundest, triangulate};
use crate::cancel::is_cancelled;
use crate::mesh::{DVec3, self_intersections, sides, vector_area};

/// The first surface for a hole: triangulates the rim, refines to the rim's density, flips edges
/// and relaxes.
///
/// The result is a disc: Euler characteristic 1, the rim as its only boundary, rim points
/// unchanged. Its interior positions are those of a relaxed membrane. A rim along a line is stitched
/// with triangles without area, and so are rim vertices at the same place.
///
/// # Errors
/// What makes the rim unusable; see [`PatchError`].
pub fn fill(rim: &Rim, options: PatchOptions) -> Result<Patch, PatchError> {
    match validate(rim, options.density) {
        Err(error @ PatchError::Collinear { .. }) => return stitch(rim).ok_or(error),
        Err(error @ PatchError::Coincident { .. }) => {
            let (reduced, kept) = without_zero_edges(rim);
            if reduced.points.len() < 3 || is_collinear(&reduced.points) {
                return stitch(rim).ok_or(error);
            }
            let patch = fill(&reduced, options)?;
            return with_zero_edges(rim, &patch, &kept).ok_or(error);
        }
        other => other?,
    }
    let frame = Frame::around(rim.points.iter().copied());
    let local = frame.local(rim);
    let triangles = triangulate(&local);
    let surface = triangulated(&local, &triangles, options.density);
    require_memory(&surface)?;
    let patch = relaxed(&local, surface);
    Ok(frame.world(patch, rim.points.iter().copied()))
}

/// Loops of up to this many edges get other first surfaces (0.1 s).
const MAX_EDGES: usize = 300;

/// Other first surfaces. Their triangulation of the rim has the fewest folded edges and intersecting or
/// excluded triangles, and the least dihedral angles among those.
pub(crate) struct OtherPatches {
    /// Refined and relaxed like that of [`fill()`].
    pub relaxed: Patch,
    /// Its triangles are parts of those of the triangulation. `None` if one of these has an edge that
    /// the mesh has already.
    pub flat: Option<Patch>,
}

/// Other first surfaces for a hole, without triangles of rim vertices that are `excluded` if that is
/// possible; `None` if the rim is unusable or has more than 300 edges.
pub(crate) fn fill_excluding(
    rim: &Rim,
    options: PatchOptions,
    excluded: &impl Fn([u32; 3]) -> bool,
) -> Option<OtherPatches> {
    validate(rim, options.density).ok()?;
    if rim.points.len() > MAX_EDGES {
        return None;
    }
    let frame = Frame::around(rim.points.iter().copied());
    let local = frame.local(rim);
    let triangles = without_intersections(&local, excluded);
    let is_forbidden = |[a, b]: [u32; 2]| local.forbidden.contains(&[a.min(b), a.max(b)]);
    let mut edges = triangles.iter().flat_map(|&t| sides(t));
    let flat = (!edges.any(is_forbidden)).then(|| {
        let mut surface = triangulated(&local, &triangles, options.density);
        subdivide(&mut surface);
        surface.compact()
    });
    let relaxed = relaxed(&local, triangulated(&local, &triangles, options.density));
    let world = |patch| frame.world(patch, rim.points.iter().copied());
    Some(OtherPatches {
        relaxed: world(relaxed),
        flat: flat.map(world),
    })
}

/// Triangulations that are tried for one without intersections.
const ATTEMPTS: usize = 12;

/// The soundest triangulation, with the fewest intersections of its triangles among [`ATTEMPTS`]: each attempt excludes the larger triangle of each intersecting pair of those before.
fn without_intersections(rim: &Rim, excluded: &impl Fn([u32; 3]) -> bool) -> Vec<[u32; 3]> {
    // the attempts ask for the same triangles
    let n = rim.points.len();
    let answers = RefCell::new(vec![None; n * n * n]);
    let excluded = |t: [u32; 3]| {
        let at = t.iter().fold(0, |at, &v| at * n + v as usize);
        let known = answers.borrow()[at];
        known.unwrap_or_else(|| *answers.borrow_mut()[at].insert(excluded(t)))
    };
    let mut intersecting: HashSet<[u32; 3]> = HashSet::new();
    let mut best: Option<(usize, Vec<[u32; 3]>)> = None;
    for _ in 0..ATTEMPTS {
        let triangles = soundest(rim, &|t| intersecting.contains(&t) || excluded(t));
        let pairs = self_intersections(&rim.points, &triangles, None, usize::MAX);
        let area = |f: u32| {
            let [a, b, c] = triangles[f as usize].map(|v| rim.points[v as usize]);
            (b - a).cross(c - a).length()
        };
        let larger = |[f, g]: &[u32; 2]| if area(*f) > area(*g) { *f } else { *g };
        intersecting.extend(pairs.iter().map(|pair| triangles[larger(pair) as usize]));
        if best.as_ref().is_none_or(|best| pairs.len() < best.0) {
            best = Some((pairs.len(), triangles));
        }
        if pairs.is_empty() || is_cancelled() {
            break;
        }
    }
    best.map_or_else(Vec::new, |best| best.1)
}

/// A triangulation of the rim with the wanted edge lengths.
fn triangulated(rim: &Rim, triangles: &[[u32; 3]], density: f64) -> Surface {
    let n = rim.points.len();
    let size = rim_sizes(&rim.points, density, n);
    let mut surface = Surface::new(rim.points.clone(), size, n, triangles);
    set_grading(&mut surface, density);
    surface
}

/// A triangulation of the rim, refined to the wanted edge lengths and relaxed.
fn relaxed(rim: &Rim, mut surface: Surface) -> Patch {
    let wanted = rim_valences(&surface, &loose_angles(rim));
    split_chords(&mut surface, &rim.forbidden);
    remesh(&mut surface, &wanted, mean_curvature(rim));
    surface.compact()
}

/// The angle of the existing face at each rim vertex that has only one, 0 elsewhere.
pub(super) fn loose_angles(rim: &Rim) -> Vec<f64> {
    let n = rim.points.len();
    (0..n)
        .map(|i| {
            let (before, after) = (rim.points[(i + n - 1) % n], rim.points[(i + 1) % n]);
            if rim.opposite[i] == before && rim.opposite[(i + n - 1) % n] == after {
                (before - rim.points[i]).angle_between(after - rim.points[i])
            } else {
                0.0
            }
        })
        .collect()
}

/// The constant mean curvature (positive: the patch rises along its normal) with which a surface
/// over the rim continues the existing faces: for every surface of constant mean curvature the
/// conormals along its boundary integrate to 2 H times its vector area (divergence theorem), and
/// both are known from the rim alone. Exact for the missing cap of a sphere up to a hemisphere.
fn mean_curvature(rim: &Rim) -> f64 {
    let n = rim.points.len();
    let area = vector_area(&rim.points);
    let (mut flux, mut length) = (DVec3::ZERO, 0.0);
    for i in 0..n {
        let (a, b) = (rim.points[i], rim.points[(i + 1) % n]);
        // into the hole, in the plane of the face, across the edge
        let inward = (a - rim.opposite[i]).reject_from(b - a).normalize_or_zero();
        flux += a.distance(b) * inward;
        length += a.distance(b);
    }
    let extent = area.length();
    // for loops that enclose next to nothing in projection the quotient is rounding
    if extent < 0.05 * length * length / (4.0 * std::f64::consts::PI) {
        return 0.0;
    }
    let hemisphere = (std::f64::consts::PI / extent).sqrt();
    let curvature = flux.dot(area) / (2.0 * extent * extent);
    if curvature.abs() < FLATTEST * hemisphere {
        return 0.0;
    }
    curvature
}

/// Curvatures below this fraction of that of a hemisphere over a disc of the same area are ignored:
/// they would lift the patch by less than noise in the faces does, and add less than 1 % to its
/// area.
const FLATTEST: f64 = 0.15;

/// Wanted edge length at every vertex of one of some rims with `edges` edges together: the mean of the
/// lengths of the rim edges near it, over a density below 1.
pub(super) fn rim_sizes(points: &[DVec3], density: f64, edges: usize) -> Vec<f64> {
    let n = points.len();
    let density = density.min(1.0) * fineness(edges);
    let mut size: Vec<f64> = (0..n)
        .map(|i| {
            let (before, after) = (points[(i + n - 1) % n], points[(i + 1) % n]);
            (points[i].distance(before) + points[i].distance(after)) / (2.0 * density)
        })
        .collect();
    // a ragged rim must not make triangles that alternate in size
    let mut smooth = size.clone();
    for _ in 0..RIM_SMOOTHING {
        for i in 0..n {
            smooth[i] = 0.25 * size[(i + n - 1) % n] + 0.5 * size[i] + 0.25 * size[(i + 1) % n];
        }
        std::mem::swap(&mut size, &mut smooth);
    }
    size
}

/// Length of the rim's edges over the wanted length. With this factor the mean edge of a large
/// patch ends at the rim's length: splitting and collapsing leave a mean edge of 0.93 of the wanted
/// one, and a patch stretches a little between the relaxed membrane and the end of the flow. In a
/// hole of few edges, all near the rim, up to 15 % more improve the accuracy (measured on the
/// analytic test surfaces after the flow).
fn fineness(edges: usize) -> f64 {
    (0.97 + 4.0 / edges as f64).min(1.15)
}

/// Passes of (1, 2, 1)/4 over the rim's edge lengths.
const RIM_SMOOTHING: usize = 4;
