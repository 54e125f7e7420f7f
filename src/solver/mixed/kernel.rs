//! Element integrals of scheme A. They have no global indices and do not allocate.

use crate::energy::{Energy, Jet2};
use crate::mesh::DVec3;
use crate::solver::mixed::splitting::Splitting;
use crate::subdivision::{BasisTable, Rule};
use crate::surface::PointGeometry;

/// Derivatives of the piecewise linear `ψ` of the three corners by the parameters.
const DPSI: [[f64; 2]; 3] = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];

/// The piecewise linear `ψ` of the three corners at a parameter point.
fn psi(v: f64, w: f64) -> [f64; 3] {
    [1.0 - v - w, v, w]
}

/// An element's integrals, as ranges of one array; `n` control vertices, corners `c`.
#[derive(Clone, Copy)]
pub struct Layout {
    n: usize,
}

impl Layout {
    /// For `n` control vertices.
    pub fn new(n: usize) -> Self {
        Self { n }
    }

    /// Length of the array.
    pub fn len(self) -> usize {
        self.rest() + 36
    }

    /// `∫ φ_i φ_j` at `[i][j]`, `j ≤ i`.
    pub fn mass(self, i: usize, j: usize) -> usize {
        i * self.n + j
    }

    /// `l^p_ij = ∫ μ ∇φ_jᵀ◇φ_i + η ∇φ_jᵀ∇φ_i` at `[i][j]`, `j ≤ i`.
    pub fn stiffness(self, i: usize, j: usize) -> usize {
        self.n * self.n + i * self.n + j
    }

    /// Entry `(row, column)` of the 3 × 3 block `l^m_ic`, for `i = 0..n`.
    pub fn b(self, corner: usize, row: usize, column: usize) -> usize {
        2 * self.n * self.n + (corner * 9 + row * 3 + column) * self.n
    }

    /// Entry `(row, column)` of the 3 × 3 block `l^g_ic`, for `i = 0..n`.
    pub fn c(self, corner: usize, row: usize, column: usize) -> usize {
        self.b(corner, row, column) + 27 * self.n
    }

    /// `l¹_ci = ∫ ∇φ_iᵀ∇ψ_c`, for `i = 0..n`.
    pub fn l1(self, corner: usize) -> usize {
        2 * self.n * self.n + (54 + corner) * self.n
    }

    /// `l²_ci = ∫ ∇φ_iᵀ◇ψ_c`, for `i = 0..n`.
    pub fn l2(self, corner: usize) -> usize {
        self.l1(corner) + 3 * self.n
    }

    fn rest(self) -> usize {
        2 * self.n * self.n + 60 * self.n
    }

    /// `m_cd = ∫ ψ_c ψ_d`.
    pub fn m(self, c: usize, d: usize) -> usize {
        self.rest() + 3 * c + d
    }

    /// The vector `−∫ ∇ψ_c = −Σ_j l¹_cj x_j`.
    pub fn rhs_h(self, corner: usize) -> usize {
        self.rest() + 9 + 3 * corner
    }

    /// The vector `−∫ ◇ψ_c = −Σ_j l²_cj x_j`.
    pub fn rhs_k(self, corner: usize) -> usize {
        self.rest() + 18 + 3 * corner
    }

    /// `∫ ψ_c (½α, ½(½β + γ), δ)`.
    pub fn weight(self, corner: usize) -> usize {
        self.rest() + 27 + 3 * corner
    }
}

/// Geometry and energy at a quadrature point, and the rows of the basis table there.
struct Point<'a> {
    p: PointGeometry,
    jet: Jet2,
    /// Quadrature weight times area element.
    area: f64,
    psi: [f64; 3],
    rows: [&'a [f64]; 6],
}

/// Memory of one thread.
#[derive(Default)]
pub struct Scratch {
    /// Control points of the element, by coordinate.
    pub x: [Vec<f64>; 3],
    /// Values at the control vertices.
    pub scalar: Vec<f64>,
    /// The same.
    pub entry: Vec<f64>,
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "part of the element kernels")]
fn point<'a>(energy: &Energy, table: &'a BasisTable, x: &[Vec<f64>; 3], at: usize) -> Point<'a> {
    let rows: [&[f64]; 6] = std::array::from_fn(|d| table.row(at, d));
    let n = table.n;
    let derivative = |d: usize| {
        let dot = |x: &[f64]| -> f64 { rows[d].iter().zip(&x[..n]).map(|(a, b)| a * b).sum() };
        DVec3::new(dot(&x[0]), dot(&x[1]), dot(&x[2]))
    };
    let p = PointGeometry::new(
        derivative(1),
        derivative(2),
        derivative(3),
        derivative(4),
        derivative(5),
    );
    let [v, w] = Rule::Twelve.points()[at];
    Point {
        jet: energy.jet(p.mean, p.gauss),
        area: Rule::Twelve.weight() * 0.5 * p.sqrt_g,
        p,
        psi: psi(v, w),
        rows,
    }
}

/// `Σ_d c_d φ_d` for a coefficient vector of `(φ, φ_u, …)`, over the derivatives.
#[inline(always)]
#[expect(clippy::inline_always, reason = "part of the element kernels")]
fn combine(c: &[f64; 6], rows: &[&[f64]; 6], out: &mut [f64]) {
    let n = out.len();
    let [u, v, uu, uv, vv] = std::array::from_fn(|d| &rows[d + 1][..n]);
    for i in 0..n {
        out[i] = c[1] * u[i] + c[2] * v[i] + c[3] * uu[i] + c[4] * uv[i] + c[5] * vv[i];
    }
}

/// All matrices of one element, equations (19)-(21), into `out` in the order of [`Layout`]; `doubled`
/// as in [`Splitting`].
#[inline(always)]
#[expect(clippy::inline_always, reason = "compiled once per instruction set")]
pub fn matrices(
    energy: &Energy,
    doubled: bool,
    table: &BasisTable,
    scratch: &mut Scratch,
    out: &mut [f64],
) {
    let n = table.n;
    let at = Layout::new(n);
    out.fill(0.0);
    let Scratch { x, scalar, entry } = scratch;
    scalar.resize(n, 0.0);
    entry.resize(n, 0.0);
    for k in 0..table.points {
        let Point {
            p,
            jet,
            area,
            psi,
            rows,
        } = point(energy, table, x, k);
        let s = Splitting::new(&jet, p.mean, p.gauss, doubled);
        let (value, du, dv) = (&rows[0][..n], &rows[1][..n], &rows[2][..n]);

        let t: [f64; 3] = std::array::from_fn(|i| area * (s.mu * p.h_inv[i] + s.eta * p.g_inv[i]));
        for i in 0..n {
            let (w, tu, tv) = (
                area * value[i],
                t[0] * du[i] + t[1] * dv[i],
                t[1] * du[i] + t[2] * dv[i],
            );
            let mass = &mut out[at.mass(i, 0)..=at.mass(i, i)];
            for (m, f) in mass.iter_mut().zip(value) {
                *m += w * f;
            }
            let stiffness = &mut out[at.stiffness(i, 0)..=at.stiffness(i, i)];
            for ((m, fu), fv) in stiffness.iter_mut().zip(du).zip(dv) {
                *m += tu * fu + tv * fv;
            }
        }

        let (lap, bx) = (p.laplacian(), p.box_operator());
        for (begin, tangent, normal) in [
            (
                at.b(0, 0, 0),
                [s.alpha, s.omega - jet.h],
                [0.5 * s.alpha, s.gamma],
            ),
            (
                at.c(0, 0, 0),
                [s.beta, s.varpi - jet.k],
                [0.5 * s.beta, s.delta],
            ),
        ] {
            if tangent == [0.0; 2] && normal == [0.0; 2] {
                continue;
            }
            let d = p.raise(std::array::from_fn(|i| {
                area * (tangent[0] * p.h_inv[i] + tangent[1] * p.g_inv[i])
            }));
            let q: [f64; 6] =
                std::array::from_fn(|i| area * (normal[0] * lap[i] + normal[1] * bx[i]));
            combine(&q, &rows, scalar);
            for row in 0..3 {
                for column in 0..3 {
                    let (a, b) = (d[0][row] * p.normal[column], d[1][row] * p.normal[column]);
                    for (((e, u), v), s) in entry.iter_mut().zip(du).zip(dv).zip(&*scalar) {
                        *e = a * u + b * v + if row == column { *s } else { 0.0 };
                    }
                    for corner in 0..3 {
                        let begin = begin + (corner * 9 + row * 3 + column) * n;
                        for (m, e) in out[begin..begin + n].iter_mut().zip(&*entry) {
                            *m += psi[corner] * e;
                        }
                    }
                }
            }
        }

        for corner in 0..3 {
            let d = DPSI[corner];
            for (begin, rhs, a) in [
                (at.l1(corner), at.rhs_h(corner), p.g_inv),
                (at.l2(corner), at.rhs_k(corner), p.h_inv),
            ] {
                let (cu, cv) = (
                    area * (a[0] * d[0] + a[1] * d[1]),
                    area * (a[1] * d[0] + a[2] * d[1]),
                );
                for ((m, fu), fv) in out[begin..begin + n].iter_mut().zip(du).zip(dv) {
                    *m += cu * fu + cv * fv;
                }
                let r = p.x_u * cu + p.x_v * cv;
                out[rhs] -= r.x;
                out[rhs + 1] -= r.y;
                out[rhs + 2] -= r.z;
            }
            for other in 0..3 {
                out[at.m(corner, other)] += area * psi[corner] * psi[other];
            }
            let w = area * psi[corner];
            let begin = at.weight(corner);
            out[begin] += w * 0.5 * s.alpha;
            out[begin + 1] += w * 0.5 * (0.5 * s.beta + s.gamma);
            out[begin + 2] += w * s.delta;
        }
    }
}

/// `Σ_j l^p_ij x_j + l^m_ij h_j + l^g_ij k_j + b_i` of one element: x, y and z components one after
/// the other, `n` each. `h` and `k` are given at the corners.
#[inline(always)]
#[expect(clippy::inline_always, reason = "compiled once per instruction set")]
pub fn residual(
    energy: &Energy,
    table: &BasisTable,
    scratch: &mut Scratch,
    h: &[DVec3; 3],
    k: &[DVec3; 3],
    out: &mut [f64],
) {
    let n = table.n;
    let Scratch { x, scalar, .. } = scratch;
    scalar.resize(n, 0.0);
    out.fill(0.0);
    for at in 0..table.points {
        let Point {
            p,
            jet,
            area,
            psi,
            rows,
        } = point(energy, table, x, at);
        let blend = |f: &[DVec3; 3]| f[0] * psi[0] + f[1] * psi[1] + f[2] * psi[2];
        let form = mixed_variation(&p, &jet, blend(h), blend(k), area);
        for axis in 0..3 {
            let c = form.map(|v| v[axis]);
            combine(&[0.0, c[0], c[1], c[2], c[3], c[4]], &rows, scalar);
            for (r, s) in out[axis * n..(axis + 1) * n].iter_mut().zip(&*scalar) {
                *r += s;
            }
        }
    }
}

/// The mixed form of the first variation at a point with curvature normals `h` and `k`, times
/// `weight`: what multiplies `φ_u, φ_v, φ_uu, φ_uv, φ_vv`.
#[inline(always)]
#[expect(clippy::inline_always, reason = "part of the element kernels")]
pub fn mixed_variation(
    p: &PointGeometry,
    jet: &Jet2,
    h: DVec3,
    k: DVec3,
    weight: f64,
) -> [DVec3; 5] {
    let s = Splitting::new(jet, p.mean, p.gauss, false);
    let (hn, kn) = (h.dot(p.normal), k.dot(p.normal));
    // everything that multiplies ◇φ and ∇φ ...
    let diamond = s.alpha * hn + s.beta * kn + s.mu;
    let nabla = (s.omega - jet.h) * hn + (s.varpi - jet.k) * kn + s.eta;
    let d = p.raise(std::array::from_fn(|i| {
        weight * (diamond * p.h_inv[i] + nabla * p.g_inv[i])
    }));
    // ... and the vectors that multiply Δφ and □φ
    let lap_by = (h * s.alpha + k * s.beta + p.normal * s.mu) * (0.5 * weight);
    let box_by = (h * s.gamma + k * s.delta + p.normal * s.nu) * weight;
    let (lap, bx) = (p.laplacian(), p.box_operator());
    let mut out = std::array::from_fn(|i| lap_by * lap[i + 1] + box_by * bx[i + 1]);
    out[0] += d[0];
    out[1] += d[1];
    out
}

/// `∫ψ_c`, `∫ψ_c 2Hn` and `∫ψ_c 2Kn` over one element.
pub fn curvature_moments(table: &BasisTable, x: &[DVec3]) -> [(f64, DVec3, DVec3); 3] {
    let mut out = [(0.0, DVec3::ZERO, DVec3::ZERO); 3];
    for (at, &[v, w]) in Rule::Twelve.points().iter().enumerate() {
        let d = |d: usize| {
            table
                .row(at, d)
                .iter()
                .zip(x)
                .fold(DVec3::ZERO, |sum, (&b, &x)| sum + x * b)
        };
        let p = PointGeometry::new(d(1), d(2), d(3), d(4), d(5));
        for (o, psi) in out.iter_mut().zip(psi(v, w)) {
            let weight = Rule::Twelve.weight() * 0.5 * p.sqrt_g * psi;
            o.0 += weight;
            o.1 += p.normal * (2.0 * p.mean * weight);
            o.2 += p.normal * (2.0 * p.gauss * weight);
        }
    }
    out
}
