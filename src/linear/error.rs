//! Errors of factorizations, with evidence.

/// Failure of a factorization or a direct solve.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LinearError {
    /// A Cholesky pivot was zero, negative or not a number.
    #[error(
        "the matrix is not positive definite: pivot {index} (in elimination order) is not \
         positive; take a smaller step or check that row for undefined values"
    )]
    NotPositiveDefinite {
        /// Row of the failing pivot, in the order the matrix was given.
        index: usize,
    },
    /// LU found a column without a pivot, or the factors are singular to working precision.
    #[error("the matrix is singular{}", column.map_or_else(
        || String::from(" to working precision; the equations do not determine all unknowns"),
        |c| format!(": column {c} has no pivot; the equations do not determine that unknown")
    ))]
    Singular {
        /// Column of the given matrix without a pivot, if the sparsity pattern alone determines it.
        column: Option<usize>,
    },
    /// An LU factorization of a matrix with different numbers of rows and columns.
    #[error(
        "the matrix has {rows} rows and {columns} columns; a direct solve needs a square \
             matrix"
    )]
    NotSquare {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        columns: usize,
    },
    /// The factor has more entries than 32-bit indices can address.
    #[error(
        "the factor of the {n} x {n} matrix is too large for 32-bit indices; split the region \
             into parts"
    )]
    TooLarge {
        /// Dimension of the matrix.
        n: usize,
    },
    /// The factor does not fit in memory.
    #[error(
        "not enough memory for the factor of the {n} x {n} matrix; split the region into parts"
    )]
    OutOfMemory {
        /// Dimension of the matrix.
        n: usize,
    },
}
