//! First surfaces for holes.
//!
//! [`fill()`] makes a triangulated disc over a rim: a triangulation without new vertices (minimum
//! weight, or constrained Delaunay in a plane, see `triangulate`), then splits, collapses, flips and
//! relaxation to the rim's density (`remesh`). A film of constant mean curvature that continues the
//! existing faces stands in for the final surface meanwhile, so that triangles are equilateral there
//! and not in a flat projection. [`blend()`] does the same between several rims. [`warm_start`] then spreads the new vertices smoothly across the
//! rim, which is where a flow starts.

mod blend;
mod data;
mod error;
mod fair;
mod fill;
mod planar;
mod remesh;
mod surface;
#[cfg(test)]
mod tests;
mod transfer;
mod triangulate;

pub use blend::{bending, blend, lofted_candidates, reblend};
pub use data::{Patch, PatchOptions, Rim, RimGeometry};
pub use error::PatchError;
pub use fair::{warm_start, warm_start_with_creases};
pub use fill::fill;
pub use planar::vector_area;
pub use transfer::{TransferError, transfer};
