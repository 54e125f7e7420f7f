//! Constrained limit positions in the matrix of scheme B.
//!
//! With the matrix `S` over all moving vertices, the step of the interpolating basis has the matrix
//! `QᵀSQ`. Instead of forming it, whose rows reach two rings further, `ρ AᵀA` is added to `S`, `A` the
//! rows of the limit mask at the held vertices along the normals: for right-hand sides that vanish
//! at the held vertices the free part of the solution tends to `(QᵀSQ)⁻¹g` as `ρ` grows, and the
//! sparsity of `S` is enough, for all neighbours of a vertex share an element with it.

use crate::linear::SymmetricPattern;
use crate::mesh::DVec3;
use crate::surface::Interpolation;

/// `ρ` over the diagonal entry of the held vertex. Large against 1, so that held vertices keep
/// their limit positions in the step to four digits, which is ample for a preconditioner of
/// the exact gradient; small enough to leave most digits of the factorization to the others.
const WEIGHT: f64 = 1e5;

/// Where the terms `ρ AᵀA` go.
pub struct Penalty {
    /// Start of each row in `members`; pairs of members start at `pairs`.
    start: Vec<u32>,
    /// Unknown and weight, the held vertex first.
    members: Vec<(u32, f64)>,
    /// Place in the values of the matrix for each pair (k, l), l ≤ k, of members of a row.
    slots: Vec<u32>,
}

impl Penalty {
    /// For the held vertices, numbered by `unknown`, in a matrix of the given pattern.
    pub fn new(interpolation: &Interpolation, unknown: &[u32], pattern: &SymmetricPattern) -> Self {
        let mut out = Self {
            start: vec![0],
            members: Vec::new(),
            slots: Vec::new(),
        };
        for (i, &v) in interpolation.held().iter().enumerate() {
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

    /// Unknown and weight of each member of a row of the limit mask, the held vertex first.
    pub fn row(&self, i: usize) -> &[(u32, f64)] {
        &self.members[self.start[i] as usize..self.start[i + 1] as usize]
    }

    /// Adds the terms to the matrix; `normals` are the directions of the unknowns. Returns the `ρ` of
    /// each held vertex.
    pub fn add(&self, normals: &[DVec3], values: &mut [f64]) -> Vec<f64> {
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
                        weight = WEIGHT * *value / (own * own);
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
