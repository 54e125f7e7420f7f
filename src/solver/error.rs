//! Errors of flows.

use crate::cancel::is_cancelled;
use crate::linear::LinearError;
use crate::mesh::TopologyError;
use crate::surface::SurfaceStats;

/// Why a flow cannot be set up or continued.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SolverError {
    /// The run to which the computation belongs was cancelled.
    #[error("the computation was cancelled")]
    Cancelled,
    /// The region is not an oriented manifold.
    #[error("the region to solve on is not an oriented manifold: {0}")]
    Topology(#[from] TopologyError),
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} of the region has a coordinate that is not a finite number")]
    NotFinite {
        /// The local vertex.
        vertex: usize,
    },
    /// A vertex index is out of range.
    #[error("vertex {vertex} of the region does not exist")]
    NoSuchVertex {
        /// The local vertex.
        vertex: usize,
    },
    /// An interior vertex has an incomplete ring of faces.
    #[error(
        "interior vertex {vertex} lies on a boundary; only vertices with a full ring of faces can flow"
    )]
    InteriorOnBoundary {
        /// The local vertex.
        vertex: usize,
    },
    /// The limit surface cannot interpolate two points at one vertex.
    #[error("vertex {vertex} has two interpolation constraints; list each constrained vertex once")]
    ConstrainedTwice {
        /// The local vertex.
        vertex: usize,
    },
    /// The unit of length is unusable.
    #[error("the hole radius {radius} is not positive and finite")]
    BadRadius {
        /// The radius given.
        radius: f64,
    },
    /// The energy or its derivatives are not finite on the starting surface.
    #[error(
        "the energy is not finite on the starting surface (H between {h_min:.3e} and {h_max:.3e}, \
         K between {k_min:.3e} and {k_max:.3e}); choose an expression defined there"
    )]
    EnergyNotFinite {
        /// Minimum mean curvature.
        h_min: f64,
        /// Maximum mean curvature.
        h_max: f64,
        /// Minimum Gaussian curvature.
        k_min: f64,
        /// Maximum Gaussian curvature.
        k_max: f64,
    },
    /// A linear system could not be solved.
    #[error("the linear system could not be solved: {0}")]
    Linear(#[from] LinearError),
    /// An option is out of range.
    #[error("{option} is {value}; {expected}")]
    BadOption {
        /// The name of the option.
        option: &'static str,
        /// The value as text.
        value: String,
        /// The accepted values.
        expected: &'static str,
    },
    /// The solver thread panicked.
    #[error("the solver stopped unexpectedly: {0}")]
    Panic(String),
}

impl SolverError {
    /// # Errors
    /// [`Self::Cancelled`] if the run of this thread was cancelled.
    pub(crate) fn unless_cancelled() -> Result<(), Self> {
        if is_cancelled() {
            return Err(Self::Cancelled);
        }
        Ok(())
    }

    /// The error for an energy that is not finite on the surface with these `stats`.
    pub(super) fn energy_not_finite(stats: &SurfaceStats) -> Self {
        Self::EnergyNotFinite {
            h_min: stats.mean[0],
            h_max: stats.mean[1],
            k_min: stats.gauss[0],
            k_max: stats.gauss[1],
        }
    }
}
