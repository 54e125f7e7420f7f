//! Basis functions of a triangle of the limit surface, by the valences of its corners.

use super::masks::limit_mask;
use super::patch::{Patch, Row};
use super::regular;
use super::rule::Rule;

/// Number of tabulated quantities: `N, N_v, N_w, N_vv, N_vw, N_ww`.
pub const DERIVATIVES: usize = 6;

/// Subdivision steps towards a corner after which the point counts as the corner.
const MAX_STEPS: usize = 100;

/// Values and derivatives of the basis functions of a triangle's control vertices at the points of
/// a quadrature rule or other fixed points.
#[derive(Clone, Debug, PartialEq)]
pub struct BasisTable {
    /// Number of control vertices.
    pub n: usize,
    /// Number of points.
    pub points: usize,
    /// `[point][derivative 0..6][control vertex 0..n]`, row-major and contiguous.
    pub data: Vec<f64>,
}

impl BasisTable {
    /// Tabulates the triangle with the given corner valences (each at least 3), with
    /// `a + b + c - 6` control vertices (4 for the tetrahedron) in standard order. All are treated
    /// as distinct, although some may coincide in a small mesh.
    ///
    /// # Panics
    /// If a valence is less than 3.
    pub fn new(valences: [usize; 3], rule: Rule) -> Self {
        Self::at_points(valences, rule.points())
    }

    /// The same at any points `(v, w)`; derivatives at irregular corners are NaN, see [`basis_at`].
    pub(super) fn at_points(valences: [usize; 3], points: &[[f64; 2]]) -> Self {
        let n = Patch::new(valences).len();
        let mut data = vec![0.0; points.len() * DERIVATIVES * n];
        let mut scratch = Scratch::default();
        for (&[v, w], block) in points.iter().zip(data.chunks_exact_mut(DERIVATIVES * n)) {
            let rows = scratch.rows(valences, v, w);
            for (i, row) in rows.iter().enumerate() {
                for (d, &value) in row.iter().enumerate() {
                    block[d * n + i] = value;
                }
            }
        }
        Self {
            n,
            points: points.len(),
            data,
        }
    }

    /// The table of a flat triangle with its corners as the only control vertices.
    pub(super) fn flat(points: &[[f64; 2]]) -> Self {
        let rows = |&[v, w]: &[f64; 2]| {
            let derivatives = [[1.0 - v - w, v, w], [-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]];
            derivatives.into_iter().chain([[0.0; 3]; 3])
        };
        Self {
            n: 3,
            points: points.len(),
            data: points.iter().flat_map(rows).flatten().collect(),
        }
    }

    /// The `n` values of one derivative (order `N, N_v, N_w, N_vv, N_vw, N_ww`) at one point.
    #[inline]
    pub fn row(&self, point: usize, derivative: usize) -> &[f64] {
        let start = (point * DERIVATIVES + derivative) * self.n;
        &self.data[start..start + self.n]
    }
}

/// Values and derivatives `[N, N_v, N_w, N_vv, N_vw, N_ww]` of each basis function of the triangle
/// with the given corner valences (each at least 3), in standard order, at the point `(v, w)` of
/// the closed parameter triangle.
///
/// At a corner of valence other than 6 the derivatives do not exist in this parametrization. They
/// are NaN there; the values are those of the limit position mask. [`super::limit_normal`] gives
/// the normal.
///
/// # Panics
/// If a valence is less than 3.
pub fn basis_at(valences: [usize; 3], v: f64, w: f64) -> Vec<[f64; DERIVATIVES]> {
    Scratch::default().rows(valences, v, w).to_vec()
}

/// Buffers of an evaluation.
#[derive(Default)]
struct Scratch {
    /// Patches passed on the way down to a regular one, and the child entered at each.
    path: Vec<(Patch, Child)>,
    rows: Vec<Row>,
    lifted: Vec<Row>,
}

#[derive(Clone, Copy)]
enum Child {
    Corner(usize),
    Middle,
}

impl Scratch {
    /// Descends by subdivision to the regular child that contains the point, evaluates the box
    /// spline there and applies the transposed subdivision matrices on the way back. The parameter
    /// directions are propagated as barycentric differences: each step doubles them, and the middle
    /// child also reverses them.
    fn rows(&mut self, mut valences: [usize; 3], v: f64, w: f64) -> &[Row] {
        let mut at = [1.0 - v - w, v, w];
        let mut along_v = [-1.0, 1.0, 0.0];
        let mut along_w = [-1.0, 0.0, 1.0];
        self.path.clear();
        self.rows.clear();
        while valences != [6, 6, 6] {
            let patch = Patch::new(valences);
            if let Some(corner) = (0..3).find(|&c| at[c] >= 0.5) {
                let turned = |x: [f64; 3]| [0, 1, 2].map(|k| x[(corner + k) % 3]);
                at = turned(at);
                let arrived = self.path.len() >= MAX_STEPS || (at[1] == 0.0 && at[2] == 0.0);
                if arrived && valences[corner] != 6 {
                    self.rows.resize(patch.len(), [0.0; DERIVATIVES]);
                    let mut value = [f64::NAN; DERIVATIVES];
                    value[0] = 1.0;
                    let mask = limit_mask(valences[corner]);
                    patch.add_star(corner, mask, &value, &mut self.rows);
                    for row in &mut self.rows {
                        row[1..].fill(f64::NAN);
                    }
                    break;
                }
                at = [at[0] - at[1] - at[2], 2.0 * at[1], 2.0 * at[2]];
                along_v = turned(along_v).map(|x| 2.0 * x);
                along_w = turned(along_w).map(|x| 2.0 * x);
                self.path.push((patch, Child::Corner(corner)));
                valences = [valences[corner], 6, 6];
            } else {
                at = at.map(|x| 1.0 - 2.0 * x);
                along_v = along_v.map(|x| -2.0 * x);
                along_w = along_w.map(|x| -2.0 * x);
                self.path.push((patch, Child::Middle));
                valences = [6, 6, 6];
            }
        }
        if self.rows.is_empty() {
            let regular = regular::evaluate(at, along_v, along_w);
            self.rows.extend_from_slice(&regular);
        }
        for (patch, child) in self.path.drain(..).rev() {
            self.lifted.clear();
            self.lifted.resize(patch.len(), [0.0; DERIVATIVES]);
            match child {
                Child::Corner(c) => patch.lift_corner(c, &self.rows, &mut self.lifted),
                Child::Middle => patch.lift_middle(&self.rows, &mut self.lifted),
            }
            std::mem::swap(&mut self.rows, &mut self.lifted);
        }
        &self.rows
    }
}

#[cfg(test)]
#[path = "basis_tests.rs"]
mod tests;
