//! What a flow tells of its steps and of its end.

use crate::solver::control::StepKind;

/// One line of the record of a flow.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StepRecord {
    /// Accepted steps so far, this one included if it was accepted.
    pub step: usize,
    /// Its time step (for quasi-Newton steps that of the factor).
    pub tau: f64,
    /// Energy after it, by the quadrature rule of the steps.
    pub energy: f64,
    /// Displacement brought to `τ_ref`, over the hole radius; NaN if rejected.
    pub residual: f64,
    /// Whether it was rejected.
    pub rejected: bool,
    /// How it was computed.
    pub kind: StepKind,
    /// Scheme A: iterations of GMRES.
    pub iterations: Option<usize>,
    /// Scheme A: relative residual of the linear solve.
    pub linear_residual: Option<f64>,
}

/// Why a flow ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The stopping rule was met.
    Converged,
    /// `max_steps` were taken.
    MaxSteps,
    /// τ collapsed: no step lowers the energy.
    StepSizeCollapsed,
    /// The surface was pinching off; the shape is the last one with an open neck.
    Pinched,
    /// The surface passes through itself; the shape is the last one that does not.
    SelfIntersected,
    /// It was told to.
    Cancelled,
}

/// How a flow went.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Outcome {
    /// Why it ended.
    pub end: End,
    /// Accepted steps.
    pub steps: usize,
    /// Rejected steps.
    pub rejected: usize,
    /// Energy at the start, by the rule of the steps, 12 points at least.
    pub energy_start: f64,
    /// Energy at the end, by the rule of the steps, 12 points at least.
    pub energy_end: f64,
    /// Warnings in plain words.
    pub warnings: Vec<String>,
}
