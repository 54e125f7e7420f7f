//! The surface a flow starts from.

use crate::mesh::VertexId;
use crate::patch;
use crate::solver::{FlowProblem, SolverError};

/// Moves the interior vertices to the solution of the graph bi-Laplacian.
///
/// # Errors
/// If the linear system cannot be solved, as in a region without fixed vertices.
pub(super) fn warm_start(problem: FlowProblem) -> Result<FlowProblem, SolverError> {
    let all = problem.interior().to_vec();
    warm_start_of(problem, &all)
}

/// [`warm_start`] that moves only some of the interior vertices.
pub(super) fn warm_start_of(
    problem: FlowProblem,
    moved: &[u32],
) -> Result<FlowProblem, SolverError> {
    let mut positions = problem.positions().to_vec();
    let interior: Vec<VertexId> = moved.iter().map(|&v| VertexId(v)).collect();
    let creases: Vec<VertexId> = problem.creases().iter().map(|&v| VertexId(v)).collect();
    patch::warm_start_with_creases(problem.topology(), &mut positions, &interior, &creases)?;
    Ok(problem.with_positions(&positions))
}
