//! Sparse linear algebra: the only module that uses the factorization crate.
//!
//! The usual sequence for a symmetric positive definite matrix over a surface mesh starts with
//! [`nested_dissection`] of the matrix graph and [`SymmetricPattern::of_permuted_graph`].
//! [`CholeskySymbolic`] follows once per topology. [`Cholesky::factorize`] and
//! [`Cholesky::solve_in_place`] can then be repeated without allocation. Everything runs on the
//! calling thread. Two threads were slower at every size tried (1,000 to 50,000 unknowns), and with
//! one thread results are bit-identical everywhere.

mod cholesky;
mod envelope;
mod error;
mod gmres;
mod lbfgs;
mod lu;
mod ordering;
mod pattern;
mod vectors;

pub use cholesky::{Cholesky, CholeskySymbolic};
pub use envelope::Envelope;
pub use error::LinearError;
pub use gmres::{GmresOptions, GmresReport, gmres};
pub use lbfgs::Lbfgs;
pub use lu::SparseLu;
pub use ordering::nested_dissection;
pub use pattern::SymmetricPattern;
pub use vectors::{flat, vector};

#[cfg(test)]
pub(crate) mod test_matrices;
