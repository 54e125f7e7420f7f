//! Records of the steps of a flow and of its end.

use crate::linear::LinearError;
use crate::warning::Warnings;

/// One line of the record of a flow.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StepRecord {
    /// Accepted steps so far, this one included if it was accepted.
    pub step: usize,
    /// Its time step (for quasi-Newton steps, that of the factor).
    pub tau: f64,
    /// Energy after it, by the quadrature rule of the steps.
    pub energy: f64,
    /// Displacement scaled to `τ_ref`, over the hole radius; NaN if rejected.
    pub residual: f64,
    /// Why it was rejected; `None` if it was accepted.
    pub rejection: Option<RejectReason>,
    /// The method of its computation.
    pub kind: StepKind,
    /// Scheme A: iterations of GMRES.
    pub iterations: Option<usize>,
    /// Scheme A: relative residual of the linear solve.
    pub linear_residual: Option<f64>,
}

impl StepRecord {
    /// Whether it was rejected.
    pub fn is_rejected(&self) -> bool {
        self.rejection.is_some()
    }
}

/// How a step was computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepKind {
    /// With a matrix of the current point.
    Factorized,
    /// With an earlier factor and quasi-Newton updates.
    QuasiNewton,
    /// Scheme A, by GMRES.
    Krylov,
}

/// Why a step was rejected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RejectReason {
    /// The energy after the step is not finite, or higher than before by more than rounding.
    #[error("the step does not lower the energy")]
    NoDescent,
    /// The surface would fold.
    #[error("the step would fold the surface")]
    Fold,
    /// τ is not a positive number.
    #[error("the time step is {0}")]
    TimeStep(f64),
    /// The energy's second derivatives are not finite somewhere.
    #[error("second derivatives of the energy are not finite on the surface")]
    UndefinedDerivatives,
    /// The run was cancelled during the step.
    #[error("the run was cancelled")]
    Cancelled,
    /// The linear system could not be solved.
    #[error("{0}")]
    Linear(#[from] LinearError),
    /// Scheme A: GMRES stopped at its limit of iterations.
    #[error(
        "GMRES did not converge: relative residual {relative_residual:.1e} after {iterations} iterations"
    )]
    NotSolved {
        /// Residual over that at the start.
        relative_residual: f64,
        /// Iterations.
        iterations: usize,
    },
    /// Scheme A: the energy fell by much more than its gradient predicts.
    #[error(
        "the surface is no longer resolved: the energy fell by {fall:.1e}, its gradient promises \
         {promised:.1e}"
    )]
    Unresolved {
        /// Decrease of the energy.
        fall: f64,
        /// Decrease predicted by its gradient.
        promised: f64,
    },
}

impl RejectReason {
    /// A stable name for traces and scripts.
    pub fn code(&self) -> &'static str {
        match self {
            Self::NoDescent => "no-descent",
            Self::Fold => "fold",
            Self::TimeStep(_) => "time-step",
            Self::UndefinedDerivatives => "undefined-derivatives",
            Self::Cancelled => "cancelled",
            Self::Linear(_) => "linear-solve",
            Self::NotSolved { .. } => "gmres",
            Self::Unresolved { .. } => "unresolved",
        }
    }
}

/// Why a flow ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum End {
    /// The stopping rule was met.
    Converged,
    /// `max_steps` was reached.
    MaxSteps,
    /// τ collapsed: no step lowers the energy.
    StepSizeCollapsed,
    /// The surface was pinching off; the shape is the last one with an open neck.
    Pinched,
    /// The surface intersects itself; the shape is the last one without a self-intersection.
    SelfIntersected,
    /// Stopped by the caller.
    Cancelled,
}

/// Summary of a flow.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Outcome {
    /// Why it ended.
    pub end: End,
    /// Accepted steps.
    pub steps: usize,
    /// Rejected steps.
    pub rejected: usize,
    /// Energy at the start, by the rule of the steps with at least 12 points.
    pub energy_start: f64,
    /// Energy at the end, by the rule of the steps with at least 12 points.
    pub energy_end: f64,
    /// Warnings for the user.
    pub warnings: Warnings,
}
