//! Sparse linear algebra: the only module that names the factorization crate.
//!
//! The usual path for a symmetric positive definite matrix over a surface mesh is
//! [`nested_dissection`] of the matrix graph, [`SymmetricPattern::of_permuted_graph`],
//! [`CholeskySymbolic`] once per topology, then [`Cholesky::factorize`] and
//! [`Cholesky::solve_in_place`] as often as wanted, without allocation. Everything runs on the
//! calling thread: two threads were slower at every size tried (1,000 to 50,000 unknowns), and one
//! thread gives the same bits everywhere.

mod cholesky;
mod error;
mod gmres;
mod lbfgs;
mod lu;
mod ordering;
mod pattern;

pub use cholesky::{Cholesky, CholeskySymbolic};
pub use error::LinearError;
pub use gmres::{GmresOptions, GmresReport, gmres};
pub use lbfgs::Lbfgs;
pub use lu::SparseLu;
pub use ordering::nested_dissection;
pub use pattern::SymmetricPattern;

#[cfg(test)]
pub(crate) mod test_matrices;
