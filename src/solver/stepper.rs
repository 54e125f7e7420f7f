//! The interface between a flow and the method that computes its steps.

use crate::mesh::DVec3;
use crate::solver::FlowProblem;
use crate::solver::assembly::EnergySum;
use crate::solver::control::Attempt;
use crate::solver::evaluator::State;

/// The parameters of one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepRequest {
    /// Time step.
    pub tau: f64,
    /// The time step that follows if this one is accepted.
    pub next_tau: f64,
    /// Whether quasi-Newton steps with the current factor may follow.
    pub may_freeze: bool,
}

/// A method that computes the steps of a flow.
pub trait Stepper: Send + Sync {
    /// The current point.
    fn state(&self) -> &State;

    /// Attempts one step. A rejected step does not change the current point.
    fn attempt(&mut self, request: &StepRequest) -> Attempt;

    /// The moving vertices and their normals; tangential relaxation slides orthogonally to these.
    /// `None` if the method already moves vertices along the surface.
    fn normals(&self) -> Option<(&[u32], &[DVec3])>;

    /// Moves to other positions on the surface after a step from energy `before`, if that gives
    /// back only a part of the step's gain. Returns whether the move was made.
    fn slide(&mut self, positions: &[DVec3], before: EnergySum) -> bool;

    /// The first time step of a flow in true time; `tau_ref` is the natural time of the hole.
    fn first_tau(&self, tau_ref: f64) -> f64;

    /// Takes the reference shapes of a problem that differs from that of the stepper in nothing else.
    fn set_references(&mut self, _: &FlowProblem) {}

    /// Vertices that are frozen because their step would fold the surface.
    fn frozen(&self) -> usize {
        0
    }
}
