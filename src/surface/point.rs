//! The geometry of a limit surface at one point.
//!
//! Symbols follow the paper: `g_ab` is the first and `b_ab` the second fundamental form, `Δ` the
//! Laplace–Beltrami and `□` the Giaquinta–Hildebrandt operator, `∇` and `◇` their gradients.

use crate::mesh::DVec3;
use crate::subdivision::Elements;

/// First and second fundamental form at a point, and the coefficients of the operators.
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
    /// `g^ab Γ^c_ab`: coefficients of the first derivatives in the Laplacian.
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

/// Mean curvature of the limit surface on a face: the average over the points of its table.
pub fn mean_curvature(elements: &Elements, element: usize, positions: &[DVec3]) -> f64 {
    let mut sum = 0.0;
    each_point(elements, element, positions, |_, p| sum += p.mean);
    sum / elements.table(element).points as f64
}

/// Calls `visit` with the point and the geometry at every quadrature point of an element.
pub fn each_point(
    elements: &Elements,
    element: usize,
    positions: &[DVec3],
    mut visit: impl FnMut(DVec3, &PointGeometry),
) {
    for point in 0..elements.table(element).points {
        let (at, geometry) = surface_point(elements, element, point, positions);
        visit(at, &geometry);
    }
}

/// Evaluates one point of an element's table: the position on the limit surface and the geometry.
#[inline]
pub fn surface_point(
    elements: &Elements,
    element: usize,
    point: usize,
    positions: &[DVec3],
) -> (DVec3, PointGeometry) {
    let table = elements.table(element);
    let vertices = elements.vertices_of(element);
    let at = |d: usize| {
        let row = table.row(point, d);
        vertices
            .iter()
            .zip(row)
            .fold(DVec3::ZERO, |sum, (&v, &b)| sum + positions[v as usize] * b)
    };
    let geometry = PointGeometry::new(at(1), at(2), at(3), at(4), at(5));
    (at(0), geometry)
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
        // z = cos u is a spherical harmonic: Δz = −2/r² z, and □ = −1/r Δ on a sphere... with b =
        // −g/r
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
}
