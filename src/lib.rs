//! Meniscus fills holes in triangle meshes with smooth surfaces.
//!
//! The patch over a hole is the limit surface of a Loop control mesh. A surface model determines its
//! shape; by default the model is chosen by prediction of the mesh around the hole. The model
//! `energy` moves the patch by the L2 gradient flow of an energy `E(S) = ∫ f(H, K) dA` (G. Xu, GMP
//! 2008) until it is stationary.
//!
//! ```
//! use meniscus::mesh::{Mesh, boundary_loops};
//! use meniscus::shapes;
//!
//! // a unit sphere with a cap cut off
//! let (positions, triangles) = shapes::cut_where(&shapes::sphere(600, 1), |p| p.z > 0.8);
//! let mesh = Mesh::from_triangles(positions, &triangles)?;
//! let filled = meniscus::fill(&mesh)?;
//! assert!(filled.complete() && boundary_loops(&filled.mesh).is_empty());
//! // it is a sphere again, the old vertices untouched
//! assert!(filled.mesh.positions.iter().all(|p| (p.length() - 1.0).abs() < 0.01));
//! assert_eq!(filled.mesh.positions[..mesh.vertex_count()], mesh.positions);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Fill`] has options: the loops, an energy, a density. [`io::open`] reads and repairs files, and
//! [`io::save_mesh`] writes them. [`mod@fill`] contains all parts of a fill and also runs fills in
//! the background ([`fill::LiveFill`]). [`refine`] refines meshes, [`analysis`] measures them, and
//! [`solver`] runs a single flow. `docs/formulation.md` describes the mathematics and the sign
//! conventions, `ARCHITECTURE.md` the modules.
//!
//! Cargo features: `render` adds the module of that name (pictures without a window), `textures` reads
//! and writes texture images. `cli` and `window` (the default) build the program.

mod api;

pub mod analysis;
#[cfg(feature = "window")]
#[doc(hidden)]
pub mod app;
mod cancel;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
pub mod energy;
pub mod fill;
pub mod images;
pub mod io;
pub mod linear;
pub mod memory;
pub mod mesh;
pub mod ops;
pub mod options;
pub mod patch;
pub mod random;
pub mod refine;
#[cfg(feature = "render")]
pub mod render;
pub mod runner;
pub mod shapes;
pub mod solver;
pub mod subdivision;
pub mod surface;
pub mod symmetry;
pub mod warning;

pub use api::{Fill, fill};
