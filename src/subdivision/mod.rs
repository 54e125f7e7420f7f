//! Loop limit surfaces: masks, basis functions of a triangle, control vertices of faces.
//!
//! The control mesh is the triangle mesh itself. A triangle `(p0, p1, p2)` of the limit surface is
//! parametrized by `(v, w)`, the point `(1 - v - w) p0 + v p1 + w p2` of a unit right triangle. It
//! depends on the vertices that share an edge with one of its corners. These are the three corners,
//! then the outer ring counter-clockwise from the vertex opposite the edge `(p0, p1)` around `p1`,
//! `p2` and `p0`. Basis values at fixed points depend only on the three corner valences. Above valence
//! [`EXACT_VALENCE`] a triangle depends on some of the neighbours only.

mod basis;
mod cache;
mod elements;
mod folding;
mod gather;
mod limit;
mod masks;
mod patch;
mod regular;
mod ring;
mod rule;

pub use basis::{BasisTable, DERIVATIVES, basis_at};
pub use elements::{Elements, Stencils, elements, elements_at};
pub use limit::{
    limit_normal, limit_normals, limit_position, limit_positions, limit_stencil, ring_points,
    tangent_stencil,
};
pub use masks::{
    BAND, EDGE_END, EDGE_OPPOSITE, EXACT_VALENCE, SAMPLE, beta, limit_mask, omega, sample,
    tangent_mask,
};
pub use rule::Rule;

#[cfg(test)]
mod surface_tests;
#[cfg(test)]
mod test_meshes;
