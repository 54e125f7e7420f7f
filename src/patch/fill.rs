//! The first patch over a hole.

use super::planar::vector_area;
use super::remesh::{remesh, rim_valences, split_chords};
use super::surface::Surface;
use super::triangulate::triangulate;
use crate::mesh::DVec3;

/// The rim of a hole, in the direction in which the patch runs through it: patch triangles contain
/// the directed edges `points[i] → points[i+1]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rim {
    /// The rim's vertices; the last is joined to the first.
    pub points: Vec<DVec3>,
    /// Third vertex of the existing face at rim edge `i → i+1`.
    pub opposite: Vec<DVec3>,
    /// Pairs (i < j) of rim indices already joined by an edge of the mesh that is not a rim edge:
    /// a patch edge there would be non-manifold.
    pub forbidden: Vec<[u32; 2]>,
}

/// How to make the first patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchOptions {
    /// Vertices per length along the patch, relative to the rim: 1 makes equilateral triangles of
    /// the rim's edge length, 2 of half of it.
    pub density: f64,
}

impl Default for PatchOptions {
    fn default() -> Self {
        Self { density: 1.0 }
    }
}

/// A triangulated disc over a rim.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchMesh {
    /// The rim's points first (bit-identical), then the new ones.
    pub points: Vec<DVec3>,
    /// Corners, oriented as the rim runs.
    pub triangles: Vec<[u32; 3]>,
}

impl PatchMesh {
    /// The smallest angle of a triangle, in degrees.
    pub fn sharpest_angle(&self) -> f64 {
        let mut least = f64::INFINITY;
        for t in &self.triangles {
            let p = t.map(|v| self.points[v as usize]);
            for k in 0..3 {
                let (u, v) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
                least = least.min(u.angle_between(v).to_degrees());
            }
        }
        least
    }
}

/// Why a hole has no patch.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PatchError {
    /// Fewer than three rim vertices.
    #[error("a rim of {edges} edges encloses nothing; remove the double face there instead")]
    TooFewEdges {
        /// How many there are.
        edges: usize,
    },
    /// `opposite` does not match `points`.
    #[error("the rim has {points} points but {opposite} adjacent faces")]
    LengthMismatch {
        /// Rim points.
        points: usize,
        /// Entries of `opposite`.
        opposite: usize,
    },
    /// A coordinate of the rim or of the faces next to it is NaN or infinite.
    #[error("rim vertex {index} or the face at it has a coordinate that is not a finite number")]
    NotFinite {
        /// Index along the rim.
        index: usize,
    },
    /// Two consecutive rim vertices lie at the same point.
    #[error(
        "rim vertices {index} and {next} lie at the same point; weld the vertices of the mesh \
         before filling"
    )]
    Coincident {
        /// The first of the two, along the rim.
        index: usize,
        /// The one after it.
        next: usize,
    },
    /// The rim lies on a straight line: a slit, not a hole.
    #[error("all {edges} rim vertices lie on one line: stitch the slit instead of filling it")]
    Collinear {
        /// Number of rim edges.
        edges: usize,
    },
    /// `forbidden` names a vertex that is not on the rim, or a pair not in order.
    #[error("forbidden pair ({}, {}) is not an ordered pair of the {edges} rim vertices", pair[0], pair[1])]
    BadForbiddenPair {
        /// The pair.
        pair: [u32; 2],
        /// Number of rim edges.
        edges: usize,
    },
    /// Two rims to be joined have a vertex in common.
    #[error(
        "rims {} and {} of the group meet at vertex {index} of the first; fill them apart",
        rims[0] + 1,
        rims[1] + 1
    )]
    RimsTouch {
        /// Numbers of the rims in the group, from 0.
        rims: [usize; 2],
        /// Index along the first of them.
        index: usize,
    },
    /// The faces at some rims of a group look to the other side than those at the others.
    #[error(
        "the faces at rim {} of the group look to the other side than those at rim 1: a surface that \
         joins them would have to pass through itself; flip that component",
        rim + 1
    )]
    InsideOut {
        /// Number of the first such rim in the group, from 0.
        rim: usize,
    },
    /// The rims of a group run around each other so that no orientable surface fits.
    #[error(
        "no orientable surface joins these rims without passing through itself: rim {} of the group \
         runs the wrong way around it, as the edge of a Moebius strip would, and its faces cannot be \
         flipped alone; leave it out, or fill it by itself",
        rim + 1
    )]
    OneSided {
        /// Number of the first such rim in the group, from 0.
        rim: usize,
    },
    /// The density is not a positive number.
    #[error("density must be a positive number, not {density}")]
    BadDensity {
        /// What was asked for.
        density: f64,
    },
}

/// The first surface for a hole: triangulates the rim, refines to the rim's density, flips edges
/// and relaxes.
///
/// The result is a disc: Euler characteristic 1, the rim as its only boundary, rim points
/// unchanged. Its interior positions are those of a relaxed membrane.
///
/// # Errors
/// What makes the rim unusable; see [`PatchError`].
pub fn fill(rim: &Rim, options: &PatchOptions) -> Result<PatchMesh, PatchError> {
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
    let (mut points, triangles) = surface.compact();
    for p in &mut points[n..] {
        *p = *p * radius + centre;
    }
    points[..n].copy_from_slice(&rim.points);
    Ok(PatchMesh { points, triangles })
}

pub(super) fn validate(rim: &Rim, density: f64) -> Result<(), PatchError> {
    let n = rim.points.len();
    if !(density.is_finite() && density > 0.0) {
        return Err(PatchError::BadDensity { density });
    }
    if n < 3 {
        return Err(PatchError::TooFewEdges { edges: n });
    }
    if rim.opposite.len() != n {
        return Err(PatchError::LengthMismatch {
            points: n,
            opposite: rim.opposite.len(),
        });
    }
    for (index, (p, o)) in rim.points.iter().zip(&rim.opposite).enumerate() {
        if !p.is_finite() || !o.is_finite() {
            return Err(PatchError::NotFinite { index });
        }
        let next = (index + 1) % n;
        if *p == rim.points[next] {
            return Err(PatchError::Coincident { index, next });
        }
    }
    for &pair in &rim.forbidden {
        if pair[0] >= pair[1] || pair[1] as usize >= n {
            return Err(PatchError::BadForbiddenPair { pair, edges: n });
        }
    }
    if is_collinear(&rim.points) {
        return Err(PatchError::Collinear { edges: n });
    }
    Ok(())
}

/// Whether all points lie on one line up to the rounding of their coordinates.
fn is_collinear(points: &[DVec3]) -> bool {
    let origin = points[0];
    let far = |from: DVec3| -> DVec3 {
        points.iter().fold(from, |best, &p| {
            if p.distance_squared(from) > best.distance_squared(from) {
                p
            } else {
                best
            }
        })
    };
    let end = far(origin);
    let axis = (end - origin).normalize_or_zero();
    let magnitude = points
        .iter()
        .map(|p| p.abs().max_element())
        .fold(0.0, f64::max);
    let tolerance = 8.0 * f64::EPSILON * magnitude;
    points
        .iter()
        .all(|&p| axis.cross(p - origin).length() <= tolerance)
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
