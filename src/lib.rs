//! Meniscus fills holes in triangle meshes with smooth surfaces.
//!
//! The patch over a hole is the limit surface of a Loop control mesh, moved by the L2 gradient flow
//! of an energy `E(S) = ∫ f(H, K) dA` (G. Xu, GMP 2008) until it is stationary; `f = H²` by default.
//!
//! ```
//! use meniscus::fill::{FillOptions, LoopChoice, choose, fill_holes};
//! use meniscus::mesh::{Mesh, Topology, boundary_loops};
//! use meniscus::shapes;
//!
//! // a unit sphere with a cap cut off
//! let (positions, triangles) = shapes::cut_where(&shapes::sphere(600, 1), |p| p.z > 0.8);
//! let topology = Topology::from_triangles(positions.len(), &triangles)?;
//! let mesh = Mesh::new(positions, topology);
//! let loops = boundary_loops(&mesh);
//! let holes: Vec<_> = choose(&loops, &LoopChoice::Auto)?.iter().map(|id| &loops[id.index()]).collect();
//! let filled = fill_holes(&mesh, &holes, &FillOptions::default(), &|_, _| true)?;
//! assert!(filled.complete() && boundary_loops(&filled.mesh).is_empty());
//! // it is a sphere again, the old vertices untouched
//! assert!(filled.mesh.positions.iter().all(|p| (p.length() - 1.0).abs() < 0.01));
//! assert_eq!(filled.mesh.positions[..mesh.vertex_count()], mesh.positions);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Files are read by [`io::load`] and made into a [`mesh::Mesh`] by [`mesh::build()`], which repairs
//! and reports; [`io::save`] writes. [`fill`] is the whole way from holes to a filled mesh, at once or
//! watched and changed on the way ([`fill::LiveFill`]), [`solver`] a single flow. The mathematics and
//! its signs are in `docs/formulation.md`, the way the modules hang together in `ARCHITECTURE.md`.

pub mod analysis;
#[cfg(feature = "window")]
#[doc(hidden)]
pub mod app;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
pub mod energy;
pub mod fill;
pub mod io;
pub mod linear;
pub mod live;
pub mod memory;
pub mod mesh;
pub mod ops;
pub mod options;
pub mod patch;
pub mod random;
pub mod refine;
#[cfg(feature = "render")]
pub mod render;
pub mod shapes;
pub mod solver;
pub mod subdivision;
pub mod surface;
