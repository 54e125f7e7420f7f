//! The flows: `∂x/∂t = −δE` for `E(S) = ∫ f(H, K) + c |∇H|² dA` over a region of a Loop limit surface.
//!
//! Sign conventions: the normal `n` points to the side from which faces are seen
//! counter-clockwise; `H = (k1 + k2)/2` is negative on a sphere with outward normal, `K` positive.
//! Flipping the orientation flips `n` and `H`, not `K`. `Δx = 2Hn`, `□x = 2Kn`.

mod assembly;
mod constraints;
mod control;
mod diffusion;
mod discretization;
mod error;
mod evaluator;
mod flow;
mod fold_guard;
pub mod forms;
mod gradient_term;
mod kernel;
mod local_g2;
mod mixed;
mod normal;
mod normals;
mod options;
mod penalty;
mod pinch;
mod problem;
mod record;
mod relax;
mod sparsity;
mod stepper;
mod unknowns;

pub use assembly::{Assembler, EnergySum, MatrixForm};
pub use control::{Attempt, FASTEST, FLOW_GROWTH, Mode, STOP, StepSizeControl, Tau};
pub use discretization::Discretization;
pub use error::SolverError;
pub use evaluator::State;
pub(crate) use evaluator::{Evaluator, PRECONDITIONER_RULE};
pub use flow::{Flow, MakeStepper, scheme_stepper};
pub(crate) use fold_guard::FoldGuard;
pub(crate) use local_g2::{G2_RINGS, Laplacian, LocalG2};
pub use mixed::{LinearSolver, MixedFlow};
pub use options::{FlowOptions, Scheme, SurfaceModel};
pub use problem::{FlowProblem, Reference, SUPPORT_RINGS};
pub use record::{End, Outcome, RejectReason, StepKind, StepRecord};
pub use relax::sharpest_cosine;
pub use stepper::{StepRequest, Stepper};
pub use unknowns::Unknowns;

#[cfg(test)]
mod test_surfaces;
