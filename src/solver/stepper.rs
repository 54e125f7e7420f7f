//! What a flow needs of a method that computes its steps.

use crate::mesh::DVec3;
use crate::solver::assembly::EnergySum;
use crate::solver::control::Attempt;
use crate::solver::evaluator::State;

/// What is asked of one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepRequest {
    /// Time step.
    pub tau: f64,
    /// The time step that follows if this one is accepted.
    pub next_tau: f64,
    /// Whether quasi-Newton steps with the present factor may follow.
    pub may_freeze: bool,
}

/// A method that computes the steps of a flow.
pub trait Stepper: Send + Sync {
    /// The current point.
    fn state(&self) -> &State;

    /// Attempts one step. If it is rejected the current point stays.
    fn attempt(&mut self, request: &StepRequest) -> Attempt;

    /// The moving vertices and the normals along which they do not slide; `None` where the method
    /// moves them along the surface by itself.
    fn normals(&self) -> Option<(&[u32], &[DVec3])>;

    /// Moves to other positions on the surface after a step from energy `before`, if that gives
    /// back only a part of the step's gain. Returns whether it moved.
    fn slide(&mut self, positions: &[DVec3], before: EnergySum) -> bool;

    /// The first time step of a flow in true time; `tau_ref` is the natural time of the hole.
    fn first_tau(&self, tau_ref: f64) -> f64;

    /// Vertices that do not move because a step of theirs would fold the surface.
    fn frozen(&self) -> usize {
        0
    }
}
