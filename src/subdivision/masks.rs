//! Loop's subdivision masks and the masks of the limit surface, with Loop's original weights.

use std::f64::consts::TAU;

/// Weight of each end of an edge in its new edge vertex.
pub const EDGE_END: f64 = 3.0 / 8.0;

/// Weight of each vertex opposite an edge in its new edge vertex.
pub const EDGE_OPPOSITE: f64 = 1.0 / 8.0;

/// Weight of each of the `n` neighbours in the new position of a vertex, whose own weight is
/// `1 - n beta(n)`: `beta(n) = (5/8 - (3/8 + cos(2 pi / n) / 4)^2) / n`.
pub fn beta(n: usize) -> f64 {
    let n = n as f64;
    let c = 0.375 + 0.25 * (TAU / n).cos();
    (0.625 - c * c) / n
}

/// Weight of each of the `n` neighbours in the limit position of a vertex, whose own weight is
/// `1 - n omega(n)`: `omega(n) = 1 / (3 / (8 beta(n)) + n)`.
pub fn omega(n: usize) -> f64 {
    (0.375 / beta(n) + n as f64).recip()
}

/// Weights of a vertex and of each of its `n` neighbours in its limit position.
pub fn limit_mask(n: usize) -> (f64, f64) {
    let omega = omega(n);
    (1.0 - n as f64 * omega, omega)
}

/// Greatest valence at which Loop's scheme is applied as it stands.
///
/// Every triangle at a vertex of valence `n` depends on all `n` neighbours, so that the triangles
/// around it have `n^2` control vertices, and their matrices `n^3` entries. Most of the neighbours
/// enter only through their mean, because the rule of a vertex needs no more of its ring. Above this
/// valence that mean is taken over [`SAMPLE`] neighbours, evenly spread, and a triangle depends on
/// these and on the [`BAND`] neighbours next to it. The surface stays smooth across its edges. The
/// control vertices of all triangles at a vertex then grow linearly with its valence.
pub const EXACT_VALENCE: usize = 64;

/// Number of neighbours whose mean stands for that of all neighbours above [`EXACT_VALENCE`].
pub const SAMPLE: usize = 12;

/// Number of neighbours next to a triangle on which it depends above [`EXACT_VALENCE`]. A point
/// depends on one more neighbour on either side with each subdivision step towards the vertex; the
/// points of [`super::Rule`] take at most five.
pub const BAND: usize = 16;

/// Places in a ring of `n` neighbours of those in the sample; all if `n` is at most
/// [`EXACT_VALENCE`]. Ascending.
pub fn sample(n: usize) -> impl ExactSizeIterator<Item = usize> {
    let count = if n > EXACT_VALENCE { SAMPLE } else { n };
    (0..count).map(move |i| i * n / count)
}

/// Weights of the `n` neighbours, in counter-clockwise order, in two tangents `(t1, t2)` of the
/// limit surface at a vertex. The vertex itself has weight 0 in both. `t1 x t2` points along the
/// normal. The lengths of the tangents are meaningless.
pub fn tangent_mask(n: usize) -> impl ExactSizeIterator<Item = (f64, f64)> {
    (0..n).map(move |j| {
        let (sin, cos) = (TAU * j as f64 / n as f64).sin_cos();
        (cos, sin)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_weights() {
        assert!((beta(6) - 1.0 / 16.0).abs() < 1e-16);
        assert!((beta(3) - 3.0 / 16.0).abs() < 1e-16);
        assert!((omega(6) - 1.0 / 12.0).abs() < 1e-16);
        assert!((omega(3) - 1.0 / 5.0).abs() < 1e-15);
    }

    /// The limit mask is the left eigenvector of the subdivision matrix of a one-ring for the
    /// eigenvalue 1. Applied after one step, it gives the same point.
    #[test]
    fn limit_mask_is_invariant_under_subdivision() {
        for n in 3..40 {
            let (centre, ring) = limit_mask(n);
            let b = beta(n);
            let m = n as f64;
            // weight of the old centre in the limit of the subdivided ring, then of one neighbour
            let old_centre = centre * (1.0 - m * b) + m * ring * EDGE_END;
            let old_ring = centre * b + ring * (EDGE_END + 2.0 * EDGE_OPPOSITE);
            assert!((old_centre - centre).abs() < 1e-15, "valence {n}");
            assert!((old_ring - ring).abs() < 1e-15, "valence {n}");
        }
    }

    #[test]
    fn samples_are_spread_evenly() {
        assert!(sample(EXACT_VALENCE).eq(0..EXACT_VALENCE));
        for n in [EXACT_VALENCE + 1, 100, 4097] {
            let places: Vec<usize> = sample(n).collect();
            assert_eq!((places.len(), places[0]), (SAMPLE, 0));
            let ends = places.iter().chain([&n]);
            let gaps = places.iter().zip(ends.skip(1)).map(|(a, b)| b - a);
            assert!(gaps.into_iter().all(|gap| gap.abs_diff(n / SAMPLE) <= 1));
        }
    }

    /// The tangent masks are left eigenvectors for the eigenvalue `3/8 + cos(2 pi / n) / 4`.
    #[test]
    fn tangent_masks_are_eigenvectors() {
        for n in 3..40 {
            let mask: Vec<_> = tangent_mask(n).collect();
            let lambda = EDGE_END + 2.0 * EDGE_OPPOSITE * (TAU / n as f64).cos();
            for j in 0..n {
                let (before, at, after) = (mask[(j + n - 1) % n], mask[j], mask[(j + 1) % n]);
                let c = EDGE_END * at.0 + EDGE_OPPOSITE * (before.0 + after.0);
                let s = EDGE_END * at.1 + EDGE_OPPOSITE * (before.1 + after.1);
                assert!((c - lambda * at.0).abs() < 1e-14);
                assert!((s - lambda * at.1).abs() < 1e-14);
            }
            let sum = mask.iter().fold((0.0, 0.0), |s, m| (s.0 + m.0, s.1 + m.1));
            assert!(sum.0.abs() < 1e-13 && sum.1.abs() < 1e-13);
        }
    }
}
