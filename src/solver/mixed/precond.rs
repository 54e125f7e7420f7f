//! Block elimination as a preconditioner of GMRES.
//!
//! With `S` the Schur complement in the positions,
//!
//! ```text
//!   ⎡ A  B  C ⎤       ⎡ Ŝ   0  0 ⎤
//!   ⎢ L¹ m  0 ⎥  · P⁻¹,  P = ⎢ L¹  m  0 ⎥ ,   Ŝ ≈ S = A − B m⁻¹ L¹ − C m⁻¹ L²,
//!   ⎣ L² 0  m ⎦       ⎣ L²  0  m ⎦
//! ```
//!
//! is block upper triangular with identities in the last two rows, so that GMRES sees `S Ŝ⁻¹` only.

use std::sync::Arc;

use glam::DMat3;
use nalgebra_sparse::CscMatrix;

use crate::linear::{Cholesky, CholeskySymbolic, LinearError, SparseLu, SymmetricPattern};
use crate::solver::energy::Jet2;
use crate::solver::forms::PositiveHessian;
use crate::solver::mixed::assembly::System;
use crate::solver::mixed::pattern::{Couplings, Lists};

/// Structure of the Schur complement with a lumped `m`: for each vertex v of rings 0 and 1, the
/// vertices whose basis functions meet `ψ_v` are coupled with each other.
struct SchurPattern {
    /// The vertices i that meet each v.
    meets: Lists,
    /// The place of each (i, v) in the coupling matrix.
    place: Vec<u32>,
    slots: Couplings,
    /// Where the entries of `M/τ + l^p` go.
    of_position: Vec<u32>,
}

impl SchurPattern {
    fn new(system: &System, upper: bool) -> Self {
        let (n, m) = (system.numbering.x.len(), system.numbering.h.len());
        let (offsets, columns, _) = system.coupling.csr_data();
        let coupling = Couplings::of_rows(offsets, columns);
        let (meets, place) = coupling.by_column(m);
        let slots = Couplings::new(&meets, &meets, n, n, upper);
        let x = &system.x_pattern;
        let mut of_position = Vec::with_capacity(x.nnz());
        for i in 0..n {
            // both rows ascend, and what shares an element shares one of its corners
            let mut at = slots.offsets[i];
            for &j in &x.row_idx[x.col_ptr[i]..x.col_ptr[i + 1]] {
                while slots.columns[at] != j {
                    at += 1;
                }
                of_position.push(at as u32);
            }
        }
        Self {
            meets,
            place,
            slots,
            of_position,
        }
    }
}

/// Which approximation of the Schur complement is factorized.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SchurKind {
    /// Scalar, symmetric positive definite: the same for x, y and z.
    Scalar,
    /// Scalar, but not made symmetric.
    ScalarLu,
    /// All of it, with `m` lumped.
    Full,
}

enum Factor {
    Scalar(Cholesky),
    ScalarLu(SparseLu),
    Full(SparseLu),
}

/// The preconditioner for one state and time step.
pub struct BlockElimination {
    mass: Cholesky,
    pattern: SchurPattern,
    symbolic: Arc<CholeskySymbolic>,
    values: Vec<f64>,
    factor: Option<Factor>,
    scratch: Vec<f64>,
}

impl BlockElimination {
    /// Symbolic factorizations.
    ///
    /// # Errors
    /// Those of [`CholeskySymbolic::new`].
    pub fn new(system: &System) -> Result<Self, LinearError> {
        let pattern = SchurPattern::new(system, true);
        let mass = Cholesky::new(Arc::new(CholeskySymbolic::new(&system.h_pattern)?));
        let n = system.numbering.x.len();
        let schur = SymmetricPattern::new(
            n,
            pattern.slots.offsets.clone(),
            pattern.slots.columns.clone(),
        );
        Ok(Self {
            mass,
            symbolic: Arc::new(CholeskySymbolic::new(&schur)?),
            pattern,
            values: Vec::new(),
            factor: None,
            scratch: Vec::new(),
        })
    }

    /// Factorizes `m`; needed once per state.
    ///
    /// # Errors
    /// [`LinearError::NotPositiveDefinite`] where the surface has degenerated.
    pub fn factorize_mass(&mut self, system: &System) -> Result<(), LinearError> {
        self.mass.factorize(&system.m)
    }

    /// `v = m⁻¹ v` for `columns` vectors.
    pub fn solve_mass(&mut self, v: &mut [f64], columns: usize) {
        self.mass.solve_in_place(v, columns);
    }

    /// Factorizes the Schur complement.
    ///
    /// # Errors
    /// Those of the factorizations.
    pub fn factorize(
        &mut self,
        system: &System,
        position: &[f64],
        kind: SchurKind,
    ) -> Result<(), LinearError> {
        match kind {
            SchurKind::Scalar => self.factorize_scalar(system, position),
            SchurKind::ScalarLu => {
                self.factor = Some(Factor::ScalarLu(scalar_lu(system, position)?));
                Ok(())
            }
            SchurKind::Full => {
                self.factor = Some(Factor::Full(full_lu(system, position)?));
                Ok(())
            }
        }
    }

    fn factorize_scalar(
        &mut self,
        system: &System,
        position: &[f64],
    ) -> Result<(), LinearError> {
        let pattern = &self.pattern;
        let values = &mut self.values;
        values.clear();
        values.resize(pattern.slots.nnz() + 1, 0.0);
        for (&slot, a) in pattern.of_position.iter().zip(position) {
            values[slot as usize] += a;
        }
        let coupling = system.coupling.values();
        let mut terms: Vec<[f64; 2]> = Vec::new();
        for v in 0..system.numbering.h.len() {
            let [hh, hk, kk] = system.weights[v];
            let jet = Jet2 {
                hh,
                hk,
                kk,
                ..Jet2::default()
            };
            let [p, q] = PositiveHessian::new(&jet, 1.0).factors;
            let root = system.lumped[v].sqrt().recip();
            let range = pattern.meets.start[v] as usize..pattern.meets.start[v + 1] as usize;
            terms.clear();
            terms.extend(pattern.place[range].iter().map(|&at| {
                let c = &coupling[at as usize];
                [
                    root * (p[0] * c.l1 + p[1] * c.l2),
                    root * (q[0] * c.l1 + q[1] * c.l2),
                ]
            }));
            let mut slots = pattern.slots.slots(v).iter();
            for a in &terms {
                for (b, &s) in terms.iter().zip(&mut slots) {
                    values[s as usize] += a[0] * b[0] + a[1] * b[1];
                }
            }
        }
        values.pop();
        let mut cholesky = match self.factor.take() {
            Some(Factor::Scalar(old)) => old,
            _ => Cholesky::new(Arc::clone(&self.symbolic)),
        };
        cholesky.factorize(values)?;
        self.factor = Some(Factor::Scalar(cholesky));
        Ok(())
    }

    /// `out = P⁻¹ v`.
    ///
    /// # Panics
    /// If nothing is factorized.
    pub fn apply(&mut self, system: &System, v: &[f64], out: &mut [f64]) {
        let (n, m) = (system.numbering.x.len(), system.numbering.h.len());
        out.copy_from_slice(v);
        let (x, hk) = out.split_at_mut(3 * n);
        match self.factor.as_mut().expect("factorized before it is applied") {
            Factor::Scalar(cholesky) => cholesky.solve_in_place(x, 3),
            Factor::ScalarLu(lu) => lu.solve_in_place(x, 3),
            Factor::Full(lu) => {
                self.scratch.clear();
                self.scratch
                    .extend((0..n).flat_map(|i| [x[i], x[n + i], x[2 * n + i]]));
                lu.solve_in_place(&mut self.scratch, 1);
                for (i, s) in self.scratch.chunks_exact(3).enumerate() {
                    (x[i], x[n + i], x[2 * n + i]) = (s[0], s[1], s[2]);
                }
            }
        }
        let (h, k) = hk.split_at_mut(3 * m);
        let (offsets, columns, values) = system.coupling.csr_data();
        for i in 0..n {
            let xi = [x[i], x[n + i], x[2 * n + i]];
            for at in offsets[i]..offsets[i + 1] {
                let (j, c) = (columns[at], &values[at]);
                for axis in 0..3 {
                    h[axis * m + j] -= c.l1 * xi[axis];
                    k[axis * m + j] -= c.l2 * xi[axis];
                }
            }
        }
        self.mass.solve_in_place(h, 3);
        self.mass.solve_in_place(k, 3);
    }
}

/// `S` with `m` lumped and the blocks replaced by a third of their traces.
fn scalar_lu(system: &System, position: &[f64]) -> Result<SparseLu, LinearError> {
    let blocks = lumped_schur(system, position);
    let n = system.numbering.x.len();
    let (pattern, values) = blocks;
    let mut coo = nalgebra_sparse::CooMatrix::new(n, n);
    for i in 0..n {
        for at in pattern.offsets[i]..pattern.offsets[i + 1] {
            let b = values[at];
            coo.push(i, pattern.columns[at], (b.x_axis.x + b.y_axis.y + b.z_axis.z) / 3.0);
        }
    }
    SparseLu::new(&CscMatrix::from(&coo))
}

fn lumped_schur(system: &System, position: &[f64]) -> (Couplings, Vec<DMat3>) {
    let full = SchurPattern::new(system, false);
    let mut values = vec![DMat3::ZERO; full.slots.nnz() + 1];
    let x = &system.x_pattern;
    for i in 0..x.n {
        for at in x.col_ptr[i]..x.col_ptr[i + 1] {
            let block = DMat3::from_diagonal(glam::DVec3::splat(position[at]));
            let j = x.row_idx[at];
            values[full.of_position[at] as usize] += block;
            if i != j {
                let row = &full.slots.columns[full.slots.offsets[j]..full.slots.offsets[j + 1]];
                let place = row.binary_search(&i).expect("the pattern is symmetric");
                values[full.slots.offsets[j] + place] += block;
            }
        }
    }
    let coupling = system.coupling.values();
    for v in 0..system.numbering.h.len() {
        let inverse = system.lumped[v].recip();
        let range = full.meets.start[v] as usize..full.meets.start[v + 1] as usize;
        let places = &full.place[range];
        let mut slots = full.slots.slots(v).iter();
        for &a in places {
            let (b, c) = (
                coupling[a as usize].b * inverse,
                coupling[a as usize].c * inverse,
            );
            for (&j, &s) in places.iter().zip(&mut slots) {
                let l = &coupling[j as usize];
                values[s as usize] -= b * l.l1 + c * l.l2;
            }
        }
    }
    (full.slots, values)
}

fn full_lu(system: &System, position: &[f64]) -> Result<SparseLu, LinearError> {
    let (pattern, values) = lumped_schur(system, position);
    let n = system.numbering.x.len();
    // the transposed pattern is the pattern: column j of the matrix holds the blocks of row j
    let mut offsets = vec![0usize];
    let mut rows = Vec::with_capacity(9 * pattern.nnz());
    let mut entries = Vec::with_capacity(9 * pattern.nnz());
    for j in 0..n {
        let range = pattern.offsets[j]..pattern.offsets[j + 1];
        let places: Vec<usize> = pattern.columns[range.clone()]
            .iter()
            .map(|&i| {
                let row = pattern.offsets[i]..pattern.offsets[i + 1];
                let at = pattern.columns[row.clone()].binary_search(&j);
                row.start + at.expect("the pattern is symmetric")
            })
            .collect();
        for column in 0..3 {
            for (&i, &at) in pattern.columns[range.clone()].iter().zip(&places) {
                for row in 0..3 {
                    rows.push(3 * i + row);
                    entries.push(values[at].col(column)[row]);
                }
            }
            offsets.push(rows.len());
        }
    }
    let matrix = CscMatrix::try_from_csc_data(3 * n, 3 * n, offsets, rows, entries)
        .expect("columns built in order with ascending rows");
    SparseLu::new(&matrix)
}
