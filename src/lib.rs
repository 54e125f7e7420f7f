//! Meniscus fills holes in triangle meshes with smooth surfaces.
//!
//! The patch over a hole is the limit surface of a Loop control mesh, moved by the L2 gradient flow
//! of an energy `E(S) = ∫ f(H, K) dA` (G. Xu, GMP 2008) until it is stationary.

pub mod cli;
pub mod fill;
pub mod io;
pub mod linear;
pub mod mesh;
pub mod patch;
pub mod solver;
pub mod subdivision;
