//! Where the entries of element matrices go.

use crate::linear::SymmetricPattern;
use crate::solver::unknowns::{Structure, Unknowns};

/// Sparsity pattern of the matrix, and for each element the places of its packed lower triangle.
pub struct Slots {
    /// Lower triangle in the order of the unknowns.
    pub pattern: SymmetricPattern,
    /// Where each element's places start in `slot`.
    pub offset: Vec<u32>,
    /// Index into the pattern's values; one behind the last for entries of fixed vertices.
    pub slot: Vec<u32>,
}

impl Slots {
    /// For elements whose vertices are `vertices[offset[e]..offset[e + 1]]`.
    pub fn new(unknowns: &mut Unknowns, offset_of: &[u32], vertices: &[u32]) -> Self {
        let n = unknowns.len();
        let count = offset_of.len() - 1;
        let mut offset = Vec::with_capacity(count + 1);
        let mut total = 0usize;
        offset.push(0);
        for e in 0..count {
            let k = (offset_of[e + 1] - offset_of[e]) as usize;
            total += k * (k + 1) / 2;
            offset.push(total as u32);
        }
        let Some(Structure {
            pattern,
            incidence,
            order,
        }) = unknowns.structure.take()
        else {
            return Self {
                pattern: SymmetricPattern::new(0, vec![0], Vec::new()),
                offset,
                slot: vec![0; total],
            };
        };
        // entries of fixed vertices go to one place behind the matrix
        let waste = pattern.row_idx.len() as u32;
        let dof: Vec<u32> = vertices
            .iter()
            .map(|&v| unknowns.of_vertex[v as usize])
            .collect();
        let mut slot = vec![waste; total];
        let mut place = vec![0u32; n + 1];
        for j in 0..n {
            let column = pattern.col_ptr[j]..pattern.col_ptr[j + 1];
            for at in column {
                place[pattern.row_idx[at]] = at as u32;
            }
            for &[e, lj] in incidence.of(order[j] as usize) {
                let (a, b) = (offset_of[e as usize], offset_of[e as usize + 1]);
                let base = offset[e as usize] as usize;
                for (li, &d) in dof[a as usize..b as usize].iter().enumerate() {
                    if d as usize >= j && (d as usize) < n {
                        slot[base + triangular(li, lj as usize)] = place[d as usize];
                    }
                }
            }
        }
        Self {
            pattern,
            offset,
            slot,
        }
    }
}

/// Index of the pair `{i, j}` in a packed lower triangle.
fn triangular(i: usize, j: usize) -> usize {
    let (a, b) = if i >= j { (i, j) } else { (j, i) };
    a * (a + 1) / 2 + b
}
