//! Element kernels: energy, gradient (12) and the matrix of scheme B on one triangle.
//!
//! A kernel has no global indices and does not allocate. Control vertices are padded with zeros to
//! a multiple of four ("chunks" of `Lane`), so that the loops over them vectorise. The common chunk
//! counts are compiled with the count as a constant.

use crate::energy::Energy;
use crate::mesh::DVec3;
use crate::solver::forms::{PositiveHessian, gauss_variation, mean_variation, variation};
use crate::surface::{Coefficients, PointGeometry};

/// Four numbers that are processed together.
pub type Lane = [f64; 4];

/// Maximum number of rank-one terms of a quadrature point: mass, two of the Hessian, two of the
/// membrane.
pub const TERMS_PER_POINT: usize = 5;

/// Data shared by all elements of one assembly.
pub struct KernelInput<'a> {
    /// The energy.
    pub energy: &'a Energy,
    /// Hole radius, for the clipping of the Hessian.
    pub radius: f64,
    /// 1/τ, the weight of the mass matrix.
    pub inv_tau: f64,
    /// Whether the membrane term is included everywhere, or only where the Hessian part is not
    /// strictly elliptic.
    pub membrane: bool,
    /// Whether the directions represent displacements that are normal to the surface everywhere.
    /// `<N_i, n>` is then 1 for moving vertices.
    pub isotropic: bool,
    /// Quadrature weight of a point (before ½√g).
    pub weight: f64,
    /// Number of quadrature points.
    pub points: usize,
}

/// One element's data, gathered and padded: `x` and `normals` hold x, y and z components one after
/// the other, `chunks` lanes each; `table` is `[point][derivative][chunk]`.
pub struct ElementInput<'a> {
    /// Basis values and derivatives.
    pub table: &'a [Lane],
    /// Control points.
    pub x: &'a [Lane],
    /// Directions in which the control points move; zero where they are fixed.
    pub normals: &'a [Lane],
}

/// The output buffers of one element.
pub struct ElementOutput<'a> {
    /// Gradient of the energy, components as in [`ElementInput::x`].
    pub gradient: &'a mut [Lane],
    /// Rows of `chunks` lanes, filled up to and including the diagonal's lane; empty if no matrix
    /// is needed.
    pub matrix: &'a mut [Lane],
    /// Scratch: `TERMS_PER_POINT * points * chunks` lanes; empty if no matrix is needed.
    pub terms: &'a mut [Lane],
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "part of the element kernels")]
fn add_product(acc: &mut Lane, a: &Lane, b: &Lane) {
    for l in 0..4 {
        acc[l] += a[l] * b[l];
    }
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "part of the element kernels")]
fn add_scaled(acc: &mut Lane, a: f64, b: &Lane) {
    for l in 0..4 {
        acc[l] += a * b[l];
    }
}

/// Computes the energy of one element. Writes its gradient (unless the output is empty) and, if
/// requested, its matrix.
#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "compiled once per instruction set and chunk count"
)]
pub fn element<const MATRIX: bool>(
    chunks: usize,
    input: &KernelInput<'_>,
    element: &ElementInput<'_>,
    out: &mut ElementOutput<'_>,
) -> f64 {
    match chunks {
        3 => element_impl::<MATRIX>(3, input, element, out),
        4 => element_impl::<MATRIX>(4, input, element, out),
        5 => element_impl::<MATRIX>(5, input, element, out),
        _ => element_impl::<MATRIX>(chunks, input, element, out),
    }
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "see element")]
fn element_impl<const MATRIX: bool>(
    chunks: usize,
    input: &KernelInput<'_>,
    element: &ElementInput<'_>,
    out: &mut ElementOutput<'_>,
) -> f64 {
    let (xs, rest) = element.x.split_at(chunks);
    let (ys, zs) = rest.split_at(chunks);
    let zs = &zs[..chunks];
    let gradient = &mut out.gradient;
    gradient.fill([0.0; 4]);
    let wanted = gradient.len() / 3;
    let (gx, rest) = gradient.split_at_mut(wanted);
    let (gy, gz) = rest.split_at_mut(wanted);

    let mut energy = 0.0;
    let mut term_count = 0;
    for point in 0..input.points {
        let table = &element.table[point * 6 * chunks..][..6 * chunks];
        let row = |d: usize| &table[d * chunks..(d + 1) * chunks];
        let p = PointGeometry::new(
            interpolate(row(1), xs, ys, zs),
            interpolate(row(2), xs, ys, zs),
            interpolate(row(3), xs, ys, zs),
            interpolate(row(4), xs, ys, zs),
            interpolate(row(5), xs, ys, zs),
        );
        let jet = input.energy.jet(p.mean, p.gauss);
        let area = input.weight * 0.5 * p.sqrt_g;
        energy += area * jet.f;

        if wanted == 0 {
            continue;
        }
        let (gx, gy, gz) = (&mut gx[..chunks], &mut gy[..chunks], &mut gz[..chunks]);
        let var = variation(&p, &jet, area);
        let (nu, nv) = (row(1), row(2));
        let (nuu, nuv, nvv) = (row(3), row(4), row(5));
        for c in 0..chunks {
            for l in 0..4 {
                let s = var.q[0] * nuu[c][l] + var.q[1] * nuv[c][l] + var.q[2] * nvv[c][l];
                gx[c][l] += var.a_u.x * nu[c][l] + var.a_v.x * nv[c][l] + p.normal.x * s;
                gy[c][l] += var.a_u.y * nu[c][l] + var.a_v.y * nv[c][l] + p.normal.y * s;
                gz[c][l] += var.a_u.z * nu[c][l] + var.a_v.z * nv[c][l] + p.normal.z * s;
            }
        }

        if MATRIX {
            let mut list = TermList::default();
            list.push([(area * input.inv_tau).sqrt(), 0.0, 0.0, 0.0, 0.0, 0.0]);
            let hessian = PositiveHessian::new(&jet, input.radius);
            let (dh, dk) = (mean_variation(&p), gauss_variation(&p));
            let root = area.sqrt();
            for factor in hessian.factors {
                if factor != [0.0; 2] {
                    let (a, b) = (root * factor[0], root * factor[1]);
                    list.push(std::array::from_fn(|i| a * dh[i] + b * dk[i]));
                }
            }
            if jet.f > 0.0
                && (input.membrane || !hessian.is_elliptic(p.mean, p.gauss, input.radius))
            {
                // f <N_i, n> <N_j, n> ∇φ_i·∇φ_j through the Cholesky factor of g^ab
                let s = (area * jet.f).sqrt();
                let l11 = p.g_inv[0].sqrt();
                let l21 = p.g_inv[1] / l11;
                let l22 = (p.g_inv[2] - l21 * l21).max(0.0).sqrt();
                list.push([0.0, s * l11, s * l21, 0.0, 0.0, 0.0]);
                list.push([0.0, 0.0, s * l22, 0.0, 0.0, 0.0]);
            }
            project_terms(
                chunks,
                &list.terms[..list.len],
                table,
                element.normals,
                (!input.isotropic).then_some(p.normal),
                &mut out.terms[term_count * chunks..],
            );
            term_count += list.len;
        }
    }
    if MATRIX {
        rank_update(chunks, &out.terms[..term_count * chunks], out.matrix);
    }
    energy
}

/// `Σ_k row_k x_k`.
#[inline(always)]
#[expect(clippy::inline_always, reason = "part of the element kernels")]
fn interpolate(row: &[Lane], xs: &[Lane], ys: &[Lane], zs: &[Lane]) -> DVec3 {
    let (mut ax, mut ay, mut az) = ([0.0; 4], [0.0; 4], [0.0; 4]);
    for (((t, x), y), z) in row.iter().zip(xs).zip(ys).zip(zs) {
        add_product(&mut ax, t, x);
        add_product(&mut ay, t, y);
        add_product(&mut az, t, z);
    }
    DVec3::new(lane_sum(ax), lane_sum(ay), lane_sum(az))
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "part of the element kernels")]
fn lane_sum(a: Lane) -> f64 {
    (a[0] + a[2]) + (a[1] + a[3])
}

/// The rank-one terms of one quadrature point.
#[derive(Default)]
struct TermList {
    terms: [Coefficients; TERMS_PER_POINT],
    len: usize,
}

impl TermList {
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "part of the element kernels")]
    fn push(&mut self, coefficients: Coefficients) {
        self.terms[self.len] = coefficients;
        self.len += 1;
    }
}

/// `<N_i, n> c · (φ_i, φ_i,u, …)` for all control vertices of the element, for each `c` of `list`.
/// Without a normal, the first component of the direction replaces `<N_i, n>`.
#[inline(always)]
#[expect(clippy::inline_always, reason = "part of the element kernels")]
fn project_terms(
    chunks: usize,
    list: &[Coefficients],
    table: &[Lane],
    normals: &[Lane],
    n: Option<DVec3>,
    terms: &mut [Lane],
) {
    for c in 0..chunks {
        let (nx, ny, nz) = (&normals[c], &normals[chunks + c], &normals[2 * chunks + c]);
        let mut along = [0.0; 4];
        match n {
            Some(n) => {
                for l in 0..4 {
                    along[l] = n.x * nx[l] + n.y * ny[l] + n.z * nz[l];
                }
            }
            None => along = *nx,
        }
        for (k, coefficients) in list.iter().enumerate() {
            let mut value = [0.0; 4];
            for d in 0..6 {
                add_scaled(&mut value, coefficients[d], &table[d * chunks + c]);
            }
            let term = &mut terms[k * chunks + c];
            for l in 0..4 {
                term[l] = value[l] * along[l];
            }
        }
    }
}

/// `matrix = Σ term termᵀ`, lanes up to the diagonal.
#[inline(always)]
#[expect(clippy::inline_always, reason = "part of the element kernels")]
fn rank_update(chunks: usize, terms: &[Lane], matrix: &mut [Lane]) {
    for i_chunk in 0..chunks {
        for j_chunk in 0..=i_chunk {
            let mut acc = [[0.0; 4]; 4];
            for term in terms.chunks_exact(chunks) {
                let (a, b) = (&term[i_chunk], &term[j_chunk]);
                for r in 0..4 {
                    add_scaled(&mut acc[r], a[r], b);
                }
            }
            for r in 0..4 {
                matrix[(4 * i_chunk + r) * chunks + j_chunk] = acc[r];
            }
        }
    }
}
