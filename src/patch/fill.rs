//! The first patch over a hole.

use super::data::{Patch, PatchOptions, Rim};
use super::error::{PatchError, validate};
use super::planar::vector_area;
use super::remesh::{remesh, rim_valences, split_chords};
use super::surface::Surface;
use super::triangulate::triangulate;
use crate::mesh::DVec3;

/// The first surface for a hole: triangulates the rim, refines to the rim's density, flips edges
/// and relaxes.
///
/// The result is a disc: Euler characteristic 1, the rim as its only boundary, rim points
/// unchanged. Its interior positions are those of a relaxed membrane.
///
/// # Errors
/// What makes the rim unusable; see [`PatchError`].
pub fn fill(rim: &Rim, options: &PatchOptions) -> Result<Patch, PatchError> {
    validate(rim, options.density)?;
    let n = rim.points.len();
    // Work near the origin at unit scale: squared areas of tiny or huge meshes stay in range.
    let centre = rim.points.iter().sum::<DVec3>() / n as f64;
    let radius = rim
        .points
        .iter()
        .map(|p| p.distance(centre))
        .fold(0.0, f64::max);
    let local = Rim {
        points: rim.points.iter().map(|&p| (p - centre) / radius).collect(),
        opposite: rim
            .opposite
            .iter()
            .map(|&p| (p - centre) / radius)
            .collect(),
        forbidden: rim
            .forbidden
            .iter()
            .copied()
            .filter(|&[i, j]| j != i + 1 && (i != 0 || j as usize != n - 1))
            .collect(),
    };
    let loose = loose_angles(&local);
    let bulge = mean_curvature(&local);
    let triangles = triangulate(&local);
    let size = rim_sizes(&local.points, options.density * fineness(n));
    let mut surface = Surface::new(local.points, size, n, &triangles);
    let wanted = rim_valences(&surface, &loose);
    split_chords(&mut surface, &local.forbidden);
    remesh(&mut surface, &wanted, bulge);
    let mut patch = surface.compact();
    for p in &mut patch.points[n..] {
        *p = *p * radius + centre;
    }
    patch.points[..n].copy_from_slice(&rim.points);
    Ok(patch)
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

/// The constant mean curvature (positive bulges along the patch's normal) with which a surface
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
    // loops that enclose next to nothing in projection have no bulge to speak of
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

/// Curvatures below this fraction of that of a hemisphere over a disc of the same area would lift
/// the patch by less than noise in the faces does, and add less than 1 % to its area.
const FLATTEST: f64 = 0.15;

/// Wanted edge length at every rim vertex: the mean of the lengths of the rim edges near it.
pub(super) fn rim_sizes(points: &[DVec3], density: f64) -> Vec<f64> {
    let n = points.len();
    let mut size: Vec<f64> = (0..n)
        .map(|i| {
            let (before, after) = (points[(i + n - 1) % n], points[(i + 1) % n]);
            (points[i].distance(before) + points[i].distance(after)) / (2.0 * density)
        })
        .collect();
    // a ragged rim is not a wish for triangles that alternate in size
    let mut smooth = size.clone();
    for _ in 0..RIM_SMOOTHING {
        for i in 0..n {
            smooth[i] = 0.25 * size[(i + n - 1) % n] + 0.5 * size[i] + 0.25 * size[(i + 1) % n];
        }
        std::mem::swap(&mut size, &mut smooth);
    }
    size
}

/// Length of the rim's edges over the wanted one. Where splitting and collapsing leave off the mean
/// edge is 0.93 of the wanted one, and a patch stretches a little between the relaxed film and the
/// end of the flow: with this the mean edge of a large patch ends at the rim's length. A hole of few
/// edges, all of them near the rim, gains accuracy from up to 15 % more (measured on the analytic
/// test surfaces after the flow).
pub(super) fn fineness(edges: usize) -> f64 {
    (0.97 + 4.0 / edges as f64).min(1.15)
}

/// Passes of (1, 2, 1)/4 over the rim's edge lengths.
const RIM_SMOOTHING: usize = 4;
