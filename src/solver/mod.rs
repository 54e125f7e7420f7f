//! The flows: `∂x/∂t = −δE` for `E(S) = ∫ f(H, K) dA` over a region of a Loop limit surface.
//!
//! Signs, once for all: the normal `n` points to the side from which faces are seen
//! counter-clockwise; `H = (k1 + k2)/2` is negative on a sphere with outward normal, `K` positive.
//! Flipping the orientation flips `n` and `H`, not `K`. `Δx = 2Hn`, `□x = 2Kn`.

mod assembly;
mod constraints;
mod control;
mod error;
mod flow;
mod fold_guard;
pub mod forms;
mod guarded;
mod kernel;
mod mixed;
mod normal;
mod normals;
mod options;
mod penalty;
mod pinch;
mod problem;
mod quadrature_levels;
mod record;
mod relax;
mod slots;
mod unknowns;

pub use assembly::{Assembler, EnergySum};
pub use control::{Attempt, FLOW_GROWTH, Mode, STOP, StepKind, StepSizeControl, Tau};
pub use error::{SolverError, panic_text};
pub use flow::Flow;
pub use fold_guard::FoldState;
pub use guarded::GuardedFlow;
pub use mixed::{LinearSolver, MixedFlow};
pub use normal::NormalFlow;
pub use normals::LimitNormals;
pub use options::{FlowOptions, Scheme};
pub use problem::{FlowProblem, SUPPORT_RINGS};
pub use record::{End, Outcome, StepRecord};
pub use relax::sharpest_cosine;
pub use unknowns::Unknowns;
