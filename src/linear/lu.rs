//! Sparse LU factorization with partial pivoting and a fill-reducing column order.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::lu::partial_pivoting::factor::PartialPivLuParams;
use faer::sparse::linalg::LuError;
use faer::sparse::linalg::lu::{
    LuRef, LuSymbolicParams, NumericLu, SymbolicLu, factorize_symbolic_lu,
};
use faer::sparse::{FaerError, SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Auto, Conj, MatMut, Par, Spec};
use nalgebra_sparse::CscMatrix;

use super::LinearError;

/// Factorization of a general square matrix.
pub struct SparseLu {
    n: usize,
    symbolic: SymbolicLu<usize>,
    numeric: NumericLu<usize, f64>,
    workspace: MemBuffer,
    /// Number of right-hand sides for which the workspace is large enough.
    columns: usize,
}

fn lu_params() -> Spec<PartialPivLuParams, f64> {
    <PartialPivLuParams as Auto<f64>>::auto().into()
}

impl std::fmt::Debug for SparseLu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SparseLu")
            .field("n", &self.n)
            .finish_non_exhaustive()
    }
}

impl SparseLu {
    /// Factorizes a square matrix.
    ///
    /// A matrix is singular if a pivot is exactly zero. It also counts as singular if a probe
    /// solution grows beyond 1/ε, because then no digit of a solution is meaningful. The probe uses
    /// the system with rows and columns scaled to largest entries 1, so the test does not depend on
    /// the units of rows and columns.
    ///
    /// # Errors
    /// [`LinearError::NotSquare`], [`LinearError::Singular`], [`LinearError::OutOfMemory`],
    /// [`LinearError::TooLarge`].
    pub fn new(matrix: &CscMatrix<f64>) -> Result<Self, LinearError> {
        let n = matrix.nrows();
        if n != matrix.ncols() {
            return Err(LinearError::NotSquare {
                rows: n,
                columns: matrix.ncols(),
            });
        }
        let structure = SymbolicSparseColMatRef::new_checked(
            n,
            n,
            matrix.col_offsets(),
            None,
            matrix.row_indices(),
        );
        let lu_error = |error| match error {
            LuError::SymbolicSingular { index } => LinearError::Singular {
                column: Some(index),
            },
            LuError::Generic(FaerError::OutOfMemory) => LinearError::OutOfMemory { n },
            LuError::Generic(_) => LinearError::TooLarge { n },
        };
        let symbolic = factorize_symbolic_lu(structure, LuSymbolicParams::default())
            .map_err(|e| lu_error(e.into()))?;
        let columns = 1;
        let scratch = StackReq::or(
            symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, lu_params()),
            symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq),
        );
        let mut workspace =
            MemBuffer::try_new(scratch).map_err(|_| LinearError::OutOfMemory { n })?;
        let mut numeric = NumericLu::new();
        symbolic
            .factorize_numeric_lu(
                &mut numeric,
                SparseColMatRef::new(structure, matrix.values()),
                Par::Seq,
                MemStack::new(&mut workspace),
                lu_params(),
            )
            .map_err(lu_error)?;
        let mut lu = Self {
            n,
            symbolic,
            numeric,
            workspace,
            columns,
        };
        if lu.probe_is_singular(matrix) {
            return Err(LinearError::Singular { column: None });
        }
        Ok(lu)
    }

    /// Replaces `rhs` by the solution of `A x = rhs`; `rhs` holds `columns` right-hand sides of
    /// length n, one after another.
    ///
    /// # Panics
    /// If `rhs` is not of length n times `columns`.
    pub fn solve_in_place(&mut self, rhs: &mut [f64], columns: usize) {
        assert_eq!(
            rhs.len(),
            self.n * columns,
            "right-hand sides of n entries each"
        );
        if columns > self.columns {
            let scratch = self
                .symbolic
                .solve_in_place_scratch::<f64>(columns, Par::Seq);
            if self.workspace.len() < scratch.unaligned_bytes_required() {
                self.workspace = MemBuffer::new(scratch);
            }
            self.columns = columns;
        }
        LuRef::new_unchecked(&self.symbolic, &self.numeric).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(rhs, self.n, columns),
            Par::Seq,
            MemStack::new(&mut self.workspace),
        );
    }

    /// One solve with a right-hand side of alternating signs, scaled as described at
    /// [`SparseLu::new`].
    fn probe_is_singular(&mut self, matrix: &CscMatrix<f64>) -> bool {
        let mut row_scale = vec![0.0_f64; self.n];
        for (i, _, &a) in matrix.triplet_iter() {
            row_scale[i] = row_scale[i].max(a.abs());
        }
        let mut column_scale = vec![0.0_f64; self.n];
        for (i, j, &a) in matrix.triplet_iter() {
            column_scale[j] = column_scale[j].max(a.abs() / row_scale[i]);
        }
        let mut x: Vec<f64> = row_scale
            .iter()
            .enumerate()
            .map(|(i, &r)| if (i * 7 + i * i / 3) % 2 == 0 { r } else { -r })
            .collect();
        self.solve_in_place(&mut x, 1);
        x.iter()
            .zip(&column_scale)
            .any(|(x, c)| (x * c).is_nan() || (x * c).abs() >= 1.0 / f64::EPSILON)
    }
}

#[cfg(test)]
#[path = "lu_tests.rs"]
mod tests;
