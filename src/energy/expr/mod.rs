//! Typed energies: the parser, the postfix program, and the algebras that evaluate it.

mod build;
mod error;
mod gradient;
mod lex;
mod pair;
mod parse;
mod poly;
mod program;
mod scalar;
mod symmetry;

pub use error::{ExprError, SyntaxError};
pub(super) use gradient::split_gradient;
pub(super) use pair::PairAlgebra;
pub(super) use parse::{is_name, is_reserved, parse};
pub(super) use poly::{Polynomial, as_polynomial};
pub(super) use program::Program;
pub(super) use scalar::JetAlgebra;
pub(super) use symmetry::{check_symmetry, sample_curvatures};

#[cfg(test)]
mod tests;
