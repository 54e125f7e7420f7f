//! First surfaces for holes.

mod fair;
mod fill;
mod planar;
mod remesh;
mod surface;
#[cfg(test)]
mod tests;
mod triangulate;

pub use fair::warm_start;
pub use fill::{PatchError, PatchMesh, PatchOptions, Rim, fill};
