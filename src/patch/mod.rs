//! First surfaces for holes.

mod fill;
mod remesh;
mod surface;
#[cfg(test)]
mod tests;
mod triangulate;

pub use fill::{PatchError, PatchMesh, PatchOptions, Rim, fill};
