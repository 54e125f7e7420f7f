//! Surface geometry and the integrands of the weak form at one quadrature point.
//!
//! Symbols follow the paper: `g_ab` first and `b_ab` second fundamental form, `Δ` the
//! Laplace–Beltrami and `□` the Giaquinta–Hildebrandt operator, `∇` and `◇` their gradients.

use crate::energy::Jet2;
use crate::mesh::DVec3;

/// First and second fundamental form at a point, and what the operators need of them.
#[derive(Clone, Copy, Debug)]
pub struct PointGeometry {
    /// Tangents `x_u`, `x_v`.
    pub x_u: DVec3,
    /// See `x_u`.
    pub x_v: DVec3,
    /// Unit normal along `x_u × x_v`.
    pub normal: DVec3,
    /// `√det g`, area of the unit parameter square.
    pub sqrt_g: f64,
    /// `g^11, g^12, g^22`.
    pub g_inv: [f64; 3],
    /// `h^11, h^12, h^22` with `h = (1/g) [[b22, -b12], [-b12, b11]]`; it exists where `K = 0`.
    pub h_inv: [f64; 3],
    /// `g^ab Γ^c_ab`: what the Laplacian takes from the first derivatives.
    pub gamma_g: [f64; 2],
    /// `h^ab Γ^c_ab`: the same for `□`.
    pub gamma_h: [f64; 2],
    /// Mean curvature `(k1 + k2) / 2`; −1/R on a sphere with outward normal.
    pub mean: f64,
    /// Gaussian curvature `k1 k2`.
    pub gauss: f64,
}

/// Coefficients of a linear differential form `c · (φ, φ_u, φ_v, φ_uu, φ_uv, φ_vv)`.
pub type Coefficients = [f64; 6];

impl PointGeometry {
    /// From the derivatives `x_u, x_v, x_uu, x_uv, x_vv`. A degenerate point (`x_u ∥ x_v`) gives
    /// values that are not finite.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "part of the element kernels, which are compiled once per instruction set"
    )]
    pub fn new(x_u: DVec3, x_v: DVec3, x_uu: DVec3, x_uv: DVec3, x_vv: DVec3) -> Self {
        let (g11, g12, g22) = (x_u.dot(x_u), x_u.dot(x_v), x_v.dot(x_v));
        let cross = x_u.cross(x_v);
        let det = cross.dot(cross);
        let sqrt_g = det.sqrt();
        let inv = 1.0 / det;
        let normal = cross * (1.0 / sqrt_g);
        let (b11, b12, b22) = (normal.dot(x_uu), normal.dot(x_uv), normal.dot(x_vv));
        let g_inv = [g22 * inv, -g12 * inv, g11 * inv];
        let h_inv = [b22 * inv, -b12 * inv, b11 * inv];
        let mean = 0.5 * (g_inv[0] * b11 + 2.0 * g_inv[1] * b12 + g_inv[2] * b22);
        let gauss = (b11 * b22 - b12 * b12) * inv;
        // <a^ab x_ab, x_d>, then the index raised
        let trace = |a: [f64; 3]| {
            let s = x_uu * a[0] + x_uv * (2.0 * a[1]) + x_vv * a[2];
            let (s_u, s_v) = (s.dot(x_u), s.dot(x_v));
            [
                g_inv[0] * s_u + g_inv[1] * s_v,
                g_inv[1] * s_u + g_inv[2] * s_v,
            ]
        };
        Self {
            x_u,
            x_v,
            normal,
            sqrt_g,
            g_inv,
            h_inv,
            gamma_g: trace(g_inv),
            gamma_h: trace(h_inv),
            mean,
            gauss,
        }
    }

    /// `Δφ = g^ab (φ_ab − Γ^c_ab φ_c)` as coefficients.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "see PointGeometry::new")]
    pub fn laplacian(&self) -> Coefficients {
        let g = &self.g_inv;
        [
            0.0,
            -self.gamma_g[0],
            -self.gamma_g[1],
            g[0],
            2.0 * g[1],
            g[2],
        ]
    }

    /// `□φ = h^ab (φ_ab − Γ^c_ab φ_c)` as coefficients.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "see PointGeometry::new")]
    pub fn box_operator(&self) -> Coefficients {
        let h = &self.h_inv;
        [
            0.0,
            -self.gamma_h[0],
            -self.gamma_h[1],
            h[0],
            2.0 * h[1],
            h[2],
        ]
    }

    /// `[x_u x_v] a^ab [φ_u φ_v]ᵀ` as the two vectors that multiply `φ_u` and `φ_v`: `∇φ` for
    /// `a = g^ab`, `◇φ` for `a = h^ab`.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "see PointGeometry::new")]
    pub fn raise(&self, a: [f64; 3]) -> [DVec3; 2] {
        [
            self.x_u * a[0] + self.x_v * a[1],
            self.x_u * a[1] + self.x_v * a[2],
        ]
    }
}

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
/// The clipping is done in the scaled variables `(r H, r² K)`, `r` the hole radius, so that it does
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

    /// Whether the clipped Hessian alone gives a strictly elliptic operator: the least over `b`
    /// between the principal curvatures of `¼ P_HH + P_HK b + P_KK b²`, against its scale.
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

    /// A sphere of radius `r` in spherical coordinates, outward normal.
    fn sphere(r: f64, u: f64, v: f64) -> PointGeometry {
        let (su, cu, sv, cv) = (u.sin(), u.cos(), v.sin(), v.cos());
        PointGeometry::new(
            r * DVec3::new(cu * cv, cu * sv, -su),
            r * DVec3::new(-su * sv, su * cv, 0.0),
            r * DVec3::new(-su * cv, -su * sv, -cu),
            r * DVec3::new(-cu * sv, cu * cv, 0.0),
            r * DVec3::new(-su * cv, -su * sv, 0.0),
        )
    }

    #[test]
    fn sphere_has_negative_mean_curvature_and_eigenfunctions() {
        let (r, u, v) = (1.7, 0.8, 0.3);
        let p = sphere(r, u, v);
        assert!((p.mean + 1.0 / r).abs() < 1e-14);
        assert!((p.gauss - 1.0 / (r * r)).abs() < 1e-14);
        // z = cos u is a spherical harmonic: Δz = −2/r² z, and □ = −1/r Δ on a sphere... with b = −g/r
        let phi = [u.cos(), -u.sin(), 0.0, -u.cos(), 0.0, 0.0];
        let apply = |c: Coefficients| -> f64 { c.iter().zip(phi).map(|(a, b)| a * b).sum() };
        assert!((apply(p.laplacian()) + 2.0 / (r * r) * phi[0]).abs() < 1e-13);
        assert!((apply(p.box_operator()) - 2.0 / (r * r * r) * phi[0]).abs() < 1e-13);
    }

    #[test]
    fn laplacian_and_box_of_position_are_curvature_normals() {
        // a general quadratic surface point: Δx = 2Hn, □x = 2Kn
        let d = [
            DVec3::new(1.0, 0.2, -0.3),
            DVec3::new(-0.1, 0.9, 0.4),
            DVec3::new(0.3, -0.2, 0.8),
            DVec3::new(-0.5, 0.1, 0.3),
            DVec3::new(0.2, 0.6, -0.4),
        ];
        let p = PointGeometry::new(d[0], d[1], d[2], d[3], d[4]);
        let apply = |c: Coefficients| (0..5).fold(DVec3::ZERO, |sum, i| sum + d[i] * c[i + 1]);
        assert!((apply(p.laplacian()) - 2.0 * p.mean * p.normal).length() < 1e-13);
        assert!((apply(p.box_operator()) - 2.0 * p.gauss * p.normal).length() < 1e-13);
    }

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
