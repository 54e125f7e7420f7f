//! First surfaces for holes.
//!
//! A [`Patch`] is a triangulated surface over one or several [`Rim`]s, the edges of the mesh around
//! a hole. It has its own vertex numbers, rim vertices first.
//!
//! [`fill()`] makes a disc over one rim. It triangulates the rim without new vertices (minimum
//! weight, or constrained Delaunay in a plane, see `triangulate`). Then it splits, collapses, flips
//! and relaxes to the rim's density (`remesh`). Meanwhile a membrane of constant mean curvature
//! that continues the existing faces stands in for the final surface, so that triangles are
//! equilateral in space and not in a flat projection. [`blend()`] does the same between several
//! rims; two rims that face each other less than an edge apart get a `strip`.
//!
//! [`warm_start`] spreads the new vertices smoothly across the rim. There a flow starts.

mod blend;
mod data;
mod dome;
mod error;
mod fair;
mod fill;
mod frame;
mod grading;
mod planar;
mod remesh;
mod slit;
mod strip;
mod surface;
#[cfg(test)]
mod tests;
mod transfer;
mod triangulate;

pub use blend::blend;
pub(crate) use blend::{bending, lofted_candidates, reblend};
pub use data::{Patch, PatchOptions, Rim, RimGeometry};
pub(crate) use dome::domed;
pub use error::PatchError;
pub use fair::warm_start;
pub(crate) use fair::warm_start_with_creases;
pub use fill::fill;
pub(crate) use fill::{OtherPatches, fill_excluding};
pub(crate) use strip::strip;
pub(crate) use transfer::{TransferError, transfer};
