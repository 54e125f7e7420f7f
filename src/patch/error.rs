//! Why a rim cannot have a patch.

use super::data::Rim;
use crate::memory::TooLittleMemory;
use crate::mesh::DVec3;

/// Why a rim cannot have a patch.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PatchError {
    /// Fewer than three rim vertices.
    #[error("a rim of {edges} edges encloses no area; remove the double face there instead")]
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
        "rim vertices {index} and {next} lie at the same point; a patch between several rims needs \
         edges with a length"
    )]
    Coincident {
        /// The first of the two, along the rim.
        index: usize,
        /// The one after it.
        next: usize,
    },
    /// The rim lies on a straight line: a slit, not a hole.
    #[error(
        "all {edges} rim vertices lie on one line: a slit, which cannot be joined to other rims"
    )]
    Collinear {
        /// Number of rim edges.
        edges: usize,
    },
    /// `forbidden` names a vertex that is not on the rim, or a pair not in order.
    #[error(
        "forbidden pair ({}, {}) is not an ordered pair of the {edges} rim vertices",
        pair[0],
        pair[1]
    )]
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
    /// The faces at some rims of a group have the opposite orientation of those at the others.
    #[error(
        "the faces at rim {} of the group have the opposite orientation of those at rim 1: a surface \
         that joins them would intersect itself; flip that component",
        rim + 1
    )]
    InsideOut {
        /// Number of the first such rim in the group, from 0.
        rim: usize,
    },
    /// The rims of a group run around each other so that no orientable surface fits.
    #[error(
        "no orientable surface joins these rims without passing through itself: rim {} of the \
         group runs the wrong way around it, as the edge of a Moebius strip would, and its faces \
         cannot be flipped alone; leave it out, or fill it separately",
        rim + 1
    )]
    OneSided {
        /// Number of the first such rim in the group, from 0.
        rim: usize,
    },
    /// The patch needs more memory than is free.
    #[error("{0}; lower the density")]
    Memory(#[from] TooLittleMemory),
    /// The density is not a positive number.
    #[error("density must be a positive number, not {density}")]
    BadDensity {
        /// The density given.
        density: f64,
    },
}

/// Checks that a patch over the rim can be made.
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
pub(super) fn is_collinear(points: &[DVec3]) -> bool {
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
