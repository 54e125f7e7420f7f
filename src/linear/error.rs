//! Errors of factorizations, with evidence.

/// Failure of a factorization or a direct solve.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LinearError {
    /// A Cholesky pivot was zero, negative or not a number.
    #[error(
        "matrix is not positive definite: pivot {index} (in the order factorized) is not positive; \
         take a smaller step or look for undefined values in that row"
    )]
    NotPositiveDefinite {
        /// Row of the failing pivot, in the order the matrix was given.
        index: usize,
    },
    /// LU met a column without a pivot, or the factors are singular to working precision.
    #[error("matrix is singular{}", column.map_or_else(
        || String::from(" to working precision; unknowns are not determined by the equations"),
        |c| format!(": column {c} has no pivot left; that unknown is not determined by the equations")
    ))]
    Singular {
        /// Column (of the given matrix) without a pivot, where the structure alone shows it.
        column: Option<usize>,
    },
    /// An LU factorization of a matrix with different numbers of rows and columns.
    #[error("matrix has {rows} rows and {columns} columns; a direct solve needs a square one")]
    NotSquare {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        columns: usize,
    },
    /// The factor has more entries than 32-bit indices can address.
    #[error("factor of the {n} x {n} matrix is too large to index; split the region into parts")]
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
