//! Supernodal sparse Cholesky factorization `A = L Lᵀ` with the symbolic part reused.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::{LltError, LltParams, LltRegularization};
use faer::sparse::linalg::SymbolicSupernodalParams;
use faer::sparse::linalg::cholesky::simplicial::{
    prefactorize_symbolic_cholesky, prefactorize_symbolic_cholesky_scratch,
};
use faer::sparse::linalg::cholesky::supernodal::{
    SupernodalLltRef, SymbolicSupernodalCholesky, factorize_supernodal_numeric_llt,
    factorize_supernodal_numeric_llt_scratch, factorize_supernodal_symbolic_cholesky,
    factorize_supernodal_symbolic_cholesky_scratch,
};
use faer::sparse::{FaerError, SparseColMatRef, SymbolicSparseColMat, SymbolicSparseColMatRef};
use faer::{Auto, Conj, MatMut, Par, Spec};

use super::{LinearError, SymmetricPattern};

/// Merging of small supernodes: (number of merged columns, maximum fraction of stored zeros).
const RELAX: &[(usize, f64)] = &[(4, 1.0), (16, 0.8), (48, 0.1), (usize::MAX, 0.05)];

/// Structure of the Cholesky factor of a pattern, computed once per pattern.
///
/// The matrix is factorized in the given order. Permute it first, with
/// [`nested_dissection`](super::nested_dissection) for matrices over surfaces.
#[derive(Debug)]
pub struct CholeskySymbolic {
    lower: SymbolicSparseColMat<u32>,
    factor: SymbolicSupernodalCholesky<u32>,
}

fn llt_params() -> Spec<LltParams, f64> {
    <LltParams as Auto<f64>>::auto().into()
}

fn symbolic_error(error: FaerError, n: usize) -> LinearError {
    match error {
        FaerError::OutOfMemory => LinearError::OutOfMemory { n },
        _ => LinearError::TooLarge { n },
    }
}

impl CholeskySymbolic {
    /// Analyses a pattern. It must already be permuted, because it is factorized in its own order.
    ///
    /// # Errors
    /// [`LinearError::TooLarge`] if the factor needs more than 2³¹ entries,
    /// [`LinearError::OutOfMemory`] if the analysis does not fit in memory.
    pub fn new(pattern: &SymmetricPattern) -> Result<Self, LinearError> {
        let n = pattern.n;
        let nnz = pattern.nnz();
        if n.max(nnz) > i32::MAX as usize {
            return Err(LinearError::TooLarge { n });
        }
        // The analysis reads the upper triangle by columns, the factorization the lower one.
        let (upper_ptr, upper_idx) = transpose_lower(pattern);
        let upper = SymbolicSparseColMatRef::new_checked(n, n, &upper_ptr, None, &upper_idx);
        let lower = SymbolicSparseColMat::new_checked(
            n,
            n,
            pattern.col_ptr.iter().map(|&p| p as u32).collect(),
            None,
            pattern.row_idx.iter().map(|&i| i as u32).collect(),
        );
        let scratch = StackReq::or(
            prefactorize_symbolic_cholesky_scratch::<u32>(n, nnz),
            factorize_supernodal_symbolic_cholesky_scratch::<u32>(n),
        );
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| LinearError::OutOfMemory { n })?;
        let stack = MemStack::new(&mut memory);
        let mut etree = vec![0_i32; n];
        let mut counts = vec![0_u32; n];
        let etree = prefactorize_symbolic_cholesky(&mut etree, &mut counts, upper, stack);
        let params = SymbolicSupernodalParams { relax: Some(RELAX) };
        let factor = factorize_supernodal_symbolic_cholesky(upper, etree, &counts, stack, params)
            .map_err(|e| symbolic_error(e, n))?;
        Ok(Self { lower, factor })
    }

    /// Dimension of the matrix.
    pub fn n(&self) -> usize {
        self.factor.nrows()
    }

    /// Stored entries of the factor, with the zeros of its dense blocks.
    #[cfg(test)]
    pub fn factor_len(&self) -> usize {
        self.factor.len_val()
    }

    /// Workspace of a solve with `columns` right-hand sides.
    fn solve_scratch(&self, columns: usize) -> StackReq {
        self.factor.solve_in_place_scratch::<f64>(columns, Par::Seq)
    }
}

/// Lower triangle by columns -> the same matrix's upper triangle by columns.
fn transpose_lower(pattern: &SymmetricPattern) -> (Vec<u32>, Vec<u32>) {
    let n = pattern.n;
    let mut ptr = vec![0_u32; n + 1];
    for &i in &pattern.row_idx {
        ptr[i + 1] += 1;
    }
    for i in 0..n {
        ptr[i + 1] += ptr[i];
    }
    let mut next = ptr[..n].to_vec();
    let mut idx = vec![0_u32; pattern.nnz()];
    for j in 0..n {
        for &i in &pattern.row_idx[pattern.col_ptr[j]..pattern.col_ptr[j + 1]] {
            idx[next[i] as usize] = j as u32;
            next[i] += 1;
        }
    }
    (ptr, idx)
}

/// A Cholesky factorization: numeric factor and workspace, reused from one matrix to the next.
pub struct Cholesky {
    symbolic: Arc<CholeskySymbolic>,
    values: Vec<f64>,
    factorized: bool,
    workspace: MemBuffer,
    /// Number of right-hand sides for which the workspace is large enough.
    columns: usize,
}

impl std::fmt::Debug for Cholesky {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cholesky")
            .field("n", &self.symbolic.n())
            .field("factorized", &self.factorized)
            .finish_non_exhaustive()
    }
}

impl Cholesky {
    /// Allocates the factor and the workspace; does not factorize yet.
    pub fn new(symbolic: Arc<CholeskySymbolic>) -> Self {
        let columns = 3;
        let scratch = StackReq::or(
            factorize_supernodal_numeric_llt_scratch::<u32, f64>(
                &symbolic.factor,
                Par::Seq,
                llt_params(),
            ),
            symbolic.solve_scratch(columns),
        );
        Self {
            values: vec![0.0; symbolic.factor.len_val()],
            factorized: false,
            workspace: MemBuffer::new(scratch),
            columns,
            symbolic,
        }
    }

    /// Factorizes the matrix with these values (lower triangle, in the order of the pattern).
    /// Does not allocate.
    ///
    /// # Errors
    /// [`LinearError::NotPositiveDefinite`] with the row of the first pivot that is not positive
    /// (also for values that are not numbers). The previous factor is then lost.
    ///
    /// # Panics
    /// If the length of `values` differs from that of the pattern.
    pub fn factorize(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let lower = self.symbolic.lower.as_ref();
        assert_eq!(
            values.len(),
            lower.row_idx().len(),
            "one value per entry of the pattern"
        );
        self.factorized = false;
        factorize_supernodal_numeric_llt(
            &mut self.values,
            SparseColMatRef::new(lower, values),
            LltRegularization::default(),
            &self.symbolic.factor,
            Par::Seq,
            MemStack::new(&mut self.workspace),
            llt_params(),
        )
        .map_err(|LltError::NonPositivePivot { index }| {
            LinearError::NotPositiveDefinite { index }
        })?;
        self.factorized = true;
        Ok(())
    }

    /// Replaces `rhs` by the solution of `A x = rhs`. `rhs` contains `columns` right-hand sides of
    /// length n, one after another. All are solved in one pass over the factor. Allocates only if
    /// `columns` exceeds 3 and every previous value.
    ///
    /// # Panics
    /// If `rhs` is not of length n times `columns`, or there is no successful factorization.
    pub fn solve_in_place(&mut self, rhs: &mut [f64], columns: usize) {
        let n = self.symbolic.n();
        assert!(
            self.factorized,
            "solve needs a successful factorization first"
        );
        assert_eq!(rhs.len(), n * columns, "right-hand sides of n entries each");
        if columns > self.columns {
            let scratch = self.symbolic.solve_scratch(columns);
            if self.workspace.len() < scratch.unaligned_bytes_required() {
                self.workspace = MemBuffer::new(scratch);
            }
            self.columns = columns;
        }
        SupernodalLltRef::new(&self.symbolic.factor, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(rhs, n, columns),
            Par::Seq,
            MemStack::new(&mut self.workspace),
        );
    }
}

#[cfg(test)]
#[path = "cholesky_tests.rs"]
mod tests;
