//! The integrands of the weak form at one quadrature point.
//!
//! Symbols follow the paper: `Δ` the Laplace–Beltrami and `□` the Giaquinta–Hildebrandt operator,
//! `∇` and `◇` their gradients.

use crate::energy::Jet2;
use crate::mesh::DVec3;
use crate::surface::{Coefficients, PointGeometry};

/// The first variation (12) at a point: `δE[φ] = a_u φ_u + a_v φ_v + n (q · (φ_uu, φ_uv, φ_vv))`,
/// a vector.
#[derive(Clone, Copy, Debug)]
pub struct Variation {
    /// Multiplies `φ_u`.
    pub a_u: DVec3,
    /// Multiplies `φ_v`.
    pub a_v: DVec3,
    /// Multiplies the second derivatives; the direction is the normal.
    pub q: [f64; 3],
}

/// `f_H ◇φ + (f − 2H f_H − 2K f_K) ∇φ + ½ f_H n Δφ + f_K n □φ`, equation (12), times `weight`.
#[inline(always)]
#[expect(clippy::inline_always, reason = "see PointGeometry::new")]
pub fn variation(p: &PointGeometry, jet: &Jet2, weight: f64) -> Variation {
    let c = jet.f - 2.0 * p.mean * jet.h - 2.0 * p.gauss * jet.k;
    let m = [0, 1, 2].map(|i| weight * (jet.h * p.h_inv[i] + c * p.g_inv[i]));
    let [d_u, d_v] = p.raise(m);
    let half_h = 0.5 * weight * jet.h;
    let f_k = weight * jet.k;
    let q = [0, 1, 2].map(|i| half_h * p.g_inv[i] + f_k * p.h_inv[i]);
    let first = [0, 1].map(|i| half_h * p.gamma_g[i] + f_k * p.gamma_h[i]);
    Variation {
        a_u: d_u - p.normal * first[0],
        a_v: d_v - p.normal * first[1],
        q: [q[0], 2.0 * q[1], q[2]],
    }
}

/// `δH / <N, n> = ½ Δφ + (2H² − K) φ` for a displacement `φ N`, as coefficients.
#[inline(always)]
#[expect(clippy::inline_always, reason = "see PointGeometry::new")]
pub fn mean_variation(p: &PointGeometry) -> Coefficients {
    let mut c = p.laplacian().map(|x| 0.5 * x);
    c[0] = 2.0 * p.mean * p.mean - p.gauss;
    c
}

/// `δK / <N, n> = □φ + 2HK φ` for a displacement `φ N`, as coefficients.
#[inline(always)]
#[expect(clippy::inline_always, reason = "see PointGeometry::new")]
pub fn gauss_variation(p: &PointGeometry) -> Coefficients {
    let mut c = p.box_operator();
    c[0] = 2.0 * p.mean * p.gauss;
    c
}

/// The positive part of the Hessian of `f`, as two weights-and-directions in `(δH, δK)`.
///
/// The clipping uses the scaled variables `(r H, r² K)`, with `r` the hole radius, so that it does
/// not depend on the unit of length (formulation, section 6).
#[derive(Clone, Copy, Debug, Default)]
pub struct PositiveHessian {
    /// `√λ_i v_i`, in `(H, K)`; zero where the eigenvalue is not positive.
    pub factors: [[f64; 2]; 2],
}

impl PositiveHessian {
    /// Spectral clipping of `D Hess D`, `D = diag(1/r, 1/r²)`.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "see PointGeometry::new")]
    pub fn new(jet: &Jet2, radius: f64) -> Self {
        let (d1, d2) = (1.0 / radius, 1.0 / (radius * radius));
        let (a, b, c) = (jet.hh * d1 * d1, jet.hk * d1 * d2, jet.kk * d2 * d2);
        let (r1, r2) = (radius, radius * radius);
        if b == 0.0 {
            return Self {
                factors: [[a.max(0.0).sqrt() * r1, 0.0], [0.0, c.max(0.0).sqrt() * r2]],
            };
        }
        let mean = 0.5 * (a + c);
        let half = 0.5 * (a - c);
        let root = half.hypot(b);
        let mut factors = [[0.0; 2]; 2];
        for (k, lambda) in [mean + root, mean - root].into_iter().enumerate() {
            if lambda > 0.0 {
                // the better-conditioned of the two rows of (A − λI) v = 0
                let (x, y) = if (a - lambda).abs() > (c - lambda).abs() {
                    (b, lambda - a)
                } else {
                    (lambda - c, b)
                };
                let s = lambda.sqrt() / x.hypot(y);
                factors[k] = [s * x * r1, s * y * r2];
            }
        }
        Self { factors }
    }

    /// Whether the clipped Hessian alone gives a strictly elliptic operator. This compares the
    /// minimum of `¼ P_HH + P_HK b + P_KK b²`, over `b` between the principal curvatures, with its
    /// scale.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "see PointGeometry::new")]
    pub fn is_elliptic(&self, mean: f64, gauss: f64, radius: f64) -> bool {
        let [[a0, a1], [b0, b1]] = self.factors;
        let (p_hh, p_hk, p_kk) = (a0 * a0 + b0 * b0, a0 * a1 + b0 * b1, a1 * a1 + b1 * b1);
        let s = (mean * mean - gauss).max(0.0).sqrt();
        let symbol = |b: f64| 0.25 * p_hh + p_hk * b + p_kk * b * b;
        let mut least = symbol(mean - s).min(symbol(mean + s));
        if p_kk > 0.0 {
            let vertex = -0.5 * p_hk / p_kk;
            if (vertex - mean).abs() < s {
                least = least.min(symbol(vertex));
            }
        }
        least > 1e-3 * (0.25 * p_hh + p_kk / (radius * radius))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positive_part_is_positive_and_keeps_definite_hessians() {
        let jet = Jet2 {
            hh: 3.0,
            hk: 1.0,
            kk: 2.0,
            ..Jet2::default()
        };
        for radius in [1.0, 0.01, 50.0] {
            let [a, b] = PositiveHessian::new(&jet, radius).factors;
            assert!((a[0] * a[0] + b[0] * b[0] - 3.0).abs() < 1e-10);
            assert!((a[0] * a[1] + b[0] * b[1] - 1.0).abs() < 1e-10);
            assert!((a[1] * a[1] + b[1] * b[1] - 2.0).abs() < 1e-10);
        }
        let concave = Jet2 {
            hh: -3.0,
            hk: 0.5,
            kk: -2.0,
            ..Jet2::default()
        };
        assert_eq!(PositiveHessian::new(&concave, 1.0).factors, [[0.0; 2]; 2]);
        assert!(!PositiveHessian::new(&concave, 1.0).is_elliptic(0.0, 0.0, 1.0));
        assert!(PositiveHessian::new(&jet, 1.0).is_elliptic(0.1, -0.2, 1.0));
    }
}
