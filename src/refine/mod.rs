//! Refinement of a mesh: every level cuts each triangle into four and places the new vertices.
//!
//! By the flow ([`Method::Pde`]) the limit surface of Loop's scheme passes every given vertex and makes
//! `∫ f(H, K) dA` stationary among all that do; the refined mesh has its vertices on that surface.
//! From one level to the next the surface is the same, only freer. Sharp edges may be kept as creases. The modified Butterfly scheme
//! and Loop's own are there to compare with.

mod boundary;
mod continuation;
mod creases;
mod descent;
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
pub use creases::{Weld, crease_edges};
pub use levels::Refinement;
pub use measures::{radius, surface_energy};
pub use options::{
    Hold, MAX_LEVELS, Method, RefineControls, RefineError, RefineOptions, natural_flow,
};
pub use process::{
    LevelFrame, LiveRefine, RefineEvent, RefineProcess, RefineSnapshot, RefineState, RefineStatus,
    RefineTimeline, refine_recorded,
};
pub use progress::{LevelReport, Progress};
pub use refined::Refined;
pub use schemes::{butterfly_step, loop_step};
