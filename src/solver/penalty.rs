//! Constrained limit positions in the matrix of scheme B.
//!
//! `S` is the matrix over all moving vertices. In the interpolating basis it is `QᵀSQ`, whose rows
//! reach two rings further. Instead, `ρ AᵀA` is added to `S`; `A` has the rows of the limit mask at
//! the constrained vertices, along the normals. For right-hand sides that vanish at the constrained
//! vertices, the free part of the solution tends to `(QᵀSQ)⁻¹g` as `ρ` grows. The sparsity of `S` is
//! enough, because all neighbours of a vertex share an element with it.

use crate::linear::SymmetricPattern;
use crate::mesh::DVec3;
use crate::surface::Interpolation;

/// `ρ` over the diagonal entry of the constrained vertex. It is large compared with 1: a step keeps
/// the limit positions to four digits, which is enough for a preconditioner of the exact gradient.
/// It is small enough to leave most digits of the factorization to the other vertices.
const WEIGHT: f64 = 1e5;

/// Where the terms `ρ AᵀA` go.
pub struct Penalty {
    /// Start of each row in `members`; pairs of members start at `pairs`.
    start: Vec<u32>,
    /// Unknown and weight, the constrained vertex first.
    members: Vec<(u32, f64)>,
    /// Place in the values of the matrix for each pair (k, l), l ≤ k, of members of a row.
    slots: Vec<u32>,
}

impl Penalty {
    /// For vertices numbered by `unknown` in a matrix of the given pattern.
    pub fn new(interpolation: &Interpolation, unknown: &[u32], pattern: &SymmetricPattern) -> Self {
        let mut out = Self {
            start: vec![0],
            members: Vec::new(),
            slots: Vec::new(),
        };
        for (i, &v) in interpolation.constrained().iter().enumerate() {
            let (own, row) = interpolation.row(i);
            let begin = out.members.len();
            out.members.push((unknown[v as usize], own));
            for &(w, weight) in row {
                let u = unknown[w as usize];
                if (u as usize) < pattern.n {
                    out.members.push((u, weight));
                }
            }
            for k in begin..out.members.len() {
                for l in begin..=k {
                    let (a, b) = (out.members[k].0 as usize, out.members[l].0 as usize);
                    out.slots.push(slot(pattern, a, b));
                }
            }
            out.start.push(out.members.len() as u32);
        }
        out
    }

    /// Unknown and weight of each member of a row of the limit mask, the constrained vertex first.
    pub fn row(&self, i: usize) -> &[(u32, f64)] {
        &self.members[self.start[i] as usize..self.start[i + 1] as usize]
    }

    /// Adds the terms to the matrix; `normals` are the directions of the unknowns. Returns the `ρ` of
    /// each constrained vertex.
    pub fn add(&self, normals: &[DVec3], values: &mut [f64]) -> Vec<f64> {
        self.add_weighted(WEIGHT, normals, values)
    }

    /// The same with another weight over the diagonal entry.
    fn add_weighted(&self, relative: f64, normals: &[DVec3], values: &mut [f64]) -> Vec<f64> {
        let mut slots = self.slots.iter();
        let add_row = |row: &[u32]| {
            let members = &self.members[row[0] as usize..row[1] as usize];
            let (u, own) = members[0];
            let normal = normals[u as usize];
            let along = |&(u, weight): &(u32, f64)| weight * normal.dot(normals[u as usize]);
            let mut weight = 0.0;
            for k in 0..members.len() {
                let a = along(&members[k]);
                for (member, &slot) in members[..=k].iter().zip(&mut slots) {
                    let value = &mut values[slot as usize];
                    if weight == 0.0 {
                        // the first pair is the diagonal
                        weight = relative * *value / (own * own);
                    }
                    *value += weight * a * along(member);
                }
            }
            weight
        };
        self.start.windows(2).map(add_row).collect()
    }
}

/// Place of the entry (a, b) among the values of the lower triangle.
fn slot(pattern: &SymmetricPattern, a: usize, b: usize) -> u32 {
    let (row, column) = (a.max(b), a.min(b));
    let range = pattern.col_ptr[column]..pattern.col_ptr[column + 1];
    let rows = &pattern.row_idx[range.clone()];
    let found = rows.binary_search(&row);
    (range.start + found.expect("neighbours of a vertex share an element with it")) as u32
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::linear::{Cholesky, CholeskySymbolic};
    use crate::solver::test_surfaces::{energy, lattice};
    use crate::solver::{Assembler, MatrixForm, Unknowns};
    use crate::subdivision::Rule;

    /// The solution `w` of `(S + ρAᵀA) w = b`, with `b = 0` at the constrained vertices, tends to that
    /// of the constrained problem: `Aw → 0` like `1/ρ`, and the residual `Sw − b` has no part along
    /// displacements that keep the constraints.
    #[test]
    fn a_growing_penalty_becomes_a_constraint() {
        let free = lattice(6);
        // no two of them are neighbours, so that each ρ is proportional to the weight
        let held: Vec<(u32, DVec3)> = [7, 10, 28]
            .map(|k| free.interior()[k])
            .map(|v| (v, free.positions()[v as usize] + free.centre()))
            .to_vec();
        let problem = free.with_constraints(&held).expect("three vertices");
        let interpolation = problem.interpolation().expect("constraints");
        let elements = problem.discretization().elements(Rule::Twelve);
        let (unknowns, scatter) =
            Unknowns::dissected(elements, problem.positions(), problem.moving());
        let n = unknowns.len();
        let penalty = Penalty::new(interpolation, &unknowns.of_vertex, &scatter.pattern);
        let form = MatrixForm::Isotropic;
        let mut assembler =
            Assembler::new(elements, Rule::Twelve, unknowns).with_matrix(scatter, form);
        let directions = vec![DVec3::X; n];
        let (x, f) = (problem.positions(), energy("1"));
        let (mut gradient, mut plain) = (Vec::new(), Vec::new());
        assembler.matrix(x, &directions, &f, 1.0, 1.0, &mut gradient, &mut plain);
        let symbolic = CholeskySymbolic::new(assembler.pattern()).expect("small");
        let mut cholesky = Cholesky::new(Arc::new(symbolic));
        let constrained: Vec<usize> = (0..3).map(|i| penalty.row(i)[0].0 as usize).collect();
        let load: Vec<f64> = (0..n)
            .map(|i| (1.3 * i as f64).sin() * f64::from(u8::from(!constrained.contains(&i))))
            .collect();
        // the limit displacement at a constrained vertex
        let limit = |i: usize, w: &[f64]| {
            let row = penalty.row(i).iter();
            row.map(|&(u, weight)| weight * w[u as usize]).sum::<f64>()
        };
        // a displacement that keeps the constraints
        let mut kept: Vec<f64> = (0..n).map(|i| (0.7 * i as f64).cos()).collect();
        for (i, &u) in constrained.iter().enumerate() {
            kept[u] -= limit(i, &kept) / penalty.row(i)[0].1;
        }
        let mut violations = Vec::new();
        for weight in [1e2, 1e3, 1e4, 1e5] {
            let mut values = plain.clone();
            penalty.add_weighted(weight, &directions, &mut values);
            cholesky.factorize(&values).expect("positive definite");
            let mut w = load.clone();
            cholesky.solve_in_place(&mut w, 1);
            let mut residual = vec![0.0; n];
            assembler.pattern().multiply(&plain, &w, &mut residual);
            let along = |r: &[f64]| r.iter().zip(&kept).map(|(r, k)| r * k).sum::<f64>();
            assert!((along(&residual) - along(&load)).abs() < 1e-9);
            violations.push((0..3).map(|i| limit(i, &w).abs()).fold(0.0, f64::max));
        }
        assert!(violations[0] > 1e-5, "{violations:?}");
        for pair in violations.windows(2) {
            assert!(
                (pair[0] / pair[1] / 10.0 - 1.0).abs() < 0.1,
                "{violations:?}"
            );
        }
    }
}
