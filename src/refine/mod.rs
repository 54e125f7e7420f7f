//! Refinement of a mesh: every level cuts each triangle into four and places the new vertices.
//!
//! With the flow ([`Method::Pde`]), the limit surface of Loop's scheme interpolates every input
//! vertex. It makes `∫ f(H, K) dA` stationary under these constraints. The vertices of the refined
//! mesh lie on that surface. The surface is the same at the start of a level as at the end of the
//! previous one, but it has more degrees of freedom. Sharp edges can be kept as creases. The
//! modified Butterfly scheme and Loop's own scheme are available for comparison.

mod boundary;
#[cfg(test)]
mod cancel_tests;
mod continuation;
mod creases;
mod descent;
mod estimate;
mod level_flow;
mod levels;
mod measures;
mod options;
mod process;
mod progress;
mod refined;
mod region;
mod schemes;
mod start;

pub use boundary::BoundaryRule;
pub use creases::{CreaseWeld, crease_edges};
pub use estimate::RefineEstimate;
pub use measures::{radius, surface_energy};
pub use options::{
    Hold, MAX_LEVELS, Method, RefineControls, RefineError, RefineOptions, mesh_adapted_flow,
};
pub use process::{
    LevelFrame, LiveRefine, RefineProcess, RefineSnapshot, RefineState, RefineStatus, refine,
};
pub use progress::{LevelReport, RefineEvent};
pub use refined::Refined;
pub use schemes::{butterfly_step, loop_step};
